"""Trials of this page, their conditions and constants."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from chapters.shared.mirror import (
    BACK_PROJECTION_MM,
    COMPARED_PX,
    DYNAMIC_MM,
    PUBLISHED,
    STAGES_MM,
    GaussianErrors,
    back_projection,
    deflected,
    lattice,
    lengths,
    load_height,
    mirror_rig,
    outline,
    primary,
    ray_angles,
    seen_board,
)
from raxel.calibration import (
    clamp_of_camera,
    linear_update,
    met_points,
    normalised,
    update_from_scene,
    update_mirror,
)
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry import on_plane, spline_grid, transform

# An unknown scene in front of the mirror: a wall, a plane, an object (5.4).
#
# Depths are measured from the mirror's middle, along the mean direction of its rays
# when flat. The plane and the object occlude parts of the wall, in vertical stripes.


# From the mirror, mm (Fig. 5.26); NEAR_MM: what only the bent mirror shows, at its end.
DEPTHS_MM = {"wall": 5000.0, "plane": 3980.0, "object": 4950.0}
NEAR_MM = 1200.0
STRIPE, LATTICE_PX = np.radians(3), 32
EACH, ALONE = 40, 0.1  # features drawn for each state; share outside a cluster
MIDDLE = 0.2  # share of the mirror's height where features cluster


class SceneFrame(NamedTuple):
    """Frame of the scene.

    middle (3,); axis (3,), unit; edge: smallest x component of a flat mirror's ray.
    """

    middle: np.ndarray
    axis: np.ndarray
    edge: float

    @classmethod
    def of(cls, flat):
        """Return the frame of the true camera of stage 0."""
        rays = flat.rays(lattice(flat, 96))
        axis = rays.directions.mean(axis=0)
        axis /= np.linalg.norm(axis)
        return cls(rays.origins.mean(axis=0), axis, rays.directions[:, 0].min())

    def depth(self, points):
        """(N,) mm of points (N, 3)."""
        return (points - self.middle) @ self.axis

    def placed(self, origins, directions, depth):
        """Points (N, 3) where rays reach depths (N,) mm."""
        along = (depth - self.depth(origins)) / (directions @ self.axis)
        return origins + along[:, None] * directions


class Field:
    """A true camera and a lattice of its pixels with their rays, made once."""

    def __init__(self, camera):
        self.camera = camera
        self.pixels = lattice(camera, LATTICE_PX)
        self.rays = camera.rays(self.pixels)
        self.middle = self.rays.origins.mean(axis=0)

    def shows(self, points):
        """Whether points (N, 3) are inside the field of the lattice.

        Near points are tested on their own: for them the size of the mirror matters.
        """
        away = points - self.middle
        reach = np.linalg.norm(away, axis=1)
        near = reach < np.median(reach) / 2
        seen = np.zeros(len(points), bool)
        for group in (near, ~near):
            if not group.any():
                continue
            at = self.rays.origins + np.median(reach[group]) * self.rays.directions
            edges = ConvexHull(_slopes(at - self.middle)).equations
            beyond = _slopes(away[group]) @ edges[:, :2].T + edges[:, 2]
            seen[group] = np.all(beyond <= 0, axis=1)
        return seen

    def pictured(self, points, errors, rng, pick_px=0.0):
        """Pixels (N, 2) of points with errors, NaN where not visible.

        Points outside the field of the lattice are excluded. pick_px: standard
        deviation of picking by hand, added to the errors.
        """
        found = np.full((len(points), 2), np.nan)
        there = np.flatnonzero(self.shows(points))
        pixels, valid = self.camera.project(points[there])
        seen = valid & self.camera.in_image(pixels)
        found[there[seen]] = pixels[seen]
        # Equally many draws whatever is visible: all levels and scenes are drawn alike.
        found = errors.corners(found, rng)
        return found + pick_px * rng.standard_normal(found.shape)


def features(view, fields, rng, clustered=False, near=False):
    """Points (N, 3) and their surfaces (N,), of features drawn in each Field.

    clustered: nine in ten lie in the middle fifth of the mirror's height; near: what
    the flat mirror does not show at its end is NEAR_MM away.
    """
    points, names = [], []
    for field in fields:
        weight = _weights(field.pixels, clustered)
        chosen = rng.choice(len(weight), EACH, replace=False, p=weight / weight.sum())
        rays = field.rays.directions[chosen]
        of = np.array(["wall", "plane", "wall", "object"])[_stripe(rays) % 4]
        depth = np.array([DEPTHS_MM[name] for name in of])
        if near:
            depth = np.where(rays[:, 0] < view.edge, NEAR_MM, depth)
        points.append(view.placed(field.rays.origins[chosen], rays, depth))
        names.append(of)
    return np.vstack(points), np.concatenate(names)


def _weights(pixels, clustered):
    if not clustered:
        return np.ones(len(pixels))
    off = np.abs(pixels[:, 1] - pixels[:, 1].mean()) / np.ptp(pixels[:, 1])
    inside = off < MIDDLE / 2
    return np.where(inside, (1 - ALONE) / inside.sum(), ALONE / (~inside).sum())


def _stripe(d):
    return np.floor(np.arctan2(d[:, 0], -d[:, 2]) / STRIPE).astype(int)


def _slopes(away):
    return np.column_stack([away[:, 0] / away[:, 2], away[:, 1] / away[:, 2]])


# Stereo between bent states: depth of a scene from the bending of the mirror.


BASELINE_MM = np.array([100.0, 0.0, 0.0])
PICKED_PX = 0.5  # by hand, as the clamp's line is (5.3.3)
STEP_PX, SPREAD_PX = 0.25, 96
STRIPS, FINER = 8, 16
OF = ("plane", "object", "wall")


def between_states(rig, view, fields, chain, errors, rng):
    """Pairs of states, calibrated (`found`) and true (`true`), one noise for both.

    `deflected`, `baseline`: medians of the relative errors of depths in the far scene,
    of stages 0 and 1 and of stage 0 moved by 100 mm; `board`: of the board at its
    position in dynamic calibration. `sd_mm`, `along`: depth noise at DYNAMIC_MM, mm per
    px, in strips from the clamp on; `finer`: ratio of the first to the last of more
    such strips. `apart_mm`: median distance of the points on the mirror where both
    states show a feature.
    """
    from scipy.stats import spearmanr

    stages = [field.camera for field in fields]
    points, _ = features(view, fields[:1], rng)
    T = rig.board_pose(rng, deflections=STAGES_MM[:2])
    board = transform(T, on_plane(rig.board.points()))
    pixels = [field.pictured(points, errors, rng) for field in fields[:2]]
    moved = fields[0].pictured(points - BASELINE_MM, errors, rng)
    of_board = [seen_board(rig, camera, T, errors, rng) for camera in stages[:2]]
    depth_sds = depth_sd(stages)
    out = dict(zip(("along", "sd_mm"), in_strips(*depth_sds, STRIPS), strict=True))
    starts = [stage.rays(p).origins for stage, p in zip(stages, pixels, strict=False)]
    apart = np.linalg.norm(starts[1] - starts[0], axis=1)
    out["apart_mm"] = float(np.nanmedian(apart))
    finer = in_strips(*depth_sds, FINER)[1]
    out["finer"] = float(finer[0] / finer[-1])
    out["trend"] = float(spearmanr(out["along"], out["sd_mm"]).statistic)
    for name, pair in (("found", chain[:2]), ("true", stages[:2])):
        if len(pair) < 2:
            continue
        shifted = _Moved(pair[0].rays(moved), BASELINE_MM)
        first = pair[0].rays(pixels[0])
        met = met_points(_of(pair[0].rays(of_board[0])), pair[1].rays(of_board[1]))[0]
        out[name] = {
            "deflected": depth_error(first, pair[1].rays(pixels[1]), points),
            "baseline": depth_error(first, shifted, points),
            "board": depth_error(
                pair[0].rays(of_board[0]), pair[1].rays(of_board[1]), board
            ),
            "met": met,
        }
    out["board_points"] = board
    return out


class _Moved:
    """Rays of a camera after a known translation."""

    def __init__(self, rays, shift):
        self.origins, self.directions = rays.origins + shift, rays.directions


def _of(rays):
    return rays.origins, rays.directions


def depth_error(first, second, points):
    """Median of |found / true - 1| of the depths of points (N, 3) along first rays."""
    met = met_points(_of(first), second)[0]
    true = np.linalg.norm(points - first.origins, axis=1)
    depth = np.sum((met - first.origins) * first.directions, axis=1)
    return float(np.nanmedian(np.abs(depth / true - 1)))


def depth_sd(stages):
    """Relative distance (n,) from the clamp, 0 to 1, and depth noise (n,) there.

    Standard deviation, mm, for 1 px in each coordinate of both images.
    """
    before = lattice(stages[0], SPREAD_PX)
    rays = stages[0].rays(before)
    points = rays.origins + DYNAMIC_MM * rays.directions
    after, valid = stages[1].project(points)
    before, after = before[valid], after[valid]
    square = 0.0
    for axis in 0.5 * STEP_PX * np.eye(4):
        ends = [
            _depths(stages, before + sign * axis[:2], after + sign * axis[2:])
            for sign in (1, -1)
        ]
        square = square + ((ends[0] - ends[1]) / STEP_PX) ** 2
    place = np.abs(rays.origins[valid, 0] - stages[0].T_viewer_mirror[0, 3])
    return place / np.nanmax(place), np.sqrt(square)


def in_strips(share, sd, count):
    """Middles (n,) and medians (n,) of the standard deviations (N,) of depths in strips
    from the clamp to the end."""
    strips = [
        (share >= k / count) & (share <= (k + 1) / count) & np.isfinite(sd)
        for k in range(count)
    ]
    some = [strip for strip in strips if strip.any()]
    return (
        np.array([share[strip].mean() for strip in some]),
        np.array([np.median(sd[strip]) for strip in some]),
    )


def _depths(stages, before, after):
    first = stages[0].rays(before)
    met = met_points(_of(first), stages[1].rays(after))[0]
    return np.sum((met - first.origins) * first.directions, axis=1)


def four_views(view, fields, chain, errors, rng):
    """The far scene from all stages: centroids, spreads, points; pixels of stage 2."""
    stages = [field.camera for field in fields]
    points, names = features(view, fields, rng)
    pixels = [field.pictured(points, errors, rng, PICKED_PX) for field in fields]
    out = {}
    for name, cameras in (("found", chain), ("true", stages)):
        if len(cameras) < len(stages):
            continue
        rays = [camera.rays(seen) for camera, seen in zip(cameras, pixels, strict=True)]
        met = nearest(rays)
        known = np.isfinite(met).all(axis=1)
        depth = view.depth(met)
        across = np.cross([0.0, 1.0, 0.0], view.axis)
        out[name] = {
            "plan": np.column_stack([(met - view.middle) @ across, depth])[known],
            "of": np.array([OF.index(one) for one in names])[known],
        }
        for one in OF:
            mine = depth[known & (names == one)]
            out[name][one] = {
                "centroid_mm": float(mine.mean()),
                "spread_mm": float(np.ptp(mine)),
                "ratio": float(mine.mean() / DEPTHS_MM[one]),
            }
    out["pixels"] = pixels[-2]
    return out


def nearest(views):
    """Points (N, 3) nearest to the rays of all views, NaN where one is missing."""
    normal, right = 0.0, 0.0
    for rays in views:
        d = rays.directions
        P = np.eye(3) - d[:, :, None] * d[:, None, :]
        normal, right = normal + P, right + np.einsum("nij,nj->ni", P, rays.origins)
    known = np.isfinite(right).all(axis=1)
    met = np.full(right.shape, np.nan)
    met[known] = np.linalg.solve(normal[known], right[known][..., None])[..., 0]
    return met


# Three pushes of 5 mm, calibrated from boards and from unknown scenes.
#
# Over 5 mm no feature of a distant scene remains in the last knot interval, so each
# push is self-calibrated in two steps of 2.5 mm. Whether one step is rejected is kept
# too.


STEPS_MM = (0.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0)
# Features of a run: (clustered, near ones at the free end). The first is that of 5.4.
SCENES = {
    "told": (True, True),
    "clustered": (True, False),
    "near": (False, True),
    "even": (False, False),
}
# Scenes for which back-projection with an estimated pose is measured.
OWN_POSE = ("told", "even")
# Places along the sheet's middle line, and across it at the load, mm.
ALONG_MM, ACROSS_MM = np.linspace(5.0, 150.0, 30), np.linspace(-40.0, 40.0, 9)
NEWTON_STEPS = 8


def course_trial(condition, rng, errors, benches, pushes):
    """Run all pushes at each of some error levels, with the same draws."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig = errors[condition["geometry"]]
    return {
        name: course(rig, bench, of_rig.on(bench), seed, pushes)
        for name, bench in benches.items()
    }


def course(rig, bench, errors, seed, pushes):
    """Calibrate from boards and scenes, and reconstruct between the states.

    `X.refused`: code of the error that ended a method.

    stage{k} of `board` and of each of SCENES; `whole.refused`: of 5 mm in one step.
    """
    rng = np.random.default_rng(seed)
    steps_mm = STEPS_MM[: 2 * pushes + 1]
    cameras = [rig.camera(mm, bench.aberration_um, seed) for mm in steps_mm]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    stages = cameras[::2]
    boards = [
        (T, seen_board(rig, camera, T, errors, rng))
        for mm, camera in zip(steps_mm[::2], stages, strict=True)
        for T in [rig.board_pose(rng, BACK_PROJECTION_MM, (mm,))]
    ]
    view = SceneFrame.of(cameras[0])
    score = _Scores(rig, stages, boards, load_height(rig, first.camera, cameras[0]))
    board, chain = by_boards(rig, stages, first, score, errors, rng)
    fields = [Field(camera) for camera in cameras]
    found = {"board": board}
    for name, kind in SCENES.items():
        points, _ = features(view, fields, rng, *kind)
        seen = [field.pictured(points, errors, rng) for field in fields]
        found[name] = by_scene(cameras, first, seen, score, name in OWN_POSE)
    found["whole"] = in_one_step(cameras, first, seen)
    found["stereo"] = between_states(rig, view, fields[::2], chain, errors, rng)
    found["multi"] = four_views(view, fields[::2], chain, errors, rng)
    return found


class _Scores:
    """Errors of a calibrated camera at a stage."""

    def __init__(self, rig, stages, boards, height):
        self.rig, self.stages, self.boards, self.height = rig, stages, boards, height

    def angle(self, k, camera):
        """Mean angle to the true rays, degrees."""
        true = self.stages[k]
        return float(np.nanmean(ray_angles(camera, true, lattice(true, COMPARED_PX))))

    def stage(self, k, camera, height, own=True):
        """Errors at stage k.

        height: of the load at the stage before, as estimated; own: whether to measure
        back-projection with an estimated pose, too.
        """
        points, (T, pixels) = self.rig.board.points(), self.boards[k]
        found = load_height(self.rig, camera, self.stages[k])
        true = back_projection(camera, pixels, points, T)
        middle = np.column_stack([ALONG_MM, 0 * ALONG_MM])
        load = np.full(len(ACROSS_MM), self.rig.load_mm)
        across = mm_beyond(self.rig, camera, self.stages[k], load, ACROSS_MM)
        out = {
            "deflection_mm": found - height,
            "height_mm": found,
            "back_true_mm": float(lengths(true).mean()),
            "angle_deg": self.angle(k, camera),
            "profile_mm": mm_beyond(self.rig, camera, self.stages[k], *middle.T)
            + self.stages[k].mirror.height(*middle.T)[0],
            "sag_mm": float(across[[0, -1]].mean() - across[len(across) // 2]),
        }
        if own:
            by_own_pose = back_projection(camera, pixels, points)
            out["back_mm"] = float(lengths(by_own_pose).mean())
        return out


def by_boards(rig, stages, first, score, errors, rng):
    """Scores of the published method, and its cameras from stage 0 on."""
    out, chain, height = {}, [first.camera], score.height
    for k in range(1, len(stages)):
        T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
        pair = stages[k - 1 : k + 1]
        seen = [seen_board(rig, camera, T, errors, rng) for camera in pair]
        try:
            stage = deflected(
                chain[-1], stages[k], seen, rig.board.points(), first.clamp, PUBLISHED
            )
            found = score.stage(k, stage.camera, height)
        except CalibrationError as refusal:
            return out | {"refused": refusal.code}, chain
        found["linear_mm"] = load_height(rig, stage.linear, stages[k]) - height
        out[f"stage{k}"], height = found, found["height_mm"]
        chain.append(stage.camera)
    return out, chain


def by_scene(cameras, first, seen, score, own):
    """Linear self-calibration, two steps for a stage; seen: pixels (N, 2) of each."""
    out, before, height = {}, first.camera, score.height
    for j, camera in enumerate(cameras[1:], 1):
        try:
            before = linear_update(
                before, seen[j - 1], seen[j], first.clamp, PUBLISHED.settings,
                outline=outline(camera),
            ).camera  # fmt: skip
            if j % 2:
                continue
            out[f"stage{j // 2}"] = score.stage(j // 2, before, height, own)
        except CalibrationError as refusal:
            return out | {"refused": refusal.code}
        height = out[f"stage{j // 2}"]["height_mm"]
    return out


def in_one_step(cameras, first, seen):
    """Whether 5 mm in one step are rejected, from the evenly spread far scene."""
    try:
        linear_update(
            first.camera, seen[0], seen[2], first.clamp, PUBLISHED.settings,
            outline=outline(cameras[2]),
        )  # fmt: skip
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    return {"went": 1.0}


def mm_beyond(rig, found, true, x, y):
    """Displacement (n,) mm of a calibrated mirror from the true one, along the push.

    x, y: (n,) mm, positions on the sheet.
    """
    along = rig.deflection_direction()
    z = true.mirror.height(x, y)[0]
    points = transform(true.T_viewer_mirror, np.column_stack([x, y, z]))
    shift = np.zeros(len(points))
    for _ in range(NEWTON_STEPS):
        P = points + shift[:, None] * along
        S = found.mirror.points(P[:, :2] / P[:, 2:])
        n = found.mirror.normals(S)
        shift += np.sum(n * (S - P), axis=1) / (n @ along)
    return shift


# Many steps of a mirror in front of a known static scene, and of boards.


# The mirror moves back and forth, so that all steps are equally hard.
TO_AND_FRO_MM, STEPS = (5.0, 7.5), 8
KNOWN_COMPARED_PX = 168


def known_trial(condition, rng):
    """Mean ray angles (STEPS,), degrees, after each step.

    `known`: with the true points of a static board; `boards`: with estimated poses.
    """
    rig, errors = mirror_rig(condition["geometry"]), GaussianErrors()
    true = [rig.camera(mm) for mm in TO_AND_FRO_MM]
    start = nearest_spline(true[0])
    clamp = clamp_of_camera(start, rig.clamp_pixels(true[0]), slope=False)
    poses = [rig.board_pose(rng, deflections=TO_AND_FRO_MM) for _ in range(2)]
    board = rig.board.points()
    points = transform(poses[0], on_plane(board))
    exact = [
        [seen_board(rig, camera, T, _Exact, rng) for camera in true] for T in poses
    ]
    pixels = [lattice(camera, KNOWN_COMPARED_PX) for camera in true]
    edges = [outline(camera) for camera in true]

    def noisy(place, at):
        return errors.corners(exact[place][at], rng)

    def by_scene(before, step, at):
        return update_from_scene(
            before, noisy(0, at), points, clamp, PUBLISHED.settings, outline=edges[at]
        )

    def by_boards(before, step, at):
        place = step % len(poses)
        return update_mirror(
            before, noisy(place, 1 - at), noisy(place, at), board, clamp,
            PUBLISHED.settings, outline=edges[at],
        )  # fmt: skip

    out = {}
    for name, way in (("known", by_scene), ("boards", by_boards)):
        camera, angles = start, np.full(STEPS, np.nan)
        for step in range(STEPS):
            at = (step + 1) % 2
            try:
                camera = way(camera, step, at).camera
            except CalibrationError as refusal:
                out[f"{name}_refused"] = refusal.code
                break
            off = ray_angles(camera, true[at], pixels[at])
            angles[step] = np.nanmean(off)
        out[name] = {f"step{k}": float(a) for k, a in enumerate(angles, 1)}
    return out


def nearest_spline(true):
    """The 7 x 3 spline nearest to a true mirror, over its whole image."""
    viewer, pixels = true.viewer, lattice(true, 48)
    span = normalised(viewer, np.vstack([pixels, outline(true)]))
    grid = spline_grid(span, (7, 3))
    return SplineMirrorCamera.fitted(
        viewer, grid, true.rays(pixels).origins, "distance"
    )


class _Exact:
    """No errors: they are drawn anew at each step."""

    @staticmethod
    def corners(pixels, rng):
        return pixels
