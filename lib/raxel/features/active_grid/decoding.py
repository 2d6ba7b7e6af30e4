"""Decoding of an active grid: the monitor position that each pixel views.

Thesis 3.2.2. The Gray code gives the cell. Each bit compares an image with its inverse,
so that an edge is where both are equal. The phase of the sinusoidal patterns gives the
position in the cell, in four quadrants (3.23). Both give the location (3.24).
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from raxel.features.active_grid.coding import (
    ALONE,
    BORDER,
    BREAK,
    DARK,
    DECODED,
    FILLED,
    OUTSIDE,
    ROWS_AROUND,
    ROWS_PER_CALL,
    SATURATED,
    UNREADABLE,
    WINDOW_RADIUS,
    CodePlan,
    ImageStack,
    Ripples,
    empty_rows,
    plan_arrays,
    strips_of,
)
from raxel.features.active_grid.errors import (
    NEIGHBOUR_VARIANCE,
    WINDOW_VARIANCE,
    Blur,
    Noise,
    estimate_noise,
    measured_blur,
    position_scatter,
    share_at_folds,
    share_noise,
    squared_bias,
    widen_at_bends,
    widen_at_folds,
)
from raxel.features.active_grid.lines import ripples_of
from raxel.features.active_grid.phase_unwrapping import (
    ROW_STEP,
    exclude_breaks,
    fill_holes,
    find_breaks,
    smooth_neighbours,
    trim_border,
    trim_sides,
    unwrapped_cells,
)
from raxel.features.active_grid.positions import locate_rows
from raxel.features.active_grid.reading import read_rows
from raxel.features.active_grid.response import (
    UNKNOWN_RESPONSE,
    Response,
    measured_response,
)
from raxel.io.files import processors
from raxel.sets.model import ActiveGrid, Pattern

# MAX_ROW_BYTES: of one row of all images, in all threads.
ROWS_PER_TASK, MAX_ROW_BYTES = 128, 4_000_000
MARGIN_PX = 6  # minimum, and the margin where the blur cannot be measured
REASONS = {
    DECODED: "decoded",
    FILLED: "filled from neighbours",
    DARK: "too little contrast",
    SATURATED: "overexposed",
    UNREADABLE: "the code cannot be read",
    ALONE: "no neighbour agrees",
    OUTSIDE: "beside the monitor",
    BORDER: "at the rim of the lit area",
    BREAK: "at a break of the surface",
}


@dataclass(frozen=True, eq=False)
class Decoded:
    """Hold the decoded location of each pixel.

    Attributes
    ----------
    location : np.ndarray
        (H, W, 2) float32, in `unit` from the upper left corner of the lit area, x right
        and y down. NaN where `mask` is False, and along an axis without patterns.
    sigma : np.ndarray
        (H, W, 2) float32, predicted standard deviation of each coordinate, in `unit`;
        NaN as `location`.
    cells : np.ndarray
        (H, W, 2) int16, the period of each axis (of a code without phases the cell), -1
        just before the first. Without meaning where `mask` is False.
    status : np.ndarray
        (H, W) uint8, a key of REASONS.
    unit : str
        Unit of the locations: 'mm', or 'px' of the monitor.
    noise : Noise
        The Noise with which sigma was computed.
    blur_px : float or None
        Standard deviation of the blur in px, given or measured; None where it could not
        be measured.
    margin_px : int
        Width in px of what was excluded at the border of the lit area.
    response : tuple[Response, Response]
        Along x and y: by how much the response of monitor and camera shifts positions,
        and what remains of it, RMS, in `unit`.
    """

    location: np.ndarray
    sigma: np.ndarray
    cells: np.ndarray
    status: np.ndarray
    unit: str
    noise: Noise
    blur_px: float | None
    margin_px: int
    response: tuple[Response, Response] = (UNKNOWN_RESPONSE, UNKNOWN_RESPONSE)

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Return where there is a location that can be trusted, (H, W) bool."""
        return self.status <= FILLED

    def counts(self) -> dict[str, int]:
        """Return the number of pixels of each of REASONS, {reason: count}."""
        return {REASONS[k]: int(np.count_nonzero(self.status == k)) for k in REASONS}


@dataclass(frozen=True, eq=False)
class DecoderSettings:
    """What holds for all rows of a view, as the compiled loops take it.

    plan: what the images encode; smooth: whether sines are averaged over windows;
    mark_own: whether sigma is negative where a phase is that of one pixel; saturated:
    the value from which a sine counts as clipped; variance:
    the Noise, float32; bias: squared, of phases (`bias.squared_bias`).
    """

    plan: CodePlan
    smooth: bool
    mark_own: bool
    saturated: np.uint16
    variance: tuple[np.float32, ...]
    ripples: Ripples
    bias: np.ndarray


def decode(
    images: np.ndarray | Sequence[np.ndarray],
    patterns: Sequence[Pattern],
    monitor: ActiveGrid,
    *,
    white: np.ndarray | None = None,
    black: np.ndarray | None = None,
    smooth: bool = True,
    neighbours: bool = False,
    fill: bool = False,
    margin_px: int | None = None,
    noise: float | Noise | None = None,
    saturated: int | None = None,
    blur_px: float | None = None,
    linear: bool = False,
    threads: int | None = None,
    shared: tuple[float, float] = (1.0, 1.0),
) -> Decoded:
    """Decode the images of one view of an active grid.

    An active grid is a phase-shift structured-light target on a monitor. The Gray code
    gives the cell, the phase of the sinusoidal patterns the position in it.

    Parameters
    ----------
    images : np.ndarray or Sequence[np.ndarray]
        (n, H, W) or n images (H, W), uint8 or uint16. A contiguous stack is used
        without a copy, others are read in blocks of rows.
    patterns : Sequence[Pattern]
        n patterns, what each image shows, in any order: one axis or both, Gray code or
        phases or both, three phase steps or more. Without Gray code, sinusoidal
        patterns of two numbers of periods or more determine together which period is
        visible (`orders`).
    monitor : ActiveGrid
        The target. Locations are in mm where its size in mm is known, else in its
        pixels.
    white, black : np.ndarray, optional
        (H, W) images of the monitor all white and black, for bits without an inverse.
        Without them the mean of the phase steps is taken.
    smooth : bool
        Average the sinusoidal patterns over 7 x 7 pixels. Such a window must hold no
        dark pixel and no two neighbours more than a quarter of a period apart. A pixel
        whose window does keeps its own value.
    neighbours : bool
        Average locations over 3 x 3 pixels under the same condition (3.2.2).
    fill : bool
        Give pixels without a location the mean of their neighbours, where these are on
        opposite sides and agree (3.2.2).
    margin_px : int, optional
        Exclude pixels so close to the border of the lit area, as a blurred one contains
        light from outside it. Pixels so close to a detected jump of the surface are
        excluded about it. None: as far as windows and blur reach, MARGIN_PX at least.
    noise : float or Noise, optional
        Standard deviation of a grey level, or a `Noise`; None: estimated from the
        images.
    saturated : int, optional
        The grey level from which a sinusoidal pattern counts as clipped; default the
        largest one.
    blur_px : float, optional
        Standard deviation in px of the blur of lens and monitor; None: measured at the
        edges of the Gray code (`blur`).
    linear : bool
        Assume that monitor and camera respond in proportion; measure and correct
        nothing.
    threads : int, optional
        Number of threads; default one per processor, fewer for large images.
    shared : tuple[float, float]
        (along x, along y): factor by which spatially correlated noise makes sigma
        larger than white noise does (`checks.scatter`).

    Returns
    -------
    Decoded
        Locations with sigma. Sigma contains the noise of a pixel, the bias of windows
        and blur where phases bend (`bias`), and the rest of the response (`response`).
        Neighbours that share a window share all of it. Folds, where positions continue
        without a jump but by another step, are in it as far as noise reveals them
        (`folds`). With `linear`, the effect of a response is not in it: with three
        steps the second order shifts the phase, with four the third.

    Raises
    ------
    InputError
        `bad-input` for images and patterns that do not fit together.

    References
    ----------
    Thesis 3.2.2, (3.23) and (3.24).
    """
    stack = ImageStack(images, patterns, monitor.monitor_px, white, black)
    limit = np.iinfo(stack.dtype).max if saturated is None else int(saturated)
    if noise is None:
        noise = estimate_noise(stack.noise_images(), limit)
    elif not isinstance(noise, Noise):
        noise = Noise(float(noise) ** 2)
    if blur_px is None:
        blur = measured_blur(stack, noise)
    else:
        blur = Blur(float(blur_px), 2 * float(blur_px))
    margins = _margins(margin_px, blur, smooth)
    unit = np.ones(2)
    if monitor.monitor_mm:
        unit = np.divide(monitor.monitor_mm, monitor.monitor_px)
    plan = plan_arrays(stack.codes, monitor.monitor_px, unit)
    if plan.unwrapped.any():
        orders = unwrapped_cells(images, stack.codes, monitor.monitor_px, noise, smooth)
        plan = plan._replace(orders=orders)
    responses = (UNKNOWN_RESPONSE,) * len(stack.codes)
    if not linear:
        responses = measured_response(stack, noise, limit, blur.px if blur else 0.0)
    ripples = [response.ripple for response in responses]
    plan = plan._replace(uneven=np.array([ripple.uneven for ripple in ripples]))
    averaged = WINDOW_VARIANCE * smooth + NEIGHBOUR_VARIANCE * neighbours
    blurred = blur.px if blur else 0.0
    spread = np.sqrt(noise.at(0)) * max(shared)  # type: ignore[union-attr]
    bias = squared_bias(
        images, stack.given_codes, averaged, blurred, spread, ripples, plan.orders
    )
    settings = DecoderSettings(
        plan=plan,
        smooth=smooth,
        mark_own=neighbours,
        saturated=np.uint16(limit),
        variance=tuple(map(np.float32, noise)),  # type: ignore[arg-type]
        ripples=ripples_of(ripples, stack.shape),
        # With the rest of the response's ripple.
        bias=bias
        + np.array([[[one.remaining or 0.0]] for one in responses], np.float32) ** 2,
    )
    shape, kinds = (len(stack.codes), *stack.shape), (np.float32, np.float32, np.int16)
    out = *(np.empty(shape, kind) for kind in kinds), np.empty(stack.shape, np.uint8)
    most = MAX_ROW_BYTES // (len(images) * stack.shape[1] * np.uint16().itemsize)
    with ThreadPoolExecutor(threads or min(processors(), 1 + most)) as pool:
        _decode_all(stack, settings, pool, out)
        if max(shared) > 1:
            factors = np.array([shared[code.axis] for code in stack.codes], np.float32)
            share_noise(out[1], settings.bias, plan.length, factors)
        if margins[0]:
            _leave_out(margins, plan, pool, out)
        _widen(settings, averaged + blurred**2, pool, out)
    location, sigma, cells, status = out
    if neighbours:
        smooth_neighbours(location, sigma, status, plan.reach)
    if fill:
        fill_holes(location, sigma, cells, status, plan.reach, plan.length)
    of_axes = {
        code.axis: response.scaled(length)
        for response, length, code in zip(
            responses, plan.length, stack.codes, strict=True
        )
    }
    return Decoded(  # type: ignore[call-arg]
        *(_both_axes(array, stack.codes) for array in (location, sigma, cells)),
        status,
        "mm" if monitor.monitor_mm else "px",
        noise,
        blur.px if blur else None,
        margins[0],
        tuple(of_axes.get(axis, UNKNOWN_RESPONSE) for axis in (0, 1)),
    )


def _margins(margin_px, blur, smooth):
    """Return (2,) px: margins at the border of the lit area and at jumps."""
    if margin_px is not None:
        return margin_px, margin_px
    if blur is None:
        return MARGIN_PX, MARGIN_PX
    return tuple(max(MARGIN_PX, margin) for margin in blur.margins(smooth))


def _decode_all(stack, settings, pool, out):
    """Decode all rows, ROWS_PER_TASK at a time; each thread has its own rows."""
    kept = threading.local()

    def decode_part(first):
        if not hasattr(kept, "rows"):
            kept.rows = empty_rows(len(stack.codes))
        _decode_part(stack, first, settings, kept.rows, out)

    list(pool.map(decode_part, range(0, stack.shape[0], ROWS_PER_TASK)))


def _leave_out(margins, plan, pool, out):
    """Exclude pixels near the lit area's border, at jumps and at the image's border."""
    location, sigma, _, status = out
    height, width = status.shape
    broken = np.empty((-(-height // ROW_STEP), width), np.uint8)
    parts = [
        (first, min(first + ROWS_PER_TASK, height))
        for first in range(0, height, ROWS_PER_TASK)
    ]
    list(pool.map(lambda part: trim_border(*part, margins[0], out), parts))
    positions = location, sigma, plan.used, plan.length
    list(pool.map(lambda part: find_breaks(*positions, *part, broken), parts))
    list(pool.map(lambda part: exclude_breaks(*part, margins[1], broken, out), parts))
    trim_sides(margins[1], plan.extent[:, None, None], out)


def _widen(settings, variance, pool, out):
    """Add the bias of windows and blur (variance, px^2) at bends and folds to sigma."""
    location, sigma, _, status = out
    plan, positions = settings.plan, (location, sigma)
    scatter = position_scatter(*positions, plan.used)
    of_folds = scatter, plan.used, share_at_folds(variance)
    of_bends = settings.bias, plan, variance / 2

    def widen(first):
        rows = first, first + ROWS_PER_TASK
        widen_at_folds(*positions, *of_folds, *rows)
        widen_at_bends(*positions, *of_bends, *rows)

    list(pool.map(widen, range(0, len(status), ROWS_PER_TASK)))


def _decode_part(stack, first, settings, rows, out):
    """Decode ROWS_PER_TASK rows from `first`; rows: work space."""
    stop = min(first + ROWS_PER_TASK, stack.shape[0])
    images, start = stack.rows(first, stop)
    plan = settings.plan
    plan = plan._replace(orders=plan.orders[:, start:])
    to_read = plan, settings.saturated, settings.variance, settings.ripples
    to_locate = plan, settings.smooth, settings.mark_own, settings.bias
    for strip in strips_of(images.shape[2]):
        known, end = max(first - start - WINDOW_RADIUS, 0), images.shape[1]
        for y in range(first - start, stop - start, ROWS_PER_CALL):
            after = min(y + ROWS_PER_CALL, stop - start)
            read_stop = min(after + ROWS_AROUND, end)
            read_rows(images, (known, read_stop, start), strip, *to_read, rows)
            part, known = (y, after, y + start), read_stop
            locate_rows(images, part, strip, *to_locate, rows, out)


def _both_axes(array, codes):
    """Return (A, H, W) as (H, W, 2), a view where both axes exist."""
    if len(codes) == 1:
        only = array[0]
        missing = np.nan if array.dtype.kind == "f" else 0
        array = np.full((2, *only.shape), missing, array.dtype)
        array[codes[0].axis] = only
    return np.moveaxis(array, 0, 2)
