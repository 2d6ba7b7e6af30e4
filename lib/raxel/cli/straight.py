"""Two ways to take the distortion out of pictures: by a camera, by one active grid."""

from typing import NamedTuple

import numpy as np

from raxel.cameras.registry import load_camera
from raxel.cli.evaluate import check_size
from raxel.errors import InputError
from raxel.features.grids import has_points, read_grid
from raxel.multiview.views import (
    perspective_view,
    plane_scale,
    remap_to_plane,
    resample,
    share_seen,
    source_pixels,
)


class Straightener(NamedTuple):
    """picture: callable, image -> picture; share: of its pixels that show anything;
    sees: what sees these; rest: why there may be few."""

    picture: callable  # type: ignore[valid-type]
    share: float
    sees: str
    rest: str


def straightener(path, image_set):
    """The Straightener of a camera file, or of a view's file of points."""
    way = _by_grid if has_points(path) else _by_camera
    return way(path, image_set)


def _by_camera(path, image_set):
    """As a pinhole at the camera's centre would see it."""
    camera = load_camera(path)
    check_size(path, camera, image_set)
    try:
        view = perspective_view(camera)
    except InputError as fault:
        raise InputError(f"{path}: {fault}") from fault
    sources = source_pixels(camera, view)
    return Straightener(
        lambda image: resample(image, sources),
        share_seen(sources, camera),
        "the camera sees",
        "a pinhole's picture cannot hold what this camera sees, or what it was "
        "calibrated with covered little of the image; a camera that looks all around "
        "is unrolled by raxel.multiview.views",
    )


def _by_grid(path, image_set):
    """Laid out on the plane of an active grid that the camera saw."""
    shape = image_set.height, image_set.width
    location, sigma, mask = read_grid(path, (*shape, 2))
    try:
        scale = plane_scale(location, mask)
        blank = np.zeros(shape, np.uint8)
        _, seen = remap_to_plane(blank, location, sigma, mask, *scale)
    except InputError as fault:
        raise InputError(f"{path}: {fault}") from fault
    return Straightener(
        lambda image: remap_to_plane(image, location, sigma, mask, *scale)[0],
        float(np.mean(seen)),
        "the grid's points cover",
        "the grid covered little of the image; move the monitor nearer",
    )
