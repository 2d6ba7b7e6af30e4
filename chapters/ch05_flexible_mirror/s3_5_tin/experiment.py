"""Trials of this page, their conditions and constants."""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from scipy.ndimage import zoom
from scipy.special import ndtri

from chapters.shared.mirror import (
    DYNAMIC_MM,
    PUBLISHED,
    STAGES_MM,
    deflected,
    lattice,
    mirror_rig,
    primary,
    ray_angles,
    seen_board,
)
from raxel.errors import CalibrationError, InputError
from raxel.features import match_features
from raxel.geometry import (
    intersect_rays_plane,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.lab import ImageTexture, Rectangle, TexturedScene, window_around, windowed
from raxel.multiview import (
    RayView,
    fit_plane,
    gaps,
    matched_rays,
    rays_of_pixels,
    triangulate,
)

# Stage 3 of a bending mirror, calibrated stage by stage as published.


LAST = len(STAGES_MM) - 1
# Mirrors of the last stage, the second as in the thesis.
EVERY_WAY = ("true", "published")
SETTINGS = {"stages_mm": list(STAGES_MM), "grid_mm": DYNAMIC_MM}


class BentMirror(NamedTuple):
    """A bent mirror and its images.

    rig: MirrorRig; cameras: the true ones of all stages; errors: of its images;
    corner_pairs: pixels (182, 2) of the board of step k, before and after it.
    """

    rig: object
    cameras: list
    errors: object
    corner_pairs: list

    @property
    def true(self):
        """The camera that sees the tin."""
        return self.cameras[LAST]


def boards_by_hand(rig, rng):
    """T_camera_board (3, 4, 4) of the boards of all steps, held by hand."""
    steps_mm = [STAGES_MM[k : k + 2] for k in range(LAST)]
    return np.stack([rig.board_pose(rng, deflections=pair) for pair in steps_mm])


def bent_mirror(rig, bench, errors, T_camera_boards, rng):
    """The BentMirror at an error level, with boards in these poses."""
    seed = int(rng.integers(2**32))
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    images = []
    for k, T in enumerate(T_camera_boards):
        pair = cameras[k : k + 2]
        images.append([seen_board(rig, camera, T, errors, rng) for camera in pair])
    return BentMirror(rig, cameras, errors, images)


def calibrations(bent, seed, ways=EVERY_WAY):
    """{way: (camera of the last stage, "")}, or (None, code of the error).

    seed: of the errors of the primary stage.
    """
    found = {"true": (bent.true, "")} if "true" in ways else {}
    if "published" in ways:
        try:
            found["published"] = stage_by_stage(bent, seed), ""
        except CalibrationError as refusal:
            found["published"] = None, refusal.code
    return found


def stage_by_stage(bent, seed):
    """The camera of the last stage, each stage from the one before."""
    rng = np.random.default_rng(seed)
    first = primary(bent.rig, bent.cameras[0], PUBLISHED, bent.errors, rng)
    found, points = first.camera, bent.rig.board.points()
    for pair, true in zip(bent.corner_pairs, bent.cameras[1:], strict=True):
        found = deflected(found, true, pair, points, first.clamp, PUBLISHED).camera
    return found


# A tin in the mirror: a box of three printed faces, seen from two positions.
#
# The positions are 100 mm apart. Its faces meet at the angles of the thesis's laser
# scan (Table 5.8), so that the reference is the same. The corner where all three meet
# points to the mirror. In the camera's frame the tin moves by the inverse motion.
#
# Frame of the tin: origin at that corner; axes nearly along the outward normals of top,
# left and right face; mm. Left and right as from the mirror, top is up.


FACES = ("top", "left", "right")
PAIRS = {"top_left": (0, 1), "top_right": (0, 2), "left_right": (1, 2)}
# Degrees, inside the tin, of PAIRS: laser scan of Table 5.8.
ANGLES_DEG = np.array([90.28, 89.15, 89.17])
# Width of the right face, of the left face, and height, mm.
RIGHT_MM, LEFT_MM, HEIGHT_MM = 70.0, 70.0, 90.0
# Between the two images (5.3.5).
SHIFT_MM = 100.0
# Distance from the mirror to the tin's middle; its tilt towards the mirror, to show the
# top; errors of placing by hand, mm and radians.
DISTANCE_MM, LEAN = 300.0, np.radians(30.0)
BY_HAND_MM, BY_HAND = 5.0, np.radians(3.0)
# Print: mm per pixel, sizes of its blots (mm), grey levels, and the room behind.
PRINT_MM, BLOTS_MM, INK, PAPER, ROOM = 0.2, (0.8, 1.6, 3.2, 6.4), 0.06, 0.85, 0.3
WORDS = ("CAFE", "RAXEL", "MOKKA")


class TinFace(NamedTuple):
    """One face: pose and printed rectangle.

    T_tin_face (4, 4): x to the right and y down on the face, z into the tin; low, high:
    (2,) mm, corners of the rectangle.
    """

    T_tin_face: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def corners(self):
        """Points (4, 3) at its corners, the tin's frame."""
        ends = np.stack([self.low, self.high])
        grid = np.stack(np.meshgrid(*ends.T), axis=-1).reshape(-1, 2)
        return transform(self.T_tin_face, on_plane(grid))

    def points(self, rng, count):
        """Random points (count, 3) on the face, the tin's frame."""
        return transform(
            self.T_tin_face, on_plane(rng.uniform(self.low, self.high, (count, 2)))
        )


def outward_normals():
    """Unit (3, 3), a row for each face, that meet at ANGLES_DEG."""
    products = np.eye(3)
    for (a, b), degrees in zip(PAIRS.values(), ANGLES_DEG, strict=True):
        products[a, b] = products[b, a] = -np.cos(np.radians(degrees))
    return np.linalg.cholesky(products)


@lru_cache(maxsize=1)
def faces():
    """The three TinFaces. Left and right share their upright edge to the last digit."""
    top, left, right = outward_normals()
    upright = np.cross(right, left)
    return (
        _face(top, np.cross(top, right), (0.0, -LEFT_MM), (RIGHT_MM, 0.0)),
        _face(left, np.cross(upright, -left), (-LEFT_MM, 0.0), (0.0, HEIGHT_MM)),
        _face(right, np.cross(upright, -right), (0.0, 0.0), (RIGHT_MM, HEIGHT_MM)),
    )


def _face(normal, across, low, high):
    x = across / np.linalg.norm(across)
    R = np.column_stack([x, np.cross(-normal, x), -normal])
    return TinFace(pose(R, np.zeros(3)), np.array(low), np.array(high))


def middle_ray(camera):
    """Origin (3,) and direction (3,) of the scene ray at the mirror's middle."""
    mirror = camera.mirror
    x = np.array([mirror.end / 2])
    z = mirror.height(x, 0 * x)[0]
    place = transform(camera.T_viewer_mirror, np.column_stack([x, 0 * x, z]))
    rays = camera.rays(camera.viewer.project(place).pixels)
    return rays.origins[0], rays.directions[0]


def two_places(camera, rng):
    """T_camera_tin (2, 4, 4) before and after the camera moves by SHIFT_MM.

    The camera moves horizontally, perpendicular to the mirror's middle ray; the tin is
    on that ray half way. Errors of placing by hand are drawn from `rng`.
    """
    origin, z = middle_ray(camera)
    x = np.cross([0, 1, 0], z)
    x /= np.linalg.norm(x)
    view = np.column_stack([x, np.cross(z, x), z])
    s = np.sqrt(0.5)
    facing = np.array([[0, -s, s], [-1, 0, 0], [0, -s, -s]])
    turn = rotation_from_vector(rng.normal(0, BY_HAND, 3))
    lean = rotation_from_vector([LEAN, 0, 0])
    R = view @ turn @ lean @ facing
    middle = R @ (-np.array([HEIGHT_MM, RIGHT_MM, LEFT_MM]) / 2)
    at = origin + DISTANCE_MM * z + rng.normal(0, BY_HAND_MM, 3) - middle
    half = SHIFT_MM / 2 * x
    return np.stack([pose(R, at - half), pose(R, at + half)])


def tin_points(rng, count):
    """(points (count, 3), face (count,)) at random on the tin, by area."""
    size = [np.prod(face.high - face.low) for face in faces()]
    which = np.sort(rng.choice(3, count, p=np.array(size) / sum(size)))
    points = [
        face.points(rng, int(n))
        for face, n in zip(faces(), np.bincount(which, minlength=3), strict=True)
    ]
    return np.concatenate(points), which


def tin_scene(T_camera_tin):
    """The TexturedScene of the tin in front of a uniform wall."""
    parts = []
    for face, texture in zip(faces(), prints(), strict=True):
        # A texture begins at uv = (0, 0): the rectangle's own corner.
        T = T_camera_tin @ face.T_tin_face @ pose(np.eye(3), [*face.low, 0.0])
        parts.append((Rectangle(T, *(face.high - face.low)), texture))
    return TexturedScene(tuple(parts), ROOM)


@lru_cache(maxsize=1)
def prints():
    """ImageTextures of the three faces: blots of several sizes, a frame and a word."""
    rng = np.random.default_rng(58)
    return [
        ImageTexture(_print(face, word, rng), PRINT_MM)
        for face, word in zip(faces(), WORDS, strict=True)
    ]


def _print(face, word, rng):
    width, height = np.rint((face.high - face.low) / PRINT_MM).astype(int)
    image = np.zeros((height, width))
    for size in BLOTS_MM:
        blots = rng.normal(size=image.shape)
        blots = cv2.GaussianBlur(blots, (0, 0), size / PRINT_MM / 2)
        image += blots / blots.std()
    image = np.rint(255 / (1 + np.exp(-1.5 * image))).astype(np.uint8)
    edge = int(2 / PRINT_MM)
    cv2.rectangle(image, (edge, edge), (width - edge, height - edge), 0, edge // 2)
    font, scale, thick = cv2.FONT_HERSHEY_SIMPLEX, 0.45 / PRINT_MM, int(2.6 / PRINT_MM)
    (wide, tall), _ = cv2.getTextSize(word, font, scale, thick)
    low = int((width - wide) / 2), int((height + tall) / 2)
    # A white label behind the word.
    margin = (np.array([3, 5]) / PRINT_MM).astype(int)
    box = np.array(low) - [0, tall] - margin, np.array(low) + [wide, 0] + margin
    cv2.rectangle(image, *(tuple(map(int, at)) for at in box), 255, cv2.FILLED)
    cv2.putText(image, word, low, font, scale, 0, thick)
    return INK + (PAPER - INK) * image / 255


# A tin from pairs of rays: points, a plane for each face, angles between planes.


# A point farther from its plane than this, in robust deviations, is an outlier of
# Fig. 5.23; a normal law has one in two thousand there.
OUTLYING = 3.5
STEP_PX = 1.0  # rays around a pixel are needed, to propagate its noise
MIN_N_POINTS = 12  # of a face


class FoundTin(NamedTuple):
    """A reconstructed tin.

    points (n, 3) mm, frame of the first image's camera; face (n,): 0 to 2; planes:
    PlaneFit of each face; distances (n,) mm from their planes, positive outside;
    angles (3,) degrees, inside the tin, of PAIRS; used (N,) bool: which pairs of rays
    became points.
    """

    points: np.ndarray
    face: np.ndarray
    planes: list
    distances: np.ndarray
    angles: np.ndarray
    used: np.ndarray = None

    def scores(self):
        """Scores that a trial keeps."""
        off = self.angles - ANGLES_DEG
        each = [self.distances[self.face == k] for k in range(3)]
        return {
            **{f"angle.{pair}": float(self.angles[k]) for k, pair in enumerate(PAIRS)},
            "off_deg": float(np.abs(off).max()),
            "points": len(self.points),
            "rms_mm": float(np.sqrt(np.mean(self.distances**2))),
            **{f"qq.{face}": normality(each[k]) for k, face in enumerate(FACES)},
            **{
                f"qq_all.{face}": normality(each[k], np.inf)
                for k, face in enumerate(FACES)
            },
        }


def with_rays(camera, pixels):
    """Which pixels (N, 2) have rays, they and their neighbours, (N,) bool."""
    steps = STEP_PX * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    there = camera.rays((pixels + steps[:, None]).reshape(-1, 2)).valid
    return there.reshape(len(steps), -1).all(axis=0)


def ray_pairs(camera, pixels, sd_px):
    """(NoisyRays of both images (n,), which (N,) of the pairs have rays).

    pixels: (2, N, 2).
    """
    known = np.all([with_rays(camera, p) for p in pixels], axis=0)
    return [rays_of_pixels(camera, p[known], sd_px) for p in pixels], known


def tin_of(rays, face, T_second_first):
    """FoundTin of pairs of rays whose faces (n,) are known, by the camera's motion.

    Points are those nearest to both rays (5.3.5). Raises InputError for a face
    with too few.
    """
    poses = np.stack([np.eye(4), T_second_first])
    found = triangulate([RayView(r) for r in rays], poses, linear=True)
    tin = tin_through(found.points[found.valid], face[found.valid])
    return tin._replace(used=found.valid)


def tin_through(points, face):
    """FoundTin of points (n, 3) on known faces (n,)."""
    count = np.bincount(face, minlength=3)
    if count.min() < MIN_N_POINTS:
        few = FACES[int(count.argmin())]
        raise InputError(
            f"tin: {count.min()} points on the {few} face; {MIN_N_POINTS} are needed"
        )
    planes = [fit_plane(points[face == k]) for k in range(3)]
    middles = np.array([plane.T_frame_plane[:3, 3] for plane in planes])
    normals = np.array([plane.normal for plane in planes])
    # A face's normal points away from the middle of all three.
    away = np.einsum("ki,ki->k", middles - middles.mean(axis=0), normals)
    sign = np.where(away < 0, -1, 1)
    normals = sign[:, None] * normals
    distances = np.empty(len(points))
    for k, plane in enumerate(planes):
        distances[face == k] = sign[k] * plane.residuals
    angles = [angle_inside(normals[a], normals[b]) for a, b in PAIRS.values()]
    return FoundTin(points, face, planes, distances, np.array(angles))


def angle_inside(first, second):
    """Degrees between two faces inside a solid, of their outward unit normals."""
    return 180 - np.degrees(
        np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second)
    )


def usual(distances, within=OUTLYING):
    """Which distances (n,) are not outliers, (n,) bool."""
    off = np.abs(distances - np.median(distances))
    return off <= within * 1.4826 * np.median(off)


def normality(distances, within=OUTLYING):
    """Correlation of distances (n,) with normal quantiles of their ranks.

    Outliers are excluded, except for `within` infinity.
    """
    d = np.sort(distances[usual(distances, within)])
    ranks = ndtri((np.arange(len(d)) + 0.5) / len(d))
    return float(np.corrcoef(d, ranks)[0, 1])


# The tin with drawn matches: published calibration and true mirror.
#
# Matches are projections by the true camera with Gaussian noise; no feature is
# detected. Both mirrors have the same boards and the same matches.


# Number of matches in the thesis, and noise of each end along an axis, px.
MATCHES, MATCH_PX = 460, 0.2
# px between the pixels whose rays are compared.
COMPARED_PX = 96
RUN_SETTINGS = SETTINGS | {
    "matches": MATCHES,
    "match_px": MATCH_PX,
    "shift_mm": SHIFT_MM,
    "tin_mm": DISTANCE_MM,
    "angles_deg": list(map(float, ANGLES_DEG)),
}


def tin_trial(condition, rng, errors, benches, ways=EVERY_WAY):
    """Every measure of one run, for some levels and mirrors, with the same draws.

    errors: {geometry: MirrorErrors}; benches: {name: Bench}.
    """
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig, boards = errors[condition["geometry"]], boards_by_hand(rig, rng)
    out = {}
    for name, bench in benches.items():
        given, drawn = of_rig.on(bench), np.random.default_rng(seed)
        bent = bent_mirror(rig, bench, given, boards, drawn)
        out[name] = of_bench(bent, seed, ways, drawn)
    return out


def of_bench(bent, seed, ways, rng):
    """{mirror: scores} of a BentMirror; `refused`: code of the error that ended one."""
    T = two_places(bent.true, rng)
    points, face = tin_points(rng, MATCHES)
    pixels = np.stack([bent.true.project(transform(one, points)).pixels for one in T])
    pixels += rng.normal(0, MATCH_PX, pixels.shape)
    out = {}
    for way, (camera, code) in calibrations(bent, seed, ways).items():
        out[way] = {"refused": code}
        if camera is None:
            continue
        try:
            out[way] = scored(camera, pixels, face, motion_of(T))
        except InputError as refusal:
            out[way] = {"refused": refusal.code}
            continue
        rays = lattice(bent.true, COMPARED_PX)
        out[way]["ray_deg"] = float(np.nanmean(ray_angles(camera, bent.true, rays)))
    return out


def motion_of(T_camera_tin):
    """T_second_first (4, 4) of the camera, known from the stage that carries it."""
    shift = T_camera_tin[1][:3, 3] - T_camera_tin[0][:3, 3]
    return pose(np.eye(3), shift)


def scored(camera, pixels, face, T_second_first):
    """Scores of the tin reconstructed from matches (2, N, 2), with a known motion."""
    rays, known = ray_pairs(camera, pixels, MATCH_PX)
    found = tin_of(rays, face[known], T_second_first)
    return found.scores() | {"distances": found.distances, "face": found.face}


# Rendered images of the tin in the bent mirror, its matched features, and its model.
#
# Two images are rendered by the simulator. Features are detected and matched by SIFT;
# matches whose rays miss each other are excluded. The face of a match is known from the
# simulation, as a person knows it from the image, and so is whether it is on the tin.


# Error of a match along an axis, px, as measured in images of other seeds; largest gap
# between the rays of correct matches, standard deviations, calibration errors included.
FEATURE_PX, MAX_GAP = 0.3, 12.0
# Largest distance of a point from its face, robust deviations.
MAX_FACE_SIGMAS = 6.0
# Points across and down each face that are projected into the image, and the factor by
# which its texture is finer: pixels between them are interpolated.
COARSE, FINER = 24, 8


class TinImages(NamedTuple):
    """Two images of the tin and their matches.

    images: two (h, w) uint8; first: (2, 2), first pixel of each in the camera's whole
    image; T_camera_tin: (2, 4, 4), true; matches: FeatureMatches, pixels of the whole
    image; face (n,): 0 to 2, -1 outside the tin; off (n, 2): px, error of a match's
    second end given the true point of its first end, NaN outside the tin.
    """

    images: list
    first: np.ndarray
    T_camera_tin: np.ndarray
    matches: object
    face: np.ndarray
    off: np.ndarray


def taken_images(rig, camera, margin_px, rng):
    """TinImages by a true camera of a rig, of the tin and some pixels around it."""
    T = two_places(camera, rng)
    images, first = [], []
    for one in T:
        corners = transform(one, np.concatenate([face.corners() for face in faces()]))
        window = window_around(camera, camera.project(corners).pixels, margin_px)
        taken = windowed(replace(rig.rig, camera=camera), window).laboratory()
        images.append(taken.render(tin_scene(one), np.eye(4), rng))
        first.append([window.u, window.v])
    first, found = np.array(first, float), match_features(*images)
    found = found._replace(pixels=found.pixels + first[:, None])
    return TinImages(images, first, T, found, *truth_of(camera, T, found.pixels))


def truth_of(camera, T_camera_tin, pixels):
    """(face (n,), off (n, 2)) of TinImages, of matches (2, n, 2)."""
    rays = camera.rays(pixels[0])
    face, nearest = np.full(len(rays.origins), -1), np.inf
    points = np.full(rays.origins.shape, np.nan)
    for k, one in enumerate(faces()):
        T = T_camera_tin[0] @ one.T_tin_face
        met = intersect_rays_plane(rays.origins, rays.directions, T).points
        there = transform(T, on_plane(met))
        distance = np.linalg.norm(there - rays.origins, axis=1)
        with np.errstate(invalid="ignore"):
            on = np.all((met >= one.low) & (met <= one.high), axis=1)
            on &= rays.valid & (distance < nearest)
        nearest = np.where(on, distance, nearest)
        face[on] = k
        points[on] = transform(T_camera_tin[1] @ one.T_tin_face, on_plane(met[on]))
    off = np.full((len(face), 2), np.nan)
    on = face >= 0
    off[on] = pixels[1][on] - camera.project(points[on]).pixels
    return face, off


def images_trial(condition, rng, errors, benches, ways):
    """Reconstruct the tin from small images at each of some levels, with each mirror.

    condition: "geometry", and "margin_px" that is rendered around the tin.
    """
    rig = mirror_rig(condition["geometry"], small=True)
    seed, boards = int(rng.integers(2**32)), boards_by_hand(rig, rng)
    of_rig = errors[condition["geometry"]]
    # Errors in px are those of images with four times the pixels in each direction.
    of_rig = of_rig._replace(corner=of_rig.corner / 4, plate=of_rig.plate / 4)
    out = {}
    for name, bench in benches.items():
        given, drawn = of_rig.on(bench), np.random.default_rng(seed)
        bent = bent_mirror(rig, bench, given, boards, drawn)
        try:
            taken = taken_images(rig, bent.true, condition["margin_px"], drawn)
        except InputError as refusal:
            out[name] = {"refused": refusal.code}
            continue
        out[name] = of_matches(taken)
        for way, (camera, code) in calibrations(bent, seed, ways).items():
            if camera is None:
                out[name][way] = {"refused": code}
                continue
            try:
                out[name][way] = model(camera, taken)
            except InputError as refusal:
                out[name][way] = {"refused": refusal.code}
    return out


def of_matches(taken):
    """Counts and errors of the matches on the tin.

    Errors of the correct ones (within 3 px), along an axis and for one end of two.
    """
    off = taken.off[taken.face >= 0]
    right = np.linalg.norm(off, axis=1) < 3
    return {
        "features": int(min(taken.matches.features)),
        "matches": len(taken.face),
        "on_tin": len(off),
        "wrong": int(np.count_nonzero(~right)),
        "match_px": float(np.sqrt(np.mean(off[right] ** 2) / 2)),
        "picture": taken.images[0],
    }


def model(camera, taken):
    """Scores of the tin that a camera reconstructs, and its textured faces."""
    pixels, face = taken.matches.pixels, taken.face
    on = face >= 0
    rays, known = ray_pairs(camera, pixels[:, on], FEATURE_PX)
    face, off = face[on][known], taken.off[on][known]
    T = motion_of(taken.T_camera_tin)
    pairs = matched_rays(*rays)
    right = np.abs(gaps(*pairs.about_centre(T), pairs)) < MAX_GAP
    found = tin_of([r.of(right) for r in rays], face[right], T)
    # A wrong match whose rays meet nevertheless is far from its face.
    near = np.zeros(len(found.points), bool)
    for k in range(3):
        near[found.face == k] = usual(found.distances[found.face == k], MAX_FACE_SIGMAS)
    kept = np.zeros(len(right), bool)
    kept[np.flatnonzero(right)[found.used][near]] = True
    found = tin_through(found.points[near], found.face[near])
    wrong = np.linalg.norm(off, axis=1) >= 3
    out = found.scores()
    out |= {
        "left_out": int(np.count_nonzero(~kept)),
        "wrong_kept": int(np.count_nonzero(wrong & kept)),
        "distances": found.distances,
        "face": found.face,
        "at": found.points,
    }
    for k, name in enumerate(FACES):
        sheet, texture = textured(camera, taken, found, k)
        out |= {f"sheet.{name}": sheet, f"texture.{name}": texture}
    return out


def textured(camera, taken, found, k):
    """(sheet (2, 2, 3) mm, texture (h, w) uint8) of face k.

    The parallelogram on its plane that its points fill, from the corner where all three
    planes meet, along the edges where it meets the two others. Each point has the grey
    value that the calibrated camera sees there.
    """
    normals = np.array([plane.normal for plane in found.planes])
    through = np.array([plane.T_frame_plane[:3, 3] for plane in found.planes])
    corner = np.linalg.solve(normals, np.sum(normals * through, axis=1))
    edges = np.cross(normals[k], np.delete(normals, k, axis=0))
    points = found.points[found.face == k] - corner
    within = np.linalg.lstsq(edges.T, points.T, rcond=None)[0]
    far = [along[np.argmax(np.abs(along))] for along in within]
    share = np.linspace(0, 1, COARSE)
    u, v = np.meshgrid(*(share * end for end in far))
    places = corner + u.reshape(-1, 1) * edges[0] + v.reshape(-1, 1) * edges[1]
    seen = camera.project(places)
    at = np.where(seen.valid[:, None], seen.pixels - taken.first[0], np.nan)
    fine = [zoom(at[:, i].reshape(COARSE, COARSE), FINER, order=1) for i in (0, 1)]
    maps = [np.nan_to_num(one, nan=-1.0).astype(np.float32) for one in fine]
    texture = cv2.remap(taken.images[0], *maps, cv2.INTER_LINEAR)
    corners = places.reshape(COARSE, COARSE, 3)[[0, 0, -1, -1], [0, -1, 0, -1]]
    return corners.reshape(2, 2, 3), texture
