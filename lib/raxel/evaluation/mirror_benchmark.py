"""Scores of a calibration of a mirror that bends, against the truth of a rendered set.

The folder `truth` of a rendered mirror set holds the true camera of every stage. It is
opened here and by no detector, decoder or calibration.

- Rays are compared at every STEP_PX-th pixel each way, counted from pixel (0, 0), where
  the true camera has a ray. Which of them an entrant answers is told apart, as a share.
- The mirror's face is compared on cells of CELL_MM, so that it does not matter where an
  entrant has many points and where few.
- Frames: both are the viewer's, but what an entrant takes for its axes is his own
  calibration's matter (a principal point 1 px off turns them). The rotation that maps
  the viewing rays before the mirror best, which no mirror has touched, is taken out
  first, where the entrant gives such rays.
"""

from typing import NamedTuple

import numpy as np

from raxel.cameras.io import load_camera
from raxel.cameras.mirrors.flexible import FlexibleMirrorCamera
from raxel.errors import InputError
from raxel.evaluation.mirror_mistakes import (
    angles_between,
    check_points,
    check_rays,
    distances_aside,
)
from raxel.evaluation.mirror_result import SampledRays, StageAnswer, read_mirror_result
from raxel.geometry.poses import (
    angle_between_rotations,
    inverse_pose,
    nearest_rotation,
    transform,
)

TRUTH = "truth"
# Pixels each way from one that is scored to the next.
STEP_PX = 8
# An answer of fewer of the pixels, or points, is none; to give none is allowed.
FEWEST_RAYS, FEWEST_POINTS = 30, 30
# A ray is right within this.
RIGHT_DEG = 0.1
# Cells of the mirror's face, mm. A deflection is read from the points within NEAR_MM of
# a place of the sheet's middle line that is this share of the way to the load: boards
# that are seen before and after a step seldom reach a load near the free edge.
CELL_MM, NEAR_MM, FEWEST_NEAR = 5.0, 10.0, 6
READ_AT, LINE_NODES = 0.75, 4097
# Axes of two calibrations of one viewer do not differ by more, degrees.
MOST_TURN = 5.0


class StageScores(NamedTuple):
    """Errors of one stage: of what the benchmark's numbers are made.

    scored: how many pixels truly have a ray; angles (n,) degrees, aside (n,) mm: of
    those answered; cells: how many the mirror's face has; heights (m,) and rms (m,)
    mm: mean error of the points in each cell that has any, and their RMS, positive
    away from the light; beside: points that lie over no cell; read (k, 3): for each
    load where it is read along the sheet, the true height there and the found one, mm,
    NaN where there are no points.
    """

    scored: int
    angles: np.ndarray
    aside: np.ndarray
    cells: int
    heights: np.ndarray
    rms: np.ndarray
    beside: int
    read: np.ndarray


def scored_pixels(size):
    """Pixels (N, 2) of a picture (width, height): every STEP_PX-th each way."""
    v, u = np.mgrid[0 : size[1] : STEP_PX, 0 : size[0] : STEP_PX]
    return np.column_stack([u.ravel(), v.ravel()]).astype(float)


def score_mirror_file(mirror_set, path):
    """`score_mirror` of the result file at `path`, which complaints name.

    Raises InputError as `read_mirror_result` and `score_mirror`.
    """
    result = read_mirror_result(path)
    try:
        return score_mirror(mirror_set, result)
    except InputError as fault:
        if not str(fault).startswith("field "):
            raise
        raise InputError(f"{path}: {fault}") from fault


def score_mirror(mirror_set, result):
    """A MirrorResult against the truth of a rendered MirrorSet: a dict.

    set, method, seconds (as stated, or None); turned_deg: the rotation that was taken
    out, and viewer_rms_deg: what the viewing rays are off beside it, None where there
    are none; stages: for each

    - rays: scored (pixels), share_with_ray, share_right (of all that are scored), deg
      (angles) and mm (how far a ray passes the place where the true one begins), each
      as rms, median and max;
    - height: cells, share_covered, beside, mean_mm (signed), rms_mm, median_mm, max_mm;
    - deflections: for each load load_mm, read_at_mm, true_mm, found_mm, error_mm;

    all: the same over all stages. None stands where there is no answer. Raises
    InputError, one line, for a set without truth, a result of another set, with another
    number of stages or too few pixels of those that are scored, and as `check_rays` and
    `check_points`.
    """
    cameras = true_cameras(mirror_set)
    _check_same(mirror_set, result)
    R, turned, viewer = _turn(cameras[0], result.viewer)
    stages = []
    for k, (answer, camera) in enumerate(zip(result.stages, cameras, strict=True)):
        answer = _in_frame(_scored_only(f"stage{k}", answer), R)
        _check(f"stage{k}", answer, camera)
        stages.append(stage_scores(answer, camera, mirror_set.size))
    loads = cameras[0].mirror.profile.loads
    return {
        "set": mirror_set.name,
        "method": result.method,
        "seconds": result.seconds,
        "turned_deg": turned,
        "viewer_rms_deg": viewer,
        "stages": [
            {"stage": k} | _stage_fields(one, stages[0], loads)
            for k, one in enumerate(stages)
        ],
        "all": _all_fields(stages),
    }


def true_cameras(mirror_set):
    """The FlexibleMirrorCameras of the stages, out of the truth, or InputError."""
    folder = mirror_set.folder / TRUTH
    if not folder.is_dir():
        raise InputError(
            f"{folder}: no such folder; scores need a mirror set as raxel render makes "
            "it, with its truth"
        )
    cameras = []
    for k in range(len(mirror_set.steps) + 1):
        path = folder / f"stage-{k}.npz"
        camera = load_camera(path)
        if not isinstance(camera, FlexibleMirrorCamera):
            raise InputError(
                f"{path}: field 'kind': found {camera.kind!r}; give the set as it was "
                "rendered"
            )
        if (camera.width, camera.height) != mirror_set.size:
            raise InputError(
                f"{path}: a camera of {camera.width} x {camera.height} px; give the "
                "set as it was rendered"
            )
        cameras.append(camera)
    return cameras


def _check_same(mirror_set, result):
    if result.set != mirror_set.name:
        raise InputError(
            f"field 'set': found {result.set!r}, and the set is {mirror_set.name!r}; "
            "give the result of this set"
        )
    if result.size != mirror_set.size:
        found, own = (f"{w} x {h} px" for w, h in (result.size, mirror_set.size))
        raise InputError(f"field 'size': found {found}, and the set has {own}")
    stages = len(mirror_set.steps) + 1
    if len(result.stages) != stages:
        raise InputError(
            f"field 'stages': found {len(result.stages)}, and the set has {stages}; "
            "give each, empty where there is no answer"
        )


def _turn(true, viewer):
    """(rotation into the true frame, its angle in degrees, RMS left in degrees)"""
    if viewer is None:
        return np.eye(3), 0.0, None
    pixels, directions = viewer
    looks = true.viewer.rays(pixels)
    seen, wanted = directions[looks.valid], looks.directions[looks.valid]
    if len(seen) < FEWEST_RAYS:
        raise InputError(
            f"field 'viewer.pixels': found {len(seen)} in the picture; give "
            f"{FEWEST_RAYS} or more, all over it, or leave viewer out"
        )
    try:
        R = nearest_rotation(wanted.T @ seen)
    except InputError as fault:
        raise InputError(
            "field 'viewer.directions': parallel, so that they do not tell how the "
            "viewer is turned; give rays all over the picture, or leave viewer out"
        ) from fault
    turned = np.degrees(angle_between_rotations(R, np.eye(3)))
    if turned > MOST_TURN:
        raise InputError(
            f"field 'viewer.directions': turned by {turned:.3g} degrees against the "
            "true ones; give the viewer's frame: x right, y down, z into the scene"
        )
    left = angles_between(seen @ R.T, wanted)
    return R, float(turned), float(np.sqrt(np.mean(left**2)))


def _in_frame(answer, R):
    rays, points = answer
    if rays is not None:
        rays = SampledRays(rays.pixels, rays.origins @ R.T, rays.directions @ R.T)
    return StageAnswer(rays, None if points is None else points @ R.T)


def _scored_only(stage, answer):
    """The answer with the pixels that are scored; InputError where it has too few."""
    rays, points = answer
    if points is not None and 0 < len(points) < FEWEST_POINTS:
        raise InputError(
            f"field '{stage}.points': found {len(points)}; give {FEWEST_POINTS} or "
            "more, all over the mirror"
        )
    if rays is None or not len(rays.pixels):
        return answer
    mine = np.all(rays.pixels % STEP_PX == 0, axis=1)
    if np.count_nonzero(mine) < FEWEST_RAYS:
        raise InputError(
            f"field '{stage}.pixels': {np.count_nonzero(mine)} of {len(mine)} are "
            f"scored; give every {STEP_PX}th each way, from (0, 0), {FEWEST_RAYS} at "
            "least"
        )
    return StageAnswer(SampledRays(*(part[mine] for part in rays)), points)


def _check(stage, answer, camera):
    """Raise InputError for what is told in another frame or unit."""
    rays, points = answer
    if rays is not None and len(rays.pixels):
        check_rays(f"field '{stage}.directions'", rays, camera)
    if points is not None and len(points):
        check_points(f"field '{stage}.points'", points, camera)


def stage_scores(answer, camera, size):
    """StageScores of a StageAnswer.

    answer: with pixels of `scored_pixels` alone; camera: the true one of the stage;
    size: (width, height) px.
    """
    rays = _ray_errors(answer.rays, camera, size)
    return StageScores(*rays, *_height_errors(answer.points, camera))


def _ray_errors(rays, camera, size):
    """(pixels that truly have a ray, degrees (n,), mm (n,) of those answered)"""
    pixels = scored_pixels(size)
    truly = camera.rays(pixels)
    if rays is None:
        return np.count_nonzero(truly.valid), np.empty(0), np.empty(0)
    # The row of each of the answer's pixels among those that are scored.
    at = (rays.pixels // STEP_PX @ [1, -(-size[0] // STEP_PX)]).astype(int)
    mine = np.flatnonzero(truly.valid[at])
    at = at[mine]
    angles = angles_between(rays.directions[mine], truly.directions[at])
    aside = distances_aside(
        rays.origins[mine], rays.directions[mine], truly.origins[at]
    )
    return np.count_nonzero(truly.valid), angles, aside


def _height_errors(points, camera):
    """(cells, mean (m,) and RMS (m,) mm of cells with points, points beside, read)

    Cells are those of the sheet laid flat, ahead of its holder. Heights are those over
    the sheet before it bends, along the mirror's z axis, which is the way in which a
    load moves it. The last is as in StageScores.
    """
    mirror = camera.mirror
    size = mirror.size - [mirror.holder, 0]
    counts = np.ceil(size / CELL_MM).astype(int)
    cells = int(counts.prod())
    read = _reading_places(mirror)
    if points is None or not len(points):
        return cells, np.empty(0), np.empty(0), 0, read
    place = transform(inverse_pose(camera.T_viewer_mirror), points)
    over = mirror.carries(place)
    x, y, z = place[over].T
    error = z - mirror.height(x, y)[0]
    flat = np.column_stack(mirror.flat(x, y)) - [mirror.holder, -mirror.half_width]
    cell = np.clip((flat / size * counts).astype(int), 0, counts - 1) @ [1, counts[0]]
    n = np.bincount(cell, minlength=cells)
    filled = n > 0
    mean = np.bincount(cell, error, cells)[filled] / n[filled]
    square = np.bincount(cell, error**2, cells)[filled] / n[filled]
    for row in read:
        row[2] = row[1] + _error_at(_across(mirror, row[0]) - x, y, error)
    return cells, mean, np.sqrt(square), int(np.count_nonzero(~over)), read


def _reading_places(mirror):
    """(k, 3) mm: where deflections are read along the sheet, true heights, NaN."""
    along = READ_AT * mirror.profile.loads
    height = mirror.height(_across(mirror, along), np.zeros(len(along)))[0]
    return np.column_stack([along, height, np.full(len(along), np.nan)])


def _across(mirror, along):
    """x of places `along` the sheet's middle line, mm from the clamp."""
    x = np.linspace(0, mirror.end, LINE_NODES)
    return np.interp(along, mirror.flat(x, np.zeros(LINE_NODES))[0], x)


def _error_at(x, y, error):
    """The error (n,) at x = y = 0, by a plane through those near it; NaN if too few."""
    near = np.hypot(x, y) <= NEAR_MM
    if np.count_nonzero(near) < FEWEST_NEAR:
        return np.nan
    rows = np.column_stack([np.ones(near.sum()), x[near], y[near]])
    return np.linalg.lstsq(rows, error[near], rcond=None)[0][0]


def _stage_fields(one, first, loads):
    """The scores of a stage by name, as `score_mirror` lists them."""
    return {
        "rays": _ray_fields(one.scored, one.angles, one.aside),
        "height": _height_fields(one.cells, one.heights, one.rms, one.beside),
        "deflections": [
            {
                "load_mm": float(load),
                "read_at_mm": float(place),
                "true_mm": float(true),
                "found_mm": _known(found),
                "error_mm": _known(found - true),
            }
            for load, (place, true, found) in zip(
                loads, _moved(one, first), strict=True
            )
        ],
    }


def _moved(one, first):
    """What was read at a stage, (k, 3), its heights those since the first stage."""
    return one.read - first.read * [0, 1, 1]


def _all_fields(stages):
    """The same over all stages; deflection_rms_mm over all readings of stages 1, 2,
    ..., None where one of them is not known."""
    names = "angles", "aside", "heights", "rms"
    angles, aside, heights, rms = (
        np.concatenate([getattr(stage, name) for stage in stages]) for name in names
    )
    scored, cells, outside = (
        sum(getattr(stage, name) for stage in stages)
        for name in ("scored", "cells", "beside")
    )
    _, true, found = np.concatenate([_moved(s, stages[0]) for s in stages[1:]]).T
    return {
        "rays": _ray_fields(scored, angles, aside),
        "height": _height_fields(cells, heights, rms, outside),
        "deflection_rms_mm": _known(np.sqrt(np.mean((found - true) ** 2))),
    }


def _ray_fields(scored, angles, aside):
    right = np.count_nonzero(angles <= RIGHT_DEG)
    return {
        "pixels": int(scored),
        "share_with_ray": len(angles) / scored if scored else None,
        "share_right": right / scored if scored else None,
        **_spread(angles, "deg"),
        **_spread(aside, "mm"),
    }


def _height_fields(cells, heights, rms, outside):
    return {
        "cells": int(cells),
        "share_covered": len(heights) / cells,
        "beside": int(outside),
        "mean_mm": float(np.mean(heights)) if len(heights) else None,
        **_spread(rms, "mm"),
    }


def _spread(errors, unit):
    """{rms_unit, median_unit, max_unit} of errors (N,), None where there are none."""
    if not len(errors):
        return dict.fromkeys((f"rms_{unit}", f"median_{unit}", f"max_{unit}"))
    return {
        f"rms_{unit}": float(np.sqrt(np.mean(errors**2))),
        f"median_{unit}": float(np.median(errors)),
        f"max_{unit}": float(errors.max()),
    }


def _known(value):
    return float(value) if np.isfinite(value) else None
