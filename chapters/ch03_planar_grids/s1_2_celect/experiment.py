"""Trials of this page, their conditions and constants."""

from __future__ import annotations

import sys
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from chapters.shared.grids import SyntheticBoard, clicks, outer, scored, steps_between
from raxel.cameras import FisheyeCamera, QuadricMirrorCamera, camera_from
from raxel.features.celect import (
    CelectSettings,
    FirstLine,
    Layers,
    Scale,
    Tracer,
    angle_difference,
    canny_edges,
    celect,
    clear_scale,
    first_line,
    near_lines,
    next_anchor,
    next_line,
    open_window,
    peaks_of,
    processed,
    smoothing_for,
    snapped,
    vote,
)
from raxel.geometry import (
    apply_homography,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.lab import board_scene, render
from raxel.sets import Chessboard
from repro.run import Plan, experiment

# Images of a chessboard with four distorting cameras (section 3.1.2).


# Side of the image (px) -> minimum length of a square's side in it (px).
MIN_SQUARE_PX = {900: 15, 600: 10}
CAMERAS = ("fisheye", "sphere", "hyperboloid", "bent sheet")
FISHEYE_DEG = 160
BOARD = Chessboard(9, 7, 30.0)
BLACK, WHITE, BACKGROUND = 25.0, 215.0, 120.0
BLUR_PX, NOISE_SD = 1.0, 4.0
DISTANCE_MM = (130, 330)
TILT_DEG = 40
MAX_SIDE_RATIO = 3
DRAWS = 2000


class BoardImage(NamedTuple):
    """An image uint8 (h, w) and the true corners (rows, columns, 2) px."""

    image: np.ndarray
    lattice: np.ndarray


def viewer(focal, size):
    """The pinhole camera that views a mirror; focal length in image sides."""
    middle, f = (size - 1) / 2, focal * size
    K = [[f, 0, middle], [0, f, middle], [0, 0, 1]]
    fields = {"K": K, "radial": [], "width": size, "height": size}
    return camera_from("perspective", fields)


@cache
def camera_of(name, size):
    """The camera of this name, with images of size x size px; mm."""
    if name == "fisheye":
        half, middle = np.radians(FISHEYE_DEG) / 2, (size - 1) / 2
        return FisheyeCamera(
            "equidistance", middle / half, [middle] * 2, size, size, half
        )
    if name == "sphere":
        return QuadricMirrorCamera.on_axis(viewer(1.8, size), "sphere", (30,), 25, 100)
    if name == "hyperboloid":
        return QuadricMirrorCamera.aligned(
            viewer(1.4, size), "hyperboloid", (30, 20), 25
        )
    heights = [[0, 0, 6], [0, 4, 0], [20, 0, 0], [5, 0, 0]]
    sheet = {"size": (400, 400), "heights": heights, "offset": (0, 0, 180)}
    return camera_from("bent mirror", {"viewer": viewer(0.65, size)} | sheet)


def drawn_pose(camera, rng):
    """T_camera_board (4, 4): around a random pixel's ray, tilted and rotated."""
    pixel = rng.uniform(0.25, 0.75, (1, 2)) * camera.width
    rays = camera.rays(pixel)
    if not rays.valid[0]:
        return None
    towards = rays.directions[0]
    across = np.cross(towards, rng.normal(size=3))
    across /= np.linalg.norm(across)
    R = np.column_stack((across, np.cross(towards, across), towards))
    tilt = np.radians(rng.uniform(-TILT_DEG, TILT_DEG, 2))
    R = R @ rotation_from_vector(np.append(tilt, 0.0))
    centre = rays.origins[0] + rng.uniform(*DISTANCE_MM) * towards
    middle = np.append(BOARD.points().mean(axis=0), 0.0)
    return pose(R, centre - R @ middle)


def lattice_at(camera, T_camera_board):
    """True corners (rows, columns, 2) px, None if a square is not visible."""
    rim = Chessboard(BOARD.columns + 2, BOARD.rows + 2, BOARD.pitch_mm)
    points = on_plane(rim.points() - BOARD.pitch_mm)
    seen = camera.project(transform(T_camera_board, points))
    inside = (seen.pixels > 4) & (seen.pixels < camera.width - 5)
    if not (seen.valid.all() and inside.all()):
        return None
    return seen.pixels.reshape(rim.rows, rim.columns, 2)[1:-1, 1:-1]


def board_view(name, size, least_px, rng):
    """Return a moderately distorted BoardImage of camera `name`, random pose.

    Moderate: every side of a square is at least least_px long, and none more
    than MAX_SIDE_RATIO times as long as another.
    """
    camera = camera_of(name, size)
    for _ in range(DRAWS):
        T_camera_board = drawn_pose(camera, rng)
        if T_camera_board is None:
            continue
        lattice = lattice_at(camera, T_camera_board)
        if lattice is None:
            continue
        sides = steps_between(lattice)
        even = sides.max() <= MAX_SIDE_RATIO * sides.min()
        if even and sides.min() >= least_px:
            return BoardImage(rendered_board(name, size, T_camera_board, rng), lattice)
    raise ValueError(f"{name}: no pose shows the complete board")


def rendered_board(name, size, T_camera_board, rng):
    """The image, uint8, blurred and noisy."""
    scene = board_scene(
        BOARD, T_camera_board, black=BLACK, white=WHITE, background=BACKGROUND
    )
    radiance = render(camera_of(name, size), np.eye(4), scene)
    return blurred_noisy(radiance, rng)


def blurred_noisy(grey, rng, blur_px=BLUR_PX, noise_sd=NOISE_SD):
    """Grey levels (h, w) after blur, noise and rounding, uint8."""
    soft = cv2.GaussianBlur(grey, (0, 0), blur_px)
    noisy = soft + rng.normal(0.0, noise_sd, grey.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


# Variations of the synthetic board of 3.3.1, and images with broken edges.


BOARDS_NOISE_SD = 4.0
MULTIPLIERS = (0.4, 0.5, 0.63, 0.8, 1.0, 1.26, 1.6, 2.0, 2.5)
BIG_FOVS = (152, 146, 134)
# Length of the faded stretch in sides of squares, and the share of all sides.
BROKEN = {
    "large squares with long breaks": {
        "length": 0.6,
        "share": 0.15,
        "squares_across": 6,
        "fov_deg": 100,
    },
    "large squares with short breaks": {
        "length": 0.4,
        "share": 0.15,
        "squares_across": 6,
        "fov_deg": 100,
    },
    "small squares with long breaks": {
        "length": 0.6,
        "share": 0.30,
        "squares_across": 10,
        "fov_deg": 134,
    },
}
FADE = 0.15
PUBLISHED = CelectSettings()
GROWN = {"published": PUBLISHED, "no growth": CelectSettings(max_growths=0)}


def clicked_score(board, noise_sd, rng, settings=PUBLISHED):
    """Score of one run on a blurred and noisy image of a SyntheticBoard."""
    image = board.image(1.0, noise_sd, rng)
    where = clicks(board.outer_corners, rng)
    result = celect(image, where, board.columns, board.rows, settings=settings)
    return scored(result, board.lattice)


def broken_edges(image, lattice, share, length, rng):
    """The image with the middle of some squares' sides faded to grey.

    share: of all sides; length: of the faded stretch, in sides. The fade ends
    FADE of a side further out on both sides.
    """
    grey = image.astype(np.float32)
    level = float(np.median(lattice_means(image, lattice)))
    v, u = np.indices(image.shape, np.float32)
    keep = np.ones(image.shape, np.float32)
    for a, b in all_sides(lattice):
        if rng.random() >= share:
            continue
        middle, side = (a + b) / 2, np.linalg.norm(b - a)
        reach = int((length / 2 + FADE) * side) + 2
        first = np.maximum(np.rint(middle).astype(int) - reach, 0)
        last = np.rint(middle).astype(int) + reach + 1
        part = slice(first[1], last[1]), slice(first[0], last[0])
        off = np.hypot(u[part] - middle[0], v[part] - middle[1]) / side
        faded = np.clip((off - length / 2) / FADE, 0, 1)
        keep[part] = np.minimum(keep[part], faded)
    return np.rint(level + keep * (grey - level)).astype(np.uint8)


def all_sides(lattice):
    """Pairs of neighbouring corners."""
    for first, second in (
        (lattice[:, :-1], lattice[:, 1:]),
        (lattice[:-1], lattice[1:]),
    ):
        yield from zip(first.reshape(-1, 2), second.reshape(-1, 2), strict=True)


def lattice_means(image, lattice):
    """Lowest and highest grey level at the centres of the squares."""
    cells = (lattice[:-1, :-1] + lattice[1:, 1:]) / 2
    u, v = np.rint(cells.reshape(-1, 2)).astype(int).T
    levels = image[v, u].astype(float)
    return np.array([levels.min(), levels.max()])


def growth_trial(condition, rng):
    """The same image of broken edges with and without growing windows.

    It is blurred by 1 px before and after the edges fade.
    """
    board = SyntheticBoard(
        square_px=1000 / condition["squares_across"], fov_deg=condition["fov_deg"]
    )
    lattice = board.lattice
    image = broken_edges(
        board.image(1.0), lattice, condition["share"], condition["length"], rng
    )
    image = blurred_noisy(image.astype(np.float32), rng, 1.0, BOARDS_NOISE_SD)
    where = clicks(board.outer_corners, rng)
    return {
        name: scored(
            celect(image, where, board.columns, board.rows, settings=settings), lattice
        )
        for name, settings in GROWN.items()
    }


# Constructed cases: windows with one or two edges, and a distorted plane.


WINDOWS = {"quick": 5, "full": 25}
CASES = {"quick": 12, "full": 200}
AVERAGED = {
    "published": CelectSettings(),
    "no averaging": CelectSettings(split_peaks=0, wrap=0),
}
EDGE_S, EDGE_CONTRAST = 24.0, 100.0
NEAR_EDGE_DEG = 30
MIN_CROSSING_DEG, MIN_MARGIN_DEG = 40, 4


def edge_image(angles_deg, offset, size, contrast, rng):
    """Image of one or two edges through the middle of a window.

    One angle: a straight edge, `offset` px from the middle. Two: the corner of
    four fields in which they cross.
    """
    middle = (size - 1) / 2
    v, u = np.indices((size, size)) - middle
    sign = 1.0
    for angle in np.radians(angles_deg):
        away = np.cos(angle) * v - np.sin(angle) * u - offset
        sign = sign * np.clip(2 * away, -1, 1)
    grey = (127.5 + contrast / 2 * sign).astype(np.float32)
    return blurred_noisy(grey, rng, 1.0, 8.0)


def edge_window(angles_deg, offset, beyond, rng):
    """(image, window at its middle, smoothing) of an `edge_image`.

    beyond: px by which the image side exceeds the window.
    """
    size = 2 * int(EDGE_S) + beyond
    image = edge_image(angles_deg, offset, size, EDGE_CONTRAST, rng)
    smoothing = smoothing_for(EDGE_S, CelectSettings())
    middle = np.full(2, (size - 1) / 2)
    return image, open_window(image, middle, EDGE_S, smoothing), smoothing


def split_trial(condition, rng):
    """Lines found in windows with one straight edge, with and without averaging."""
    counts = {name: {"any": 0, "near": 0} for name in AVERAGED}
    published = AVERAGED["published"]
    for _ in range(condition["windows"]):
        angle = rng.uniform(0, 180)
        offset = rng.uniform(-0.2, 0.2) * EDGE_S
        _, window, smoothing = edge_window([angle], offset, 41, rng)
        scale = Scale(
            smoothing, float(np.hypot(window.gradient_u, window.gradient_v).max()), 1.0
        )
        edges = canny_edges(window, scale, published.canny_high, published.canny_low)
        space = vote(edges, window.centre, EDGE_S)
        for name, settings in AVERAGED.items():
            lines = peaks_of(space, settings, EDGE_S).lines
            near = (angle_difference(lines[:, 1], angle) < NEAR_EDGE_DEG) & (
                np.abs(lines[:, 0]) < settings.near_centre * EDGE_S
            )
            counts[name]["any"] += len(lines) > 1
            counts[name]["near"] += int(near.sum()) > 1
    return counts


@experiment("table_3_2_split", artefact="table_3_2")
def split_peaks(effort):
    """Windows with one edge, with and without averaging of peaks."""
    return Plan(split_trial, [{"windows": 40}], WINDOWS[effort])


def start_case(rng):
    """(L4, true edge, wrong edge) in degrees, L1 being 0; far from every boundary."""
    t4 = CelectSettings().first_angle_deg
    while True:
        side_4 = rng.uniform(50, 130)
        true, wrong = rng.uniform(-85, 85, 2)
        margins = (
            angle_difference(true, wrong) - MIN_CROSSING_DEG,
            abs(angle_difference(true, side_4) - t4) - MIN_MARGIN_DEG,
            abs(angle_difference(wrong, side_4) - t4) - MIN_MARGIN_DEG,
            abs(abs(true) - abs(wrong)) - MIN_MARGIN_DEG,
        )
        if min(margins) >= 0:
            return side_4, true, wrong


def predicted_wrong(side_4, true, wrong):
    """The two conditions of the text: each flag is True where tracing should fail."""
    t4 = CelectSettings().first_angle_deg
    nearer = angle_difference(wrong, side_4) > t4 and abs(wrong) < abs(true)
    return bool(angle_difference(true, side_4) < t4), bool(nearer)


def start_trial(condition, rng):
    """One constructed first corner: what is chosen, and what the text predicts."""
    side_4, true, wrong = start_case(rng)
    near_side_4, nearer = predicted_wrong(side_4, true, wrong)
    image, window, smoothing = edge_window([true, wrong], 0.0, 201, rng)
    settings = CelectSettings(max_growths=0)
    scale = clear_scale([window], smoothing, settings)
    tracer = Tracer(image, scale, settings, record=True)
    start = window.centre
    end = start + [3 * EDGE_S, 0]
    first = FirstLine(side_4 % 180, False, end - start)
    steps = tracer.trace(start, end, EDGE_S, first, 1).steps
    chosen = None
    if steps:
        theta = steps[0].lines[steps[0].chosen, 1]
        off = {
            "true": angle_difference(theta, true),
            "wrong": angle_difference(theta, wrong),
        }
        chosen = min(off, key=off.get)
    return {
        "side_4_deg": side_4,
        "true_deg": true,
        "wrong_deg": wrong,
        "near_side_4": near_side_4,
        "nearer": nearer,
        "predicted": near_side_4 or nearer,
        "went_wrong": chosen != "true",
        "chosen": chosen or "none",
    }


@experiment("table_3_2_start", artefact="table_3_2")
def start_cases(effort):
    """First corners on both sides of each condition of the text."""
    return Plan(start_trial, [{}], CASES[effort])


def bias_trial(condition, rng):
    """A corner and a disc, bent: how far their centres move, in px.

    The plane goes through a random homography and p -> p (1 + k r^2). The corner
    is where two bent lines meet, found by Newton's method on the lines' own
    parameters; the disc's centre is its centroid, from its bent outline.
    """
    tilt = rng.uniform(-2e-4, 2e-4, 2)
    turn = rng.uniform(0, 2 * np.pi)
    centre = rng.uniform(-200, 200, 2)
    k = -condition["bend"] / 300.0**2

    c, s = np.cos(turn), np.sin(turn)
    rigid = np.array([[c, -s, centre[0]], [s, c, centre[1]], [0, 0, 1]])
    H = np.array([[1, 0, 0], [0, 1, 0], [*tilt, 1]]) @ rigid

    def bent(points):
        flat = apply_homography(H, points)
        return flat * (1 + k * (flat**2).sum(axis=1))[:, None]

    true = bent(np.zeros((1, 2)))[0]
    return {
        "corner_px": float(np.linalg.norm(crossing(bent) - true)),
        "disc_px": float(np.linalg.norm(centroid(bent, condition["radius"]) - true)),
    }


@experiment("exp_c3_bias", artefact="sec_3_1_2")
def bias(effort):
    """A corner and a disc under a homography and a radial law."""
    return Plan(bias_trial, [{"bend": 0.2, "radius": 20.0}], CASES[effort])


def crossing(bent, step=1e-3, rounds=20):
    """Where the images (2,) of the two axes meet: f(a, 0) = f(0, b)."""
    a, b = 7.0, -5.0
    for _ in range(rounds):
        ends = bent(np.array([[a, 0], [0, b], [a + step, 0], [0, b + step]]))
        J = np.column_stack((ends[2] - ends[0], ends[1] - ends[3])) / step
        a, b = np.array([a, b]) - np.linalg.solve(J, ends[0] - ends[1])
    return bent(np.array([[a, 0.0]]))[0]


def centroid(bent, radius, count=4000):
    """Centroid (2,) of the image of a disc, from its outline."""
    angle = np.arange(count) * 2 * np.pi / count
    x, y = bent(radius * np.column_stack((np.cos(angle), np.sin(angle)))).T
    p, q = np.roll(x, -1), np.roll(y, -1)
    cross = x * q - p * y
    return np.array([((x + p) * cross).sum(), ((y + q) * cross).sum()]) / (
        3 * cross.sum()
    )


# Recorded runs of CELECT: every step, or the order of the code's stages.


def recorded(result):
    """Arrays of a recorded run: contours end to end, and every step.

    steps (n, 9): contour, u, v and radius of the window, R and theta of its
    line, u and v of the next anchor, number of lines. corners (m, 3): step,
    u, v. edges (k, 3): the same of the edge pixels.
    """
    steps = [
        (number, step)
        for number, contour in enumerate(result.contours)
        for step in contour.steps
    ]

    def seen(what):
        """Rows of one attribute of every step, the step's number first."""
        rows = [
            [here, *one]
            for here, (_, step) in enumerate(steps)
            for one in getattr(step, what)
        ]
        return np.array(rows, float)

    walked = [
        [
            number,
            *step.centre,
            step.radius,
            *step.lines[step.chosen],
            *step.anchor,
            len(step.lines),
        ]
        for number, step in steps
    ]
    merged = [
        [number, *c]
        for number, contour in enumerate(result.contours)
        for c in contour.merged
    ]
    return {
        "steps": np.array(walked, float),
        **{what: seen(what) for what in ("corners", "edges", "lines")},
        "merged": np.array(merged, float),
        "outer": result.outer_corners,
        "grid": result.corners,
        "s": np.array([c.s for c in result.contours]),
    }


def drawn_run(condition, rng):
    """One recorded run for a figure: the first random view that is correct."""
    for tried in range(1, condition["views"] + 1):  # noqa: B007
        view = board_view(
            condition["camera"], condition["size_px"], condition["least_px"], rng
        )
        rows, columns = view.lattice.shape[:2]
        where = clicks(outer(view.lattice), rng)
        result = celect(view.image, where, columns, rows, record=True)
        if result.found:
            break
    seen = {"image": view.image, "tried": tried}
    return scored(result, view.lattice) | recorded(result) | seen


@experiment("fig_3_1_run", artefact="fig_3_1")
def run_on_fisheye(effort):
    """Run for a figure: windows, lines, candidates of every step."""
    condition = {"camera": "fisheye", "size_px": 600, "least_px": 22, "views": 10}
    return Plan(drawn_run, [condition], 1)


@experiment("fig_3_4_run", artefact="fig_3_4")
def run_on_mirror(effort):
    """Run on a mirror image for a figure."""
    condition = {"camera": "hyperboloid", "size_px": 900, "least_px": 18, "views": 10}
    return Plan(drawn_run, [condition], 1)


STAGES = {
    "snap": snapped,
    "window": Layers.edges,
    "hough": vote,
    "peaks": peaks_of,
    "near": near_lines,
    "first line": first_line,
    "next line": next_line,
    "anchor": next_anchor,
    "corners": Layers.corners,
    "arrived": Tracer._arrived,
    "process": processed,
}


def stage_trial(condition, rng):
    """Count how often each stage of the code follows another one in a run.

    Keys "a > b". Calls within the snapping of the clicks count as snapping; the
    choice of a first line is one stage.
    """
    board = SyntheticBoard()
    image = board.image(1.0, BOARDS_NOISE_SD, rng)
    where = clicks(board.outer_corners, rng)
    names = {f.__code__: name for name, f in STAGES.items()}
    whole = {snapped.__code__, first_line.__code__}
    order, within = [], []

    def note(frame, event, _):
        code = frame.f_code
        if event == "call" and code in names and not within:
            order.append(names[code])
        if code in whole and event == "call":
            within.append(code)
        elif code in whole and event == "return":
            within.pop()

    sys.setprofile(note)
    try:
        result = celect(image, where, board.columns, board.rows)
    finally:
        sys.setprofile(None)
    counts = {"found": result.found, "contours": len(result.contours)}
    for pair in zip(["start", *order], [*order, "end"], strict=True):
        key = " > ".join(pair)
        counts[key] = counts.get(key, 0) + 1
    return counts


@experiment("fig_3_3_stages", artefact="fig_3_3")
def stages(effort):
    """Transitions between stages of the code, counted in a run."""
    return Plan(stage_trial, [{}], 1)


# The synthetic board in many sizes: large squares, and one smoothing for all.


SQUARES_ACROSS = (20, 15, 12, 10, 8, 6, 5)


def square_trial(condition, rng):
    """The synthetic board with larger squares under strong distortion."""
    board = SyntheticBoard(
        square_px=1000 / condition["squares_across"], fov_deg=condition["fov_deg"]
    )
    return clicked_score(board, BOARDS_NOISE_SD, rng)


@experiment("exp_c3_big_square", artefact="sec_3_1_2")
def big_squares(effort):
    """Sizes of square at three wide fields of view."""
    across = SQUARES_ACROSS[::6] if effort == "quick" else SQUARES_ACROSS
    conditions = [
        {"squares_across": n, "fov_deg": fov} for fov in BIG_FOVS for n in across
    ]
    return Plan(square_trial, conditions, {"quick": 1, "full": 12}[effort])
