"""Scores against the truth of a rendered set: corners and cameras.

Only this module opens the folder that a set names as its `truth` (written by
`raxel.lab.set_rendering`): no detector, decoder or calibration does.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from raxel.cameras.core.base import Camera, closest_point
from raxel.cameras.registry import load_camera
from raxel.errors import InputError
from raxel.evaluation.cross_validation import corner_errors, is_right
from raxel.evaluation.distortion import angular_residual
from raxel.features.boards import Board
from raxel.geometry.poses import nearest_rotation
from raxel.sets.model import ImageSet
from raxel.sets.reference import load_reference

GRID_PIXELS = 100_000  # a camera is scored on about as many pixels
FAR_MM = 1000.0  # from the centre: point on a ray, for a direction


def score_corners(image_set: ImageSet, boards: Iterable[Board]) -> dict[str, Any]:
    """Score the boards of a detector against the true corners of a rendered set.

    A board is correct if, in the best symmetry of its lattice (mirrored ones too),
    every corner is within 1 px.

    Parameters
    ----------
    image_set : ImageSet
        A rendered chessboard set.
    boards : iterable of Board
        From `detect_boards` or `read_boards`, one per view.

    Returns
    -------
    dict
        ``views``, ``found``, ``right``: counts. ``wrong``: names of boards that are
        found but not correct. ``rms_px``, ``median_px``, ``max_px``: over the corners
        of the correct boards, None without any. ``images``: per view ``file``,
        ``found``, ``right``, and ``rms_px`` and ``max_px`` of its corners.

    Raises
    ------
    InputError
        If the set has no such truth.
    """
    truth_folder(image_set)
    named = replace(image_set, reference=f"{image_set.truth.rstrip('/')}/corners.json")  # type: ignore[union-attr]
    truth = load_reference(named)
    images, errors = [], []
    for board in boards:
        label, detection = board.view.label, board.detection
        if label not in truth:
            raise InputError(
                f"{named.folder / named.reference}: images: no {label!r}; give the set "  # type: ignore[operator]
                "as it was rendered"
            )
        distances = corner_errors(detection, truth[label])
        right = is_right(distances, truth[label])
        if right:
            errors.append(distances)
        entry = {"file": label, "found": bool(detection.found), "right": right}
        images.append(entry | _spread(distances, "px", ("rms", "max")))
    return {
        "views": len(images),
        "found": sum(image["found"] for image in images),
        "right": sum(image["right"] for image in images),
        "wrong": [i["file"] for i in images if i["found"] and not i["right"]],
        **_spread(np.concatenate(errors) if errors else None, "px"),  # type: ignore[arg-type]
        "images": images,
    }


def score_camera(
    image_set: ImageSet, camera: Camera, pixels: np.ndarray | None = None
) -> dict[str, Any]:
    """Score a calibrated central camera against the true one, on a grid of pixels.

    The frames of the two cameras are chosen independently. Therefore the rotation that
    maps the rays best (least squares over all of them) is removed first.

    Parameters
    ----------
    image_set : ImageSet
        A rendered set.
    camera : Camera
        The camera to score.
    pixels : ndarray, shape (N, 2), or None
        Pixels (u, v) of the comparison; None for `scoring_grid`.

    Returns
    -------
    dict
        ``pixels``: number of those that have a true ray. ``share_with_ray``: share of
        these. ``median_deg``, ``rms_deg``, ``max_deg``: angles between the rays.
        ``median_px``, ``rms_px``, ``max_px``: distance from the pixel to where the true
        camera sees the direction of the ray, over those that it sees.

    Raises
    ------
    InputError
        If the set has no such truth, a camera is not central or of another size, or
        there are too few rays.
    """
    path = truth_folder(image_set) / "camera.npz"
    true = load_camera(path)
    for name, one in (("the true camera", true), ("the camera to score", camera)):
        if not one.central:
            raise InputError(
                f"{image_set.description}: truth: {name} is not central; rays are "
                "compared as directions, for central cameras only"
            )
    if (camera.width, camera.height) != (true.width, true.height):
        raise InputError(
            f"{image_set.description}: width, height: the camera to score has "
            f"{camera.width} x {camera.height} px, the true one {true.width} x "
            f"{true.height}; give one of the same size"
        )
    if pixels is None:
        pixels = scoring_grid(true.width, true.height)
    truly = true.rays(pixels)
    pixels, directions = pixels[truly.valid], truly.directions[truly.valid]
    rays = camera.rays(pixels)
    if rays.valid.sum() < 3:
        raise InputError(
            f"{image_set.description}: truth: the camera to score has "
            f"{rays.valid.sum()} rays where the true one has {len(pixels)}; give 3"
        )
    seen, wanted = rays.directions[rays.valid], directions[rays.valid]
    turned = seen @ nearest_rotation(wanted.T @ seen).T
    angles = np.degrees(angular_residual(turned, wanted, aligned=False))
    # A mirror's rays start on the mirror; a direction belongs to their centre.
    places = true.project(closest_point(truly) + FAR_MM * turned).pixels
    apart = np.linalg.norm(places - pixels[rays.valid], axis=1)
    return {
        "pixels": len(pixels),
        "share_with_ray": float(rays.valid.mean()),
        **_spread(angles, "deg"),
        **_spread(apart[np.isfinite(apart)], "px"),
    }


def scoring_grid(width: int, height: int) -> NDArray[np.float64]:
    """Return every n-th pixel along each axis: about GRID_PIXELS, or all.

    Parameters
    ----------
    width, height : int
        Size of the image, px.

    Returns
    -------
    ndarray, shape (N, 2)
        Pixels (u, v).

    Examples
    --------
    >>> from raxel.evaluation import scoring_grid
    >>> scoring_grid(640, 480).shape
    (307200, 2)
    >>> scoring_grid(4000, 3000)[0].tolist()
    [5.0, 5.0]
    """
    step = max(1, int(np.sqrt(width * height / GRID_PIXELS)))
    v, u = np.mgrid[step // 2 : height : step, step // 2 : width : step]
    return np.column_stack([u.ravel(), v.ravel()]).astype(float)


def truth_folder(image_set: ImageSet) -> Path:
    """Return the folder of the truth of a set.

    Parameters
    ----------
    image_set : ImageSet
        The set.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    InputError
        If the set names none, or the folder does not exist.
    """
    if not image_set.truth:
        raise InputError(
            f"{image_set.description}: truth: none named; scores need a rendered set, "
            "as raxel render makes"
        )
    folder = image_set.folder / image_set.truth
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; give the set as it was rendered")
    return folder


def _spread(errors, unit, names=("rms", "median", "max")):
    """{rms_unit, median_unit, max_unit} of errors (N,); None without any."""
    if errors is None or not len(errors):
        return {f"{name}_{unit}": None for name in names}
    of = {
        "rms": np.sqrt(np.mean(errors**2)),
        "median": np.median(errors),
        "max": errors.max(),
    }
    return {f"{name}_{unit}": float(of[name]) for name in names}
