"""Rendered images of the tin in the bent mirror, its matched features, and its model.

Two images are rendered by the simulator. Features are detected and matched by SIFT;
matches whose rays miss each other are excluded. The face of a match is known from the
simulation, as a person knows it from the image, and so is whether it is on the tin.
"""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from scipy.ndimage import zoom

from chapters.ch05_flexible_mirror.s3_5_tin.trials.calibrated import (
    bent_mirror,
    boards_by_hand,
    calibrations,
)
from chapters.ch05_flexible_mirror.s3_5_tin.trials.faces import (
    ray_pairs,
    tin_of,
    tin_through,
    usual,
)
from chapters.ch05_flexible_mirror.s3_5_tin.trials.run import motion_of
from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import (
    FACES,
    faces,
    tin_scene,
    two_places,
)
from chapters.shared.mirror_rigs import mirror_rig
from raxel.errors import InputError
from raxel.features.sift import match_features
from raxel.geometry import intersect_rays_plane, transform
from raxel.geometry.planes import on_plane
from raxel.lab.windowed import window_around, windowed
from raxel.multiview.ray_gaps import gaps, matched_rays

# Error of a match along an axis, px, as measured in images of other seeds; largest gap
# between the rays of correct matches, standard deviations, calibration errors included.
FEATURE_PX, MAX_GAP = 0.3, 12.0
# Largest distance of a point from its face, robust deviations.
FAR = 6.0
# Points across and down each face that are projected into the image, and the factor by
# which its texture is finer: pixels between them are interpolated.
COARSE, FINER = 24, 8


class TinPictures(NamedTuple):
    """Two images of the tin and their matches.

    pictures: two (h, w) uint8; first: (2, 2), first pixel of each in the camera's whole
    image; T_camera_tin: (2, 4, 4), true; matches: FeatureMatches, pixels of the whole
    image; face (n,): 0 to 2, -1 outside the tin; off (n, 2): px, error of a match's
    second end given the true point of its first end, NaN outside the tin.
    """

    pictures: list
    first: np.ndarray
    T_camera_tin: np.ndarray
    matches: object
    face: np.ndarray
    off: np.ndarray


def taken_pictures(rig, camera, margin_px, rng):
    """TinPictures by a true camera of a rig, of the tin and some pixels around it."""
    T = two_places(camera, rng)
    pictures, first = [], []
    for one in T:
        corners = transform(one, np.concatenate([face.corners() for face in faces()]))
        window = window_around(camera, camera.project(corners).pixels, margin_px)
        taken = windowed(replace(rig.rig, camera=camera), window).laboratory()
        pictures.append(taken.photograph(tin_scene(one), np.eye(4), rng))
        first.append([window.u, window.v])
    first, found = np.array(first, float), match_features(*pictures)
    found = found._replace(pixels=found.pixels + first[:, None])
    return TinPictures(pictures, first, T, found, *truth_of(camera, T, found.pixels))


def truth_of(camera, T_camera_tin, pixels):
    """(face (n,), off (n, 2)) of TinPictures, of matches (2, n, 2)."""
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


def pictures_trial(condition, rng, errors, benches, ways):
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
            taken = taken_pictures(rig, bent.true, condition["margin_px"], drawn)
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
        "picture": taken.pictures[0],
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
        near[found.face == k] = usual(found.distances[found.face == k], FAR)
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
    texture = cv2.remap(taken.pictures[0], *maps, cv2.INTER_LINEAR)
    corners = places.reshape(COARSE, COARSE, 3)[[0, 0, -1, -1], [0, -1, 0, -1]]
    return corners.reshape(2, 2, 3), texture
