"""The linear stage of CGSP beside plain code, in one run: time, memory, differences.

Every contender gets the points of the same rays on three grids and gives the centre.
The homographies are where they differ; what follows takes no time.
"""

import time
import tracemalloc
from typing import NamedTuple

import cv2
import numpy as np

from raxel.calibration.linear.cgsp import linear_cgsp
from raxel.calibration.linear.synthetic_pinhole import centre_of, scaled
from raxel.geometry import apply_homography, intersect_rays_plane, on_plane, pose
from raxel.geometry.homography import normalising
from raxel.geometry.poses import rotation_from_vector

RAYS = 200_000, 2_000_000
NOISE_MM, OUTLIERS = 0.3, 0.05
CENTRE_MM = np.array([0.0, 0.0, 600.0])
REACH_MM = 500.0
PLAIN = "plain numpy, normal equations"
ROUNDS = 3


class RunTime(NamedTuple):
    """wall_s, cpu_s: the best of all rounds; bytes: new ones a ray, of numpy; off_mm:
    of the centre from where it is."""

    name: str
    wall_s: float
    cpu_s: float
    bytes: float
    off_mm: float


def rays_to_bench(count, outliers=0.0, seed=0):
    """Points (3, count, 2) of rays on three tilted grids, with noise; mm."""
    rng = np.random.default_rng(seed)
    tilts = rotation_from_vector(
        np.radians([[0, 0, 0], [20, -10, 5], [-15, -25, 30.0]])
    )
    grids = pose(tilts, [[0, 0, 0], [30.0, -20, -60], [-40, 50, 70]])
    base = rng.uniform(-REACH_MM, REACH_MM, (count, 2))
    rays = on_plane(base) - CENTRE_MM
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    points = np.stack([intersect_rays_plane(CENTRE_MM, rays, T).points for T in grids])
    points += NOISE_MM * rng.normal(size=points.shape)
    wrong = rng.random((3, count)) < outliers
    points[wrong] = rng.uniform(-REACH_MM, REACH_MM, (np.count_nonzero(wrong), 2))
    return points


def contenders():
    """{name: (function of points that gives the centre, whether it bears outliers)}"""

    def raxel(**options):
        return lambda points: linear_cgsp(points, side=1, **options).centre

    def robust(points):
        rng = np.random.default_rng(0)
        return linear_cgsp(points, side=1, robust="ransac", rng=rng).centre

    def opencv(method):
        return lambda points: centre_by(
            lambda a, b: cv2.findHomography(a, b, method, 5 * NOISE_MM)[0], points
        )

    return {
        "raxel": (raxel(), False),
        "raxel, weighted twice": (raxel(weights="image noise"), False),
        "raxel, outliers left out": (robust, True),
        PLAIN: (lambda points: centre_by(plain_homography, points), False),
        "cv2.findHomography": (opencv(0), False),
        "cv2.findHomography, RANSAC": (opencv(cv2.RANSAC), True),
    }


def plain_homography(source, target):
    """The normalised DLT as one writes it with arrays: all rows, then A^T A."""
    T_s, T_t = normalising(source), normalising(target)
    s = np.pad(apply_homography(T_s, source), ((0, 0), (0, 1)), constant_values=1.0)
    t = apply_homography(T_t, target)
    zero = np.zeros_like(s)
    A = np.block([[s, zero, -t[:, :1] * s], [zero, s, -t[:, 1:] * s]])
    h = np.linalg.eigh(A.T @ A)[1][:, 0]
    return np.linalg.solve(T_t, h.reshape(3, 3) @ T_s)


def centre_by(homography, points):
    """The centre (3,) from two homographies of `homography`, normalised as usual."""
    base = normalising(points[0])
    found = [
        base @ homography(own, points[0]) @ np.linalg.inv(normalising(own))
        for own in points[1:]
    ]
    centre = centre_of(scaled(np.stack(found)), 0.0, side=1)[0]
    return (centre - [*base[:2, 2], 0.0]) / base[0, 0]


def bench_calibrators(count, rounds=ROUNDS):
    """[RunTime, ...] on as many rays; one round asks one contender after the other."""
    cv2.setNumThreads(1)
    clean, spoilt = rays_to_bench(count), rays_to_bench(count, OUTLIERS)
    few = rays_to_bench(1000)
    runs = contenders()
    best = dict.fromkeys(runs, (np.inf, np.inf))
    for run, _ in runs.values():
        run(few)
    for _ in range(rounds):
        for name, (run, robust) in runs.items():
            wall, cpu = time.perf_counter(), time.process_time()
            run(spoilt if robust else clean)
            spent = time.perf_counter() - wall, time.process_time() - cpu
            best[name] = tuple(map(min, best[name], spent))
    found = []
    for name, (run, robust) in runs.items():
        tracemalloc.start()
        centre = run(spoilt if robust else clean)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        off = np.linalg.norm(centre - CENTRE_MM)
        found.append(RunTime(name, *best[name], peak / count, off))
    return found


def calibrators_table(run_times):
    """Lines to print: seconds, ratio to plain numpy, bytes a ray, error in mm."""
    plain = next(t for t in run_times if t.name == PLAIN)
    lines = [
        f"{'linear stage':<32}{'wall s':>9}{'CPU s':>9}{'x numpy':>9}"
        f"{'bytes/ray':>11}{'off mm':>9}"
    ]
    for t in run_times:
        lines.append(
            f"{t.name:<32}{t.wall_s:>9.3f}{t.cpu_s:>9.3f}{plain.cpu_s / t.cpu_s:>9.1f}"
            f"{t.bytes:>11.1f}{t.off_mm:>9.4f}"
        )
    return lines
