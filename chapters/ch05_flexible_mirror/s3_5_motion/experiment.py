"""Trials of this page, their conditions and constants."""

from itertools import pairwise as pairwise_of
from typing import NamedTuple

import numpy as np

from chapters.shared.mirror import (
    PUBLISHED,
    STAGES_MM,
    deflected,
    lattice,
    mirror_rig,
    primary,
    ray_angles,
    seen_board,
)
from raxel.cameras import Rays, closest_point
from raxel.errors import CalibrationError, InputError
from raxel.geometry import (
    angle_between_rotations,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.multiview import (
    RayView,
    bundle_rays,
    fit_cylinder,
    generalised_pose_ransac,
    motion_information,
    rays_of_pixels,
    refine_generalised_pose,
    triangulate,
)

# A mirror calibrated stage by stage as published, after three pushes.


LAST = len(STAGES_MM) - 1


def calibrated(rig, true, errors, seed):
    """(cameras of the stages that were reached, code of the error that ended it or "").

    true: the true cameras; seed: draws the errors.
    """
    rng = np.random.default_rng(seed)
    try:
        first = primary(rig, true[0], PUBLISHED, errors, rng)
    except InputError as refusal:
        return [], refusal.code
    found, points = [first.camera], rig.board.points()
    for k in range(1, LAST + 1):
        T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
        pair = [seen_board(rig, c, T, errors, rng) for c in true[k - 1 : k + 1]]
        try:
            stage = deflected(found[-1], true[k], pair, points, first.clamp, PUBLISHED)
        except InputError as refusal:
            return found, refusal.code
        found.append(stage.camera)
    return found, ""


# A cylinder with marks that a stage moves in front of the bent mirror (5.3.5).
#
# The cylinder is upright in the field of the mirror and moves sideways. Its position is
# chosen by one criterion: all marks are in view in all six positions. Frame: that of
# the viewer; mm.


RADIUS_MM, MARKS = 62.98, 25
STEP_MM, STEPS = 25.0, 5
# Distance from mirror to axis; half the marked height; angular range of the marks, on
# the side towards the mirror.
AWAY_MM, HALF_MM, AROUND = 450.0, 75.0, np.radians(65)
TILT = np.radians(5)  # of the axis and of the stage, standard deviation
NOISE_PX = 0.2
RIM_PX = 8.0
TRIED, MAX_N_TRIES = 90, 50
TURNS = np.arange(6) * np.pi / 3


class PlacedCylinder(NamedTuple):
    """Pose and motion of the cylinder.

    axes (3, 3): in columns, the cylinder's axis second and the direction away from the
    mirror last; middle (3,): of the axis at first; along (3,): direction of motion.
    """

    axes: np.ndarray
    middle: np.ndarray
    along: np.ndarray

    @property
    def axis(self):
        """Unit vector (3,) along the cylinder."""
        return self.axes[:, 1]

    def points(self, turn, height):
        """Points (N, 3) of the surface.

        turn: angle from the side that faces the mirror, radians; height: mm.
        """
        local = np.column_stack(
            [RADIUS_MM * np.sin(turn), height, -RADIUS_MM * np.cos(turn)]
        )
        return self.middle + local @ self.axes.T

    def motions(self):
        """T (6, 4, 4): motions of the cylinder after 0 to 5 steps."""
        steps = STEP_MM * np.arange(STEPS + 1)[:, None] * self.along
        return np.array([pose(np.eye(3), step) for step in steps])


class MovedCylinder(NamedTuple):
    """Marks, motions and image points of the cylinder.

    points (25, 3): marks at first; T (6, 4, 4): their motions after 0 to 5 steps;
    pixels (6, 25, 2): true image points; axis (3,): unit vector along the cylinder.
    """

    points: np.ndarray
    T: np.ndarray
    pixels: np.ndarray
    axis: np.ndarray


def moved_cylinder(camera, rng):
    """The MovedCylinder seen by a true camera. RuntimeError where none is visible."""
    for _ in range(MAX_N_TRIES):
        placed = placed_cylinder(camera, rng)
        turn = rng.uniform(-AROUND, AROUND, TRIED)
        points = placed.points(turn, rng.uniform(-HALF_MM, HALF_MM, TRIED))
        pixels, seen = seen_in_all(camera, points, placed.motions())
        keep = np.flatnonzero(seen)[:MARKS]
        if len(keep) == MARKS:
            T = placed.motions()
            return MovedCylinder(points[keep], T, pixels[:, keep], placed.axis)
    raise RuntimeError(f"of {TRIED} marks fewer than {MARKS} are seen in all places")


def seen_in_all(camera, points, T):
    """(pixels (V, N, 2), seen (N,)) of points under motions (V, 4, 4).

    seen: visible in all.
    """
    found = [camera.project(transform(one, points)) for one in T]
    seen = np.all([f.valid & shown(camera, f.pixels) for f in found], axis=0)
    return np.array([f.pixels for f in found]), seen


def shown(camera, pixels):
    """Whether a camera has rays for pixels (N, 2) and all around them, (N,) bool."""
    around = RIM_PX * np.column_stack([np.cos(TURNS), np.sin(TURNS)])
    places = np.where(np.isfinite(pixels), pixels, -1.0) + around[:, None]
    inside = camera.in_image(places.reshape(-1, 2))
    rays = camera.rays(places.reshape(-1, 2))
    return (inside & rays.valid).reshape(len(around), -1).all(axis=0)


def placed_cylinder(camera, rng):
    """The PlacedCylinder, in the middle of a camera's field after half its steps."""
    size = np.array([camera.width, camera.height])
    rays = camera.rays(size * rng.uniform(0.05, 0.95, (TRIED, 2)))
    o, d = np.nanmean(rays.origins, axis=0), np.nanmean(rays.directions, axis=0)
    d /= np.linalg.norm(d)
    x = np.cross([0.0, 1.0, 0.0], d)
    axes = np.column_stack([x / np.linalg.norm(x), np.zeros(3), d])
    axes[:, 1] = np.cross(d, axes[:, 0])
    axes = axes @ rotation_from_vector(rng.normal(0, TILT, 3))
    along = axes @ rotation_from_vector(rng.normal(0, TILT, 3))[:, 0]
    return PlacedCylinder(axes, o + AWAY_MM * d - STEPS * STEP_MM / 2 * along, along)


# Motion of a cylinder from pairs of images, and its shape (Table 5.7).
#
# The camera is static and the cylinder moves, which is the inverse motion of the
# camera. T_k (4, 4) takes points of the first image to where they are in image k. A
# translation is that of the point closest to all rays, about which rays determine a
# rotation best. Step lengths are open and estimated from the rays, or each is given.
# All six images are also adjusted in one bundle with open lengths. Frame: the viewer's;
# mm, degrees.


# Rays of a calibrated camera miss by more than noise: the start is from the first of
# these multiples of the standard deviation within which most pairs agree. All matches
# are correct.
THRESHOLDS, MIN_AGREEMENT, DRAWS = (10.5, 31.5), 0.8, 64
MAX_STEPS = 20  # of a fit: diverging lengths would go on
MIN_IN_FRONT = 0.5  # share of points in front of the mirror, as all of them are
MIN_N_PAIRS = 17  # for the linear solution
MARKER_MM = 3.0
BASELINES = range(1, STEPS + 1)


class SeenMarks(NamedTuple):
    """Rays of the marks.

    used (25,): marks with rays in all positions; rays: NoisyRays of each position;
    centre (3,): the point closest to all of them.
    """

    used: np.ndarray
    rays: list
    centre: np.ndarray

    def shift(self, T):
        """Translation (3,) of the centre by a motion (4, 4)."""
        return T[:3, :3] @ self.centre + T[:3, 3] - self.centre


def seen_by(camera, pixels, noise_px=NOISE_PX):
    """SeenMarks of pixels (6, 25, 2). Raises CalibrationError for too few marks."""
    used = np.all([shown(camera, x) for x in pixels], axis=0)
    if used.sum() < MIN_N_PAIRS:
        raise CalibrationError(
            f"cylinder: the camera has rays of {used.sum()} marks in all places"
        )
    rays = [rays_of_pixels(camera, x[used], noise_px) for x in pixels]
    o, d = (
        np.concatenate([getattr(one, name) for one in rays])
        for name in ("origins", "directions")
    )
    return SeenMarks(used, rays, closest_point(Rays(o, d, np.ones(len(o), bool))))


def motion_and_shape(camera, scene, pixels, rng, alone=False, noise_px=NOISE_PX):
    """Motion and shape of the cylinder by a camera, as a trial keeps them.

    alone: whether lengths are open only; otherwise they are given as well, and all six
    images are adjusted together.
    """
    try:
        seen = seen_by(camera, pixels, noise_px)
        pairs = pairwise(seen.rays, rng)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    out = {"open": of_pairs(seen, scene, pairs)}
    if alone:
        return out
    given = pairwise(seen.rays, rng, STEP_MM, pairs)
    return out | {
        "given": of_pairs(seen, scene, given),
        "together": together(seen, chained(given)),
    }


def pairwise(rays, rng, length=None, near=None):
    """T_2_1 (4, 4) of each place and the next, from rays.

    length: mm, where known. Each pair is searched from samples; near: an additional
    start of each pair. Without one, the step before is a start where the search ends
    with most points behind the mirror, or fails, as the motion is even. Solutions with
    points in front of the mirror come first, then the best fit.
    """
    found = []
    for k, pair in enumerate(pairwise_of(rays)):
        ends = [_of_all(pair, T, length) for T in _from_samples(*pair, rng, length)]
        if near is not None:
            ends += [_of_all(pair, near[k], length)]
        if found and not any(end.ahead >= MIN_IN_FRONT for end in ends):
            ends += [_of_all(pair, found[-1], length)]
        if not ends:
            raise CalibrationError("motion: no two rays of most pairs meet")
        best = min(ends, key=lambda end: (end.ahead < MIN_IN_FRONT, end.rms))
        found.append(best.T_2_1)
    return found


def _of_all(pair, start, length):
    return refine_generalised_pose(*pair, start, length=length, most=MAX_STEPS)


def _from_samples(rays_1, rays_2, rng, length):
    """[T_2_1 (4, 4)] from samples, [] where no motion fits most of the pairs."""
    for threshold in THRESHOLDS:
        try:
            found = generalised_pose_ransac(
                rays_1, rays_2, rng, threshold, length=length, most_trials=DRAWS
            )
        except CalibrationError:
            continue
        if np.mean(found.inliers) >= MIN_AGREEMENT:
            return [found.T_2_1]
    return []


def chained(pairs):
    """T (6, 4, 4) from the first position, of those from each to the next."""
    T = [np.eye(4)]
    for step in pairs:
        T.append(step @ T[-1])
    return np.array(T)


def of_pairs(seen, scene, pairs):
    """Steps estimated one by one and added up, and the cylinder under them.

    Lengths are scaled so that the mean step is the true one, as in Table 5.7. Both
    radii of the cylinder are kept; distances are from the scaled one.
    """
    lengths = [np.linalg.norm(seen.shift(T)) for T in pairs]
    scale = STEP_MM / np.mean(lengths)
    T = chained(pairs)
    out = {"mean_mm": float(np.mean(lengths))}
    path = np.zeros((STEPS + 1, 3))
    for k in BASELINES:
        path[k] = scale * seen.shift(T[k])
        out[f"step{k}"] = {
            "length_mm": float(np.linalg.norm(path[k])),
            "turn_deg": turn_between(T[k], scene.T[k]),
            "off_mm": float(np.linalg.norm(path[k] - scene.T[k][:3, 3])),
        }
    return out | {"path": path} | shape_of(seen, T, scale)


def shape_of(seen, T, scale):
    """The cylinder through the marks under motions (6, 4, 4).

    Only `no_shape` where none can be fitted.
    """
    views = [RayView(one) for one in seen.rays]
    return cylinder_through(triangulate(views, T).points, scale)


def cylinder_through(points, scale=1.0):
    """Radius, distances and axis of the cylinder through points (n, 3), NaN allowed."""
    known = np.isfinite(points).all(axis=1)
    try:
        fit = fit_cylinder(points[known])
    except InputError as refusal:
        return {"no_shape": refusal.code}
    off = scale * np.abs(fit.residuals)
    return {
        "radius_mm": fit.radius,
        "scaled_mm": scale * fit.radius,
        "fit_mm": float(off.mean()),
        "fit_sd_mm": float(off.std(ddof=1)),
        "missed": int(MARKS - np.count_nonzero(off <= MARKER_MM)),
        "points": scale * points,
        "cylinder": scaled_cylinder(fit, scale),
    }


def scaled_cylinder(fit, scale):
    """(7,): a point of the axis, its direction, the radius."""
    at = fit.T_frame_cylinder[:3, 3]
    return np.array([*(scale * at), *fit.axis, scale * fit.radius])


def together(seen, start):
    """Six views in one bundle: length of the whole translation, and its SD, percent."""
    try:
        bundle = bundle_rays([RayView(one) for one in seen.rays], start)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    T = bundle.T_view_world[STEPS]
    return {
        "length_mm": float(np.linalg.norm(seen.shift(T))),
        "told_percent": 100 * bundle.scale_sd(STEPS),
    }


def turn_between(T, true):
    """Degrees between the rotations of two motions."""
    return float(np.degrees(angle_between_rotations(T[:3, :3], true[:3, :3])))


# A calibrated mirror, and a cylinder that moves in front of it.
#
# Two cameras use the same images of stage 3: the true one, and that of the published
# method, stage by stage. Errors of the true one come from the geometry, the rest from
# the calibration. At earlier stages only the scale is estimated, and what the rays
# determine of it.


SETTINGS = {
    "stages_mm": list(STAGES_MM),
    "marks": MARKS,
    "mark_px": NOISE_PX,
    "radius_mm": RADIUS_MM,
    "step_mm": STEP_MM,
    "cylinder_mm": AWAY_MM,
}
# px between the pixels whose rays are compared with the true ones.
COMPARED_PX = 96


def motion_trial(condition, rng, errors, benches, alone=False):
    """Run both cameras at each of some error levels, with the same draws.

    alone: only the published one, with open lengths at stage 3.
    """
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig = errors[condition["geometry"]]
    return {
        name: one_bench(rig, bench, of_rig.on(bench), seed, alone)
        for name, bench in benches.items()
    }


def one_bench(rig, bench, errors, seed, alone):
    """Calibrate at one level, and estimate the cylinder's motion with each camera."""
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    found, refusal = calibrated(rig, cameras, errors, seed)
    out = {"refused": refusal} if refusal else {}
    seers = {"published": found[LAST]} if len(found) > LAST else {}
    for stage in (LAST,) if alone else range(LAST + 1):
        rng = np.random.default_rng([seed, stage])
        scene = moved_cylinder(cameras[stage], rng)
        pixels = scene.pixels + NOISE_PX * rng.standard_normal(scene.pixels.shape)
        if not alone:
            out[f"stage{stage}"] = length_bounds(cameras[stage], scene)
            if stage < min(LAST, len(found)):
                out[f"stage{stage}"] |= steps_found(found[stage], pixels, rng)
    if not alone:
        seers["true"] = cameras[LAST]
        out["marks"] = {"path": scene.T[:, :3, 3]}
    rays = lattice(cameras[LAST], COMPARED_PX)
    for name, camera in seers.items():
        drawn = np.random.default_rng([seed, LAST + 1])
        out[name] = motion_and_shape(camera, scene, pixels, drawn, alone)
        off = ray_angles(camera, cameras[LAST], rays)
        out[name]["ray_deg"] = float(np.nanmean(off))
    return out


def length_bounds(camera, scene):
    """Smallest standard deviation of the length of one step and of more, percent.

    From the Fisher information of exact rays with this noise, for any unbiased method.
    Rays through one point determine no length.
    """
    seen = seen_by(camera, scene.pixels)
    out = {}
    for k in BASELINES:
        bound = motion_information(scene.T[k], seen.rays[0], seen.rays[k])
        if bound.spread:
            out[f"told{k}"] = {"length_percent": 100 * bound.scale_sd}
    return out | {"spread_mm": bound.spread}


def steps_found(camera, pixels, rng):
    """Mean length of the steps from pairs of images."""
    try:
        seen = seen_by(camera, pixels)
        lengths = [np.linalg.norm(seen.shift(T)) for T in pairwise(seen.rays, rng)]
    except CalibrationError:
        return {}
    return {"mean_mm": float(np.mean(lengths))}
