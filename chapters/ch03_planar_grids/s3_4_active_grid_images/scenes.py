"""What the trials of this page share: scenes, cameras and measures."""

from functools import cache
from itertools import combinations

import numpy as np

from raxel.calibration import board_views, calibrate_zhang
from raxel.features import DEFAULT_DETECTOR, detect_boards, find_board
from raxel.features.active_grid import decode, nearest_pixels
from raxel.features.localise import (
    blurred,
    fit_ridges,
    fit_saddles,
    gradient,
    opencv_subpix,
)
from raxel.geometry import apply_homography, homography_dlt, refine_homography
from raxel.lab import load_rig
from raxel.multiview import perspective_view, remap_to_plane, resample, source_pixels
from raxel.sets import load_set, read_image
from repro.run.rendered import CHECKOUT, rendered_set

# Rendered sets of section 3.3.4, opened and decoded like recorded ones.


def rig_of(name):
    """Return the rig of a file of data/rigs."""
    return load_rig(CHECKOUT / f"data/rigs/{name}.yaml")


def capture_of(rig, seed, pose=0):
    """Return (set, view) of one pose of a rendered set."""
    image_set = load_set(rendered_set(rig, seed))
    return image_set, image_set.views[pose]


def images_of(image_set, view):
    """Return patterns (n, H, W), and white, black and chessboard by name."""
    patterns = np.array(
        [read_image(image_set, pattern.image) for pattern in view.patterns]
    )
    others = {
        name: read_image(image_set, getattr(view, name))
        for name in ("white", "black", "chessboard")
        if getattr(view, name)
    }
    return patterns, others


def decoded(image_set, view, prepare=lambda image: image, **options):
    """Return (Decoded, chessboard or None) of a view.

    prepare: applied to every image first; options: of `decode`.
    """
    patterns, others = images_of(image_set, view)
    others = {name: prepare(image) for name, image in others.items()}
    chessboard = others.pop("chessboard", None)
    found = decode(
        np.array([prepare(image) for image in patterns]),
        view.patterns,
        image_set.target,
        linear=True,
        **others,
        **options,
    )
    return found, chessboard


# Conditions of section 3.3.4: rigs, runs, settings, and the sets they read.


SMALL = {"quick": "-small", "full": ""}
SEEDS = {"quick": (1,), "full": (1, 2, 3)}
# Full widths and SDs (px): of the sweep, and of a coarser one.
WINDOWS = {"quick": (5, 13, 21), "full": tuple(range(5, 58, 4))}
COARSE = {"quick": (5, 21), "full": tuple(range(5, 58, 8))}
BLURS = {"quick": (0.5, 2.0), "full": (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)}
COARSE_BLURS = {"quick": (0.5,), "full": (0.5, 2.0, 4.0, 8.0)}
COARSER = ("sharp", "16 bits")
VIEWS = ("long wall", "corner")
PITCHES = ("pitched", "half pitched")

# Literals, which the workflow reads without running them.
CORNER_SETS = {
    "quick": ("d200-boards-small/1", "d200-lens-small/1", "d200-lens-sharp-small/1"),
    "full": (
        "d200-boards/1", "d200-boards/2", "d200-boards/3",
        "d200-lens/1", "d200-lens/2", "d200-lens/3",
        "d200-lens-sharp/1", "d200-lens-sharp/2", "d200-lens-sharp/3",
    ),
}  # fmt: skip
FISHEYE_SETS = {
    "quick": ("d200-fisheye-small/1",),
    "full": ("d200-fisheye/1", "d200-fisheye/2", "d200-fisheye/3"),
}
BALL_SETS = {
    "quick": ("mirror-ball-small/1",),
    "full": ("mirror-ball/1", "mirror-ball/2", "mirror-ball/3"),
}


def corner_conditions(effort, cases):
    """Return a condition for each seed of the cases of Table 3.8, by name."""
    return [
        {
            "case": case,
            "seed": seed,
            "rig": f"d200-lens{'-sharp' * (case == 'sharp')}{SMALL[effort]}",
            "boards": f"d200-boards{SMALL[effort]}",
            "pose": int(case == "far"),
            "bits": 16 if case == "16 bits" else 8,
            "windows": list((COARSE if case in COARSER else WINDOWS)[effort]),
            "blurs": list((COARSE_BLURS if case in COARSER else BLURS)[effort]),
        }
        for case in cases
        for seed in SEEDS[effort]
    ]


def line_conditions(effort, pitches, views):
    """Return a condition for each seed, pitch of the grid and view of the room."""
    return [
        {
            "rig": f"d200-fisheye{SMALL[effort]}",
            "seed": seed,
            "pose": PITCHES.index(pitch),
            "pitch": pitch,
            "view": view,
            "drawn": (seed, pitch, view) == (1, PITCHES[0], VIEWS[0]),
        }
        for view in views
        for pitch in pitches
        for seed in SEEDS[effort]
    ]


def ball_conditions(effort):
    """Return a condition for each seed of the mirror ball."""
    rig = f"mirror-ball{SMALL[effort]}"
    return [{"rig": rig, "seed": seed, "drawn": seed == 1} for seed in SEEDS[effort]]


# Search of decoded data for the image of a screen position.


NEAREST = 12  # candidate pixels, of which four are chosen
MIN_SINE = 0.05  # of the angles of a valid triangle
HALF = 3  # half-width of the window of the local fit, px


def at_four_pixels(grid, places):
    """Return pixels (n, 2) that see positions (n, 2) mm, by four near pixels (3.3.4).

    The homography from the locations of four pixels, no three of them collinear, to
    these pixels maps the position. They are the first such four when pixels are
    ordered by the distance of their locations from the position. NaN where no pixel
    is near.
    """
    out = np.full((len(places), 2), np.nan)
    for n, (place, window) in enumerate(windows_about(grid, places)):
        if window is None:
            continue
        pixels, locations, _ = window
        away = np.linalg.norm(locations - place, axis=1)
        order = np.argsort(away, kind="stable")[:NEAREST]
        four = first_four(pixels[order])
        if four is not None:
            chosen = order[list(four)]
            H = through_four(locations[chosen] - place, pixels[chosen])
            out[n] = H[:2, 2] / H[2, 2]
    return out


def by_local_fit(grid, places):
    """Return pixels (n, 2) that see positions (n, 2) mm, by all pixels of a window.

    Locations are fitted by a quadratic polynomial of the pixels, weighted with
    their sigma. Newton's method inverts it. NaN where no pixel is near.
    """
    out = np.full((len(places), 2), np.nan)
    for n, (place, window) in enumerate(windows_about(grid, places)):
        if window is None:
            continue
        pixels, locations, sigma = window
        middle = pixels.mean(axis=0)
        rows = terms(pixels - middle) / sigma[:, None]
        fit, *_ = np.linalg.lstsq(rows, locations / sigma[:, None], rcond=None)
        at = np.zeros(2)
        for _ in range(5):
            x, y = at
            value = terms(at[None])[0] @ fit
            slope = np.array([[0, 1, 0, 2 * x, y, 0], [0, 0, 1, 0, x, 2 * y]]) @ fit
            at = at + np.linalg.solve(slope.T, place - value)
        if np.abs(at).max() <= HALF + 1:
            out[n] = middle + at
    return out


def terms(p):
    """Return the six terms of degree up to two of positions (n, 2)."""
    x, y = p.T
    return np.column_stack([np.ones(len(p)), x, y, x * x, x * y, y * y])


def windows_about(grid, places):
    """Yield (place, (pixels (m, 2), locations (m, 2), sigma (m,)) or None) by place.

    The window is around the decoded pixel whose location is nearest to the place.
    None where the distance exceeds the step of two pixels.
    """
    location = np.where(grid.mask[..., None], grid.location, np.nan)
    step = np.nanmedian(np.linalg.norm(np.diff(location, axis=1), axis=2))
    height, width = grid.mask.shape
    nearest = nearest_pixels(np.ascontiguousarray(location), places)
    for place, (u, v) in zip(places, nearest, strict=True):
        if u < 0 or np.linalg.norm(location[v, u] - place) > 2 * step:
            yield place, None
            continue
        rows = slice(max(v - HALF, 0), min(v + HALF + 1, height))
        columns = slice(max(u - HALF, 0), min(u + HALF + 1, width))
        y, x = np.mgrid[rows, columns]
        known = grid.mask[rows, columns]
        sigma = np.linalg.norm(grid.sigma[rows, columns][known], axis=1)
        yield (
            place,
            (
                np.column_stack([x[known], y[known]]).astype(float),
                location[rows, columns][known].astype(float),
                sigma.astype(float),
            ),
        )


def first_four(pixels):
    """Return the first four of pixels (n, 2), in their order, no three collinear."""
    for last in range(3, len(pixels)):
        for others in combinations(range(last), 3):
            four = (*others, last)
            if all(is_triangle(pixels[list(t)]) for t in combinations(four, 3)):
                return four
    return None


def is_triangle(points):
    """Return whether three points (3, 2) are clearly not collinear."""
    a, b = points[1] - points[0], points[2] - points[0]
    area = abs(a[0] * b[1] - a[1] * b[0])
    return area > MIN_SINE * np.linalg.norm(a) * np.linalg.norm(b)


def through_four(source, target):
    """Return the homography (3, 3) that maps four points (4, 2) to four others."""
    rows = [
        row
        for (x, y), (u, v) in zip(source, target, strict=True)
        for row in (
            [x, y, 1, 0, 0, 0, -u * x, -u * y, -u],
            [0, 0, 0, x, y, 1, -v * x, -v * y, -v],
        )
    ]
    return np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)


# Table 3.8: corners of one board by four methods, in undistorted images.


# In 16-bit images the camera's rounding to 8 bits is the only noise.
NOISE = {8: {}, 16: {"noise": 257 / np.sqrt(12)}}


def corner_trial(condition, rng):
    """Return residuals of every corner by every method and setting, at one pose.

    condition: rig, boards (the rig whose images calibrate the camera), seed, pose
    (its number), bits (of the undistorted images), windows: full widths, px; blurs:
    SD, px. Returns the mean residual (px) by method, window and blur, infinite
    where a corner was not found. For the best setting of each method, also returns
    the corners and their residuals, and (`true_lens`) the residuals after
    undistortion with the true lens.
    """
    camera = calibrated(condition["boards"], condition["seed"])
    sources = source_pixels(camera, perspective_view(camera))
    image_set, view = capture_of(condition["rig"], condition["seed"], condition["pose"])
    grid, image = decoded(
        image_set,
        view,
        lambda taken: resample(in_bits(taken, condition["bits"]), sources),
        neighbours=True,
        fill=True,
        **NOISE[condition["bits"]],
    )
    metric = image_set.target.chessboard_points()
    found = {
        "four nearest pixels": at_four_pixels(grid, metric)[None],
        "local fit": by_local_fit(grid, metric)[None],
    }
    start = starts(found["local fit"][0], metric)
    found |= sweep(image, start, condition["windows"], condition["blurs"])
    truth = rig_of(condition["rig"]).camera
    out = {name: best_of(corners, metric) for name, corners in found.items()}
    for name, corners in found.items():
        best = corners.reshape(-1, *metric.shape)[out[name]["best"]]
        moved = residual_of(through(camera, truth, best), metric)
        out[name]["true_lens"] = {key: moved[key] for key in ("mean", "sd")}
    return out | {
        "metric": metric,
        "largest_window_px": largest_window(start, image.shape),
        "square_px": square_px(start, metric),
        "middle": camera.K[:2, 2],
        "radial": camera.radial,
        "views": len(image_set.views),
    }


def starts(corners, metric):
    """Return whole pixels (n, 2) from which corners are localised, as from a detector.

    Corners that the active grid lacks are predicted from the others.
    """
    known = np.isfinite(corners[:, :1])
    return np.rint(np.where(known, corners, mapped(corners, metric)))


def mapped(corners, metric):
    """Return the metric grid (n, 2) by the homography to the corners found."""
    found = np.isfinite(corners[:, 0])
    H = refine_homography(
        homography_dlt(metric[found], corners[found]), metric[found], corners[found]
    )
    return apply_homography(H, metric)


def in_bits(image, bits):
    """Return an 8-bit image as it is, or in 16 bits to reduce rounding."""
    return image if bits == 8 else image.astype(np.uint16) * 257


@cache
def calibrated(rig, seed):
    """Return the camera that Zhang's method gives from a rig's chessboard images."""
    boards = load_set(rendered_set(rig, seed))
    found = detect_boards(boards, DEFAULT_DETECTOR, boards.views, lambda line: None)
    views = board_views(boards, found)
    return calibrate_zhang(views, boards.width, boards.height).camera


def through(camera, truth, corners):
    """Return corners (n, 2) undistorted with one camera, as by another."""
    as_taken = camera.project(perspective_view(camera).directions(corners)).pixels
    rays = truth.rays(as_taken).directions
    return rays[:, :2] / rays[:, 2:] @ truth.K[:2, :2].T + truth.K[:2, 2]


def sweep(image, start, windows, blurs):
    """Return {method: corners (settings..., n, 2)} at every setting, NaN if not found.

    A window that leaves the image at any corner finds none.
    """
    if image.dtype == np.uint16:
        image = (image / 257).astype(np.float32)
    slopes = gradient(image.astype(float))
    nowhere = np.full_like(start, np.nan)
    fit = [window_inside(start, image.shape, w // 2).all() for w in windows]

    def in_windows(method):
        pairs = zip(windows, fit, strict=True)
        return np.array([method(w) if fits else nowhere for w, fits in pairs])

    def derivative(window):
        ridges, settled = fit_ridges(slopes, start, window)
        return kept(ridges[:, :2], settled)

    def opencv(half):
        moved = opencv_subpix(image, start, half)
        return kept(moved, (moved != start).any(axis=1))

    def saddle(blur):
        soft = blurred(image.astype(float), blur)
        return in_windows(lambda window: kept(*fit_saddles(soft, start, window)))

    return {
        "derivative": in_windows(derivative),
        "OpenCV": in_windows(lambda window: opencv(window // 2)),
        # The same numbers as half-windows.
        "OpenCV half": np.array([opencv(window) for window in windows]),
        "saddle point": np.array([saddle(blur) for blur in blurs]),
    }


def kept(corners, good):
    """Return corners (n, 2), NaN where they are not valid."""
    return np.where(good[:, None], corners, np.nan)


def window_inside(corners, shape, half):
    """Return which corners (n, 2) have a window of this half-width inside the image."""
    size = np.array(shape[::-1])
    return ((corners >= half) & (corners <= size - 1 - half)).all(axis=1)


def largest_window(corners, shape):
    """Return the full width (px) of the largest window that fits around all corners."""
    room = min(corners.min(), (np.array(shape[::-1]) - 1 - corners).min())
    return 2 * int(room) + 1


def residual_of(corners, metric):
    """Return residual vectors (px) after the homography from the metric grid (n, 2)."""
    found = np.isfinite(corners[:, 0])
    vectors = corners - mapped(corners, metric)
    size = np.linalg.norm(vectors[found], axis=1)
    return {
        "corners": corners,
        "vectors": vectors,
        "mean": float(size.mean()),
        "sd": float(size.std(ddof=1)),
        "lost": int((~found).sum()),
    }


def best_of(settings, metric):
    """Return the mean residual at each setting, and the residuals of the best one.

    settings: corners (..., n, 2). The mean is infinite where a setting loses a
    corner.
    """
    shape = settings.shape[:-2]
    flat = settings.reshape(-1, *settings.shape[-2:])
    mean = np.full(len(flat), np.inf)
    lost = np.isnan(flat[..., 0]).sum(axis=1)
    for k in np.flatnonzero(lost == 0):
        mean[k] = residual_of(flat[k], metric)["mean"]
    best = int(mean.argmin()) if (lost == 0).any() else int(lost.argmin())
    return residual_of(flat[best], metric) | {
        "means": mean.reshape(shape),
        "best": best,
    }


def square_px(corners, metric):
    """Return the median side (px) of a square of the board."""
    lattice = corners.reshape(-1, int(np.sqrt(len(metric))), 2)
    return float(np.nanmedian(np.linalg.norm(np.diff(lattice, axis=1), axis=2)))


# Fig. 3.18: a chessboard in a ball of flat mirrors, reassembled by an active grid.


MM_PER_PX = 0.3
# Half-width (mm) of the window of a localised corner: all its pixels must be visible.
HALF_MM = 2.4
# Share of a square: smaller errors count as correct.
NEAR = 0.1
MIN_PIXELS = 100  # of a facet that shows the monitor


def facet_trial(condition, rng):
    """Reassemble the monitor's chessboard from facets; compare with a static grid.

    condition: rig, seed; drawn: whether the images are kept. Returns the error
    (squares) of each corner of the remapped chessboard that can be localised. Also
    returns, by facet, the share of pixels whose position a static grid gives to
    NEAR squares, from corners of the same facet or of all facets together.
    """
    image_set, view = capture_of(condition["rig"], condition["seed"])
    blur = max(rig_of(condition["rig"]).optics.blur_sd_px)
    margin = int(np.ceil(3 + 3 * blur))
    grid, image = decoded(image_set, view, smooth=False, margin_px=margin)
    target = image_set.target
    laid, seen = remap_to_plane(
        image, grid.location, grid.sigma, grid.mask, target.monitor_mm, MM_PER_PX
    )
    metric = target.chessboard_points()
    square = float(np.linalg.norm(metric[1] - metric[0]))
    camera = rig_of(condition["rig"]).camera
    truth = np.load(image_set.folder / f"truth/{view.label}.npz")["points_mm"]
    facet, lit = facets_of(camera), np.isfinite(truth[..., 0])
    shown, count = np.unique(facet[lit], return_counts=True)
    of_facets = [(facet == k) & lit for k in shown[count >= MIN_PIXELS]]
    everywhere = visible_corners(truth, metric, lit)

    def right(corners, mine):
        return share_right(corners, metric, truth, mine, NEAR * square)

    known = grid.mask & lit
    board = target.chessboard
    drawn = {"picture": image, "laid": laid, "seen": seen} if condition["drawn"] else {}
    return drawn | {
        "corner_squares": corner_errors(laid, seen, metric) / square,
        "corners": len(metric),
        "metric": metric,
        "facets": len(of_facets),
        "within": np.array(
            [right(visible_corners(truth, metric, mine), mine) for mine in of_facets]
        ),
        "across": np.array([right(everywhere, mine) for mine in of_facets]),
        "detector_found": bool(find_board(image, board.columns, board.rows).found),
        "decoded": int(known.sum()),
        "decoded_elsewhere": int((grid.mask & ~known).sum()),
        "share_of_grid": float(seen.mean()),
    }


def facets_of(camera):
    """Return the facet (H, W) that each pixel's centre sees, -1 for none."""
    v, u = np.mgrid[: camera.height, : camera.width]
    pixels = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    return camera.facet_of(pixels).reshape(u.shape)


def corner_errors(laid, seen, metric):
    """Return errors (mm) of corners localised in the remapped image.

    NaN where the window around the position is not fully visible, or OpenCV does
    not move the corner.
    """
    half = round(HALF_MM / MM_PER_PX)
    places = metric / MM_PER_PX - 0.5
    found = opencv_subpix(laid, places, half)
    off = np.linalg.norm(found - places, axis=1) * MM_PER_PX
    for k, (x, y) in enumerate(np.rint(places).astype(int)):
        window = seen[y - half : y + half + 1, x - half : x + half + 1]
        if not window.all() or (found[k] == places[k].astype(np.float32)).all():
            off[k] = np.nan
    return off


def visible_corners(truth, metric, where):
    """Return pixels (n, 2) that see the corners of a board, NaN where none does.

    truth: (H, W, 2) mm, positions that pixels see; where: mask of pixels to search.
    """
    v, u = np.nonzero(where & np.isfinite(truth[..., 0]))
    out = np.full((len(metric), 2), np.nan)
    if not len(v):
        return out
    location = truth[v, u]
    step = np.nanmedian(np.linalg.norm(np.diff(truth, axis=1), axis=2))
    for k, place in enumerate(metric):
        away = np.linalg.norm(location - place, axis=1)
        nearest = away.argmin()
        if away[nearest] < step:
            out[k] = u[nearest], v[nearest]
    return out


def share_right(corners, metric, truth, mine, near):
    """Return the share of pixels whose position a static grid gives to `near` mm.

    corners: pixels (n, 2) of the corners in order, as from a perfect detector; NaN
    if not visible. Each pixel uses the homography of a surrounding square of the
    board whose four corners are all visible.
    """
    side = int(np.sqrt(len(metric)))
    v, u = np.nonzero(mine)
    pixels = np.column_stack([u, v]).astype(float)
    error = np.full(len(pixels), np.inf)
    order = np.arange(len(metric)).reshape(side, side)
    for row, column in np.ndindex(side - 1, side - 1):
        four = order[row : row + 2, column : column + 2].ravel()[[0, 1, 3, 2]]
        if not np.isfinite(corners[four, 0]).all():
            continue
        inside = in_quadrilateral(pixels, corners[four])
        if inside.any():
            H = homography_dlt(corners[four], metric[four])
            off = apply_homography(H, pixels[inside]) - truth[v, u][inside]
            error[inside] = np.minimum(error[inside], np.linalg.norm(off, axis=1))
    return float(np.mean(error <= near))


def in_quadrilateral(points, corners):
    """Return which points (n, 2) a quadrilateral (4, 2) holds; none if not convex."""
    sides = np.roll(corners, -1, axis=0) - corners
    turns = sides[:, 0] * np.roll(sides, -1, axis=0)[:, 1]
    turns = turns - sides[:, 1] * np.roll(sides, -1, axis=0)[:, 0]
    if not (np.all(turns > 0) or np.all(turns < 0)):
        return np.zeros(len(points), bool)
    away = points[:, None] - corners
    across = sides[:, 0] * away[..., 1] - sides[:, 1] * away[..., 0]
    return np.all(across * np.sign(turns[0]) >= 0, axis=1)
