"""Orders raised step by step, beyond where residuals are white: what each would give.

A fifth of the features is kept out of all fits and tells the kept-out error.
"""

import numpy as np

from chapters.ch05_flexible_mirror.ext_orders.trials.knots import CORNER_PX
from chapters.shared.mirror_bench import BENCH, BENCHES, Bench
from chapters.shared.mirror_errors import PHASES, DecodingPool, MirrorErrors
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    CLAMP_PICKS,
    CLAMP_SD_PX,
    PUBLISHED,
    calibrated_viewer,
    decoded,
    lattice,
    outline,
    poses_in_platter,
    seen_board,
)
from chapters.shared.mirror_scores import ray_angles
from raxel.calibration import SplineOrder, primary_by_order, stage_by_order
from raxel.calibration.mirror.clamp_line import clamp_line, fixed_line
from raxel.calibration.mirror.orders import rising
from raxel.calibration.mirror.whiteness import whiteness
from raxel.errors import CalibrationError
from raxel.geometry import transform
from raxel.geometry.planes import on_plane

# Standard deviation of a decoded point along each axis, where noise is white.
DECODED_MM = 0.01
WHITE = Bench(aberration_um=0.0)
CASES = {
    "smooth": WHITE,
    "uneven": WHITE._replace(aberration_um=BENCHES[BENCH].aberration_um),
    "bench": BENCHES[BENCH],
}
# Coefficients up to which orders are raised: where relief and no noise hides it, more.
MOST = {"smooth": 42, "uneven": 100, "bench": 64}
KEPT_OUT = 5  # one feature of so many
COMPARED_PX = 168
POOL = 4000  # deviates that white errors are drawn from
# What a step's row holds.
NAMES = ("functions_u", "functions_v", "degree", "residual_mm", "excess", "kept_mm",
         "angle_deg")  # fmt: skip
STAGES = ("primary", "stage")


def orders_trial(condition, rng, errors):
    """Rows (steps, NAMES) of the primary stage and of one of 5 mm after it; `white`:
    number of the first step whose residuals are white, -1 where there is none;
    `published`: the row of 7 x 3 quadratic functions, NaN where
    it is refused."""
    case = condition["case"]
    bench, seed = CASES[case], int(rng.integers(2**32))
    rig = mirror_rig(condition["geometry"])
    errors = errors[condition["geometry"]]._replace(factor=bench.factor)
    errors = errors if case == BENCH else white_errors(rng)
    flat, bent = (rig.camera(mm, bench.aberration_um, seed) for mm in STAGES_MM[:2])
    viewer, true = calibrated_viewer(rig, errors, rng), rig.monitor_poses(rng)
    T = poses_in_platter(rig, viewer, true, errors, rng).T_camera_grid
    line = clamp_line(viewer, rig.clamp_pixels(flat, CLAMP_PICKS, rng, CLAMP_SD_PX))
    pixels, points = decoded(rig, flat, true, errors, rng)
    out = rng.permutation(len(pixels)) % KEPT_OUT == 0
    calibrate = primary_by_order(
        viewer, pixels[~out], points[:, ~out], T, angle=line.angle,
        quantity=PUBLISHED.quantity, span=line.points(CLAMP_PICKS),
    )  # fmt: skip

    def kept_of_monitor(found):
        return np.concatenate(
            [off_mm(found.camera, pixels[out], transform(pose, on_plane(xy[out])))
             for pose, xy in zip(T, points, strict=True)]
        )  # fmt: skip

    first, camera = followed(calibrate, condition["most"], kept_of_monitor, flat)
    board = rig.board.points()
    pose = rig.board_pose(rng, deflections=STAGES_MM[:2])
    before, after = (seen_board(rig, c, pose, errors, rng) for c in (flat, bent))
    out = rng.permutation(len(board)) % KEPT_OUT == 0
    calibrate = stage_by_order(
        camera, before, np.where(out[:, None], np.nan, after), board,
        fixed_line(camera, line)._replace(slopes=None), outline=outline(bent),
    )  # fmt: skip

    def kept_of_board(found):
        placed = transform(found.pose.T_camera_grid, on_plane(board))
        return off_mm(found.camera, after[out], placed[out])

    try:
        second = followed(calibrate, condition["most"], kept_of_board, bent)[0]
    except CalibrationError as refusal:
        second = {"refused": str(refusal)}
    return {"primary": first, "stage": second}


def white_errors(rng):
    """MirrorErrors that are independent and Gaussian."""
    corner = rng.normal(0, CORNER_PX, (2, POOL, 2))
    points = rng.normal(0, DECODED_MM, (2, POOL, 2))
    pools = [DecodingPool(np.zeros((2, PHASES)), rest, np.ones(2)) for rest in points]
    return MirrorErrors(*corner, *pools)


def followed(calibrate, most, kept, true):
    """What each order gave, and the camera of the first whose residuals are white, or
    else of the last.

    calibrate: of a SplineOrder; kept: of a calibration the kept-out distances, mm;
    true: the true camera.
    """
    pixels = lattice(true, COMPARED_PX)

    def row(order, found, variance, excess):
        off = ray_angles(found.camera, true, pixels)
        return [
            *order.shape, order.degree[0], np.sqrt(variance), excess,
            np.sqrt(np.nanmean(kept(found) ** 2) / 2), np.nanmean(off),
        ]  # fmt: skip

    rows, white, camera = [], -1, None
    for step in rising(calibrate):
        if rows and step.order.size > most:
            break
        if white < 0:
            camera = step.found.camera
            white = len(rows) if step.whiteness.white else -1
        excess = step.whiteness.excess
        rows.append(row(step.order, step.found, step.variance, excess))
    found = {"rows": np.array(rows), "white": white}
    order = SplineOrder(PUBLISHED.shape)
    try:
        published, fitted = calibrate(order)
    except CalibrationError:
        return found | {"published": np.full(len(NAMES), np.nan)}, camera
    last = row(order, published, fitted.variance, whiteness(fitted).excess)
    return found | {"published": np.array(last)}, camera


def off_mm(camera, pixels, points):
    """Distances (N,), mm, of points (N, 3) from the rays of pixels (N, 2), NaN where
    there is none."""
    rays = camera.rays(pixels)
    way = points - rays.origins
    along = np.sum(way * rays.directions, axis=1)[:, None] * rays.directions
    return np.linalg.norm(way - along, axis=1)
