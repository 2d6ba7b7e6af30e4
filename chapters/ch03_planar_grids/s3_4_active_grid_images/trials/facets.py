"""Fig. 3.18: a chessboard in a ball of flat mirrors, reassembled by an active grid."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import (
    capture_of,
    decoded,
    rig_of,
)
from raxel.features import find_board
from raxel.features.localise.subpix import opencv_subpix
from raxel.geometry.homography import apply_homography, homography_dlt
from raxel.multiview.plane_view import remap_to_plane

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
    grid, picture = decoded(image_set, view, smooth=False, margin_px=margin)
    target = image_set.target
    laid, seen = remap_to_plane(
        picture, grid.location, grid.sigma, grid.mask, target.monitor_mm, MM_PER_PX
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
    drawn = (
        {"picture": picture, "laid": laid, "seen": seen} if condition["drawn"] else {}
    )
    return drawn | {
        "corner_squares": corner_errors(laid, seen, metric) / square,
        "corners": len(metric),
        "metric": metric,
        "facets": len(of_facets),
        "within": np.array(
            [right(visible_corners(truth, metric, mine), mine) for mine in of_facets]
        ),
        "across": np.array([right(everywhere, mine) for mine in of_facets]),
        "detector_found": bool(find_board(picture, board.columns, board.rows).found),
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
