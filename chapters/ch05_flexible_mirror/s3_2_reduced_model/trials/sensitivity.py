"""Effect of a primary error on the surface after a deflection (5.3.2).

The primary curve is the best fit to the true mirror, changed by an error of known size;
viewing rays, corners and clamp are exact. The rest is as in `run.calibrated`: the rays
of the curve give the board's pose, and the clamp is fixed on the curve.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.plane import (
    ReducedCamera,
    distances_next_to,
    in_plane,
)
from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.run import (
    DEFLECTIONS_MM,
    DEPTH_MM,
    MIN_N_CORNERS,
)
from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.scan import scan_of
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import CLAMP_PICKS, outline
from raxel.calibration.mirror.clamp_line import clamp_line
from raxel.calibration.mirror.curves import DistanceCurve
from raxel.calibration.mirror.reduced import calibrate_reduced
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.errors import CalibrationError
from raxel.geometry import transform
from raxel.geometry.planes import on_plane

# Mean distances of the changed curve from the best fit, mm.
INJECTED_MM = (0.0, 0.1, 0.2, 0.4, 0.8)
# Kinds of error: orders of Legendre polynomials along the mirror.
KINDS = {"shift": (0,), "tilt": (1,), "bend": (2,), "all": (0, 1, 2, 3)}


def sensitivity_trial(condition, rng):
    """Errors (levels,) mm after a deflection, for INJECTED_MM before it.

    kind: of the error, see KINDS; its parts are drawn from a normal distribution, and
    are the same at all levels. `final_mm`: mean distance of the final curve from the
    true mirror; `before_mm`: that of the primary curve; NaN where rejected.
    """
    rig = mirror_rig(condition["geometry"])
    cameras = [rig.camera(mm) for mm in DEFLECTIONS_MM]
    T = rig.board_pose(rng, DEPTH_MM, DEFLECTIONS_MM, MIN_N_CORNERS)
    orders = KINDS[condition["kind"]]
    parts = np.zeros(4)
    parts[list(orders)] = rng.standard_normal(len(orders))
    line = clamp_line(rig.viewer, rig.clamp_pixels(cameras[0], CLAMP_PICKS))
    scans = [scan_of(rig, camera, line.angle) for camera in cameras]
    spans = [span_of(rig, camera, line) for camera in cameras]
    true = distances_next_to(scans[0].points, spans[0])
    pictures = [np.where(s[:, None], p, np.nan)
                for p, s in (rig.corners(camera, T) for camera in cameras)]  # fmt: skip
    before, final = np.full((2, len(INJECTED_MM)), np.nan)
    for level, size_mm in enumerate(INJECTED_MM):
        curve = moved(true, scans[0], parts, size_mm)
        before[level] = np.mean(np.abs(scans[0].off(curve)))
        try:
            found = deflected_from(curve, spans[1], rig, line, pictures)
        except CalibrationError:
            continue
        final[level] = np.mean(np.abs(scans[1].off(found)))
    return {"before_mm": before, "final_mm": final}


def span_of(rig, camera, line):
    """u at the clamp and at the free edge of a true camera's mirror."""
    edges = ReducedCamera(rig.viewer, line.angle, None).u(outline(camera))
    return tuple(sorted([edges.min(), edges.max()], key=lambda u: abs(u - at(line))))


def at(line):
    """u of the clamp's line."""
    return float(
        np.mean(line.points(CLAMP_PICKS) @ [np.cos(line.angle), np.sin(line.angle)])
    )


def moved(curve, scan, parts, size_mm):
    """A DistanceCurve with a mean error of `size_mm`, perpendicular to the scan.

    parts: (4,) Legendre coefficients, from clamp to free edge, of the change of its
    distances.
    """
    powers = np.polynomial.legendre.leg2poly(parts)
    change = np.pad(powers, (0, 4 - len(powers)))
    off = scan.off(curve.replaced(curve.coefficients + change)) - scan.off(curve)
    # Distances along viewing rays are linear in the coefficients, and so is the error.
    scale = size_mm / np.mean(np.abs(off))
    return curve.replaced(curve.coefficients + scale * change)


def deflected_from(before, span, rig, line, pictures):
    """The curve after a deflection; pictures: pixels (182, 2) before and after."""
    camera, points = ReducedCamera(rig.viewer, line.angle, before), rig.board.points()
    first, second = pictures
    T = pose_from_non_central_rays(camera.rays(first), points).T_camera_grid
    both = np.isfinite(first + second).all(axis=1)
    clamp = at(line), float(before.distances([at(line)])[0])
    return calibrate_reduced(
        DistanceCurve(before.coefficients, span),
        camera.u(second[both]),
        camera.plane_rays(camera.u(first[both])),
        in_plane(transform(T, on_plane(points)), line.angle)[both],
        clamp,
    ).curve
