"""Covered mirror and condition of the data matrix at each step of the loop.

The loop is that of Table 5.5: a board in another pose at each step out, one fixed board
on the way back. The boards are the same at each error level.
"""

import numpy as np
from scipy.spatial import ConvexHull

from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import (
    LOOP,
    OUT,
    boards_of_loop,
)
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.calibration.mirror.clamp import clamped
from raxel.calibration.mirror.linear import orthogonality_rows, reflection_normals
from raxel.calibration.mirror.sightings import normalised
from raxel.errors import CalibrationError
from raxel.geometry import inverse_pose, transform


def conditioning_trial(condition, rng, errors, benches):
    """Both measures of every step, at each of some error levels."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    out, stay = boards_of_loop(rig, rng)
    of_rig, boards = errors[condition["geometry"]], [*out, *(stay,) * OUT]
    return {
        name: visible_in_steps(rig, bench, of_rig.on(bench), boards, seed)
        for name, bench in benches.items()
    }


def visible_in_steps(rig, bench, errors, boards, seed):
    """{step: {covered, reciprocal}} of a loop; `refused` is the code of a rejection.

    covered: share of the sheet within the convex hull of the common corners, where they
    are seen after the step; reciprocal: smallest over largest singular value of the
    equilibrated data matrix of the linear stage (5.22, 5.23).
    """
    rng = np.random.default_rng(seed)
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    before, found = first.camera, {}
    for number, T in enumerate(boards, 1):
        ends = [cameras[stage] for stage in LOOP[number - 1 : number + 1]]
        pictures = [seen_board(rig, camera, T, errors, rng) for camera in ends]
        try:
            stage = deflected(
                before, ends[1], pictures, rig.board.points(), first.clamp, PUBLISHED
            )
        except CalibrationError as refusal:
            return found | {"refused": refusal.code}
        common = [pixels[stage.used] for pixels in pictures]
        found[f"step{number}"] = {
            "swing_deg": stage.swing_deg,
            "covered": covered_share(ends[1], common[1]),
            "reciprocal": reciprocal_condition(
                before, stage.linear, common, first.clamp
            ),
        }
        before = stage.camera
    return found


def covered_share(true, pixels):
    """Share of a true camera's sheet that the hull of what pixels (N, 2) see covers."""
    points = transform(inverse_pose(true.T_viewer_mirror), true.rays(pixels).origins)
    mirror = true.mirror
    # In two dimensions `volume` is the hull's area.
    return float(
        ConvexHull(points[:, :2]).volume / (2 * mirror.half_width * mirror.end)
    )


def reciprocal_condition(before, linear, common, clamp):
    """Of the matrix that a linear stage solved, in the clamp's subspace.

    before: the camera before the step; linear: what the stage gave; common: pixels
    (N, 2) of the common corners before and after.
    """
    p = normalised(linear.viewer, common[1])
    viewing = np.column_stack([p, np.ones(len(p))])
    normals = reflection_normals(viewing, before.rays(common[0]).directions)
    rows = orthogonality_rows(p, normals, linear.grid, linear.quantity)
    rows = rows @ clamped(linear.grid, clamp).directions
    size = np.linalg.svd(rows / np.linalg.norm(rows, axis=0), compute_uv=False)
    return float(size[-1] / size[0])
