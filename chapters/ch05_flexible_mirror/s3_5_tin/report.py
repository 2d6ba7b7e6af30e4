"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.experiment import (
    ANGLES_DEG,
    FACES,
    MATCHES,
    OUTLYING,
    PAIRS,
    SHIFT_MM,
    tin_points,
    two_places,
    usual,
)
from chapters.shared.mirror import (
    BENCHES,
    LABORATORY,
    LEVEL,
    LEVEL_NAMES,
    BenchRuns,
    middle,
    mirror_rig,
    reached,
    with_published,
)
from raxel.geometry import transform
from raxel.show import Points, Surface, framed
from repro.page import INK, legend_below, new_figure, series, value
from repro.page.space import draw_scene
from repro.run import Drawing, Table, Value, claim, columns, figure, numbers, table

# Claims about the tin for single runs.
#
# Each function takes the `TinRuns` at an error level. It returns whether the claim
# holds (runs,), the measured value (runs,), its unit, and words. A rejected run has
# no value.


MAX_ERROR_DEG = 2.5
MIN_NORMALITY = 0.99


def angles_found(runs):
    """The largest difference of the three angles from the reference."""
    off = runs.off()
    most = np.abs(off).max(axis=0)
    below = np.mean(np.all(off < 0, axis=0))
    return (
        most <= MAX_ERROR_DEG,
        most,
        "deg",
        "largest difference of the three; by the true mirror "
        f"{middle(runs.of('off_deg', 'true'))} degrees; all three below the reference "
        f"in {100 * below:.0f} % of the simulated runs",
    )


def distances_normal(runs):
    """The smallest of the three faces' correlations with a normal law."""
    least, whole, true = (
        runs.normality(*of).min(axis=0)
        for of in (("published",), ("published", "qq_all"), ("true",))
    )
    return (
        least >= MIN_NORMALITY,
        least,
        "",
        f"least of the three faces, without those beyond {OUTLYING:g} robust "
        f"deviations; with them {middle(whole)}; by the true mirror {middle(true)}",
    )


# Runs of the tin with drawn matches: result, error level and mirror.


RUNS, SWEPT_RUNS = "table_5_8_runs", "table_5_8_swept"
JUDGED = ("table_5_8_runs", "table_5_8_swept")
IMAGES = "fig_5_22_pictures"
# The true mirror, and the calibration of the thesis.
WAYS = {"true": "true mirror", "published": "as published"}
PUBLISHED = "published"


class TinRuns(BenchRuns):
    """A tin seen twice."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)

    def of(self, name, way=PUBLISHED):
        """A value (runs,) of a mirror, nan where a run was rejected."""
        return self.result.column(self.bench, way, name)

    def angles(self, way=PUBLISHED):
        """Angles (3, runs), degrees, of PAIRS."""
        return self.result.column(self.bench, way, "angle", tuple(PAIRS))

    def off(self, way=PUBLISHED):
        """Errors (3, runs) of the angles, degrees."""
        return self.angles(way) - ANGLES_DEG[:, None]

    def normality(self, way=PUBLISHED, name="qq"):
        """Correlations (3, runs) with a normal law, of each face."""
        return self.result.column(self.bench, way, name, tuple(FACES))


# Numbers quoted on the page: medians, as words, over the runs that have a tin.


BENT_MM = 15.0


def in_words(number):
    """A number below 10 with two digits, a larger one as a whole number."""
    return f"{number:.2g}" if abs(number) < 10 else f"{number:.0f}"


def quoted_median(found):
    """Median of the runs that have a value, as words; "no" without any."""
    known = found[np.isfinite(found)]
    return in_words(np.median(known)) if len(known) else "no"


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {RUNS: open_results(RUNS)}
    runs = TinRuns(results, bench=LEVEL)
    value("true.off", quoted_median(runs.of("off_deg", "true")))
    _, least, _, _ = distances_normal(runs)
    value("normal.least", quoted_median(least))
    low_noise = TinRuns(results, bench=LABORATORY)
    for name, measure in (("off", "off_deg"), ("rms", "rms_mm")):
        value(f"lab.published.{name}", quoted_median(low_noise.of(measure)))
    way_mm, degrees = meeting_rays()
    value("way", way_mm)
    value("meet", degrees)


def meeting_rays():
    """Return the mean distance of the tin's points from the mirror, mm, and the mean
    angle at which the two rays of each meet, degrees; one tin, rig A."""
    camera = mirror_rig("A").camera(BENT_MM)
    rng = np.random.default_rng(0)
    poses = two_places(camera, rng)
    points, _ = tin_points(rng, MATCHES)
    seen = [transform(T, points) for T in poses]
    rays = [camera.rays(camera.project(at).pixels) for at in seen]
    ways = [
        np.linalg.norm(at - r.origins, axis=1) for at, r in zip(seen, rays, strict=True)
    ]
    turns = np.einsum("ni,ni->n", *(r.directions for r in rays))
    return float(np.mean(ways)), float(np.degrees(np.mean(np.arccos(turns))))


# Textured model of the tin, and distances of its points from their planes.


UP, ASPECT, POINT_PX = (0.0, -1.0, 0.0), 1.0, 4.0
DRAWN_WAYS = ("true", PUBLISHED)
BINS = 25


def tin_model(result, level=LEVEL, way=PUBLISHED):
    """(textured Surfaces and points, viewing direction (3,)) of the first run's tin.

    None where it has none.
    """
    parts = []
    for name in FACES:
        sheets = result.arrays(level, way, "sheet", name)
        if not sheets:
            return None
        texture = result.arrays(level, way, "texture", name)[0]
        parts.append(Surface(sheets[0], texture=texture))
    # Viewed along the faces' normals, from outside.
    inside = np.mean([np.mean(part.points, axis=(0, 1)) for part in parts], axis=0)
    sight = -sum(_outward(part.points, inside) for part in parts)
    points = result.arrays(level, way, "at")[0]
    parts.append(Points(points, series(1)["color"], "matched points", POINT_PX))
    return parts, sight / np.linalg.norm(sight)


def _outward(sheet, inside):
    """Unit normal (3,) of a sheet (2, 2, 3), away from a point."""
    normal = np.cross(sheet[0, 1] - sheet[0, 0], sheet[1, 0] - sheet[0, 0])
    away = np.mean(sheet, axis=(0, 1)) - inside
    return normal * np.sign(normal @ away) / np.linalg.norm(normal)


@figure("fig_5_22", needs=("fig_5_22_pictures",), evidence="rendered", scene=True)
def model_figure(results):
    """Image of the tin in the mirror, and its model."""
    result = results[IMAGES]
    level, way = next(
        (b, w)
        for b, w in ((LEVEL, PUBLISHED), (LEVEL, "true"), (LABORATORY, "true"))
        if tin_model(result, b, w) is not None
    )
    parts, sight = tin_model(result, level, way)
    note = "Faces are planes through triangulated matches, coloured by calibrated rays."
    scene = framed(parts, tuple(sight), UP, note, aspect=ASPECT)
    drawn, axes = new_figure(1, 2, height_in=3.4)
    image = result.arrays(level, "picture")[0]
    axes[0].imshow(image, cmap="gray", vmin=0, vmax=255)
    axes[0].set(xticks=[], yticks=[])
    for panel, letter in zip(axes, "ab", strict=True):
        panel.set_title(f"({letter})")
    draw_scene(axes[1], scene)
    return Drawing(
        drawn,
        columns(
            ("face", "points"),
            [
                (name, int(np.sum(result.arrays(level, way, "face")[0] == k)))
                for k, name in enumerate(FACES)
            ],
        ),
        "The tin in the bent mirror, rendered (a), and its model (b): planes through "
        "matched features of each face, with the grey values of the image. Rig A, "
        f"{LEVEL_NAMES[level]}, mirror: {WAYS[way]}. The mirror image is reversed, "
        "the model is not.",
        scene=scene,
    )


@figure("fig_5_23", needs=("table_5_8_runs",), evidence="rendered")
def distances_figure(results):
    """Histograms of the signed distances of each face, and normal curves."""
    from scipy.stats import norm

    result, rows = results[RUNS], []
    drawn, axes = new_figure(1, 3, height_in=3.0, sharey=True)
    came = [np.isfinite(result.column(LEVEL, w, "rms_mm")) for w in DRAWN_WAYS]
    both = np.flatnonzero(np.logical_and.reduce(came))
    seed = both[0] if len(both) else 0
    for number, way in enumerate(DRAWN_WAYS):
        if not came[number][seed]:
            continue
        place = np.count_nonzero(came[number][:seed])
        distances, face = (
            result.arrays(LEVEL, way, name)[place] for name in ("distances", "face")
        )
        for k, panel in enumerate(axes):
            d = distances[face == k]
            look = series(number)["color"]
            counts, edges = np.histogram(d, BINS)
            width = edges[1] - edges[0]
            panel.stairs(counts, edges, color=look, fill=way == PUBLISHED,
                         alpha=0.6, label=WAYS[way])  # fmt: skip
            kept = d[usual(d)]
            x = np.linspace(edges[0], edges[-1], 100)
            curve = len(kept) * width * norm.pdf(x, kept.mean(), kept.std(ddof=1))
            panel.plot(x, curve, color=look, marker="", lw=1.4)
            rows += [
                (way, FACES[k], float(at), int(n))
                for at, n in zip(edges[:-1] + width / 2, counts, strict=True)
            ]
    for panel, name in zip(axes, FACES, strict=True):
        panel.set_title(f"{name.capitalize()} face")
        panel.set_xlabel("Signed distance (mm)")
        panel.axvline(0, color=INK, lw=0.6)
    axes[0].set_ylabel("Number of points")
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(("mirror", "face", "distance_mm", "count"), rows),
        "Signed distances of the tin's points from the plane of their face, positive "
        "outside, with the true mirror and with the published calibration. Curves: "
        "normal distributions of the same spread, outliers excluded. First run of the "
        "second level that has both.",
    )


# Table 5.8 at all levels, its numbers, and what they depend on.


SET = "the tin's faces meet at the angles of the thesis's laser scan"
MOVED = "the camera is moved by this distance"
MEDIANS = "Medians over the runs that have a tin, with 95 % intervals."


@table("table_5_8", needs=("table_5_8_runs",), evidence="rendered")
def table_5_8(results):
    """Angles between the faces, estimated and true."""
    rows = []
    for level in BENCHES:
        runs = TinRuns(results, bench=level)
        for k, pair in enumerate(PAIRS):
            rows.append(
                (
                    LEVEL_NAMES[level],
                    pair.replace("_", " - "),
                    reached(runs.angles(PUBLISHED)[k]),
                    float(ANGLES_DEG[k]),
                    reached(runs.angles("true")[k]),
                )
            )
    ids = {
        "As published (°)": with_published(
            [f"t5_8_{pair}_est" for pair in PAIRS], len(rows)
        ),
        "Reference (°)": with_published(
            [f"t5_8_{pair}_ref" for pair in PAIRS], len(rows)
        ),
    }
    heads = ("Error level", "Faces", *ids, "True mirror (°)")
    return Table(
        columns(heads, rows),
        "Angles between the planes of the tin's faces: with the published calibration, "
        f"reference, and with the true mirror. Rig A. {MEDIANS}",
        printed=ids,
    )


@table("ext_tin_ways", needs=("table_5_8_runs",), evidence="rendered")
def ext_tin_ways(results):
    """Errors of angles, rays and planes, by mirror."""
    rows = []
    for level, way in ((b, w) for b in BENCHES for w in WAYS):
        runs = TinRuns(results, bench=level)
        found = runs.of("off_deg", way)
        rows.append(
            (
                LEVEL_NAMES[level],
                WAYS[way],
                int(np.isfinite(found).sum()),
                reached(runs.of("ray_deg", way)),
                reached(runs.of("rms_mm", way)),
                reached(found),
            )
        )
    heads = (
        "Error level",
        "Mirror",
        "Runs",
        "Mean ray error (°)",
        "Distance from planes, RMS (mm)",
        "Worst angle error (°)",
    )
    return Table(
        columns(heads, rows),
        "Errors of the rays, distances of points from their own planes, and error of "
        f"the worst of the three angles, by mirror. Rig A. {MEDIANS}",
    )


def of_runs(runs, found, unit):
    """Return the Value of a measure (runs,), and how many runs have none."""
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} runs were rejected" if lost else ""
    return Value.of_seeds(found, unit, reason)


@numbers("table_5_8", needs=("table_5_8_runs",), evidence="rendered")
def numbers_of_table_5_8(results):
    """Angles found and put in, and the largest difference."""
    runs = TinRuns(results)
    found, out = runs.angles(), {}
    for k, pair in enumerate(PAIRS):
        out[f"t5_8_{pair}_est"] = of_runs(runs, found[k], "deg")
        out[f"t5_8_{pair}_ref"] = Value(float(ANGLES_DEG[k]), unit="deg", put_in=SET)
    most = np.abs(runs.off()).max(axis=0)
    return out | {"t5_8_max": of_runs(runs, most, "deg")}


@numbers("fig_5_22", needs=("fig_5_22_pictures",), evidence="rendered")
def numbers_of_fig_5_22(results):
    """Translation of the camera, and matches on the tin in rendered images."""
    counts = results["fig_5_22_pictures"].column(LEVEL, "on_tin")
    return {
        "s5_3_5_tin_t": Value(SHIFT_MM, unit="mm", put_in=MOVED),
        "s5_3_5_tin_n": Value.of_seeds(counts, "count"),
    }


# Claims about the tin, tested as registered.


LEVELS = ("mirror_bench",)


@claim("c5_tin_angles", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_angles(results, options):
    """The largest of three differences from the reference is 2.5 degrees at most.

    Fixed before the run: the calibration is the published one, stage by stage; the
    motion between the images is known; run by run.
    """
    return TinRuns.judged_by_seed(results, options, angles_found)


@claim("c5_tin_normal", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_normal(results, options):
    """Correlation with a normal law of 0.99 or more, on each of the three faces.

    Fixed before the run: outliers, which the thesis sets apart, are distances beyond
    3.5 robust standard deviations of a face; published calibration, known motion.
    """
    return TinRuns.judged_by_seed(results, options, distances_normal)
