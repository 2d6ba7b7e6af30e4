"""Trials of section 3.1.2: runs that are drawn, ablations, constructed cases."""

from __future__ import annotations

import sys

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import (
    LEAST_PX,
    board_view,
    photographed,
    sides_of,
)
from chapters.shared.grid_views import outer
from chapters.shared.scoring import scored
from chapters.shared.synthetic_board import Board, clicks
from raxel.features.celect import CelectSettings, celect
from raxel.features.celect.algorithm import snapped
from raxel.features.celect.hough import angle_apart, peaks_of, vote
from raxel.features.celect.layers import Layers
from raxel.features.celect.processing import processed
from raxel.features.celect.trace import (
    FirstLine,
    Tracer,
    first_line,
    near_lines,
    next_anchor,
    next_line,
)
from raxel.features.celect.window import (
    Scale,
    canny_edges,
    clear_scale,
    open_window,
    smoothing_for,
)
from raxel.geometry import apply_homography

NOISE_SD = 4.0
ABLATED = {
    "published": CelectSettings(),
    "no growth": CelectSettings(most_growths=0),
    "no averaging": CelectSettings(split_peaks=0, wrap=0),
}


def recorded(result):
    """Arrays of a recorded run: contours end to end, and every step.

    steps (n, 9): contour, u, v and radius of the window, R and theta of its
    line, u and v of the next anchor, number of lines. corners (m, 3): step,
    u, v. edges (k, 3): the same of the edge pixels.
    """
    steps, corners, edges, lines = [], [], [], []
    for number, contour in enumerate(result.contours):
        for step in contour.steps:
            R, theta = step.lines[step.chosen]
            here = len(steps)
            steps.append(
                [
                    number,
                    *step.centre,
                    step.radius,
                    R,
                    theta,
                    *step.anchor,
                    len(step.lines),
                ]
            )
            corners += [[here, *c] for c in step.corners]
            edges += [[here, *e] for e in step.edges]
            lines += [[here, *line] for line in step.lines]
    merged = [
        [number, *c]
        for number, contour in enumerate(result.contours)
        for c in contour.merged
    ]
    return {
        "steps": np.array(steps, float),
        "corners": np.array(corners, float),
        "edges": np.array(edges, float),
        "lines": np.array(lines, float),
        "merged": np.array(merged, float),
        "outer": result.outer_corners,
        "grid": result.corners,
        "s": np.array([c.s for c in result.contours]),
    }


def drawn_run(condition, rng):
    """One recorded run that is drawn: the first random view that is read."""
    for tried in range(1, condition["views"] + 1):  # noqa: B007
        view = board_view(
            condition["camera"],
            condition["size_px"],
            condition["least_px"],
            rng,
        )
        rows, columns = view.lattice.shape[:2]
        where = clicks(outer(view.lattice), rng)
        result = celect(view.image, where, columns, rows, record=True)
        if result.found:
            break
    values = scored(result, view.lattice) | recorded(result)
    return values | {"image": view.image, "tried": tried}


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
    """How often each stage of the code follows each other one, in one run.

    Keys "a > b". What the snapping of the clicks calls counts as snapping, and
    the choice of a first line as one stage.
    """
    board = Board()
    image = board.image(1.0, NOISE_SD, rng)
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


def camera_trial(condition, rng):
    """One board before one of the four cameras."""
    size = condition["size_px"]
    view = board_view(condition["camera"], size, LEAST_PX[size], rng)
    rows, columns = view.lattice.shape[:2]
    where = clicks(outer(view.lattice), rng)
    result = celect(view.image, where, columns, rows)
    sides = sides_of(view.lattice)
    merged = int(np.isfinite(result.corners[..., 0]).sum())
    return scored(result, view.lattice) | {
        "least_px": float(sides.min()),
        "uneven": float(sides.max() / sides.min()),
        "candidates": candidates_of(result),
        "merged": merged,
        "wanted": rows * columns,
    }


def candidates_of(result):
    """How many candidate corners a run found, each once.

    Contours cross at the corners of the sides, so two of them see a candidate.
    """
    seen = [c.candidates for c in result.contours]
    return len(np.unique(np.vstack(seen), axis=0)) if seen else 0


def window_trial(condition, rng):
    """The synthetic board with another window radius."""
    board = Board()
    image = board.image(1.0, NOISE_SD, rng)
    where = clicks(board.outer_corners, rng)
    settings = CelectSettings(radius_scale=condition["multiplier"])
    result = celect(
        image, where, board.columns, board.rows, settings=settings
    )
    return scored(result, lattice_of(board))


def lattice_of(board):
    """True corners (rows, columns, 2) of a synthetic board."""
    return board.corners.reshape(board.rows, board.columns, 2)


FADE = 0.15


def broken_edges(image, lattice, share, length, rng):
    """The picture with the middle of some squares' sides faded to grey.

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
        yield from zip(
            first.reshape(-1, 2), second.reshape(-1, 2), strict=True
        )


def lattice_means(image, lattice):
    """Grey levels at the middle of all cells: half of them dark, half bright."""
    cells = (lattice[:-1, :-1] + lattice[1:, 1:]) / 2
    u, v = np.rint(cells.reshape(-1, 2)).astype(int).T
    levels = image[v, u].astype(float)
    return np.array([levels.min(), levels.max()])


def growth_trial(condition, rng):
    """The same broken picture with and without growing windows.

    Blurred by 1 px before the edges fade and again after it.
    """
    board = Board(
        square_px=1000 / condition["squares_across"],
        fov_deg=condition["fov_deg"],
    )
    lattice = lattice_of(board)
    whole = board.image(1.0)
    image = broken_edges(
        whole, lattice, condition["share"], condition["length"], rng
    )
    image = photographed(image.astype(np.float32), rng, 1.0, NOISE_SD)
    where = clicks(board.outer_corners, rng)
    return {
        name: scored(
            celect(
                image,
                where,
                board.columns,
                board.rows,
                settings=ABLATED[name],
            ),
            lattice,
        )
        for name in ("published", "no growth")
    }


def edge_picture(angles_deg, offset, size, contrast, rng):
    """A window's picture of edges through its middle: one or two of them.

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
    return photographed(grey, rng, 1.0, 8.0)


EDGE_S, EDGE_CONTRAST = 24.0, 100.0
NEAR_EDGE_DEG = 30


def split_trial(condition, rng):
    """Lines found in windows with one straight edge, with and without averaging."""
    size = 2 * int(EDGE_S) + 41
    centre = np.full(2, (size - 1) / 2)
    names = ("published", "no averaging")
    counts = {name: {"any": 0, "near": 0} for name in names}
    for _ in range(condition["windows"]):
        angle = rng.uniform(0, 180)
        offset = rng.uniform(-0.2, 0.2) * EDGE_S
        image = edge_picture([angle], offset, size, EDGE_CONTRAST, rng)
        smoothing = smoothing_for(EDGE_S, ABLATED["published"])
        window = open_window(image, centre, EDGE_S, smoothing)
        scale = Scale(
            smoothing,
            float(np.hypot(window.gradient_u, window.gradient_v).max()),
            1.0,
        )
        published = ABLATED["published"]
        edges = canny_edges(
            window, scale, published.canny_high, published.canny_low
        )
        space = vote(edges, centre, EDGE_S)
        for name in names:
            settings = ABLATED[name]
            lines = peaks_of(space, settings, EDGE_S).lines
            near = (angle_apart(lines[:, 1], angle) < NEAR_EDGE_DEG) & (
                np.abs(lines[:, 0]) < settings.near_centre * EDGE_S
            )
            counts[name]["any"] += len(lines) > 1
            counts[name]["near"] += int(near.sum()) > 1
    return counts


LEAST_CROSSING_DEG, LEAST_MARGIN_DEG = 40, 4


def start_case(rng):
    """(L4, true edge, wrong edge) in degrees, L1 being 0; far from every boundary."""
    t4 = CelectSettings().first_angle_deg
    while True:
        side_4 = rng.uniform(50, 130)
        true, wrong = rng.uniform(-85, 85, 2)
        margins = (
            angle_apart(true, wrong) - LEAST_CROSSING_DEG,
            abs(angle_apart(true, side_4) - t4) - LEAST_MARGIN_DEG,
            abs(angle_apart(wrong, side_4) - t4) - LEAST_MARGIN_DEG,
            abs(abs(true) - abs(wrong)) - LEAST_MARGIN_DEG,
        )
        if min(margins) >= 0:
            return side_4, true, wrong


def predicted_wrong(side_4, true, wrong):
    """The two conditions of the text: which of them say that tracing goes wrong."""
    t4 = CelectSettings().first_angle_deg
    near_side_4 = angle_apart(true, side_4) < t4
    nearer = angle_apart(wrong, side_4) > t4 and abs(wrong) < abs(true)
    return bool(near_side_4), bool(nearer)


def start_trial(condition, rng):
    """One constructed first corner: what is chosen, and what the text predicts."""
    side_4, true, wrong = start_case(rng)
    near_side_4, nearer = predicted_wrong(side_4, true, wrong)
    size = 2 * int(EDGE_S) + 201
    centre = np.full(2, (size - 1) / 2)
    image = edge_picture([true, wrong], 0.0, size, EDGE_CONTRAST, rng)
    settings = CelectSettings(most_growths=0)
    smoothing = smoothing_for(EDGE_S, settings)
    window = open_window(image, centre, EDGE_S, smoothing)
    scale = clear_scale([window], smoothing, settings)
    tracer = Tracer(image, scale, settings, record=True)
    end = centre + [3 * EDGE_S, 0]
    first = FirstLine(side_4 % 180, False, end - centre)
    steps = tracer.trace(centre, end, EDGE_S, first, 1).steps
    chosen = None
    if steps:
        theta = steps[0].lines[steps[0].chosen, 1]
        off = {
            "true": angle_apart(theta, true),
            "wrong": angle_apart(theta, wrong),
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


def square_trial(condition, rng):
    """The synthetic board with larger squares under strong distortion."""
    board = Board(
        square_px=1000 / condition["squares_across"],
        fov_deg=condition["fov_deg"],
    )
    image = board.image(1.0, NOISE_SD, rng)
    where = clicks(board.outer_corners, rng)
    result = celect(image, where, board.columns, board.rows)
    return scored(result, lattice_of(board))


def limit_trial(condition, rng):
    """The synthetic board, with one smoothing for all sizes of square."""
    board = Board(square_px=1000 / condition["squares_across"])
    image = board.image(1.0, condition["noise_sd"], rng)
    where = clicks(board.outer_corners, rng)
    smoothing = condition["smoothing_px"]
    settings = CelectSettings()
    if smoothing is not None:
        settings = CelectSettings(smoothing_limits_px=(smoothing,) * 2)
    result = celect(
        image, where, board.columns, board.rows, settings=settings
    )
    return scored(result, lattice_of(board))


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
        "disc_px": float(
            np.linalg.norm(centroid(bent, condition["radius"]) - true)
        ),
    }


def crossing(bent, step=1e-3, rounds=20):
    """Where the images (2,) of the two axes meet: f(a, 0) = f(0, b)."""
    a, b = 7.0, -5.0
    for _ in range(rounds):
        ends = bent(
            np.array([[a, 0], [0, b], [a + step, 0], [0, b + step]])
        )
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
