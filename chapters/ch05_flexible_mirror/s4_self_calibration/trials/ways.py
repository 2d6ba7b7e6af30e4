"""One step of 2.5 mm without a target, by every way that was thought of.

The mirror before is known, up to what a spline can follow, so that all that is wrong
comes of the step itself.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import STEPS_MM
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.scene import (
    Field,
    SceneFrame,
    features,
)
from chapters.shared.gaussian_errors import GaussianErrors
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import lattice, outline
from chapters.shared.mirror_scores import load_height, ray_angles
from raxel.calibration.mirror.clamp import clamp_of_camera
from raxel.calibration.mirror.self_calibration import (
    feedback_updates,
    linear_update,
    one_depth_update,
)
from raxel.calibration.mirror.sightings import magnification, normalised
from raxel.calibration.mirror.straight_edges import straight_edges_update
from raxel.calibration.mirror.update import MirrorSettings
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError
from raxel.geometry.spline_grid import spline_grid

ROUNDS = 6
# What rays before are off by where a spline cannot follow the sheet, told as features'
# noise: some 0.04 degrees, far more than that of corners. Chosen on seeds that judge
# nothing.
MISFIT_PX = 3.0
PRIOR = MirrorSettings(prior_sd=0.1, noise_px=MISFIT_PX)
EDGES, ALONG = 12, 15  # straight edges, and pixels of each
COMPARED_PX = 168


def ways_trial(condition, rng):
    """{way: deflection and mean ray angle}; `X.refused` where one gave none.

    condition: geometry, and depth_mm, of a room whose features lie within a tenth of
    that; 0: the far scene of 5.4.
    """
    rig, errors = mirror_rig(condition["geometry"]), GaussianErrors()
    true = [rig.camera(mm) for mm in STEPS_MM[:2]]
    before = nearest_spline(true[0])
    clamp = clamp_of_camera(before, rig.clamp_pixels(true[0]), slope=False)
    view = SceneFrame.of(true[0])
    fields = [Field(camera) for camera in true]
    points, ends = scene_of(condition["depth_mm"], view, fields, rng)
    share = np.linspace(0, 1, ALONG)[:, None]
    lines = [a + share * (b - a) for a, b in zip(*ends, strict=True)]
    whole = np.vstack([points, *lines])
    seen = [field.pictured(whole, errors, rng) for field in fields]
    matched = [pixels[: len(points)] for pixels in seen]
    edges = [np.split(pixels[len(points) :], EDGES) for pixels in seen]
    edges = [[p[np.isfinite(p[:, 0])] for p in of_picture] for of_picture in edges]
    held = nearest_spline(true[0], "inverse depth")
    at_slope = clamp_of_camera(held, rig.clamp_pixels(true[0]))
    given, traced = (before, *matched, clamp), {"outline": outline(true[1])}
    start = load_height(rig, before, true[0])

    def scored(camera):
        pixels = lattice(true[1], COMPARED_PX)
        return {
            "deflection_mm": load_height(rig, camera, true[1]) - start,
            "angle_deg": float(np.nanmean(ray_angles(camera, true[1], pixels))),
        }

    linear = linear_update(*given, **traced).camera
    out = {"linear": scored(linear)}
    loop = feedback_updates(*given, **traced, rounds=ROUNDS)
    for number, one in enumerate(loop[1:], 1):
        out[f"feedback{number}"] = scored(one.camera) | {
            "depth_mm": one.depth_mm,
            "rms": one.rms,
            "left": int(np.count_nonzero(one.used)),
        }
    noise = MISFIT_PX / np.median(
        magnification(rig.viewer, matched[1][_known(matched)])
    )
    for name, way in {
        "one_depth": lambda: one_depth_update(*given, PRIOR, **traced),
        # As the bundle of 5.3.3 has it: inverse depth, the clamp's slope held.
        "one_depth_held": lambda: one_depth_update(
            held, *matched, at_slope, PRIOR, **traced
        ),
        "edges": lambda: straight_edges_update(
            linear, edges[1], clamp, noise=noise, prior_sd=PRIOR.prior_sd
        ),
        "lines": lambda: straight_edges_update(
            linear, edges[1], clamp, noise=noise, prior_sd=PRIOR.prior_sd,
            before=(before, edges[0]),
        ),
    }.items():  # fmt: skip
        try:
            found = way()
            more = {"rms": found.rms}
            more |= {"depth_mm": getattr(found, "depth_mm", np.nan)}
            out[name] = scored(found.camera) | more
        except CalibrationError as refusal:
            out[name] = {"refused": str(refusal)}
    return out


def _known(matched):
    return np.isfinite(matched[0] + matched[1]).all(axis=1)


def nearest_spline(true, quantity="distance"):
    """The 7 x 3 spline nearest to a true mirror, over all of its picture."""
    viewer, pixels = true.viewer, lattice(true, 48)
    span = normalised(viewer, np.vstack([pixels, outline(true)]))
    grid = spline_grid(span, (7, 3))
    return SplineMirrorCamera.fitted(viewer, grid, true.rays(pixels).origins, quantity)


def scene_of(depth_mm, view, fields, rng):
    """Points (N, 3) of features, and ends (2, EDGES, 3) of straight edges."""
    points, _ = features(view, 3 * fields, rng)
    if depth_mm:
        depth = depth_mm * rng.uniform(0.9, 1.1, len(points))
        away = points - view.middle
        origins = np.broadcast_to(view.middle, points.shape)
        points = view.placed(origins, away, depth)
    pairs = rng.choice(len(points), (2, EDGES), replace=False)
    return points, points[pairs]
