"""Trials of this page, their conditions and constants."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chapters.shared.mirror import (
    ABERRATION_UM,
    BACK_PROJECTION_MM,
    BENCHES,
    CLAMP_PICKS,
    LEVEL,
    PUBLISHED,
    back_projection,
    board_image,
    lattice,
    lengths,
    mirror_rig,
    outline,
    primary,
    ray_angles,
    seen_board,
)
from raxel.calibration import (
    DistanceCurve,
    HeightCurve,
    calibrate_reduced,
    clamp_line,
    normalised,
    pose_from_non_central_rays,
)
from raxel.cameras import Rays
from raxel.errors import CalibrationError
from raxel.geometry import on_plane, transform
from raxel.sets import Chessboard

# A chessboard 5 m away in a smooth and an uneven mirror, rendered (Fig. 5.6).


DEPTH_MM = 5000.0
# Columns, rows and pitch, mm, of a board large enough to be visible at 5 m.
BOARD = 24, 24, 120.0
# Strain from cutting at the free edges is as high as the unevenness: the thesis
# mentions it (5.3.3) without its size.
STRAIN_UM = ABERRATION_UM
# mm from the mirror at which rays are compared; px between them.
DEPTHS_MM, STEP_PX = (280.0, 1000.0, DEPTH_MM), 16
SETTINGS = {
    "depth_mm": DEPTH_MM,
    "board": list(BOARD),
    "aberration_um": ABERRATION_UM,
    "strain_um": STRAIN_UM,
}


def image_trial(condition, rng):
    """Two images (h, w) uint8 of one board, and its displacement in the uneven mirror.

    moved.<depth>: mean displacement, mm, of the point that a pixel sees at a depth. The
    camera is the small one, the same lens with 768 x 576 pixels.
    """
    rig = mirror_rig(condition["geometry"], small=True)
    rig = replace(rig, rig=replace(rig.rig, target=Chessboard(*BOARD)))
    seed = int(rng.integers(2**32))
    even, uneven = rig.camera(0.0), rig.camera(0.0, ABERRATION_UM, seed, STRAIN_UM)
    T = rig.board_pose(rng, DEPTH_MM)
    moved = {f"{depth:g}": aside(even, uneven, depth) for depth in DEPTHS_MM}
    return {
        "even": board_image(rig, even, T, rng).image,
        "uneven": board_image(rig, uneven, T, rng).image,
        "moved": moved,
    }


def aside(even, uneven, depth):
    """Mean distance (mm) of the rays of one mirror from points on those of the other.

    depth: mm along the even mirror's rays.
    """
    pixels = lattice(even, STEP_PX)
    first, second = even.rays(pixels), uneven.rays(pixels)
    away = first.origins + depth * first.directions - second.origins
    along = np.sum(away * second.directions, axis=1, keepdims=True)
    return float(np.nanmean(np.linalg.norm(away - along * second.directions, axis=1)))


# The plane of the reduced model, and the camera that its curve makes (5.3.2).
#
# The plane is perpendicular to the clamp's line in the image: coordinates are rotated
# about the principal axis until that line is vertical, and then the vertical one is
# dropped. Nothing is lost for a mirror whose rulings are parallel to the image plane:
# seen along the rulings, reflection at it is reflection at a curve. Points and
# directions of the plane are rows (x, z), in mm.


class ReducedCamera(NamedTuple):
    """A camera that views a mirror with the same curve at every height.

    angle: of the u axis in the image, radians; curve: a DistanceCurve or HeightCurve.
    """

    viewer: object
    angle: float
    curve: object

    def u(self, pixels):
        """Coordinates u (N,) of pixels (N, 2), NaN where there is no pixel."""
        return normalised(self.viewer, pixels) @ _axes(self.angle)[0, :2]

    def plane_rays(self, u):
        """Unit directions (N, 2) of the scene rays in the plane, NaN where u is."""
        known = np.isfinite(u)
        out = np.full((len(u), 2), np.nan)
        out[known] = self.curve.scene_rays(u[known])
        return out

    def rays(self, pixels):
        """Rays of pixels (N, 2), in the viewer's frame: the curve moved upwards."""
        axes = _axes(self.angle)
        view = self.viewer.rays(pixels).directions @ axes.T
        known = np.isfinite(view).all(axis=1)
        x, y, z = view[known].T
        S, tangents = self.curve.points(x / z), self.curve.tangents(x / z)
        n = np.column_stack([-tangents[:, 1], 0 * x, tangents[:, 0]])
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        away = view[known] - 2 * np.sum(view[known] * n, axis=1, keepdims=True) * n
        origins, directions = np.full((2, len(view), 3), np.nan)
        origins[known] = np.column_stack([S[:, 0], y / z * S[:, 1], S[:, 1]]) @ axes
        directions[known] = away @ axes
        return Rays(origins, directions, known)


def in_plane(points, angle):
    """Rows (x, z) (N, 2) of points or directions (N, 3) in the viewer's frame."""
    return np.asarray(points) @ _axes(angle)[[0, 2]].T


def plane_normals(viewing, scene, angle):
    """Normals (N, 2), unit, between viewing and scene rays (N, 3), unit (5.8).

    The components of both rays along the rulings are equal and cancel.
    """
    normals = in_plane(viewing - scene, angle)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def distances_next_to(points, span, normals=None):
    """The DistanceCurve of mirror points (N, 2); span: u at clamp and free edge.

    normals: (N, 2), then the points give its scale alone, and the normals its shape
    (5.15, 5.16), as published; without them it is fitted to the points' distances.
    """
    curve = DistanceCurve(np.zeros(4), span)
    u, distances = points[:, 0] / points[:, 1], np.linalg.norm(points, axis=1)
    powers = np.vander(2 * curve.fraction(u) - 1, 4, increasing=True)
    if normals is None:
        return curve.replaced(np.linalg.lstsq(powers, distances, rcond=None)[0])
    rows, _ = curve.slope_equations(u, normals)
    shape = np.linalg.svd(rows, full_matrices=False)[2][-1]
    scale = (powers @ shape) @ distances / np.sum((powers @ shape) ** 2)
    return curve.replaced(scale * shape)


def heights_next_to(points, clamp, free, normals):
    """The HeightCurve of points (N, 2) of a nearly flat mirror with normals (N, 2).

    clamp, free: u of both ends of the line fitted to the points. The normals give the
    slopes, and the points the distance.
    """
    middle = points.mean(axis=0)
    across = np.linalg.svd(points - middle, full_matrices=False)[2][1]
    foot, end = (
        np.array([u, 1.0]) * (middle @ across) / (across @ [u, 1.0])
        for u in (clamp, free)
    )
    length = float(np.linalg.norm(end - foot))
    along = (end - foot) / length
    flat = HeightCurve(np.zeros(4), foot, along, length)
    rows, sides = flat.slope_equations(points[:, 0] / points[:, 1], normals)
    slopes = np.linalg.lstsq(rows[:, 1:], sides, rcond=None)[0]
    powers = np.vander((points - foot) @ along / length, 4, increasing=True)
    heights = (points - foot) @ [-along[1], along[0]]
    shift = np.mean(heights - powers[:, 1:] @ slopes)
    return flat.replaced([shift, *slopes])


def _axes(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


# The true mirror in place of the laser scan, and distances of curves from it (5.3.2).
#
# The scan is the middle line, in the plane of the reduced model. It is compared in the
# camera's frame, and after rigid motions: the camera's pose relative to a scanner is
# unknown.


PLACES = 101
# Fraction of the largest effect of a motion: motions of the scan along itself have less
# and are excluded.
ALONG_ITSELF = 0.05


class Scan(NamedTuple):
    """x (N,) mm from the clamp, points (N, 2) mm, and normals (N, 2), unit, in the
    direction of the deflection; at_load: index of the point closest to the load."""

    x: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    at_load: int

    def off(self, curve):
        """Distances (N,) mm of a curve from the scan, along the normals.

        At the points where the viewing rays of the scan's points meet the curve.
        """
        found = curve.points(self.points[:, 0] / self.points[:, 1])
        return np.einsum("ij,ij->i", found - self.points, self.normals)

    def moved(self, centre):
        """Changes (N, 3) of `off` by two shifts and a rotation about a centre.

        centre: (2,) mm; shifts in mm, the rotation in radians.
        """
        from_centre = self.points - centre
        turn = self.normals[:, 1] * from_centre[:, 0]
        turn -= self.normals[:, 0] * from_centre[:, 1]
        return np.column_stack([self.normals, turn])


def scan_of(rig, camera, angle):
    """The Scan of a true camera's mirror; angle: of the u axis, radians."""
    mirror = camera.mirror
    x = np.linspace(0, mirror.end, PLACES)
    on = np.column_stack([x, 0 * x, mirror.height(x, 0 * x)[0]])
    points = in_plane(transform(camera.T_viewer_mirror, on), angle)
    along = np.gradient(points, axis=0)
    normals = np.column_stack([-along[:, 1], along[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals *= np.sign(normals[0] @ in_plane(rig.deflection_direction(), angle))
    load = np.argmin(np.abs(x - camera.mirror.profile.places[0]))
    return Scan(x, points, normals, int(load))


def aligned(scans, off):
    """Offsets (N,) from two scans after the motion that fits the first best.

    scans: those before and after, by a static scanner; off: the offsets of a curve from
    each, in the camera's frame.
    """
    centre = scans[0].points.mean(axis=0)
    motion = _motion(scans[0].moved(centre), off[0])
    return [o - scan.moved(centre) @ motion for scan, o in zip(scans, off, strict=True)]


def alone(scan, off):
    """Offsets (N,) from one scan after the motion that fits it best."""
    change = scan.moved(scan.points.mean(axis=0))
    return off - change @ _motion(change, off)


def _motion(change, off):
    """Least-squares shifts and rotation (3,), without motion along the scan."""
    # Equal weight of both shifts: the smallest motion has no part along the scan.
    size = np.array([1.0, 1.0, np.sqrt(len(off)) / np.linalg.norm(change[:, 2])])
    return size * np.linalg.lstsq(change * size, off, rcond=ALONG_ITSELF)[0]


# One deflection of a mirror, calibrated with the reduced model (Fig. 5.7).
#
# Corners and decoded points are projections by the true camera, with the errors of
# rendered images. The rays of the primary curve give the board's pose, and its corners
# are then projected into the plane.


DEFLECTION_MM, RUN_DEPTH_MM = 7.98, 280.0
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
RUN_SETTINGS = {
    "deflection_mm": DEFLECTION_MM,
    "depth_mm": RUN_DEPTH_MM,
    "least_corners": MIN_N_CORNERS,
    "strip": STRIP,
    "ways": {name: way._asdict() for name, way in WAYS.items()},
}


class Bent(NamedTuple):
    """One mirror before and after its deflection, and its images.

    cameras: the two true ones; first: Primary of the first one; corner_pair: two arrays
    (182, 2) px of the board's corners.
    """

    rig: object
    cameras: tuple
    first: object
    corner_pair: tuple

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
            rejected = {"refused": refusal.code}
            out[name] = dict.fromkeys((PUBLISHED_WAY, *ways), rejected)
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
        rig.board_pose(rng, RUN_DEPTH_MM, DEFLECTIONS_MM, MIN_N_CORNERS),
        rig.board_pose(rng, BACK_PROJECTION_MM, (DEFLECTION_MM,)),
    ]


def looked_at(rig, bench, errors, seed, T_camera_board):
    """The Bent of one run: primary stage, and a board imaged before and after."""
    rng = np.random.default_rng(seed)
    cameras = tuple(rig.camera(mm, bench.aberration_um, seed) for mm in DEFLECTIONS_MM)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    images = tuple(
        seen_board(rig, camera, T_camera_board, errors, rng) for camera in cameras
    )
    return Bent(rig, cameras, first, images)


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
    first, second = bent.corner_pair
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


# Effect of a primary error on the surface after a deflection (5.3.2).
#
# The primary curve is the best fit to the true mirror, changed by an error of known
# size; viewing rays, corners and clamp are exact. The rest is as in `run.calibrated`:
# the rays of the curve give the board's pose, and the clamp is fixed on the curve.


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
    T = rig.board_pose(rng, RUN_DEPTH_MM, DEFLECTIONS_MM, MIN_N_CORNERS)
    orders = KINDS[condition["kind"]]
    parts = np.zeros(4)
    parts[list(orders)] = rng.standard_normal(len(orders))
    line = clamp_line(rig.viewer, rig.clamp_pixels(cameras[0], CLAMP_PICKS))
    scans = [scan_of(rig, camera, line.angle) for camera in cameras]
    spans = [span_of(rig, camera, line) for camera in cameras]
    true = distances_next_to(scans[0].points, spans[0])
    images = [np.where(s[:, None], p, np.nan)
                for p, s in (rig.corners(camera, T) for camera in cameras)]  # fmt: skip
    before, final = np.full((2, len(INJECTED_MM)), np.nan)
    for level, size_mm in enumerate(INJECTED_MM):
        curve = moved_curve(true, scans[0], parts, size_mm)
        before[level] = np.mean(np.abs(scans[0].off(curve)))
        try:
            found = deflected_from(curve, spans[1], rig, line, images)
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


def moved_curve(curve, scan, parts, size_mm):
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


def deflected_from(before, span, rig, line, images):
    """The curve after a deflection, from pixels (182, 2) before and after."""
    camera, points = ReducedCamera(rig.viewer, line.angle, before), rig.board.points()
    first, second = images
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
