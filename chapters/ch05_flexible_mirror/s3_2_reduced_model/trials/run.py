"""One deflection of a mirror, calibrated with the reduced model (Fig. 5.7).

Corners and decoded points are projections by the true camera, with the errors of
rendered images. The rays of the primary curve give the board's pose, and its corners
are then projected into the plane.
"""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.plane import (
    ReducedCamera,
    distances_next_to,
    heights_next_to,
    in_plane,
    plane_normals,
)
from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.scan import (
    aligned,
    alone,
    scan_of,
)
from chapters.shared.mirror_bench import BENCHES, LEVEL
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, lattice, outline, primary, seen_board
from chapters.shared.mirror_scores import back_projection, lengths, ray_angles
from raxel.calibration.mirror.curves import DistanceCurve
from raxel.calibration.mirror.reduced import calibrate_reduced
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.errors import CalibrationError
from raxel.geometry import transform
from raxel.geometry.planes import on_plane

DEFLECTION_MM, DEPTH_MM = 7.98, 280.0
DEFLECTIONS_MM = 0.0, DEFLECTION_MM
# Minimum number of corners that both images show: fewer fit into the mirror at a larger
# distance.
MIN_N_CORNERS = 80
STRIP = 1 / 3  # of the mirror's height in the image: its middle strip
# px between the pixels whose rays are compared: about the thesis's 168 (Table 5.3).
COMPARED_PX = 168


class Way(NamedTuple):
    """A calibration: kind of curve, data of the primary curve, corners used."""

    curve: str = "distance"
    start: str = "normals"
    corners: str = "all"


PUBLISHED_WAY = "published"
WAYS = {
    PUBLISHED_WAY: Way(),
    "height": Way(curve="height"),
    "points": Way(start="points"),
    "strip": Way(corners="strip"),
}
OTHER_WAYS = tuple(way for way in WAYS if way != PUBLISHED_WAY)
SETTINGS = {
    "deflection_mm": DEFLECTION_MM,
    "depth_mm": DEPTH_MM,
    "least_corners": MIN_N_CORNERS,
    "strip": STRIP,
    "ways": {name: way._asdict() for name, way in WAYS.items()},
}


class Bent(NamedTuple):
    """One mirror before and after its deflection, and its images.

    cameras: the two true ones; first: Primary of the first one; pictures: two arrays
    (182, 2) px of the board's corners.
    """

    rig: object
    cameras: tuple
    first: object
    pictures: tuple

    @property
    def angle(self):
        """Angle of the u axis in the image, radians: perpendicular to the clamp."""
        return self.first.clamp.angle

    @property
    def clamp_u(self):
        """u of the clamp's line."""
        axis = np.array([np.cos(self.angle), np.sin(self.angle)])
        return float(np.mean(self.first.clamp.points @ axis))

    @property
    def points(self):
        """Corners (182, 2) of the board, mm."""
        return self.rig.board.points()

    @property
    def viewer(self):
        """The calibrated perspective camera."""
        return self.first.camera.viewer

    def camera(self, curve):
        """The calibrated camera with a curve."""
        return ReducedCamera(self.viewer, self.angle, curve)

    def span(self, k):
        """u at the clamp and at the free edge, of edges traced before (0) or after."""
        u = self.camera(None).u(outline(self.cameras[k]))
        ends = [float(u.min()), float(u.max())]
        return tuple(sorted(ends, key=lambda end: abs(end - self.clamp_u)))


def reduced_trial(condition, rng, errors, benches, ways):
    """Every measure of one deflection, at each of some error levels.

    Calibrated as published, and in the other `ways`, names of WAYS. Boards, poses of
    the monitor and errors have the same draws at all levels.
    """
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    boards = board_poses(rig, rng)
    of_rig = errors[condition["geometry"]]
    out = {}
    for name, bench in benches.items():
        these = of_rig.on(bench)
        try:
            bent = looked_at(rig, bench, these, seed, boards[0])
        except CalibrationError as refusal:
            refused = {"refused": refusal.code}
            out[name] = dict.fromkeys((PUBLISHED_WAY, *ways), refused)
            continue
        back = seen_board(rig, bent.cameras[1], boards[1], these, rng)
        out[name] = {way: scored(bent, WAYS[way]) for way in ways}
        out[name][PUBLISHED_WAY] = scored(bent, WAYS[PUBLISHED_WAY], back)
    return out


def curves_trial(condition, rng, errors):
    """Arrays of one trial at the primary level, for Fig. 5.7.

    x: (101,) mm from the clamp; heights (101,) mm of the mirror before and after, and
    of the three curves, above the true flat sheet, in the direction of the load.
    """
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    these = errors[condition["geometry"]].on(BENCHES[LEVEL])
    bent = looked_at(rig, BENCHES[LEVEL], these, seed, board_poses(rig, rng)[0])
    before, found = calibrated(bent, WAYS[PUBLISHED_WAY])
    scans = [scan_of(rig, camera, bent.angle) for camera in bent.cameras]
    along, way = (
        in_plane(bent.cameras[0].T_viewer_mirror[:3, axis], bent.angle)
        for axis in (0, 2)
    )
    foot = in_plane(bent.cameras[0].T_viewer_mirror[:3, 3], bent.angle)
    shapes = {"true_before": scans[0].points, "true_after": scans[1].points}
    for name, curve, scan in (
        ("before", before, scans[0]),
        ("linear", found.linear, scans[1]),
        ("final", found.curve, scans[1]),
    ):
        shapes[name] = curve.points(scan.points[:, 0] / scan.points[:, 1])
    return {
        name: np.stack([(points - foot) @ along, (points - foot) @ way])
        for name, points in shapes.items()
    }


def board_poses(rig, rng):
    """T_camera_board of the calibration board, and of one farther away."""
    return [
        rig.board_pose(rng, DEPTH_MM, DEFLECTIONS_MM, MIN_N_CORNERS),
        rig.board_pose(rng, BACK_PROJECTION_MM, (DEFLECTION_MM,)),
    ]


def looked_at(rig, bench, errors, seed, T_camera_board):
    """The Bent of one run: primary stage, and a board imaged before and after."""
    rng = np.random.default_rng(seed)
    cameras = tuple(rig.camera(mm, bench.aberration_um, seed) for mm in DEFLECTIONS_MM)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    pictures = tuple(
        seen_board(rig, camera, T_camera_board, errors, rng) for camera in cameras
    )
    return Bent(rig, cameras, first, pictures)


def before_bending(bent, way):
    """The primary curve, from viewing and scene rays (5.2.1)."""
    found = bent.first.calibration
    known = found.mirror.valid
    points = in_plane(found.mirror.points[known], bent.angle)
    viewing = bent.viewer.rays(found.pixels[known]).directions
    normals = plane_normals(viewing, found.mirror.directions[known], bent.angle)
    span = bent.span(0)
    if way.curve == "height":
        return heights_next_to(points, bent.clamp_u, span[1], normals)
    return distances_next_to(points, span, normals if way.start == "normals" else None)


def calibrated(bent, way):
    """The primary curve, and the ReducedCalibration after the deflection."""
    before = before_bending(bent, way)
    camera = bent.camera(before)
    first, second = bent.pictures
    T = pose_from_non_central_rays(camera.rays(first), bent.points).T_camera_grid
    points = in_plane(transform(T, on_plane(bent.points)), bent.angle)
    both = np.isfinite(first).all(axis=1) & np.isfinite(second).all(axis=1)
    if way.corners == "strip":
        both &= in_strip(bent, second)
    u, V_r = camera.u(second[both]), camera.plane_rays(camera.u(first[both]))
    start = before
    if way.curve == "distance":
        start = DistanceCurve(before.coefficients, bent.span(1))
    clamp = bent.clamp_u, float(before.distances([bent.clamp_u])[0])
    return before, calibrate_reduced(start, u, V_r, points[both], clamp)


def in_strip(bent, pixels):
    """Which pixels (N,) are in the middle strip of the bent mirror, clamp to edge."""
    upright = np.array([-np.sin(bent.angle), np.cos(bent.angle)])
    edges = outline(bent.cameras[1]) @ upright
    low, high = edges.min(), edges.max()
    from_middle = np.abs(pixels @ upright - (low + high) / 2)
    return np.nan_to_num(from_middle, nan=np.inf) < STRIP * (high - low) / 2


def scored(bent, way, back=None):
    """Errors of the primary curve, and of the linear and the final estimate.

    back: a board's pixels (182, 2) after the deflection; then rays and back-projection
    are scored too.
    """
    try:
        before, found = calibrated(bent, way)
        out = off_scans(bent, before, linear=found.linear, final=found.curve)
        if back is not None:
            out["final"]["angle_deg"] = mean_angle(bent, found.curve)
            camera = bent.camera(found.curve)
            own = lengths(back_projection(camera, back, bent.points))
            out["back"] = {"own_mm": float(np.mean(own))}
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    return out | {"residual_mm": float(np.mean(np.abs(found.residuals)))}


def off_scans(bent, before, **after):
    """Mean distances of the primary curve, and of those after, from the scans.

    camera_mm: in the camera's frame; shared_mm: with both scans aligned to the curve
    before; alone_mm: with each scan aligned to its curve; deflection_mm: at the load.
    """
    scans = [scan_of(bent.rig, camera, bent.angle) for camera in bent.cameras]
    off_before = scans[0].off(before)
    out = {}
    for name, curve in after.items():
        off = off_before, scans[1].off(curve)
        shared = aligned(scans, off)
        at_load = [o[scan.at_load] for o, scan in zip(off, scans, strict=True)]
        for stage, k in (("before", 0), (name, 1)):
            out[stage] = {
                "camera_mm": float(np.mean(np.abs(off[k]))),
                "shared_mm": float(np.mean(np.abs(shared[k]))),
                "alone_mm": float(np.mean(np.abs(alone(scans[k], off[k])))),
            }
        moved = DEFLECTION_MM + at_load[1] - at_load[0]
        out[name]["deflection_mm"] = float(moved)
    return out


def mean_angle(bent, curve):
    """Mean angle between calibrated and true rays after bending, degrees."""
    true = bent.cameras[1]
    pixels = lattice(true, COMPARED_PX)
    return float(np.nanmean(ray_angles(bent.camera(curve), true, pixels)))
