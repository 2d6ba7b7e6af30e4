"""Figs 5.1 and 5.2, drawn with computed mirrors, and the error of the cubic beam."""

import numpy as np

from chapters.ch05_flexible_mirror.s1_model.results import BEAM, SMALL, compared_beams
from chapters.ch05_flexible_mirror.s1_model.trials.plane import ANCHORS
from chapters.shared.mirror_rigs import DYNAMIC_MM, mirror_rig
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from raxel.show import Arrows, Labels, Points, framed
from raxel.show.cameras import frustum, mirrors
from repro.page.space import scene_figure
from repro.page.style import INK, legend_below, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

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
