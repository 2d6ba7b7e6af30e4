"""What a mirror's pictures can get wrong without a calibration noticing by itself.

Each is refused, or flagged in one line: never a confident wrong shape.
"""

import numpy as np

from raxel.calibration.mirror.sightings import normalised
from raxel.errors import CalibrationError, InputError

# mm between two places of the monitor: nearer, they are one, or tell of no directions.
NEAREST_MM = 10.0
# The least share of pixels that see another point of the monitor in its other place,
# and by how many mm another.
OTHERS, OTHER_MM = 0.5, 1.0
# How far the clamp's line may lie outside what sees the monitor, and how much of that
# may lie beyond the line, and beyond one that stands in for a hidden clamp: shares of
# its extent along u, and of its pixels.
OUTSIDE, BEYOND, BEYOND_HIDDEN = 0.1, 0.02, 0.15
# Mean angles that residuals of a stage stand for. Smooth sheets leave 0.015 degrees. Of
# a board that was moved the shape takes up most: 6 mm, 260 mm before the mirror, leave
# 0.015 to 0.06, and a millimetre cannot be told from a bend.
LARGE_DEG, WRONG_DEG = 0.02, 0.25
# Of the first shape's picture along u: a stage that shows less says so.
MOST_OF_IT = 0.8


def check_apart(poses, grids):
    """Refuse a place of the monitor that the platter shows twice.

    poses: PlatterPoses; grids: views of the monitor in the mirror, in their order.
    """
    middle = np.mean(grids[0].points[np.isfinite(grids[0].pixels[:, 0])], axis=0)
    for first, second in _pairs(grids):
        moved = poses.motion(first, second, middle).distance
        if moved < NEAREST_MM:
            raise CalibrationError(
                f"primary calibration: {_named(grids, first, second)} are one place of "
                f"the monitor, {moved:.1f} mm apart in the platter; move it by some "
                "100 mm between them",
                code="same-place",
            )


def check_two_pictures(points, grids):
    """Refuse a monitor that the bending mirror shows twice in one place.

    points: (n, N, 2) mm, what pixels see of each grid, NaN where nothing.
    """
    for first, second in _pairs(grids):
        apart = np.linalg.norm(points[first] - points[second], axis=1)
        apart = apart[np.isfinite(apart)]
        if len(apart) and np.mean(apart > OTHER_MM) < OTHERS:
            raise CalibrationError(
                f"primary calibration: pixels see the same points of the monitor in "
                f"{_named(grids, first, second)}; photograph its patterns in the "
                "mirror at both places",
                code="same-points",
            )


def check_beside(line, viewer, grids, hidden=False):
    """Refuse a ClampLine that lies away from the mirror, or across it; hidden: whether
    it stands in for a clamp that cannot be seen."""
    pixels = np.concatenate([view.pixels for view in grids])
    p = normalised(viewer, pixels[np.isfinite(pixels[:, 0])])
    axis = np.array([np.cos(line.angle), np.sin(line.angle)])
    off = (p - line.ends.mean(axis=0)) @ axis
    off = off * (1.0 if np.median(off) > 0 else -1.0)
    # A few pixels at the border are decoded wrongly.
    nearest, extent = np.quantile(off, 0.005), np.ptp(off)
    if nearest > OUTSIDE * extent:
        raise InputError(
            f"clamp: its line lies {100 * nearest / extent:.0f} % of the mirror's "
            "length away from where the mirror shows the monitor; pick it at the edge "
            "of the mirror, and let the monitor fill the mirror"
        )
    beyond = np.mean(off < 0)
    if beyond > (BEYOND_HIDDEN if hidden else BEYOND):
        raise InputError(
            f"clamp: {100 * beyond:.0f} % of the pixels that see the monitor lie "
            "beyond its line; pick it where the mirror is held, at the mirror's edge"
        )


def misfit_flags(stage, step, degrees):
    """Flags (list) for residuals (N,), degrees, that no noise explains.

    step: StepViews. Raises CalibrationError where they are so large that the shape is
    none.
    """
    mean = np.mean(degrees) if len(degrees) else np.inf
    if mean < LARGE_DEG:
        return []
    found = (
        f"corners lie {mean:.2g} deg (mean) from their rays: did the board, the "
        "viewer or the clamp move between the pictures, or is the step too large?"
    )
    if mean > WRONG_DEG:
        names = f"{step.before.name}, {step.after.name}"
        raise CalibrationError(
            f"step {stage} ({names}): {found}", code="moved-between-images"
        )
    return [f"stage {stage}: {found}"]


def short_of_the_edge(cameras):
    """Flags (list) for stages whose corners show a part of the mirror only.

    cameras: SplineMirrorCameras of the stages, the first of which shows all.
    """
    flags = []
    for k, camera in enumerate(cameras[1:], 1):
        spans = [np.ptp(one.grid.breaks[0]) for one in (camera, cameras[0])]
        if spans[0] < MOST_OF_IT * spans[1]:
            flags.append(
                f"stage {k}: common corners reach over {100 * spans[0] / spans[1]:.0f} "
                "% of the mirror's picture from the clamp on; towards the free edge "
                "it has no rays"
            )
    return flags


def _pairs(grids):
    count = len(grids)
    return [(i, j) for i in range(count) for j in range(i + 1, count)]


def _named(grids, first, second):
    return f"{grids[first].name} and {grids[second].name}"
