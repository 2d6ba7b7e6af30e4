"""Trials of this page, their conditions and constants."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import cv2
import numpy as np

from chapters.shared.grids import (
    CELECT,
    CLICK_SD_PX,
    CLICKLESS,
    HARD,
    LINEAR,
    OPENCV,
    OPENCV_SB,
    SETS,
    clockwise,
    corner_areas,
    is_right,
    outer,
    returned,
    rig_of,
)
from raxel.errors import InputError
from raxel.evaluation import distances, in_order_of
from raxel.features import undo_srgb
from raxel.features.celect import along_contour, celect
from raxel.geometry import intersect_rays_plane, on_plane, transform
from raxel.lab import (
    Raster,
    Rig,
    board_scene,
    grey_of,
    light_of_room,
    mirror_in_view,
    outline_of,
    window_of,
)

# Runs of the detectors on one image: click orders, and losses by merging.


NO_CLICKS = (OPENCV, OPENCV_SB, CLICKLESS)
NOT_RUN = "outer corner"
WRONG = "wrong corner returned"
DONE = "done"
# A point belongs to a corner within this share of its nearest neighbour's distance.
NEAR = 0.25


class Clicked(NamedTuple):
    """One run of CELECT: the order's true lattice, its result, and where it failed."""

    lattice: np.ndarray
    result: object
    stage: str

    @property
    def right(self):
        """Whether every corner is correct."""
        return self.stage == DONE


def draw_clicks(rng):
    """Return offsets (4, 2) px of the clicks on a clockwise lattice."""
    return rng.normal(0.0, CLICK_SD_PX, (4, 2))


def ordered(lattice, first, reverse=False):
    """Return the lattice as clicked from outer corner `first` (0 to 3) on.

    reverse: anticlockwise.
    """
    turned = np.rot90(lattice, first)
    return turned.transpose(1, 0, 2) if reverse else turned


def run(image, lattice, offsets, first=None, reverse=False):
    """Run CELECT from clicks at the true outer corners plus `offsets` (4, 2): Clicked.

    lattice: (rows, columns, 2), clockwise; first: the first clicked corner, by
    default that with the smallest square, as 3.3.2 advises.
    """
    if first is None:
        first = int(corner_areas(lattice).argmin())
    clicked = lattice.copy()
    clicked[[0, 0, -1, -1], [0, -1, -1, 0]] += offsets
    truth = ordered(lattice, first, reverse)
    rows, columns = truth.shape[:2]
    clicks = outer(ordered(clicked, first, reverse))
    try:
        result = celect(image, clicks, columns, rows)
    except InputError:
        return Clicked(truth, None, NOT_RUN)
    if not result.found:
        return Clicked(truth, result, result.failures[0].stage)
    right = is_right(result.corners.reshape(-1, 2), truth.reshape(-1, 2))
    return Clicked(truth, result, DONE if right else WRONG)


def detected(name, image, lattice):
    """Return whether a detector without clicks finds the lattice, from any corner.

    name: as in `grid_detectors`; lattice: true corners (rows, columns, 2).
    """
    rows, columns = lattice.shape[:2]
    corners = returned(name, image, columns, rows)
    if corners is None:
        return False
    truth = lattice.reshape(-1, 2)
    return is_right(in_order_of(truth, corners, columns, rows), truth)


def both_tones(image, lattice, offsets):
    """Run CELECT on an image as it is, and with its tone curve undone."""
    return tuple(run(tone, lattice, offsets) for tone in (image, undo_srgb(image)))


def every_detector(runs, image, lattice, others=NO_CLICKS):
    """Return whether CELECT, by `both_tones`, and others, without clicks, succeed."""
    clicked, linear = runs
    values = {CELECT: clicked.right, LINEAR: linear.right, "stage": clicked.stage}
    return values | {name: detected(name, image, lattice) for name in others}


def eight_orders(image, lattice, offsets):
    """Return where CELECT ends from every first corner, in both directions.

    For the image as it is, and (`linear_`) with its tone curve undone; rank 0
    starts at the smallest square.
    """
    areas = corner_areas(lattice)
    values = {"area_ratio": float(areas.max() / areas.min())}
    for tone, toned in {"": image, "linear_": undo_srgb(image)}.items():
        for reverse, way in ((False, "clockwise"), (True, "reverse")):
            for rank, first in enumerate(np.argsort(areas)):
                clicked = run(toned, lattice, offsets, int(first), reverse)
                values[f"{tone}{way}_{rank}"] = clicked.right
                values[f"{tone}{way}_{rank}_stage"] = clicked.stage
    return values


def merging(runs):
    """Return the effect of merging in `both_tones` of an image."""
    clicked, linear = runs
    return _merging(clicked) | {"linear": _merging(linear)}


def _merging(clicked):
    return {
        "size_ratio": size_variation(clicked.lattice),
        "merge_failed": merge_failed(clicked.result, clicked.lattice),
        "success": clicked.right,
        "stage": clicked.stage,
    }


def size_variation(lattice):
    """Return the largest ratio of the longest to the shortest step along one contour.

    lattice: (rows, columns, 2). Contours are the four sides and the columns, as
    CELECT follows them.
    """
    contours = [lattice[0], lattice[-1], *lattice.swapaxes(0, 1)]
    steps = [np.linalg.norm(np.diff(c, axis=0), axis=1) for c in contours]
    return float(max(s.max() / s.min() for s in steps))


def merge_failed(result, lattice):
    """Return whether merging lost or doubled a corner on a traced contour.

    result: CelectResult or None; lattice: (rows, columns, 2) in the order of
    clicks.
    """
    if result is None:
        return False
    reach = NEAR * nearest_distances(lattice)
    for contour in result.contours:
        truth = along_contour(contour.name, lattice)
        near = along_contour(contour.name, reach)
        if not len(contour.merged):
            continue
        before = claimed(contour.inliers, truth, near)
        after = claimed(contour.merged, truth, near)
        if ((before > 0) & (after == 0)).any() or (after > 1).any():
            return True
    return False


def claimed(points, truth, near):
    """Return how many points (m, 2) are within near (n,) of each corner (n, 2)."""
    return (distances(truth, points) <= near[:, None]).sum(axis=1)


def nearest_distances(lattice):
    """Return the distance (rows, columns) px of each corner to its neighbour."""
    flat = lattice.reshape(-1, 2)
    apart = distances(flat, flat)
    np.fill_diagonal(apart, np.inf)
    return apart.min(axis=1).reshape(lattice.shape[:2])


# A board rendered once, with its light changed afterwards.
#
# Radiance is linear, and light changes little over a point spread. An image in other
# light is therefore the image in full, even light times the light at the board position
# that each pixel sees. Blemishes and the sensor follow, in physical order.


LIGHT_LEVELS = (0.8, 0.4, 0.2, 0.1, 0.05, 0.025, 0.0125)
CUT_PX = 24
# Blur extends less than this from the edge of a board.
EDGE_PX = 3


def level_name(level):
    """Return the key of a light level in a trial's values."""
    return f"light {level:g}".replace(".", "_")


class Sheet(NamedTuple):
    """A board in front of a rig's camera, in full and even light.

    irradiance: (h, w) or (h, w, 3) of the part of the image from pixel `first` (u,
    v) on that contains the board; uv: (h, w, 2) mm, the position on the board's
    plane that a pixel sees, also outside the board, nan where it sees none;
    points: (rows, columns, 2) mm and lattice: the same in px of the whole image,
    rows and columns turning clockwise in it; specimen, exposure: start values of the
    mirror's flaws, and of glare and noise.
    """

    rig: Rig
    T_camera_board: np.ndarray
    irradiance: np.ndarray
    first: tuple[int, int]
    uv: np.ndarray
    points: np.ndarray
    lattice: np.ndarray
    specimen: int
    exposure: int

    def place(self, points):
        """Return true pixels (N, 2) of positions on the board (N, 2), mm."""
        seen = transform(self.T_camera_board, on_plane(points))
        return self.rig.camera.project(seen).pixels


def sheet_of(set_name, rng, poses=HARD):
    """Return a board of a set (key of `grid_rigs.SETS`), with random pose and flaws.

    poses: range of the poses; that of the rig's file, or WHOLE of `grid_rigs`.
    """
    number = rng.integers(sum(count for _, count in SETS[set_name]))
    rig = rig_of(set_name, int(number), poses)
    pose = rig.draw_poses(rng, 1)[0]
    scene = board_scene(rig.target, pose, rig.border_mm, **rig.radiances)
    window = window_of(rig, pose)
    irradiance = rig.laboratory().irradiance(
        scene, np.eye(4), colour=rig.sensor.bayer is not None, window=window
    )
    columns, rows = rig.target.columns, rig.target.rows
    points = rig.target.points().reshape(rows, columns, 2)
    specimen, exposure = (int(seed) for seed in rng.integers(2**31, size=2))
    sheet = Sheet(
        rig,
        pose,
        irradiance,
        (window.u, window.v),
        _visible_positions(rig, pose, window),
        points,
        points,
        specimen,
        exposure,
    )
    lattice = sheet.place(points.reshape(-1, 2)).reshape(points.shape)
    if clockwise(lattice) is not lattice:
        points, lattice = points[:, ::-1], lattice[:, ::-1]
    return sheet._replace(points=points, lattice=lattice)


def lit_sheet(set_name, rng, poses):
    """Return a board of a set and its illumination, both drawn at random."""
    sheet = sheet_of(set_name, rng, poses)
    return sheet, sheet.rig.light.draw(rng, sheet.rig.extent)


def whole_image(sheet, light):
    """Return the whole image (H, W) uint8 in a light: positions (N, 2) mm -> (N,)."""
    return _exposed(sheet, light, None)


def cropped_image(sheet, light):
    """Return the image cropped to the board and 24 px around it, and its true lattice.

    The lattice (rows, columns, 2) is in px of the cropped image. The rest is never
    exposed, so the noise differs from that of `whole_image`.
    """
    height, width = sheet.irradiance.shape[:2]
    low = np.array(sheet.first) - CUT_PX // 2
    high = np.array(sheet.first) + (width, height) + CUT_PX // 2
    camera = sheet.rig.camera
    low = np.maximum(low, 0) // 2 * 2
    high = np.minimum(high, (camera.width, camera.height))
    cut = slice(low[1], high[1]), slice(low[0], high[0])
    return _exposed(sheet, light, cut), sheet.lattice - low


def contrast(image, lattice):
    """Return the median difference of grey levels between neighbouring squares."""
    middles = (
        lattice[:-1, :-1] + lattice[1:, 1:] + lattice[:-1, 1:] + lattice[1:, :-1]
    ) / 4
    u, v = np.rint(middles).astype(int).transpose(2, 0, 1)
    grey = image[v, u].astype(float)
    return float(np.median(np.abs(np.diff(grey, axis=1))))


def outline_px(sheet, low, high):
    """Return the true outline (100, 2) px of a rectangle of the board."""
    return sheet.place(outline_of(low, np.asarray(high) - low))


def _exposed(sheet, light, cut):
    """Return the image, or only its part `cut` (slices of rows and columns)."""
    rig = sheet.rig
    rng = np.random.default_rng(sheet.exposure)
    aside, whole = light_of_room(rig)
    if sheet.irradiance.ndim == 3:
        aside, whole = (np.repeat(x[..., None], 3, axis=2) for x in (aside, whole))
    (u, v), (height, width) = sheet.first, sheet.uv.shape[:2]
    place = slice(v, v + height), slice(u, u + width)
    whole[place] = aside[place] + _lit(sheet, light)
    mirror = mirror_in_view(rig.camera)
    specimen = np.random.default_rng(sheet.specimen)
    whole = rig.blemishes.apply(whole, mirror, specimen, rng)
    whole = whole if cut is None else whole[cut]
    if rig.light.coloured:
        whole = rig.light.tinted(whole)
    return grey_of(rig.sensor.expose(whole, rng, colour=whole.ndim == 3))


def _lit(sheet, light):
    """Return the board's part of the image in a light; the room keeps its own.

    At the edge of the board a pixel sees a mixture of paper and room, blurred by
    the lens. There the share of paper follows from the irradiance.
    """
    full, rig = sheet.irradiance, sheet.rig
    seen = np.isfinite(sheet.uv[..., 0])
    share = np.ones(seen.shape, np.float32)
    share[seen] = light(sheet.uv[seen])
    share = share.reshape(share.shape + (1,) * (full.ndim - 2))
    lens = _lens_shade(sheet).reshape(share.shape)
    white, room = (rig.radiances[name] for name in ("white", "background"))
    paper = np.clip((full / lens - room) / (white - room), 0, 1)
    at_edge = full + lens * paper * white * (share - 1)
    inside, around = (m.reshape(share.shape) for m in _inside_and_around(sheet))
    return np.where(inside, full * share, np.where(around, at_edge, full))


def _lens_shade(sheet):
    """Return the share of light (h, w) that the lens transmits, where the board is."""
    camera = sheet.rig.camera
    shade = sheet.rig.optics.vignetting(camera.width, camera.height)
    (u, v), (height, width) = sheet.first, sheet.uv.shape[:2]
    return shade[v : v + height, u : u + width]


def _inside_and_around(sheet):
    """Return pixels (h, w) certainly on the board, and those possibly on it."""
    corner, size = sheet.rig.extent
    with np.errstate(invalid="ignore"):
        on = (sheet.uv >= corner) & (sheet.uv <= corner + size)
    on = on.all(axis=2).astype(np.uint8)
    reach = np.ones((2 * EDGE_PX + 1,) * 2, np.uint8)
    return (f(on, reach) > 0 for f in (cv2.erode, cv2.dilate))


def _visible_positions(rig, T_camera_board, window):
    """Return positions (h, w, 2) mm on the board's plane that pixels see, or nan."""
    raster = Raster(rig.camera, window=window)
    rays = raster.grid(np.arange(raster.width), np.arange(raster.height))
    met = intersect_rays_plane(*rays[:2], T_camera_board).points
    return met.reshape(raster.height, raster.width, 2)


# Extraction of parts of a large grid without a border (Fig. 3.14).
#
# Parts of the grid are tried from the whole grid downwards, excluding the smallest
# squares, until a method returns one. Then rows or columns are added as long as the
# larger part is returned, too. CELECT gets the image as it is and clicks on the part's
# corners; OpenCV gets white paint around the part's squares.


MIN_LINES = 3
WHITE = 255
BORDER_PX = 24
# Each part tried has at most this share of the corners of the one before.
NEXT_SHARE = {"quick": 0.8, "full": 0.95}


class Part(NamedTuple):
    """Corners of rows top to bottom and columns left to right, ends included."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def count(self):
        """Number of corners."""
        return (self.bottom - self.top + 1) * (self.right - self.left + 1)

    def of(self, lattice):
        """The part (rows, columns, 2) of a lattice."""
        return lattice[self.top : self.bottom + 1, self.left : self.right + 1]

    def moved(self, side, step):
        """The part with one side moved outwards by `step` lines (-1: inwards)."""
        outwards = (-step, step, -step, step)[side]
        return self._replace(**{self._fields[side]: self[side] + outwards})


def large_grids(effort):
    """Return the conditions of both cameras with a large grid."""
    return [
        {"camera": camera, "next_share": NEXT_SHARE[effort]}
        for camera in ("hyperboloidal", "fisheye")
    ]


def candidate_parts(lattice, next_share):
    """Return parts from the whole lattice down, each the largest of its smallest step.

    Excluding exactly the squares below a size gives one of them. Each has at most
    `next_share` of the corners of the one before.
    """
    parts, kept, longest = _all_parts(lattice), [], -1.0
    for part, step in sorted(parts, key=lambda p: (-p[0].count, -p[1])):
        if step <= longest:
            continue
        longest = step
        if not kept or part.count <= next_share * kept[-1].count:
            kept.append(part)
    return kept


def _all_parts(lattice):
    """Return every part of at least MIN_LINES lines each way, and its smallest step."""
    rows, columns = lattice.shape[:2]
    across = np.linalg.norm(np.diff(lattice, axis=1), axis=2)
    down = np.linalg.norm(np.diff(lattice, axis=0), axis=2)
    found = []
    for top in range(rows - MIN_LINES + 1):
        for bottom in range(top + MIN_LINES - 1, rows):
            h = across[top : bottom + 1].min(axis=0)
            v = down[top:bottom].min(axis=0)
            for left in range(columns - MIN_LINES + 1):
                steps = np.minimum.accumulate(
                    np.minimum(v[left:], np.append(np.inf, h[left:]))
                )
                steps = np.minimum(steps, v[left])
                found += [
                    (Part(top, bottom, left, right), float(steps[right - left]))
                    for right in range(left + MIN_LINES - 1, columns)
                ]
    return found


def largest_part(returns, lattice, next_share):
    """Return the part at which the search ends, or None, and the number of parts tried.

    returns: part -> whether the method returned all of it, in order.
    """
    rows, columns = lattice.shape[:2]
    whole = Part(0, rows - 1, 0, columns - 1)
    known = {}

    def tried(part):
        if part not in known:
            known[part] = returns(part)
        return known[part]

    part = next(filter(tried, candidate_parts(lattice, next_share)), None)
    while part:
        larger = next(filter(tried, _extended(part, whole)), None)
        if larger is None:
            break
        part = larger
    return part, len(known)


def _extended(part, whole):
    """Return the part with one line more at any side; the longest line first."""
    more = [part.moved(side, 1) for side in range(4) if part[side] != whole[side]]
    return sorted(more, key=lambda p: -p.count)


def painted(sheet, image, part):
    """Return the image with white around the squares of a part, by their true outline.

    Returns the image cropped to the squares and 24 px around them, and the part's
    true corners (rows, columns, 2) in it.
    """
    points = part.of(sheet.points).reshape(-1, 2)
    pitch = sheet.rig.target.pitch_mm
    low, high = points.min(axis=0) - pitch, points.max(axis=0) + pitch
    mask = np.zeros(image.shape, np.uint8)
    around = np.rint(outline_px(sheet, low, high)).astype(np.int32)
    cv2.fillPoly(mask, [around], 1)
    bordered = np.where(mask == 1, image, np.uint8(WHITE))
    first = np.maximum(around.min(axis=0) - BORDER_PX, 0)
    end = around.max(axis=0) + BORDER_PX + 1
    cut = bordered[first[1] : end[1], first[0] : end[0]]
    return cut, part.of(sheet.lattice) - first


def border_distance(corners, image):
    """Return the distance (px) of corners (..., 2) to the image border."""
    height, width = image.shape
    far = np.array([width - 0.5, height - 0.5])
    return float(min((corners + 0.5).min(), (far - corners).min()))


def partial_trial(condition, rng):
    """Return the largest part of CELECT and of OpenCV in one image of a large grid."""
    sheet, image = _large_image(condition, rng)
    offsets = draw_clicks(rng)
    stages = Counter()

    def returns(part):
        clicked = run(image, part.of(sheet.lattice), offsets)
        stages[clicked.stage] += 1
        return clicked.right

    share = condition["next_share"]
    clicked = _extracted(returns, sheet, image, share)
    return {
        "picture": image,
        "lattice": sheet.lattice,
        CELECT: clicked | {"lost": {s: n for s, n in stages.items() if s != DONE}},
        OPENCV: _by_detector(OPENCV, sheet, image, share),
    }


def partial_sb_trial(condition, rng):
    """Return the largest part of OpenCV's sector-based detector in the same image."""
    image = _large_image(condition, rng)
    return {OPENCV_SB: _by_detector(OPENCV_SB, *image, condition["next_share"])}


def _large_image(condition, rng):
    sheet = sheet_of(f"large-{condition['camera']}", rng)
    return sheet, whole_image(sheet, sheet.rig.light.draw(rng, sheet.rig.extent))


def _by_detector(name, sheet, image, next_share):
    """Return values of the search with white paint around every part."""

    def returns(part):
        return detected(name, *painted(sheet, image, part))

    return _extracted(returns, sheet, image, next_share)


def _extracted(returns, sheet, image, next_share):
    """Return values of a search: final part, size and distance to the border."""
    part, tries = largest_part(returns, sheet.lattice, next_share)
    if part is None:
        return {"tries": tries, "count": 0}
    corners = part.of(sheet.lattice)
    bordered, cut_corners = painted(sheet, image, part)
    long, short = sorted(corners.shape[:2], reverse=True)
    return {
        "tries": tries,
        "count": part.count,
        "columns": long,
        "rows": short,
        "border_px": border_distance(corners, image),
        "corners": corners,
        "painted": bordered,
        "first": corners[0, 0] - cut_corners[0, 0],
    }
