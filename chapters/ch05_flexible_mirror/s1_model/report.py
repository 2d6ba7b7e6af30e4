"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch05_flexible_mirror.s1_model.experiment import ANCHORS, SHAPE, VALUES
from chapters.shared.mirror import DYNAMIC_MM, STAGES_MM, mirror_rig
from chapters.shared.mirror import lattice as pixel_lattice
from raxel.cameras import centrality
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from raxel.show import Arrows, Labels, Points, framed
from raxel.show.cameras import frustum, mirrors
from repro.page import INK, legend_below, new_figure, series, value
from repro.page.space import scene_figure
from repro.run import (
    Case,
    Check,
    Drawing,
    Reading,
    claim,
    columns,
    figure,
    median_interval,
    with_worst,
)

# Results of section 5.1 and the numbers that its page quotes.


BEAM = {
    "beam_compared": {
        "bent to the same deflection": "same_deflection",
        "by the same force": "same_force",
    }
}
# Squared slopes: the largest that the thesis states, and that of its usual deflection.
SMALL = 0.036
USUAL = 0.0036
MIN_PAIRS = -(-(SHAPE[0] * SHAPE[1] - 1) // 2)
"""ceil((K_f K_g - 1) / 2), two equations from each pair of rays (E-5.07)."""
OFF_ANCHOR = [number for number, factor in enumerate(ANCHORS) if factor != 1.0]


def compared_beams(result, options=None):
    """Differences (levels,) of elastica and cubic in a reading, and their levels."""
    name = Case(BEAM, options)["beam_compared"]
    levels = result.levels("slope2")
    found = [float(result.column(name, slope2=level)[0]) for level in levels]
    return np.array(levels), np.array(found)


def slope_over(result, key, name):
    """Log-log slope of a value over a condition's ``key``, and the values."""
    levels = result.levels(key)
    found = [float(np.mean(result.column(name, **{key: at}))) for at in levels]
    return float(np.polyfit(np.log(levels), np.log(found), 1)[0]), found


def rank_range(result, kind, pairs):
    """Smallest and largest rank over the trials of a number of pairs."""
    ranks = result.column(kind, pairs=pairs)
    return int(ranks.min()), int(ranks.max())


def name_values(open_results):
    """Name the numbers of the prose."""
    for name, number in quoted(open_results).items():
        value(name, number)


def quoted(open_results):
    """Name -> number, of what the prose quotes."""
    levels, found = compared_beams(open_results("exp_c5_beam_cubic"))
    shapes = open_results("exp_c5_shape_ambiguity")
    pairs = open_results("exp_c5_min_pairs")
    edges = open_results("exp_c5_edge_refine")
    usual, at_end = (
        float(found[np.argmin(abs(levels - slope2))]) for slope2 in (USUAL, SMALL)
    )
    return {
        "beam.usual": 100 * usual,
        "beam.end": 100 * at_end,
        "shapes.off": min(
            shapes.column(f"anchor_{n}.beyond_scale_mm")[0] for n in OFF_ANCHOR
        ),
        "pairs.random": float(np.median(pairs.column("random", pairs=MIN_PAIRS))),
        **{
            f"edge.{name}": float(np.nanmedian(edges.column(f"{name}_mm")))
            for name in ("pick.picked", "pick.refined")
        },
    }


# Figs 5.1 and 5.2, drawn with computed mirrors, and the error of the cubic beam.


FAINT = {"color": "#7a828c", "linewidth": 0.8, "marker": ""}
SHOWN = (2, 20, 38)
EXACT = 1e-4
WORDS = {0.9: "10 % nearer", 1.0: "true", 1.1: "10 % farther"}

# Fig. 5.1: rows and columns of corners that are drawn, and the sight from above.
SHOWN_CORNERS = (slice(2, None, 4), slice(3, None, 4))
BENT_MM, BODY_MM = 15.0, 60.0
SIGHT, UP = (-0.25, -0.9, -0.45), (0.0, 0.0, 1.0)


@figure("fig_5_1", needs=(), evidence="analytic", scene=True)
def fig_5_1(results):
    """Viewing rays to a bent mirror, and scene rays to the points that they see."""
    rig = mirror_rig("A")
    camera = rig.camera(BENT_MM)
    T = rig.board_pose(np.random.default_rng(0), DYNAMIC_MM, (BENT_MM,))
    points = transform(T, on_plane(rig.board.points()))
    lattice = points.reshape(rig.board.rows, rig.board.columns, 3)
    shown = lattice[SHOWN_CORNERS].reshape(-1, 3)
    pixels, seen = camera.project(shown)
    shown, met = shown[seen], camera.rays(pixels[seen])
    off = np.linalg.norm(np.cross(shown - met.origins, met.directions), axis=1).max()
    eye = np.zeros_like(shown)
    blue, orange = series(0)["color"], series(1)["color"]
    names = {"camera": [0, 0, 0], "mirror": met.origins[-1], "scene point": shown[-1]}
    parts = [
        frustum(camera.viewer, BODY_MM),
        *mirrors(camera, opacity=0.8),
        Arrows(eye, met.origins, blue, "viewing rays", 1.5),
        Arrows(met.origins, shown, orange, "scene rays", 1.5),
        Points(shown, INK, "scene points", 8.0),
        *(Labels(np.array([at], float), [name], INK) for name, at in names.items()),
    ]
    scene = framed(parts, SIGHT, up=UP, note=rig.rig.summary)
    traced = {
        f"{what}_{axis}_mm": places[:, k].tolist()
        for what, places in (("mirror", met.origins), ("point", shown))
        for k, axis in enumerate("xyz")
    }
    return Drawing(
        scene_figure(scene, height_in=4.2),
        traced,
        "Viewing rays and scene rays of a flexible mirror camera, rig A with its "
        "mirror pushed by 15 mm. Viewing rays go from the camera to the mirror, scene "
        "rays from there to the visible points. Scene rays have no common point.",
        Check(bool(off < EXACT), f"scene rays miss their points by {off:.0e} mm"),
        scene,
    )


@figure("fig_5_2", needs=("exp_c5_shape_ambiguity",), evidence="analytic")
def fig_5_2(results):
    """Mirrors that have the same rays, or the same scene points."""
    trial = results["exp_c5_shape_ambiguity"].select()
    points = trial.arrays("points")[0]
    curves = [trial.arrays(f"anchor_{n}.curve")[0] for n in range(len(ANCHORS))]
    true = curves[ANCHORS.index(1.0)]
    copies = [factor * true for factor in ANCHORS]
    drawn, (left, right) = new_figure(1, 2, height_in=4.6, sharex=True, sharey=True)
    left.set_title("(a) depth")
    right.set_title("(b) shape")
    rows = []
    for axes, kind, family in ((left, "depth", copies), (right, "shape", curves)):
        for n, (factor, mirror) in enumerate(zip(ANCHORS, family, strict=True)):
            look = {"color": INK} if factor == 1.0 else {"color": series(n)["color"]}
            axes.plot(*mirror.T, **look, marker="", linestyle="-", linewidth=2,
                      label=WORDS[factor])  # fmt: skip
            rows += [(kind, factor, *place) for place in mirror]
            for at in SHOWN:
                ray = points[at] - (true if kind == "depth" else mirror)[at]
                shown = 0.8 if kind == "depth" else 1.0
                way = np.array([[0, 0], mirror[at], mirror[at] + shown * ray])
                axes.plot(*way.T, **FAINT, linestyle="-")
        axes.set_aspect("equal")
        axes.set(xlabel="x (mm)")
    right.plot(*points[list(SHOWN)].T, **series(1) | {"linestyle": ""},
               label="scene point")  # fmt: skip
    left.set_ylabel("z (mm)")
    legend_below(drawn, right, ncols=4)
    offset = max(trial.column(f"anchor_{n}.offset_mm")[0] for n in range(len(ANCHORS)))
    return Drawing(
        drawn,
        columns(("ambiguity", "anchor", "x_mm", "z_mm"), rows),
        "Ambiguous mirrors, computed for a beam bent by 16.7 mm; the camera is at (0, "
        "0). (a) Known viewing and scene rays: a mirror and its scaled copies have the "
        "same directions. (b) Known viewing rays and scene points: a mirror at another "
        "distance shows the same points on the same viewing rays, with another shape.",
        Check(
            bool(offset < EXACT),
            f"scene points are within {offset:.0e} mm of the scene rays in (b)",
        ),
    )


@figure("ext_beam_cubic", needs=("exp_c5_beam_cubic",), evidence="analytic")
def ext_beam_cubic(results):
    """Difference of elastica and cubic over the largest squared slope."""
    result, rows = results["exp_c5_beam_cubic"], []
    drawn, axes = new_figure(height_in=3.6)
    for number, option in enumerate(BEAM["beam_compared"]):
        levels, found = compared_beams(result, {"beam_compared": option})
        axes.plot(levels, 100 * found, **series(number), label=option)
        rows += [(option, *row) for row in zip(levels, 100 * found, strict=True)]
    axes.axhline(2, color=INK, linestyle=":", marker="", label="2 %")
    axes.axvline(SMALL, color=INK, linestyle="--", marker="", label="0.036")
    axes.set(xscale="log", yscale="log", xlabel="Largest squared slope")
    axes.set_ylabel("Difference (% of tip deflection)")
    legend_below(drawn, axes, ncols=4)
    return Drawing(
        drawn,
        columns(("compared", "slope2", "difference_percent"), rows),
        "Largest difference of the beam's cubic (5.1) from the elastica, which is "
        "exact for any deflection, against the cubic's largest squared slope. Dashed: "
        "the largest squared slope that the thesis states.",
    )


# The claims of sections 5.1 and 5.2 that follow from the equations.


MAX_BEAM = 0.02
CLAIMS_EXACT, EXACT_MM = 1e-9, 1e-6
SAME_POINT_MM, ANOTHER_SHAPE_MM = 1e-4, 0.1
WORSE = 1e3
RAISED = 3.0
NOT_CENTRAL_MM, CENTRE_PX = 0.1, 64
INVERSE, PROPORTIONAL = (-1.1, -0.9), (0.95, 1.05)


@claim(
    "c5_beam_cubic",
    needs=("exp_c5_beam_cubic",),
    evidence="analytic",
    readings=("beam_compared",),
)
def judge_beam_cubic(results, options):
    """Test that elastica and cubic agree within 2 % up to a squared slope of 0.036."""
    levels, found = compared_beams(results["exp_c5_beam_cubic"], options)
    most = float(found[levels <= SMALL].max())
    beyond = levels[found >= MAX_BEAM]
    remark = f"2 % are reached at {beyond[0]:g}" if len(beyond) else "2 % not reached"
    return Reading.of(
        most < MAX_BEAM,
        100 * most,
        "%",
        f"largest difference over the deflection of the tip, at a squared slope of "
        f"{levels[levels <= SMALL][-1]:g} ({options['beam_compared']}); "
        f"{remark}",
    )


@claim("c5_depth_ambiguity", needs=("exp_c5_depth_ambiguity",), evidence="analytic")
def judge_depth_ambiguity(results):
    """Test that the rays leave one direction undetermined, the true mirror."""
    found = results["exp_c5_depth_ambiguity"]
    open_ones, off = found.column("open"), float(found.column("off").max())
    return Reading.of(
        bool(np.all(open_ones == 1)) and off < CLAIMS_EXACT,
        off,
        "1",
        f"largest distance of the null vector from the true coefficients, both of unit "
        f"length, in {len(open_ones)} mirrors; coefficients left open: "
        f"{open_ones.min():.0f} to {open_ones.max():.0f}",
    )


@claim("c5_shape_ambiguity", needs=("exp_c5_shape_ambiguity",), evidence="analytic")
def judge_shape_ambiguity(results):
    """Test that curves with another anchor show the same points and other shapes."""
    found = results["exp_c5_shape_ambiguity"]
    offset = max(found.column(f"anchor_{n}.offset_mm")[0] for n in range(len(ANCHORS)))
    apart = min(found.column(f"anchor_{n}.beyond_scale_mm")[0] for n in OFF_ANCHOR)
    return Reading.of(
        offset < SAME_POINT_MM and apart > ANOTHER_SHAPE_MM,
        float(apart),
        "mm",
        "least RMS distance from the true curve after the best scaling, anchored 10 % "
        f"nearer or farther; points lie within {offset:.0e} mm of their scene rays",
    )


@claim("c5_fix_removes", needs=("exp_c5_fix_removes",), evidence="analytic")
def judge_fix_removes(results):
    """Test that with one fixed point both stages recover the true mirror."""
    found = results["exp_c5_fix_removes"]
    linear, refined = (
        float(found.column(name).max()) for name in ("linear_mm", "refined_mm")
    )
    open_ones = found.column("open")
    return Reading.of(
        bool(np.all(open_ones == 0)) and max(linear, refined) < EXACT_MM,
        linear,
        "mm",
        f"largest error of a coefficient in {len(open_ones)} mirrors, linear stage; "
        f"refined from a start {found.column('start_mm').min():.2g} mm off or more: "
        f"{refined:.0e} mm",
    )


@claim("c5_min_pairs", needs=("exp_c5_min_pairs",), evidence="analytic")
def judge_min_pairs(results):
    """Test that ten well spread pairs, not nine, have full rank less one."""
    found = results["exp_c5_min_pairs"]
    full = int(found.column("size", pairs=MIN_PAIRS)[0]) - 1
    counts = found.levels("pairs")
    ranks = {n: rank_range(found, "spread", n) for n in counts}
    holds = all(
        low == high == full if n >= MIN_PAIRS else high < full
        for n, (low, high) in ranks.items()
    )
    random = float(np.median(found.column("random", pairs=MIN_PAIRS)))
    return Reading.of(
        holds,
        float(min(n for n, (low, _) in ranks.items() if low == full)),
        "count",
        f"least number of well spread pairs with rank {full} in all of "
        f"{found.trials_per_condition} mirrors; {max(counts)} pairs have rank "
        f"{ranks[max(counts)][1]}; {MIN_PAIRS} at random have rank {random:g} "
        "(median)",
    )


@claim("c5_end_knots", needs=("exp_c5_end_knots",), evidence="analytic")
def judge_end_knots(results):
    """Test that without features in an end interval the rank or condition degrades."""
    found = results["exp_c5_end_knots"]
    ranks, lost = [], []
    for condition in found.conditions:
        all_of_them, without = (
            found.column(f"{kind}.rank", **condition) for kind in ("all", "without")
        )
        worse = [
            found.column(f"{kind}.reciprocal", **condition)
            for kind in ("all", "without")
        ]
        ranks.append(without - all_of_them)
        lost.append((without < all_of_them) | (worse[0] > WORSE * worse[1]))
    return Reading.of(
        bool(np.all(lost)),
        float(-np.max(ranks)),
        "count",
        f"least loss of rank over {len(ranks)} ends (both of u with 7 x 3 functions, "
        f"both of u and of v with 7 x 5), {found.trials_per_condition} mirrors each",
    )


@claim("c5_lin_ok_far", needs=("exp_c5_lin_ok_far",), evidence="analytic")
def judge_far(results):
    """Test that the rotation of scene rays falls as one over a large depth."""
    slope, found = slope_over(results["exp_c5_lin_ok_far"], "depth", "angle_deg")
    return Reading.of(
        INVERSE[0] <= slope <= INVERSE[1],
        slope,
        "1",
        f"log-log slope from 10 to 100 camera distances; mean angle {found[0]:.2f} "
        f"to {found[-1]:.3f} deg",
    )


@claim("c5_aberr_depth", needs=("exp_c5_aberr_depth",), evidence="analytic")
def judge_aberration(results):
    """Test that a fixed rotation of the mirror displaces points by their depth."""
    slope, found = slope_over(results["exp_c5_aberr_depth"], "depth", "moved_mm")
    return Reading.of(
        PROPORTIONAL[0] <= slope <= PROPORTIONAL[1],
        slope,
        "1",
        f"log-log slope; a defect of 1 mrad moves what is seen by {found[0]:.2f} mm at "
        f"250 mm and {found[-1]:.0f} mm at 10 m",
    )


@claim(
    "c5_edge_refine",
    needs=("exp_c5_edge_refine",),
    evidence="synthetic",
    readings=("clamp_value",),
)
def judge_edges(results, options):
    """Test that picks with 1 px error triple the deflection error of refined ones."""
    found = results["exp_c5_edge_refine"]
    known = VALUES[options["clamp_value"]]
    picked, refined = (
        found.column(f"{known}.{name}_mm") for name in ("picked", "refined")
    )
    # A rejected stage has an infinite error.
    ratio = median_interval(with_worst(picked) / refined)
    refused = int(np.count_nonzero(np.isnan(picked)))
    return Reading.of(
        ratio.low >= RAISED,
        ratio,
        reason="error of a deflection of 5 mm with fixed points picked 1 px off over "
        f"that with points refined to a line; medians {np.nanmedian(picked):.3f} and "
        f"{np.nanmedian(refined):.3f} mm over {len(picked)} trials, {refused} of which "
        "are refused as picked",
    )


@claim("c5_noncentral", needs=(), evidence="analytic")
def judge_centre(results):
    """Test that scene rays of a bent mirror miss a common point by over 0.1 mm."""
    rig = mirror_rig("A")
    flat, off = (
        centrality(camera.rays(pixel_lattice(camera, CENTRE_PX)))
        for camera in map(rig.camera, STAGES_MM[:2])
    )
    return Reading.of(
        off > NOT_CENTRAL_MM,
        off,
        "mm",
        "RMS distance of the scene rays from their best common point, geometry A, "
        f"deflected by {STAGES_MM[1]:g} mm; flat {flat:.0e} mm",
    )
