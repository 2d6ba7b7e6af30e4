"""A picture laid out on a plane whose points the pixels are known to see.

An active grid tells each pixel the point of its plane that it sees. That alone takes
the distortion out of any picture that the same camera takes: no model is needed, and
none is fitted (thesis 3.3.4). What the plane's view cannot show is depth; where the
camera is central, the picture is the one of a pinhole whose image plane the grid is.
"""

import math

import numba
import numpy as np

from raxel.errors import InputError
from raxel.geometry.pixel_cells import usual_step, whole_cells

MOST_SAMPLES = 8  # along each axis of a pixel of the picture
MOST_PIXELS = 4  # of a picture to one of the image
EDGE = 1e-9  # of a triangle: so little outside counts as inside
LEAST_VARIANCE = 1e-12  # of a point that is said to be exact


def plane_scale(location, mask=None):
    """(size, length per px) of a picture of all that `remap_to_plane` can show.

    In the unit of the locations: the size from the grid's corner to the last place that
    is seen; a pixel of the picture is as long as the median step between neighbouring
    pixels of the image, or longer where the picture would have more than MOST_PIXELS
    times the image's pixels. Raises InputError where no neighbours see anything.
    """
    location, _ = _checked(location[..., 0], location, None, mask)
    step = usual_step(location)
    if not step > 0:
        raise InputError("location: no two neighbouring pixels see different places")
    size = np.nanmax(location.reshape(-1, 2), axis=0)
    if not (size > 0).all():
        raise InputError("location: all of it is left of the grid or above it")
    most = MOST_PIXELS * location[..., 0].size
    return tuple(size), max(step, float(np.sqrt(np.prod(size) / most)))


def remap_to_plane(image, location, sigma, mask, size_mm, mm_per_px):
    """What a camera saw, as a picture of the plane that an active grid lay in.

    image: (H, W) or (H, W, C), of the camera whose pixels see `location` (H, W, 2), in
    mm from the upper left corner of the grid, x right and y down. sigma: (H, W, 2), mm,
    standard deviations, or None; mask: (H, W) bool, where a location counts, or None
    for all that are finite. size_mm: (width, height) of the picture's area, from the
    grid's corner; mm_per_px: of the picture, whose pixel (u, v) has its centre at
    mm_per_px (u + 1/2, v + 1/2).

    Between four pixels that see one piece of surface (`whole_cells`) values are linear
    in two triangles; nothing is filled in beyond. Where several parts of the image see
    a place, as through facets, they are averaged with weights 1/sigma^2. Where the
    camera sees more finely than the picture shows, up to 8 x 8 samples of a pixel are
    averaged. Memory: a copy of the image and the picture as float, a byte a sample.

    Returns picture (h, w[, C]) of the image's type, 0 where nothing is seen, and seen
    (h, w) bool: at least half of the pixel's samples are. Raises InputError for shapes
    that do not fit, and where no four pixels see one surface.
    """
    image = np.asarray(image)
    location, sigma = _checked(image, location, sigma, mask)
    width, height = (math.floor(s / mm_per_px + 1e-9) for s in size_mm)
    if width < 1 or height < 1:
        raise InputError(
            f"size_mm: found {tuple(size_mm)} at {mm_per_px} mm per px; not one pixel"
        )
    whole = whole_cells(location, sigma)
    if not whole.any():
        raise InputError("location: no four neighbouring pixels see one surface")
    fine = math.ceil(mm_per_px / max(usual_step(location), 1e-9))
    fine = min(max(fine, 1), MOST_SAMPLES)
    places = location * (fine / mm_per_px) - 0.5  # of samples
    values = np.atleast_3d(image).astype(np.float32)
    sums = np.zeros((height, width, values.shape[2] + 1))
    hit = np.zeros((height * fine, width * fine), np.bool_)
    _add_cells(places, values, _weights(location, sigma), whole, fine, sums, hit)
    counts = np.count_nonzero(hit.reshape(height, fine, width, fine), axis=(1, 3))
    seen = 2 * counts >= fine * fine
    with np.errstate(invalid="ignore"):
        picture = np.where(seen[..., None], sums[..., :-1] / sums[..., -1:], 0)
    if image.dtype.kind in "ui":
        picture = np.rint(picture)
    return picture.reshape(height, width, *image.shape[2:]).astype(image.dtype), seen


def _checked(image, location, sigma, mask):
    """location and sigma as float arrays, NaN where they do not count."""
    location = np.array(location, float)
    location[~np.isfinite(location)] = np.nan
    shape = (*image.shape[:2], 2)
    found = {"location": location.shape}
    if sigma is not None:
        found["sigma"] = np.shape(sigma)
    if mask is not None:
        found["mask"] = (*np.shape(mask), 2)
        if np.shape(mask) == location.shape[:2]:
            location[~np.asarray(mask, bool)] = np.nan
    for name, given in found.items():
        if given != shape:
            raise InputError(
                f"{name}: found {given[0]} x {given[1]} pixels; the image has "
                f"{shape[0]} x {shape[1]}"
            )
    return location, None if sigma is None else np.asarray(sigma, float)


def _weights(location, sigma):
    if sigma is None:
        return np.ones(location.shape[:2])
    return 1 / np.maximum(np.sum(np.square(sigma), axis=2), LEAST_VARIANCE)


@numba.njit(cache=True)
def _add_cells(places, values, weights, whole, fine, sums, hit):
    """Add both triangles of each whole cell; places: (H, W, 2), in samples."""
    rows, columns = whole.shape
    for v in range(rows):
        for u in range(columns):
            if whole[v, u]:
                corners = (v, u), (v, u + 1), (v + 1, u)
                _add_triangle(places, values, weights, corners, fine, sums, hit)
                corners = (v + 1, u + 1), (v + 1, u), (v, u + 1)
                _add_triangle(places, values, weights, corners, fine, sums, hit)


@numba.njit(cache=True)
def _add_triangle(places, values, weights, corners, fine, sums, hit):
    """Add weighted values, linear in the triangle, at the samples that it covers."""
    a, b, c = corners
    ax, ay = places[a]
    bx, by = places[b][0] - ax, places[b][1] - ay
    cx, cy = places[c][0] - ax, places[c][1] - ay
    twice = bx * cy - by * cx
    if twice == 0:
        return
    height, width = hit.shape
    first = max(math.ceil(ax + min(bx, cx, 0.0) - EDGE), 0)
    last = min(math.floor(ax + max(bx, cx, 0.0) + EDGE), width - 1)
    top = max(math.ceil(ay + min(by, cy, 0.0) - EDGE), 0)
    bottom = min(math.floor(ay + max(by, cy, 0.0) + EDGE), height - 1)
    channels = values.shape[2]
    for y in range(top, bottom + 1):
        for x in range(first, last + 1):
            of_b = ((x - ax) * cy - (y - ay) * cx) / twice
            of_c = ((y - ay) * bx - (x - ax) * by) / twice
            of_a = 1 - of_b - of_c
            if of_a < -EDGE or of_b < -EDGE or of_c < -EDGE:
                continue
            hit[y, x] = True
            weight = of_a * weights[a] + of_b * weights[b] + of_c * weights[c]
            at = sums[y // fine, x // fine]
            at[channels] += weight
            for k in range(channels):
                value = of_a * values[a][k] + of_b * values[b][k] + of_c * values[c][k]
                at[k] += weight * value
