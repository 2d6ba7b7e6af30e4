"""Fig. 4.5, and what of each picture is calibrated."""

import numpy as np
from matplotlib.colors import ListedColormap

from chapters.ch04_central_generic.s3_1_setup.results import CAMERAS, FIELD
from chapters.shared.central_sets import LINEAR_GRIDS
from chapters.shared.rigs import rig_named
from raxel.show.rigs import drawn_poses, posed_targets
from repro.page.space import scene_figure
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

SEED = 0
SHADES = ("#d5d9de", "#56b4e9", "#0072b2", "#e69f00", "#d55e00", "#7a3b00")


@figure("fig_4_5", needs=(), evidence="analytic", scene=True)
def fig_4_5(results):
    """The camera below its mirror, and the three grids of the linear stage."""
    rig = rig_named("onevr-d70")
    poses = drawn_poses(rig, SEED)[:LINEAR_GRIDS]
    count = len(poses)
    scene = posed_targets(
        rig.camera, [rig.target] * count, poses, ["calibrate"] * count, rig.summary
    )
    corner, size = rig.extent
    middles = poses[:, :3] @ [*(corner + size / 2), 0, 1]
    data = {"grid": list(range(1, len(poses) + 1))} | {
        f"{axis}_mm": middles[:, k].tolist() for k, axis in enumerate("xyz")
    }
    seen = sum(bool(rig.shows(T)) for T in poses)
    return Drawing(
        scene_figure(scene, height_in=4.6),
        data,
        "The omnidirectional camera of the rig onevr-d70 in its own frame: the z "
        "axis leads from a D70-like camera ahead to the mirror (in the room: up), "
        "and the monitor where the three grids of the linear stage stand. Blue: the "
        "edge of the field of view. The bracket between camera and mirror is not "
        "drawn; it holds the mirror 1 mm off its place.",
        Check(seen == len(poses), f"{seen} of {len(poses)} grids are in view"),
        scene,
    )


@figure("ext_fig_4_5_coverage", needs=("sec_4_3_1_field",), evidence="rendered")
def ext_fig_4_5_coverage(results):
    """How many grids each pixel has seen, of the first set of each camera."""
    result = results[FIELD]
    drawn, axes = new_figure(1, 2, height_in=3.4)
    rows = []
    shades = ListedColormap(["#ffffff", *SHADES])
    most = len(SHADES) - 1
    for panel, camera in zip(axes, CAMERAS.values(), strict=True):
        count = result.select(camera=camera).arrays("count")[0]
        shown = panel.imshow(
            np.minimum(count, most), cmap=shades, vmin=-1.5, vmax=most + 0.5,
            interpolation="nearest",
        )  # fmt: skip
        panel.set(title=camera, xticks=[], yticks=[])
        inside = count[count >= 0]
        rows += [
            (camera, grids, float(np.mean(inside == grids)))
            for grids in range(inside.max() + 1)
        ]
    bar = drawn.colorbar(shown, ax=axes, shrink=0.8, ticks=range(most + 1))
    bar.ax.set_ylim(-0.5, most + 0.5)
    bar.ax.set_yticklabels([*range(most), f"{most} or more"])
    bar.set_label("grids (1)")
    return Drawing(
        drawn,
        columns(("camera", "grids", "share_of_pixels"), rows),
        "How many grids were decoded in each pixel, of the first rendered set. "
        "White: no ray, beside the mirror or the fisheye's circle. The CSV has the "
        "shares of the pixels that have a ray.",
    )
