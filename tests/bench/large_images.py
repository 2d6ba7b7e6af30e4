"""`python -m tests.bench.large_images [MEGAPIXELS ...] [--keep]`: cost of large images.

For each size an active grid is drawn from formulas: the 26 images of `raxel patterns`
for a monitor of 3840 x 2160 px in one pose, and decoded points of two more; and two
images of a chessboard. Every command runs in a process of its own. Printed are its
processor seconds, its wall time, its peak memory (`ru_maxrss`: all resident pages, also
those of mapped files), and the median error against the formulas: of decoded positions
in px of the monitor, of rays and corners in px of the image. Last comes the cost model,
memory = base + bytes per pixel, from all sizes but the largest, which it predicts.
`--keep` writes the costs to lib/repro/workflow/image_costs.csv.
"""

import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from raxel.cameras import PerspectiveCamera, load_camera, pixel_grid
from raxel.geometry import (
    intersect_rays_plane,
    nearest_rotation,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.sets import (
    ActiveGrid,
    Chessboard,
    ImageSet,
    View,
    patterns_of,
    plan_of_cells,
    write_set,
)
from raxel.sets.image_files import write_png
from tests.active_grids import shown

MEGAPIXELS = 1, 4, 16, 50, 100
MODELS = "zhang", "kannala-brandt", "generic"
MAX_TABLE_MEGAPIXELS = 16  # of the per-pixel ray model
COSTS = Path("lib/repro/workflow/image_costs.csv")
PX_MM, MONITOR_PX = 0.18, np.array([3840, 2160])
GRID = ActiveGrid((3840, 2160), tuple(map(float, PX_MM * MONITOR_PX)))
BOARD = Chessboard(9, 6, 45.0)
TILTS = (0.25, -0.2, 0.05), (-0.3, 0.15, -0.1), (0.1, 0.35, 0.2)  # rotation vectors
DISTANCE_MM, NOISE = 520.0, 1.5  # of a target; SD of a grey level
SIGMA_PX = 0.05  # of drawn points, px of the monitor
ROWS = 128  # drawn at once


def camera_of(megapixels):
    """Camera with an image of 4:3 and barrel distortion."""
    height = round(np.sqrt(megapixels * 3e6 / 4))
    width = round(4 / 3 * height)
    K = [[0.9 * width, 0, width / 2], [0, 0.9 * width, height / 2], [0, 0, 1]]
    return PerspectiveCamera(K, [-0.08, 0.01], width, height)


def pose_of(number, extent_mm):
    """Pose of a target whose middle is on the optical axis."""
    R = rotation_from_vector(np.array(TILTS[number]))
    return pose(R, [0, 0, DISTANCE_MM] - R[:, :2] @ (np.array(extent_mm) / 2))


def rows_of(camera, T_camera_target):
    """Yield (rows, points (rows, width, 2) mm of a target that they see)."""
    for first in range(0, camera.height, ROWS):
        rows = slice(first, min(first + ROWS, camera.height))
        pixels = pixel_grid(camera.width, rows.stop - first) + [0, first]
        rays = camera.rays(pixels)
        hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_target)
        yield rows, hits.points.reshape(-1, camera.width, 2)


def draw(paths, camera, T_camera_target, light):
    """Write images; light: of each at points, from 0 to 1."""
    rng = np.random.default_rng(0)
    images = np.empty((len(paths), camera.height, camera.width), np.uint8)
    noise = rng.normal(20, NOISE, 2 * ROWS * camera.width).astype(np.float32)
    for rows, points in rows_of(camera, T_camera_target):
        for image, value in zip(images, light(points), strict=True):
            begin = rng.integers(ROWS * camera.width)
            grey = noise[begin : begin + value.size].reshape(value.shape)
            image[rows] = np.rint(grey + 180 * value)
    for path, image in zip(paths, images, strict=True):
        write_png(path, image)


def is_on_monitor(points):
    return ((points >= 0) & (points < GRID.monitor_mm)).all(axis=-1)


def light_of_monitor(patterns, points):
    """Yield the light of the patterns, and of white."""
    on = is_on_monitor(points)
    for pattern in patterns:
        place = points[..., "xy".index(pattern.axis)] / PX_MM
        yield on * (0.06 + 0.94 * shown(pattern, place, GRID.monitor_px))
    yield on


def light_of_board(px_per_mm, points):
    """Yield the light of a chessboard with edges 2 px wide."""
    squares = points / BOARD.pitch_mm
    value = np.prod(np.sin(np.pi * squares), axis=-1)
    value = 0.5 + value * BOARD.pitch_mm * px_per_mm / (2 * np.pi)
    on = (squares > -1) & (squares < [BOARD.columns, BOARD.rows])
    yield np.where(on.all(axis=-1), np.clip(value, 0, 1), 1.0)


def make_grids(folder, camera):
    """Write the images of the first pose, and decoded points of the others."""
    views = views_of_grid()
    patterns, T = views[0].patterns, pose_of(0, GRID.monitor_mm)
    paths = [folder / name for name in (*(p.image for p in patterns), views[0].white)]
    draw(paths, camera, T, lambda points: light_of_monitor(patterns, points))
    rng = np.random.default_rng(1)
    for number, view in enumerate(views[1:], 1):
        shutil.copy(paths[-1], folder / view.white)
        for pattern in view.patterns:
            (folder / pattern.image).touch()
        points = np.empty((camera.height, camera.width, 2), np.float32)
        for rows, exact in rows_of(camera, pose_of(number, GRID.monitor_mm)):
            points[rows] = exact
            points[rows] += SIGMA_PX * PX_MM * rng.normal(size=exact.shape)
            points[rows][~is_on_monitor(exact)] = np.nan
        sigma, mask = 0 * points + np.float32(SIGMA_PX * PX_MM), is_on_monitor(points)
        fields = {"points_mm": points, "sigma_mm": sigma, "mask": mask}
        np.savez(folder / f"{view.label}.npz", **fields)


def views_of_grid():
    """Poses of the monitor."""
    patterns = patterns_of(plan_of_cells(GRID.monitor_px))
    views = []
    for name in (f"pose-{k}" for k in range(len(TILTS))):
        own = tuple(replace(p, image=f"{name}-{p.image}") for p in patterns)
        views.append(View(name=name, white=f"{name}-white.png", patterns=own))
    return views


def make_boards(folder, camera):
    """Write two images of a chessboard."""
    extent, px_per_mm = extent_of_board(), 0.9 * camera.width / DISTANCE_MM
    for number in range(2):
        T = pose_of(number, extent)
        path = folder / f"board-{number}.png"
        draw([path], camera, T, lambda points: light_of_board(px_per_mm, points))


def extent_of_board():
    """(width, height) of the interior corners, mm."""
    return BOARD.pitch_mm * (BOARD.columns - 1), BOARD.pitch_mm * (BOARD.rows - 1)


def error_of_decoding(folder, camera):
    """Median error of the first pose, px of the monitor."""
    with np.load(folder / "points" / "pose-0.npz") as found:
        points, mask = found["points_mm"], found["mask"]
    errors = [
        np.linalg.norm(points[rows] - exact, axis=-1)[mask[rows]]
        for rows, exact in rows_of(camera, pose_of(0, GRID.monitor_mm))
    ]
    return np.median(np.concatenate(errors)) / PX_MM


def error_of_rays(path, camera):
    """Median distance of rays after the best rotation, px of the image."""
    size = np.array([camera.width, camera.height])
    pixels = 0.1 * size + 0.8 * size * pixel_grid(40, 30) / [39, 29]
    exact, found = (one.rays(np.rint(pixels)) for one in (camera, load_camera(path)))
    known = exact.valid & found.valid
    exact, found = exact.directions[known], found.directions[known]
    rotated = found @ nearest_rotation(exact.T @ found).T
    return np.median(np.linalg.norm(rotated - exact, axis=1)) * camera.K[0, 0]


def error_of_corners(path, camera):
    """Median error of corners, px of the image."""
    errors = []
    grid = BOARD.pitch_mm * pixel_grid(BOARD.columns, BOARD.rows)
    for number, found in enumerate(json.loads(path.read_text())["views"]):
        points = np.pad(grid, ((0, 0), (0, 1)))
        exact = camera.project(transform(pose_of(number, extent_of_board()), points))
        corners = np.array(found["corners"], float)
        errors += [np.linalg.norm(exact.pixels - corners, axis=1)]
    return np.median(np.concatenate(errors))


def run(*words):
    """Run a command of raxel: (processor seconds, wall seconds, peak MB)."""
    began = time.perf_counter()
    words = [sys.executable, "-m", "raxel", *map(str, words)]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{' '.join(words[2:])}: exit status {status >> 8}")
    spent = usage.ru_utime + usage.ru_stime
    return spent, time.perf_counter() - began, usage.ru_maxrss * 1024 / 1e6


def measured(folder, megapixels, work):
    """Yield (step, processor seconds, wall seconds, peak MB, error) of one size.

    work: a pool of one process. It makes and compares all arrays, since the peak memory
    of a process is at least that of its parent.
    """
    camera, views = camera_of(megapixels), views_of_grid()
    grids, boards, points = folder / "grids", folder / "boards", folder / "points"
    grids.mkdir(), boards.mkdir()
    work.submit(make_grids, grids, camera).result()
    size = camera.width, camera.height
    write_set(ImageSet("monitor", *size, GRID, tuple(views[:1]), grids))
    costs = run("decode", grids, "--out", points)
    yield "decode", *costs, work.submit(error_of_decoding, folder, camera).result()
    write_set(ImageSet("monitor", *size, GRID, tuple(views), grids))
    for view in views[1:]:
        os.rename(grids / f"{view.label}.npz", points / f"{view.label}.npz")
    for model in MODELS:
        if model == "generic" and megapixels > MAX_TABLE_MEGAPIXELS:
            continue
        out = folder / model
        costs = run(
            "calibrate", grids, "--points", points, "--model", model, "--out", out
        )
        error = work.submit(error_of_rays, out / "camera.npz", camera).result()
        yield f"calibrate {model}", *costs, error
    work.submit(make_boards, boards, camera).result()
    corners = folder / "corners.json"
    board = f"{BOARD.columns}x{BOARD.rows}"
    costs = run("corners", boards, "--board", board, "--json", corners)
    yield "corners", *costs, error_of_corners(corners, camera)


def main():
    """Measure all sizes, print the table and the cost model."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("megapixels", nargs="*", type=float, default=MEGAPIXELS)
    parser.add_argument("--keep", action="store_true")
    options = parser.parse_args()
    rows = []
    print("megapixels step processor_s wall_s peak_mb median_error_px", flush=True)
    for megapixels in sorted(options.megapixels):
        context = get_context("spawn")
        with (
            tempfile.TemporaryDirectory() as folder,
            ProcessPoolExecutor(1, context) as work,
        ):
            for step, *costs in measured(Path(folder), megapixels, work):
                rows.append((megapixels, step, costs[0], costs[2]))
                numbers = " ".join(f"{cost:.3g}" for cost in costs)
                print(f"{megapixels:g} {step}: {numbers}", flush=True)
    for step in dict.fromkeys(row[1] for row in rows):
        own = np.array([(row[0], row[3]) for row in rows if row[1] == step])
        if len(own) > 2:
            slope, base = np.polyfit(*own[:-1].T, 1)
            predicted = base + slope * own[-1, 0]
            print(
                f"{step}: {base:.0f} MB + {slope:.1f} bytes per pixel; at "
                f"{own[-1, 0]:g} megapixels {predicted:.0f} MB, measured "
                f"{own[-1, 1]:.0f} MB"
            )
    if options.keep:
        with COSTS.open("w", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(["megapixels", "step", "processor_seconds", "peak_mb"])
            for megapixels, step, seconds, peak in rows:
                table.writerow([f"{megapixels:g}", step, f"{seconds:.1f}", f"{peak:.0f}"])


if __name__ == "__main__":
    main()
