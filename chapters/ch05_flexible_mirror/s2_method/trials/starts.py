"""From which starts does the refinement of a deflection end in one place? (5.2.2)

A mirror is bent by 5 mm and refined on the same features from three starts: the linear
estimate, as published; the true surface, which no calibration knows; and the surface as
it was before, which needs no linear stage.
"""

import numpy as np

from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_runs import (
    PUBLISHED,
    deflected,
    lattice,
    primary,
    seen_board,
)
from chapters.shared.mirror_scores import load_height
from raxel.calibration.mirror.refine import refine_shape
from raxel.calibration.mirror.sightings import magnification, normalised
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry import transform
from raxel.geometry.planes import on_plane

# px between the mirror points that a start is fitted to.
FITTED_PX = 64
STEP_MM = STAGES_MM[:2]


def one_deflection(rig, bench, errors, seed):
    """End of each start: cost (mm^2), deflection (mm), number of steps.

    `refused` is the code of a run or a start without a value.
    """
    rng = np.random.default_rng(seed)
    uneven = {"aberration_um": bench.aberration_um, "seed": seed}
    flat, bent = (rig.camera(deflection, **uneven) for deflection in STEP_MM)
    first = primary(rig, flat, PUBLISHED, errors, rng)
    T = rig.board_pose(rng, deflections=STEP_MM)
    pictures = [seen_board(rig, camera, T, errors, rng) for camera in (flat, bent)]
    board = rig.board.points()
    try:
        stage = deflected(first.camera, bent, pictures, board, first.clamp, PUBLISHED)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    starts = {
        "linear": stage.linear,
        "true": on_knots_of(stage.camera, bent),
        "before": on_knots_of(stage.camera, first.camera),
    }
    height = load_height(rig, first.camera, flat)
    found = {"common": int(np.count_nonzero(stage.used))}
    for name, start in starts.items():
        found[name] = {"start_mm": load_height(rig, start, bent) - height}
        try:
            camera, fit = refined(start, stage, pictures[1], board, first.clamp)
        except CalibrationError as refusal:
            found[name]["refused"] = refusal.code
            continue
        found[name] |= {
            "deflection_mm": load_height(rig, camera, bent) - height,
            "cost_mm2": float(np.sum(fit.residuals**2)),
            "steps": len(fit.costs) - 1,
        }
    return found


def on_knots_of(camera, other):
    """The spline on a calibrated camera's knots that is nearest to another's mirror."""
    points = other.rays(lattice(other, FITTED_PX)).origins
    return SplineMirrorCamera.fitted(
        camera.viewer, camera.grid, points, camera.quantity
    )


def refined(start, stage, pixels, board, clamp):
    """(SplineMirrorCamera, ShapeFit) from a start, on the features of a MirrorUpdate.

    pixels: (N, 2) after bending; board: (N, 2) mm.
    """
    viewer, used = start.viewer, stage.used
    placed = transform(stage.pose.T_camera_grid, on_plane(board))
    noise = PUBLISHED.settings.noise_px / np.median(magnification(viewer, pixels[used]))
    fit = refine_shape(
        normalised(viewer, pixels[used]),
        placed[used],
        start.grid,
        start.quantity,
        start.coefficients.ravel("F"),
        noise=noise,
        clamp=clamp,
    )
    found = SplineMirrorCamera.on_grid(
        viewer, start.grid, fit.coefficients, start.quantity
    )
    return found, fit
