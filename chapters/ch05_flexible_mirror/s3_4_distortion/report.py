"""Results of this page read: values of the prose, figures, tables."""

from functools import cache
from itertools import combinations

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.experiment import (
    DEFLECTION_MM,
    PLACES,
    RADIUS_MM,
    held,
    ring_on,
)
from chapters.shared.mirror import (
    ABERRATION_UM,
    BENCHES,
    LEVEL,
    LEVEL_NAMES,
    MEDIANS,
    STAGES_MM,
    BenchRuns,
    mirror_rig,
    reached,
    with_published,
)
from chapters.shared.mirror import middle as words_of
from raxel.cameras import FlexibleMirrorCamera, PerspectiveCamera
from raxel.multiview import (
    algebraic_conic,
    circle_distances,
    circle_outline,
    conic_distances,
    fit_conic,
    measured_circle,
)
from raxel.multiview import value as value_of_conics
from repro.page import (
    INK,
    legend_below,
    look_of,
    new_figure,
    plot_estimates,
    series,
    value,
)
from repro.run import (
    Check,
    Drawing,
    Table,
    Value,
    columns,
    figure,
    median_and_range,
    median_interval,
    numbers,
    table,
)

# Noise-free checks: a circle on a plane, and its conic in a flat mirror.


SEED = 0  # of the target's pose and of the mirror's waves


@cache
def exact_radii():
    """Errors (8,) mm of the radius at stages 0 to 3, smooth and uneven mirror."""
    rig = mirror_rig("A")
    return np.array(
        [
            _radius(rig, deflection, uneven) - RADIUS_MM
            for uneven in (0.0, ABERRATION_UM)
            for deflection in STAGES_MM
        ]
    )


def _radius(rig, deflection, uneven):
    camera, T = rig.camera(deflection, uneven, SEED), held(rig, deflection, SEED)
    centre = ring_on(rig.board).centre
    pixels = circle_outline(camera, T, centre, RADIUS_MM, PLACES)[0]
    return measured_circle(camera, pixels, T).fit.radius


@cache
def conic_of_flat_mirror():
    """Largest distance, px, from a conic; flat mirror, lens without distortion."""
    rig = mirror_rig("A")
    camera = rig.camera(0.0)
    viewer = PerspectiveCamera(rig.viewer.K, [], rig.viewer.width, rig.viewer.height)
    flat = FlexibleMirrorCamera(**camera.arguments() | {"viewer": viewer})
    T = held(rig, 0.0, SEED)
    centre = ring_on(rig.board).centre
    pixels = circle_outline(flat, T, centre, RADIUS_MM, PLACES)[0]
    seen = np.isfinite(pixels).all(axis=1)
    return float(np.abs(fit_conic(pixels[seen]).residuals).max())


# Runs of 5.3.4: result, error level, stage and camera.


RUNS, SWEPT_RUNS = "table_5_6_runs", "table_5_6_swept"
IMAGES = "fig_5_14_pictures"
JUDGED = ("table_5_6_runs", "table_5_6_swept")
STAGES = tuple(range(len(STAGES_MM)))
STAGE_NAMES = tuple(f"stage{stage}" for stage in STAGES)
# Magnification of the residuals in Figs. 5.14 to 5.17.
SCALE = 50
FIRST, LAST = 1, STAGES[-1]
# Mirror that corrects: the true one, and that of the published calibration.
WAYS = {"true": "true mirror", "published": "stage by stage"}


class CircleRuns(BenchRuns):
    """Circle and face of every run at one error level."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)

    def of(self, stage, name, way="published"):
        """A value (runs,) of one stage, nan where a run was rejected before."""
        return self.at(name, way)[stage]

    def at(self, name, way="published"):
        """A value (stages, runs) of all stages."""
        return self.result.column(self.bench, way, STAGE_NAMES, name)

    def face(self, name, camera="calibrated"):
        """A value (runs,) of the face."""
        return self.result.column(self.bench, "face", camera, name)

    def profiles(self, stage):
        """Residuals (runs, PLACES) mm around the circle, outwards.

        nan where a run was rejected and where a point is not visible.
        """
        known = np.isfinite(self.of(stage, "radius_mm"))
        found = np.full((self.seeds, PLACES), np.nan)
        if known.any():
            path = "published", STAGE_NAMES[stage], "profile"
            found[known] = self.result.arrays(self.bench, *path)
        return found


class ImageRuns(CircleRuns):
    """Runs with rendered images; all are at the primary level."""

    EXPERIMENTS = (IMAGES, IMAGES)

    def drawn(self):
        """(way, run) of the figures: the first run calibrated at all stages.

        The first run of the true mirror without one of its own.
        """
        came = np.flatnonzero(np.isfinite(self.of(LAST, "radius_mm")))
        return ("published", int(came[0])) if len(came) else ("true", 0)

    def array(self, way, stage, name, run):
        """An array of a run that reached the stage."""
        before = self.of(stage, "radius_mm", way)[:run]
        arrays = self.result.arrays(self.bench, way, STAGE_NAMES[stage], name)
        return arrays[np.count_nonzero(np.isfinite(before))]

    def image(self, stage, run):
        """Image of a run at a stage."""
        path = "picture", STAGE_NAMES[stage], "grey"
        return self.result.arrays(self.bench, *path)[run]

    def corrected(self, run):
        """Image of the last stage, rectified to the board."""
        return self.result.arrays(self.bench, "corrected")[run]


# Claims of 5.3.4 for single runs.
#
# Each function takes the `CircleRuns` at an error level. It returns whether the claim
# holds (runs,), the measured value (runs,), its unit, and words. A run that was
# rejected before the last stage has no value.


MAX_RADIUS_ERROR = 1.5  # %
MAX_CORRELATION = 0.3
MAX_REMAINDER = 0.2
MIN_N_SHARED = 20  # points that two profiles have in common


def _by_stage(values):
    return ", ".join(words_of(of_stage) for of_stage in values)


def radius_errors(runs, way="published"):
    """Errors (stages, runs) of the circle's radius, %."""
    return 100 * (runs.at("radius_mm", way) / RADIUS_MM - 1)


def radii_agree(runs):
    """The radius is within 1.5 % at every stage."""
    off = np.abs(radius_errors(runs))
    return (
        np.all(off <= MAX_RADIUS_ERROR, axis=0),
        off.max(axis=0),
        "%",
        f"largest error of the four stages; by stage {_by_stage(off)} %; rays are "
        f"{_by_stage(runs.at('angle_deg'))} degrees off",
    )


def conic_departs(runs):
    """The distance from a conic in the image grows from stage to stage."""
    off = runs.at("conic_px", "picture")
    return (
        np.all(np.diff(off, axis=0) > 0, axis=0),
        off[-1] / off[0],
        "x",
        f"stage 3 over stage 0; by stage {_by_stage(off)} px; without the lens's "
        f"distortion {_by_stage(runs.at('conic_no_lens_px', 'picture'))} px",
    )


def alike(runs):
    """Mean correlation (runs,) of the residuals around the circle of two stages."""
    profiles = [runs.profiles(stage) for stage in STAGES]
    return np.array(
        [
            np.mean(
                [
                    correlation(first[seed], second[seed])
                    for first, second in combinations(profiles, 2)
                ]
            )
            for seed in range(runs.seeds)
        ]
    )


def correlation(first, second):
    """Pearson correlation over the points (N,) that both have; nan for too few."""
    both = np.isfinite(first) & np.isfinite(second)
    if np.count_nonzero(both) < MIN_N_SHARED:
        return np.nan
    return float(np.corrcoef(first[both], second[both])[0, 1])


def no_common_error(runs):
    """Residuals around the circle do not correlate between stages."""
    found = alike(runs)
    return (
        found < MAX_CORRELATION,
        found,
        "",
        "mean correlation of the residuals around the circle, all pairs of stages",
    )


def face_left(runs, camera="calibrated"):
    """Remaining distortion (runs,) of a face over that of the image."""
    return runs.face("corrected_px", camera) / runs.face("raw_px", camera)


def face_corrected(runs):
    """At most a fifth of the distortion of a face remains."""
    found = face_left(runs)
    return (
        found <= MAX_REMAINDER,
        found,
        "",
        f"left over raw; with the true mirror {words_of(face_left(runs, 'true'))}",
    )


# Numbers quoted on the page: medians over the runs that completed, in words.
#
# Where no run completed, as in quick builds, there are words for that.


def in_words(number, form=".2g"):
    """A number in the format of the prose."""
    return format(float(number), form) if np.isfinite(number) else "(no number)"


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = CircleRuns({RUNS: open_results(RUNS)}, bench=LEVEL)
    value(f"radius.{LAST}", in_words(middle(np.abs(radius_errors(runs))[LAST])))
    for stage in (0, LAST):
        value(f"angle.{stage}", in_words(middle(runs.of(stage, "angle_deg"))))
    value("alike", in_words(middle(alike(runs))))
    for name, camera in (("face", "calibrated"), ("face.true", "true")):
        value(name, in_words(100 * middle(face_left(runs, camera)), ".0f"))


# Figs. 5.14 to 5.19: the circle and the face in the mirror, and corrected.


RED = "#d62728"
EXACT = 1e-9


LOOKS = {"true": look_of("true mirror"), "published": series(0)}
CORRECTED_BY = {"published": "the calibrated mirror", "true": "the true mirror"}


def two_panels(results, stage):
    """The circle at one stage: in the image, and on the board after correction."""
    runs = ImageRuns(results, bench=LEVEL)
    way, run = runs.drawn()
    image = runs.image(stage, run)
    line, points, left, centre = (
        runs.array(way, stage, name, run)
        for name in ("line_px", "points_mm", "residuals_mm", "centre_mm")
    )
    radius = runs.of(stage, "radius_mm", way)[run]
    drawn, (raw, board) = new_figure(1, 2, height_in=3.4)
    conic = algebraic_conic(line)
    off, _ = conic_distances(conic, line)
    raw.imshow(image, cmap="gray")
    rows, across = image.shape
    u, v = np.meshgrid(np.arange(across), np.arange(rows))
    q = value_of_conics(conic, np.column_stack([u.ravel(), v.ravel()]).astype(float))
    raw.contour(u, v, q.reshape(rows, across), [0.0], colors=RED, linewidths=0.9)
    raw.set(xticks=[], yticks=[], title="(a) image and best conic")
    outward = points - centre
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    feet = points - left[:, None] * outward
    ends = feet + SCALE * left[:, None] * outward
    angle = np.linspace(0, 2 * np.pi, 361)
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    circle = centre + radius * around
    board.plot(*circle.T, color=INK, lw=0.8, marker="")
    look = {"color": series(0)["color"], "lw": 0.9, "ls": "-", "marker": ""}
    board.plot(*np.stack([feet, ends], axis=-1).transpose(1, 2, 0), **look)
    board.set_aspect("equal")
    board.invert_yaxis()
    board.set(xlabel="x on the board (mm)", ylabel="y on the board (mm)")
    board.set_title(f"(b) corrected, residuals × {SCALE}")
    ring = np.array([[*centre, radius]])
    gap = float(np.abs(circle_distances(ring, points)[0] - left).max())
    return Drawing(
        drawn,
        columns(
            ("u_px", "v_px", "off_conic_px", "x_mm", "y_mm", "residual_mm"),
            [
                (*p, o, *x, r)
                for p, o, x, r in zip(line, off, points, left, strict=True)
            ],
        ),
        f"The circle at stage {stage}: (a) rendered image of {across} x {rows} px with "
        "the conic of least algebraic error, at a mean distance of "
        f"{np.abs(off).mean():.2f} px; (b) after correction by {CORRECTED_BY[way]}, "
        f"residuals from the best circle, magnified {SCALE} times. Their mean is "
        f"{np.abs(left).mean():.2f} mm, the radius {radius:.2f} mm. One run, geometry "
        "A, second solved level.",
        Check(
            gap < EXACT,
            f"drawn residuals equal the distances from the circle, to {gap:.0e} mm",
        ),
    )


@figure("fig_5_14", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_14(results):
    """The circle at stage 0."""
    return two_panels(results, 0)


@figure("fig_5_15", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_15(results):
    """The circle at stage 1."""
    return two_panels(results, 1)


@figure("fig_5_16", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_16(results):
    """The circle at stage 2."""
    return two_panels(results, 2)


@figure("fig_5_17", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_17(results):
    """The circle at stage 3."""
    return two_panels(results, 3)


@figure("fig_5_18", needs=("fig_5_14_pictures",), evidence="rendered")
def fig_5_18(results):
    """The image of stage 3, rectified to the board."""
    runs = ImageRuns(results, bench=LEVEL)
    way, run = runs.drawn()
    image = runs.corrected(run)
    drawn, axes = new_figure(height_in=4.4)
    axes.imshow(image, cmap="gray")
    axes.set(xticks=[], yticks=[])
    rows, across = image.shape
    return Drawing(
        drawn,
        columns(("rows", "columns", "mean_grey"), [(rows, across, image.mean())]),
        "The image of Fig. 5.17 rectified to the board, in the pose estimated with "
        f"{CORRECTED_BY[way]}. Black: outside the mirror.",
    )


@figure("fig_5_19", needs=("fig_5_19_picture",), evidence="rendered")
def fig_5_19(results):
    """The bust in the mirror, and corrected to a nearly perspective view."""
    result = results["fig_5_19_picture"]
    drawn, axes = new_figure(1, 2, height_in=3.8)
    for panel, name, title in zip(
        axes, ("picture", "corrected"), ("(a) image", "(b) corrected"), strict=True
    ):
        (image,) = result.arrays(name)
        panel.imshow(image, cmap="gray")
        panel.set(xticks=[], yticks=[], title=title)
    (ideal,) = result.arrays("ideal_px")
    way = "published" if result.column("calibrated")[0] else "true"
    axes[1].plot(*ideal.T, ls="", marker="+", color=RED, ms=4)
    return Drawing(
        drawn,
        columns(("ideal_u_px", "ideal_v_px"), [tuple(p) for p in ideal]),
        "A bust in low relief, in place of the thesis's face, in a mirror pushed by "
        f"12 mm: (a) camera image, (b) corrected by {CORRECTED_BY[way]} as a plane. "
        "Crosses: landmarks in the desired pinhole view.",
    )


@figure("ext_circle_blind", needs=("table_5_6_runs",), evidence="rendered")
def ext_circle_blind(results):
    """Radius errors and ray errors over the stages."""
    drawn, panels = new_figure(1, 2, height_in=3.3)
    runs, rows = CircleRuns(results, bench=LEVEL), []
    for way in WAYS:
        for panel, name, values in (
            (panels[0], "radius_percent", np.abs(radius_errors(runs, way))),
            (panels[1], "angle_deg", angles_of(runs, way)),
        ):
            came = {
                stage: median_interval(trials[np.isfinite(trials)])
                for stage, trials in zip(STAGES, values, strict=True)
                if np.isfinite(trials).any()
            }
            if not came:
                continue
            look = {"look": LOOKS[way], "label": WAYS[way]}
            whose = (WAYS[way], name)
            rows += plot_estimates(
                panel, list(came), list(came.values()), whose, **look
            )
    for panel, words in zip(
        panels, ("Radius error (%)", "Mean ray error (°)"), strict=True
    ):
        panel.set(xlabel="Stage", ylabel=words, xticks=STAGES, ylim=(0, None))
    legend_below(drawn, panels[0], ncols=3)
    return Drawing(
        drawn,
        columns(("mirror", "measure", "stage", "value", "low", "high"), rows),
        "Error of the circle's radius (left), and mean angle between calibrated and "
        "true rays over the mirror (right), by stage. Medians over the completed runs "
        "with 95 % intervals; rig A, second level. The rays of the true mirror "
        "are exact; its radius has the errors of corners and edges.",
    )


def angles_of(runs, way):
    """Angles (stages, runs) to the true rays; zero for the true mirror."""
    if way == "true":
        return np.zeros((len(STAGES), runs.seeds))
    return runs.at("angle_deg", way)


# Table 5.6 at all levels, and its numbers.


DRAWN = "the target has this radius"
IN_MM = ("residual", "residual_sd", "radius")
PRINTED = {
    "Residual (mm)": "mean",
    "SD (mm)": "sd",
    "Radius (mm)": "radius",
    "Radius error (%)": "err",
}


@table("table_5_6", needs=("table_5_6_runs",), evidence="rendered")
def table_5_6(results):
    """Residuals and radii of the corrected circle at four stages."""
    rows = []
    for level in BENCHES:
        runs = CircleRuns(results, bench=level)
        off = np.abs(radius_errors(runs))
        rows += [
            (
                LEVEL_NAMES[level],
                stage,
                int(np.isfinite(runs.of(stage, "radius_mm")).sum()),
                *(reached(runs.of(stage, f"{name}_mm")) for name in IN_MM),
                reached(off[stage]),
                reached(runs.of(stage, "angle_deg")),
                reached(runs.of(stage, "pose_mm")),
            )
            for stage in STAGES
        ]
    heads = ("Error level", "Stage", "Runs", *PRINTED, "Ray error (°)", "Pose (mm)")
    return Table(
        columns(heads, rows),
        "Residuals and radius of the circle of 87.21 mm after correction, with the "
        "board's pose estimated with the same camera. Right: what these do not show, "
        "the mean ray error over the mirror and the position error of the board's "
        f"middle. Rig A. {MEDIANS}",
        printed={
            head: with_published(
                [f"t5_6_s{stage}_{end}" for stage in STAGES], len(rows)
            )
            for head, end in PRINTED.items()
        },
    )


@numbers("table_5_6", needs=("table_5_6_runs",), evidence="rendered")
def numbers_of_table_5_6(results):
    """Residuals, radii and their errors at each stage."""
    runs = CircleRuns(results)
    measures = {
        "mean": (runs.at("residual_mm"), "mm"),
        "sd": (runs.at("residual_sd_mm"), "mm"),
        "radius": (runs.at("radius_mm"), "mm"),
        "err": (np.abs(radius_errors(runs)), "%"),
    }
    found = {"t5_6_true": Value(RADIUS_MM, unit="mm", put_in=DRAWN)}
    for stage in STAGES:
        for end, (values, unit) in measures.items():
            found[f"t5_6_s{stage}_{end}"] = value_of(values[stage], unit)
    return found


def value_of(trials, unit):
    """The Value of seeds (n,), and how many have none: in words if that is all."""
    lost = np.count_nonzero(~np.isfinite(trials))
    reason = f"{lost} of {len(trials)} runs were rejected before" if lost else ""
    if lost == len(trials):
        return Value("nothing", unit=unit, reason=reason)
    return Value.of_seeds(trials, unit, reason)


@numbers("fig_5_14", needs=(), evidence="analytic")
def numbers_of_fig_5_14(results):
    """Magnification of the residuals."""
    return {"fig5_14_scale": Value(SCALE, unit="x")}


@numbers("fig_5_19", needs=(), evidence="analytic")
def numbers_of_fig_5_19(results):
    """Deflection of the mirror for the face."""
    return {"fig5_19_defl": Value(DEFLECTION_MM, unit="mm")}
