"""Refit of a format's models to the rays of a camera."""

from typing import NamedTuple

import numpy as np

from raxel.cameras.core.base import pixel_grid, under_boards
from raxel.formats.conventions import FISHEYE, PLANE, REFIT_PLANE, Model
from raxel.formats.models import parameters, pixels
from raxel.geometry.poses import rotation_from_vector
from raxel.multiview.views import perspective_view

N_GRID = 25  # pixels along each axis of the image
# Rays beyond the boards are extrapolated; they keep a polynomial from diverging.
OUTSIDE_WEIGHT = 0.1
# Of a rotation of 1 rad, as a fraction of f: a narrow lens does not distinguish a
# rotation from a displacement of the principal point.
ROTATION_WEIGHT, NO_ROTATION = 1e-3, 1e3
MAX_RESIDUAL_PX = 1e3  # in a fit, also that of a ray without a pixel
MAX_N_STEPS = 60  # a valley of rational functions has no end
# Models that cameras of Raxel equal, for the import of others.
OMNI = "xi fx fy s cx cy k1 k2 k3 p1 p2 s1 s3"
OWN = [
    Model("omni", OMNI, 180, OMNI),
    Model("omni", OMNI, 180, OMNI.removeprefix("xi ")),
    Model("fisheye", FISHEYE, 180, FISHEYE),
]
N_ANGLES, N_AZIMUTHS = 60, 120  # of rays for an import
MARGIN = 0.51  # of the image, from its middle: with all corners
START = {"xi": 1.0, "alpha": 0.5, "beta": 1.0, "c": 1.0}


class RaySample(NamedTuple):
    """Rays of a grid of pixels: pixels (N, 2), directions (N, 3), and whether a board
    covered the pixel (N,), all True for a camera without this area."""

    pixels: np.ndarray
    directions: np.ndarray
    covered: np.ndarray


def sample_of(camera):
    """Return the rays of the grid, from the first to the last pixel."""
    size = np.array([camera.width, camera.height])
    grid = pixel_grid(N_GRID, N_GRID) * (size - 1) / (N_GRID - 1)
    rays = camera.rays(grid)
    sample = RaySample(grid, rays.directions, under_boards(camera, grid))
    return RaySample(*(part[rays.valid] for part in sample))


def angles_of(R, sample):
    """Angles of the rays to the axis of a model, deg."""
    return np.degrees(np.arccos(np.clip(sample.directions @ R[2], -1, 1)))


def refit(camera, models, sample):
    """Return name, parameters, R_model_camera and residuals of the rays, px, of the
    model with the smallest RMS under the boards, of those that hold the most rays
    there. Residuals are NaN outside the field of view of the model."""

    def rank(fit):
        errors = fit[-1][sample.covered]
        share = np.mean(np.isfinite(errors))
        return -round(share, 2), np.nansum(errors**2) / max(share, 1e-9)

    frame = _frame(camera)
    fits = [_fitted(name, m, frame, sample) for name, m in models.items() if m.refit]
    return min(fits, key=rank)


def refit_own(model, p, width, height):
    """Return formula, parameters and residuals in px, NaN without a pixel, of the model
    in OWN with the smallest RMS to the rays of a format's model, in its frame."""
    sample = _sample_of_model(model, p, width, height)
    frame = np.eye(3), np.array([p["cx"], p["cy"]])
    fits = [_fitted(own.formula, own, frame, sample, NO_ROTATION) for own in OWN]
    formula, found, _, errors = min(
        fits, key=lambda fit: (fit[1]["xi"] < 0, np.sum(fit[-1] ** 2))
    )
    return formula, found, errors


def _sample_of_model(model, p, width, height):
    """Rays that a model images in the image, up to the angle where it folds."""
    limit = REFIT_PLANE if model.max_angle_deg == PLANE else model.max_angle_deg
    reach, size = np.radians(limit), np.array([width, height])
    azimuth = np.linspace(0, 2 * np.pi, N_AZIMUTHS, endpoint=False)[:, None]
    for _ in range(2):  # once to find the largest angle in the image
        angle = np.linspace(0, reach, N_ANGLES) + 0 * azimuth
        across, ahead = np.sin(angle), np.cos(angle)
        directions = np.dstack(
            [across * np.cos(azimuth), across * np.sin(azimuth), ahead]
        )
        seen = pixels(model.formula, p, directions.reshape(-1, 3)).reshape(
            *angle.shape, 2
        )
        radius = np.hypot(*np.moveaxis(seen - [p["cx"], p["cy"]], 2, 0))
        rising = np.diff(radius, axis=1, prepend=-1) > 0
        inside = np.logical_and.accumulate(rising, axis=1)
        inside &= (np.abs(seen - (size - 1) / 2) < MARGIN * size).all(axis=2)
        reach = min(reach, angle[inside].max(initial=0.0) + angle[0, 1])
    return RaySample(seen[inside], directions[inside], np.ones(inside.sum(), bool))


def _fitted(name, model, frame, sample, rotation_weight=ROTATION_WEIGHT):
    from scipy.optimize import least_squares

    R, centre = frame
    limit = REFIT_PLANE if model.max_angle_deg == PLANE else model.max_angle_deg
    held = angles_of(R, sample) < limit
    if not held.any():
        return name, {}, R, np.full(len(held), np.nan)
    seen, directions = sample.pixels[held], sample.directions[held]
    weights = np.where(sample.covered[held], 1.0, OUTSIDE_WEIGHT)[:, None]
    focal, start = _start(model.formula, centre, seen, directions @ R.T)
    stiffness = rotation_weight * focal * np.sqrt(weights.sum())
    names = model.refit.split()
    # A coefficient ak of the radius in px is relative to the largest radius.
    powers = [int(n[1:]) if n[0] == "a" and n[1:].isdigit() else 1 for n in names]
    units = np.hypot(*(seen - centre).T).max(initial=1.0) ** (1.0 - np.array(powers))

    def placed(x):
        return parameters(names, units * x[3:]), rotation_from_vector(x[:3]) @ R

    def residuals(x):
        p, turned = placed(x)
        off = pixels(model.formula, p, directions @ turned.T) - seen
        off = np.clip(np.nan_to_num(off, nan=np.inf), -MAX_RESIDUAL_PX, MAX_RESIDUAL_PX)
        return np.concatenate([(weights * off).ravel(), stiffness * x[:3]])

    x = np.concatenate([np.zeros(3), np.divide([start[n] for n in names], units)])
    x = least_squares(residuals, x, x_scale="jac", max_nfev=MAX_N_STEPS).x
    p, turned = placed(x)
    errors = np.full(len(held), np.nan)
    off = pixels(model.formula, p, directions @ turned.T) - seen
    errors[held] = np.where(np.isfinite(off).all(axis=1), np.hypot(*off.T), np.nan)
    return name, p, turned, errors


def _frame(camera):
    """R_model_camera to start with, and the pixel of its axis: +z if the image shows
    it, otherwise the ray in the middle of the image."""
    axis = camera.project([[0, 0, 1e6]])
    if axis.valid[0] and camera.in_image(axis.pixels)[0]:
        return np.eye(3), axis.pixels[0]
    view = perspective_view(camera)
    return view.R_camera_view.T, view.K[:2, 2]


def _start(formula, centre, seen, directions):
    """Focal length of rays about the axis, and the model with it without distortion."""
    p = parameters(("cx", "cy"), centre) | START
    radius = np.hypot(*(seen - centre).T)
    across, ahead = np.hypot(*directions[:, :2].T), directions[:, 2]
    if formula == "ocam":
        terms = across[:, None] * radius[:, None] ** [0, 2, 3, 4]
        found = np.linalg.lstsq(terms, radius * ahead, rcond=None)[0]
        return found[0], p | dict(zip(("a0", "a2", "a3", "a4"), found, strict=True))
    with np.errstate(all="ignore"):
        points = np.hypot(*(pixels(formula, p, directions) - centre).T)
        focal = float(np.nanmedian(radius / points))
    return focal, p | {"fx": focal, "fy": focal}
