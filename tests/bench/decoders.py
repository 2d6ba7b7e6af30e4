"""The decoder of active grids beside others, in one run: speed, memory, differences."""

import os
import time
import tracemalloc
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from raxel.features.active_grid import Noise, decode, estimate_noise, locate
from raxel.sets import ActiveGrid
from tests.active_grids import Scene, drawn, plainly_decoded
from tests.bench import peers

SIZE, NOISE = (2000, 1500), 3.0
MONITOR_PX = (1920, 1440)
ROUNDS = 5
CROP = 300  # rows compared with the plain reference, which is slow
PLAIN = "plain OpenCV calls"
NO_FRINGES = (
    "fringes is not installed: python3 lib/repro/bootstrap.py --bench (as make bench)"
)


class Timing(NamedTuple):
    """wall_ns, cpu_ns: a pixel, the best of all rounds; bytes: new ones a pixel."""

    name: str
    cores: int
    wall_ns: float
    cpu_ns: float
    bytes: float


class Agreement(NamedTuple):
    """With the plain reference: pixels, cells and masks that differ, cells at most."""

    pixels: int
    cells: int
    masks: int
    location: float


def scene_to_bench(size=SIZE):
    """A tilted monitor that fills the picture, noise 3, blur 1 px."""
    return drawn(
        size=size, monitor=MONITOR_PX, noise=NOISE, blur=1.0, tilt=0.3, share=1.4
    )


def bench_decoders(scene, rounds=ROUNDS, cores=None):
    """[Timing, ...] of decoders on a Scene of Gray code and phases along both axes.

    One round gives the pictures to one after the other; what is compiled at first use
    is compiled before.
    """
    cores = cores or len(os.sched_getaffinity(0))
    cv2.setNumThreads(1)
    runs = contenders(scene, cores)
    for run, _ in runs.values():
        run()
    best = dict.fromkeys(runs, (np.inf, np.inf))
    for _ in range(rounds):
        for name, (run, _) in runs.items():
            wall, cpu = time.perf_counter(), time.process_time()
            run()
            spent = time.perf_counter() - wall, time.process_time() - cpu
            best[name] = tuple(map(min, best[name], spent))
    pixel = scene.images[0].size * 1e-9
    timings = []
    for name, (run, used) in runs.items():
        wall, cpu = best[name]
        timings.append(
            Timing(name, used, wall / pixel, cpu / pixel, memory(run, scene))
        )
    return timings


def contenders(scene, cores):
    """{name: (function without arguments, cores that it may use)}"""
    images, patterns, grid = scene.images, scene.patterns, scene.grid
    axes = peers.read_plan(patterns, grid.monitor_px)
    noise = float(np.sqrt(noise_of(scene).floor))
    kept = decode(images, patterns, grid)
    out = np.empty((2, *images[0].shape), np.float32)
    located = locate(images, patterns, grid)

    def raxel(threads, **options):
        return lambda: decode(images, patterns, grid, threads=threads, **options)

    def places(threads):
        return lambda: locate(images, patterns, grid, threads=threads, into=located)

    raw = {"smooth": False, "margin_px": 0, "into": kept}
    runs = {
        "raxel": (raxel(cores), cores),
        "raxel, arrays kept": (raxel(cores, into=kept), cores),
        "raxel, one core": (raxel(1), 1),
        "raxel, one core, arrays kept": (raxel(1, into=kept), 1),
        "raxel, unsmoothed, arrays kept": (raxel(cores, **raw), cores),
        "raxel, locations alone": (places(cores), cores),
        "raxel, locations alone, one core": (places(1), 1),
        PLAIN: (lambda: peers.with_opencv(images, axes, noise), 1),
        "plain numpy": (lambda: peers.with_numpy(images, axes, noise), 1),
        "bandwidth bound": (lambda: peers.read_and_write(images, out, cores), cores),
        "bandwidth bound, one core": (lambda: peers.read_and_write(images, out, 1), 1),
    }
    package = peers.fringes_decoder(len(images), images[0].shape[::-1])
    if package:
        runs["fringes"] = (lambda: package(cores), cores)
    return runs


def noise_of(scene):
    sines = [k for k, p in enumerate(scene.patterns) if p.kind == "phase"]
    return estimate_noise([scene.images[k] for k in sines[:8]], 255)


def memory(run, scene):
    """Bytes a pixel that numpy holds at most while it runs, beyond what was there."""
    tracemalloc.start()
    run()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / scene.images[0].size


def agreement(scene, rows=CROP):
    """The Agreement with plain array arithmetic, on the upper rows of the pictures."""
    images = np.ascontiguousarray(scene.images[:, :rows])
    pixels = ActiveGrid(scene.grid.monitor_px)
    part = replace(scene, images=images, grid=pixels)
    variance = noise_of(scene).floor
    found = decode(images, scene.patterns, pixels, noise=Noise(variance), margin_px=0)
    place, cells, mask = plainly_decoded(part, variance)
    both = mask & found.mask
    off = np.abs(found.location - place)[both]
    width = [cell for *_, cell in peers.read_plan(scene.patterns, pixels.monitor_px)]
    return Agreement(
        mask.size,
        int(np.sum(found.cells[both] != cells[both])),
        int(np.sum(found.mask != mask)),
        float((off / width).max(initial=0)),
    )


def table(timings):
    """Lines to print: Mpx/s of wall time, CPU ns a pixel, ratios, bytes a pixel.

    The bound is what it takes to read the pictures and write both coordinates.
    """
    plain = next(t for t in timings if t.name == PLAIN)
    bound = min(t.wall_ns for t in timings if t.name.startswith("bandwidth"))
    lines = [
        f"{'decoder':<32}{'cores':>6}{'Mpx/s':>9}{'CPU ns/px':>11}"
        f"{'x OpenCV':>10}{'of bound':>10}{'bytes/px':>10}"
    ]
    for t in timings:
        lines.append(
            f"{t.name:<32}{t.cores:>6}{1e3 / t.wall_ns:>9.1f}{t.cpu_ns:>11.1f}"
            f"{plain.wall_ns / t.wall_ns:>10.2f}{bound / t.wall_ns:>10.2f}"
            f"{t.bytes:>10.1f}"
        )
    if not any(t.name == "fringes" for t in timings):
        lines.append(NO_FRINGES)
    return lines


def scene_of_set(image_set):
    """The first view of an active-grid set, as a Scene without a truth."""
    from raxel.sets import read_image

    view = image_set.views[0]
    images = np.array([read_image(image_set, p.image) for p in view.patterns])
    return Scene(images, view.patterns, image_set.target, None, None, None)
