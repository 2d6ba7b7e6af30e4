"""Constructed cases: windows with one or two edges, and a distorted plane."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import photographed
from raxel.features.celect import CelectSettings
from raxel.features.celect.hough import angle_apart, peaks_of, vote
from raxel.features.celect.trace import FirstLine, Tracer
from raxel.features.celect.window import (
    Scale,
    canny_edges,
    clear_scale,
    open_window,
    smoothing_for,
)
from raxel.geometry import apply_homography
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

WINDOWS = {"quick": 5, "full": 25}
CASES = {"quick": 12, "full": 200}
AVERAGED = {
    "published": CelectSettings(),
    "no averaging": CelectSettings(split_peaks=0, wrap=0),
}
EDGE_S, EDGE_CONTRAST = 24.0, 100.0
NEAR_EDGE_DEG = 30
MIN_CROSSING_DEG, MIN_MARGIN_DEG = 40, 4


def edge_picture(angles_deg, offset, size, contrast, rng):
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
    return photographed(grey, rng, 1.0, 8.0)


def edge_window(angles_deg, offset, beyond, rng):
    """(image, window at its middle, smoothing) of an `edge_picture`.

    beyond: px by which the image side exceeds the window.
    """
    size = 2 * int(EDGE_S) + beyond
    image = edge_picture(angles_deg, offset, size, EDGE_CONTRAST, rng)
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
            near = (angle_apart(lines[:, 1], angle) < NEAR_EDGE_DEG) & (
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
            angle_apart(true, wrong) - MIN_CROSSING_DEG,
            abs(angle_apart(true, side_4) - t4) - MIN_MARGIN_DEG,
            abs(angle_apart(wrong, side_4) - t4) - MIN_MARGIN_DEG,
            abs(abs(true) - abs(wrong)) - MIN_MARGIN_DEG,
        )
        if min(margins) >= 0:
            return side_4, true, wrong


def predicted_wrong(side_4, true, wrong):
    """The two conditions of the text: which of them say that tracing goes wrong."""
    t4 = CelectSettings().first_angle_deg
    nearer = angle_apart(wrong, side_4) > t4 and abs(wrong) < abs(true)
    return bool(angle_apart(true, side_4) < t4), bool(nearer)


def start_trial(condition, rng):
    """One constructed first corner: what is chosen, and what the text predicts."""
    side_4, true, wrong = start_case(rng)
    near_side_4, nearer = predicted_wrong(side_4, true, wrong)
    image, window, smoothing = edge_window([true, wrong], 0.0, 201, rng)
    settings = CelectSettings(most_growths=0)
    scale = clear_scale([window], smoothing, settings)
    tracer = Tracer(image, scale, settings, record=True)
    start = window.centre
    end = start + [3 * EDGE_S, 0]
    first = FirstLine(side_4 % 180, False, end - start)
    steps = tracer.trace(start, end, EDGE_S, first, 1).steps
    chosen = None
    if steps:
        theta = steps[0].lines[steps[0].chosen, 1]
        off = {"true": angle_apart(theta, true), "wrong": angle_apart(theta, wrong)}
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
