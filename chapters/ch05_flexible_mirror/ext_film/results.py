"""What the film's page reads of its two experiments, and the numbers that it quotes."""

from typing import NamedTuple

import numpy as np

from repro.judge.statistics import median_interval, with_worst
from repro.page.reader import value
from repro.page.wording import rounded

FILM, SEEDS = "ext_mirror_film_pictures", "ext_mirror_film_seeds"
WAYS = {
    "tracked": "each picture by itself (tracked)",
    "handed_on": "each from the one before (stages)",
}
UM, FIRST = 1000.0, "first_mm"
# Below this deflection, mm, corners reach the free edge.
BELOW_MM = 10.0


class Frames(NamedTuple):
    """The film of the rendered pictures, a row for each of n frames.

    true_mm, found_mm, angle_deg, residual_mm (n,); used (n,) corners; at_edge (n,)
    of them in the knot interval next to the free edge; off_px (n,); first_mm: how much
    too high the first shape stands at the load; picture (n, h, w) uint8; corners
    (n, N, 2) px of the whole picture; mirror, directions (n, a, b, 3); profile
    (n, b, 2) mm; T_camera_board (4, 4).
    """

    true_mm: np.ndarray
    found_mm: np.ndarray
    angle_deg: np.ndarray
    residual_mm: np.ndarray
    used: np.ndarray
    at_edge: np.ndarray
    off_px: np.ndarray
    first_mm: float
    picture: np.ndarray
    corners: np.ndarray
    mirror: np.ndarray
    directions: np.ndarray
    profile: np.ndarray
    T_camera_board: np.ndarray

    @classmethod
    def of(cls, result):
        """Those of the film's only trial."""
        found = {name: result.arrays(name)[0] for name in cls._fields if name != FIRST}
        return cls(**found, first_mm=float(result.column(FIRST)[0]))

    @property
    def error_um(self):
        """Found minus true deflection (n,), um."""
        return UM * (self.found_mm - self.true_mm)

    @property
    def peak(self):
        """Number of the frame with the largest deflection."""
        return int(np.argmax(self.true_mm))


def courses(result, way, name):
    """A measure over the film, (seeds, n), of the seeds that no picture refused."""
    if refusals(result, way) == result.trials_per_condition:
        return np.empty((0, 0))
    found = result.arrays(f"{way}.{name}")
    return np.array([own for own in found if own is not None and np.size(own)])


def loops_um(result, way):
    """|um| (seeds,) by which the found deflection is off when the mirror is flat again,
    infinite where a seed was refused."""
    found = courses(result, way, "found_mm")
    refused = result.trials_per_condition - len(found)
    loops = UM * np.abs(found[:, -1]) if len(found) else []
    return with_worst(np.append(loops, np.full(refused, np.nan)))


def refusals(result, way):
    """Seeds in which a picture was refused."""
    return sum(text is not None for text in result.texts(f"{way}.refused"))


def name_values(open_results):
    """Name the numbers of the prose."""
    frames, seeds = Frames.of(open_results(FILM)), open_results(SEEDS)
    quoted = of_film(frames)
    for way in WAYS:
        quoted |= of_seeds(seeds, way)
    quoted["seeds"] = seeds.trials_per_condition
    for name, number in quoted.items():
        value(name, number)


def of_film(frames):
    """Name -> what prose quotes of the rendered film."""
    error, peak = np.abs(frames.error_um), frames.peak
    counts = np.count_nonzero(np.isfinite(frames.corners[..., 0]), axis=1)
    step = frames.corners[1:] - frames.corners[:-1]
    below = error[frames.true_mm < BELOW_MM]
    return {
        "frames": len(frames.true_mm),
        "below_mm": f"{BELOW_MM:g}",
        "peak_mm": f"{frames.true_mm[peak]:g}",
        "corners.least": int(counts.min()),
        "corners.most": int(counts.max()),
        "off_px": f"{np.sqrt(np.mean(frames.off_px**2)):.2g}",
        "step_px": f"{np.nanmax(np.linalg.norm(step, axis=-1)):.0f}",
        "error.peak": f"{error[peak]:.2g}",
        "error.most": f"{error.max():.2g}",
        "error.below": f"{below.max():.2g}",
        "at_edge.first": int(frames.at_edge[0]),
        "at_edge.peak": int(frames.at_edge[peak]),
        "loop": f"{error[-1]:.1g}",
        "angle.first": f"{frames.angle_deg[0]:.2g}",
        "angle.peak": f"{frames.angle_deg[peak]:.2g}",
        "angle.last": f"{frames.angle_deg[-1]:.2g}",
        "first_um": f"{UM * np.abs(frames.first_mm):.2g}",
        "residual.peak": f"{frames.residual_mm[peak]:.2g}",
    }


def of_seeds(result, way):
    """Name -> what prose quotes of a way over the seeds."""
    found = {
        f"{way}.loop": in_words(median_interval(loops_um(result, way))),
        f"{way}.refused": refusals(result, way),
    }
    angles = courses(result, way, "angle_deg")
    for name, share in (("first", 0), ("peak", 0.5), ("last", 1)):
        told = "(no number)"
        if len(angles):
            frame = round(share * (angles.shape[1] - 1))
            told = in_words(median_interval(angles[:, frame]))
        found[f"{way}.angle.{name}"] = told
    return found


def in_words(estimate):
    """An Estimate with its interval, for a sentence; a single seed has none."""
    if not np.isfinite(estimate.value):
        return "(no number)"
    ends = estimate.low, estimate.high
    return rounded(estimate.value, ends if np.isfinite(ends).all() else None)
