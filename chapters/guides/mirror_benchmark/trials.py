"""This library's entries: ways to calibrate a set's pictures, each scored as anybody's.

All get the same `MirrorViews`, that is, what was found in the pictures. None opens the
truth; `score_mirror` does.
"""

from time import process_time
from typing import NamedTuple

import numpy as np

from chapters.shared.records import set_of
from raxel.calibration.mirror.clamp_line import clamp_line, fixed_line
from raxel.calibration.mirror.from_pictures import mirror_views
from raxel.calibration.mirror.platter import grid_poses_in_platter
from raxel.calibration.mirror.primary import calibrate_primary
from raxel.calibration.mirror.stages import SETTINGS, calibrate_mirror
from raxel.calibration.mirror.update import MirrorSettings, update_mirror
from raxel.calibration.pose.three_point import placed_points
from raxel.errors import InputError
from raxel.evaluation.mirror_benchmark import score_mirror, scored_pixels
from raxel.evaluation.mirror_result import (
    MirrorResult,
    SampledRays,
    StageAnswer,
    sampled_result,
)

RIGS = "clean", "aberrated", "twisted", "two-loads"
LEVELS = "low", "middle", "high"
SEEDS = 1, 2, 3
# mm; the prior of chapter 5's targets, chosen there on runs that judge nothing.
PRIOR_MM = 0.1
LINE_POINTS = 9
RECORD = "mirrors"  # of data/records
NO_RAYS = SampledRays(np.empty((0, 2)), np.empty((0, 3)), np.empty((0, 3)))
NO_ANSWER = StageAnswer(NO_RAYS, np.empty((0, 3)))


class Answer(NamedTuple):
    """What a method makes of MirrorViews: a camera for each stage, as far as it got,
    or a StageAnswer where it has no camera; refused: why it got no further."""

    stages: tuple
    refused: str = ""


def as_published(views):
    """Distances along viewing rays, the clamp's place alone, each stage from the one
    before, by the corners common to both pictures."""
    poses = grid_poses_in_platter(views.viewer, views.platter, views.thickness)
    line = clamp_line(views.viewer, views.clamp.points)
    first = calibrate_primary(
        views.viewer, views.grids, poses,
        angle=line.angle, quantity="distance", span=line.points(LINE_POINTS),
    ).camera  # fmt: skip
    held = fixed_line(first, line)._replace(slopes=None)
    cameras = [first]
    try:
        for step in views.steps:
            found = update_mirror(
                cameras[-1], step.before.pixels, step.after.pixels, step.before.points,
                held, MirrorSettings(), outline=_shown_after(views, len(cameras)),
            )  # fmt: skip
            cameras.append(found.camera)
    except InputError as fault:
        return Answer(tuple(cameras), str(fault))
    return Answer(tuple(cameras))


def _shown_after(views, stage):
    """Pixels (N, 2) of all corners that the pictures of a stage show."""
    shown = [views.steps[stage - 1].after.pixels]
    shown += [step.before.pixels for step in views.steps[stage : stage + 1]]
    shown = np.concatenate(shown)
    return shown[np.isfinite(shown[:, 0])]


def stage_by_stage(views, settings=SETTINGS):
    """Inverse depth, place and slope of the clamp, as many knots as corners carry; each
    stage from the one before."""
    found = calibrate_mirror(views, settings=settings)
    return Answer((found.primary.camera, *(one.camera for one in found.updates)))


def all_after(views):
    """The same, with the corners that only the picture after shows a ray for."""
    return stage_by_stage(views, SETTINGS._replace(all_after=True))


def all_at_once(views, settings=SETTINGS):
    """What raxel calibrate does: after that, all stages and boards together."""
    return Answer(calibrate_mirror(views, settings=settings).cameras)


def with_prior(views):
    """All at once, with a prior that a sheet bends smoothly."""
    return all_at_once(views, SETTINGS._replace(prior_sd=PRIOR_MM))


def two_places(views):
    """The general camera: a ray through the two points that a pixel sees, and no model
    of a mirror. Nobody shows a monitor in two places at later stages."""
    poses = grid_poses_in_platter(views.viewer, views.platter, views.thickness)
    pixels = scored_pixels((views.viewer.width, views.viewer.height))
    u, v = pixels.astype(int).T
    seen = [grid.location[v, u].astype(float) for grid in views.grids[:2]]
    both = np.isfinite(seen).all(axis=(0, 2))
    near, far = (
        placed_points(points[both], T)
        for points, T in zip(seen, poses.T_camera_grid, strict=False)
    )
    along = far - near
    along *= np.where(_backwards(views.viewer, pixels[both], near, far), -1, 1)[:, None]
    directions = along / np.linalg.norm(along, axis=1, keepdims=True)
    first = StageAnswer(SampledRays(pixels[both], near, directions), None)
    return Answer((first,), "no monitor in two places after the first stage")


def _backwards(viewer, pixels, near, far):
    """Whether the second of two points (N, 3) lies nearer to the viewing ray, where the
    mirror is."""
    looks = viewer.rays(pixels).directions
    aside = [np.linalg.norm(np.cross(looks, p), axis=1) for p in (near, far)]
    return aside[1] < aside[0]


METHODS = {
    "published": as_published,
    "stages": stage_by_stage,
    "all_after": all_after,
    "at_once": all_at_once,
    "prior": with_prior,
    "two_places": two_places,
}


def entries(mirror_set):
    """Name of a method -> scores of its answer to a MirrorSet, with `refused`, why it
    ended early ('' where it did not), and `seconds` of one core from photographs on."""
    began = process_time()
    try:
        views = mirror_views(mirror_set)
    except InputError as fault:
        told = str(fault).replace(str(mirror_set.folder), mirror_set.name)
        return {name: {"refused": told, "answered": 0} for name in METHODS}
    reading = process_time() - began
    return {
        name: _entry(mirror_set, views, name, method, reading)
        for name, method in METHODS.items()
    }


def _entry(mirror_set, views, name, method, reading):
    began = process_time()
    try:
        answer = method(views)
    except InputError as fault:
        return {"refused": str(fault), "answered": 0}
    result = as_result(mirror_set, views, answer, name)
    seconds = reading + process_time() - began
    scores = score_mirror(mirror_set, result)
    told = {"refused": answer.refused, "answered": len(answer.stages)}
    return scores | told | {"seconds": seconds}


def as_result(mirror_set, views, answer, name):
    """The MirrorResult of an Answer, empty at the stages that it has none for."""
    pixels = scored_pixels(mirror_set.size)
    looks = views.viewer.rays(pixels)
    viewer = pixels[looks.valid], looks.directions[looks.valid]
    cameras = [one for one in answer.stages if not isinstance(one, StageAnswer)]
    stages = answer.stages
    if cameras:
        stages = sampled_result(mirror_set, cameras, pixels).stages
    missing = len(mirror_set.steps) + 1 - len(stages)
    stages = (*stages, *[NO_ANSWER] * missing)
    return MirrorResult(mirror_set.name, mirror_set.size, stages, viewer, method=name)


def recorded_entries(condition):
    """What the record says of one set: {method: its scores}."""
    return {
        one["method"]: {name: value for name, value in one.items() if name != "method"}
        for one in set_of(RECORD, condition)["scores"]
    }
