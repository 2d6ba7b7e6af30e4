"""Fig. 1.1, and the resolution of its unwrapped picture."""

import numpy as np

from chapters.ch01_introduction.s1_1_panorama.trials import (
    ECCENTRICITIES,
    RIG_MIRROR,
    T_world_camera,
    laboratory,
)
from chapters.shared.surroundings import drawn_surroundings
from raxel.lab import room
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

EXACT_PX = 1e-6
STRAIGHT_PX = 0.5
BORDER_COLUMNS = ("edge_column_px", "found_column_px", "deviation_px", "rows_found")
SCALES = {
    "area": ("Area", "Source per unwrapped pixel (px²)"),
    "along_row": ("Along a row", "Source per unwrapped pixel (px)"),
    "along_column": ("Along a column", "Source per unwrapped pixel (px)"),
}


@figure("fig_1_1", needs=("fig_1_1_picture",), evidence="rendered")
def fig_1_1(results):
    """(a) the picture in the mirror; (b) the same picture unwrapped."""
    ran = results["fig_1_1_picture"]
    picture, unwrapped, borders = (
        ran.arrays(name)[0] for name in ("picture", "unwrapped", "borders")
    )
    drawn, axes = new_figure(2, 1, height_in=7.4, height_ratios=(4.4, 2.9))
    titles = ("(a) picture in the mirror", "(b) unwrapped on a cylinder")
    for panel, image, title in zip(axes, (picture, unwrapped), titles, strict=True):
        panel.imshow(image, interpolation="antialiased")
        panel.set(title=title, xlabel="u (px)", ylabel="v (px)")
        panel.grid(False)
    row = ran.column("horizon_error_px").max()
    spread = ran.column("spread_px").max()
    off = borders[:, 2].max()
    exact = max(row, spread) < EXACT_PX
    return Drawing(
        drawn,
        dict(zip(BORDER_COLUMNS, borders.T, strict=True)),
        "A room in a hyperboloidal mirror: (a) as the camera below the "
        "mirror takes it, straight ahead on top; (b) the same picture, "
        "unwrapped on a cylinder about the mirror's focus through the "
        "camera's rays, straight ahead in the middle.",
        Check(
            bool(exact and off < STRAIGHT_PX),
            "projected into (a) and unwrapped with the pixel's ray, each "
            f"upright edge of the room keeps to one column to {spread:.0e} "
            f"px, the horizon to one row to {row:.0e} px; the "
            f"{len(borders)} upright borders found in (b) keep to one "
            f"column, each with a median deviation of at most {off:.2f} px",
        ),
    )


@figure("ext_fig_1_1_room", needs=("ext_rigs",), evidence="analytic", scene=True)
def ext_fig_1_1_room(results):
    """The room of Fig. 1.1 with its camera."""
    camera = laboratory(1.0).camera
    return drawn_surroundings(
        room(),
        camera,
        T_world_camera(camera),
        "The room of Fig. 1.1 from outside, two walls and the ceiling left "
        "out, and the camera in its middle. It looks straight up (z) into "
        "the mirror. Blue: the highest rays that come back from the mirror, "
        "cut off at one length; below them the camera sees all around. The "
        "camera is drawn larger than it is.",
    )


@figure("ext_fig_1_1_resolution", needs=("fig_1_1_resolution",), evidence="analytic")
def ext_fig_1_1_resolution(results):
    """Source pixels per unwrapped pixel against elevation."""
    ran = results["fig_1_1_resolution"]
    drawn, axes = new_figure(1, 3, height_in=3.6)
    rows = []
    for index, mirror in enumerate(ECCENTRICITIES):
        curves = {
            name: ran.arrays(name, mirror=mirror)[0]
            for name in ("elevation_deg", *SCALES)
        }
        for panel, name in zip(axes, SCALES, strict=True):
            panel.plot(
                curves["elevation_deg"],
                curves[name],
                label=label_of(ran, mirror) if name == "area" else None,
                markevery=60,
                **series(index),
            )
        rows += [(mirror, *cells) for cells in zip(*curves.values(), strict=True)]
    for panel, (title, label) in zip(axes, SCALES.values(), strict=True):
        panel.set(title=title, ylabel=label, xlabel="Elevation (deg)")
        panel.set(ylim=(0, None), xticks=np.arange(-50, 51, 25))
    drawn.legend(loc="outside lower center", ncols=2)
    return Drawing(
        drawn,
        columns(("mirror", "elevation_deg", *SCALES), rows),
        "How much of the picture one pixel of the unwrapped picture is "
        "made of, by its row: area, and length each way. All mirrors have "
        "the same rim in the world and in the picture; e is the "
        "eccentricity.",
    )


def label_of(ran, mirror):
    """Legend entry of a mirror, with its eccentricity."""
    e = ran.column("eccentricity", mirror=mirror)[0]
    shape = mirror.split()[0]
    shape = "mirror of Fig. 1.1" if mirror == RIG_MIRROR else shape
    return f"{shape}, e = {e:.2f}"
