"""`python -m tests.bench.large_images [MEGAPIXELS ...] [--keep]`: cost of large images.

Three poses of a monitor (26 images each, as of `raxel patterns`) are drawn, decoded and
calibrated, and a chessboard is detected. Of each command, in its own process: processor
seconds, peak MB (`ru_maxrss`: all resident pages, also of mapped files), and the median
error against the formulas: of decoded positions and corners in px of the monitor, of
rays in px of the image. `--keep` writes lib/repro/workflow/image_costs.csv.
"""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from raxel.cameras import load_camera, pixel_grid
from raxel.cli import main as raxel
from raxel.geometry import nearest_rotation, rotation_from_vector
from raxel.io import read_json
from raxel.sets import patterns_of, plan_of_cells
from raxel.sets.image_files import write_png
from repro.workflow.scale import IMAGES
from tests.active_grids import shown
from tests.drawn_images import Lens

SIZES, MAX_TABLE = (1, 4, 16, 50, 100), 16  # megapixels; of the table of rays
COMMANDS = {
    "decode": "decode set --out points",
    "corners": "corners board --board 15x15 --json corners",
    "zhang": "calibrate set --points points --model zhang --out zhang",
    "generic": "calibrate set --points points --model generic --out generic",
}
MONITOR = "patterns --width 3840 --height 2160 --poses 3 --out set --quiet"
SCREEN, SQUARE = (3840, 2160), np.array([240, 135])  # px
PATTERNS = patterns_of(plan_of_cells(SCREEN))
NAMES = [*(pattern.image for pattern in PATTERNS), "white.png", "black.png"]
TILTS = [0.25, -0.2, 0.05], [-0.3, 0.15, -0.1], [0.1, 0.35, 0.2]


# What pixels see of a monitor whose middle is on the optical axis, px (..., 2).
def positions(lens, pose, u, v):
    R = rotation_from_vector(np.array(TILTS[pose - 1]))[:, :2]
    H = np.column_stack([R, [0, 0, 3500] - R @ SCREEN / 2])
    points = lens.rays(u, v) @ np.linalg.inv(H).T
    return np.float32(points[..., :2] / points[..., 2:])


def make(lens):
    raxel(MONITOR.split())
    text = Path("set/set.yaml").read_text()
    text = text.replace("[0, 0]", f"[{lens.width}, {lens.height}]")
    Path("set/set.yaml").write_text(text)
    for pose in 1, 2, 3:
        rows = np.array_split(np.arange(lens.height), lens.height // 64)
        blocks = (np.meshgrid(range(lens.width), block) for block in rows)
        at = np.concatenate([positions(lens, pose, *block) for block in blocks])
        on = ((at >= 0) & (at < SCREEN)).all(axis=2)
        for k, name in enumerate(NAMES):
            own = at[..., int("-y-" in name)]
            value = shown(PATTERNS[k], own, SCREEN) if k < 24 else 25 - k
            noise = np.random.default_rng(k).standard_normal(on.shape, np.float32)
            image = 20.5 + 1.5 * noise + on * (10 + 170 * value)
            write_png(Path("set", f"pose-{pose}", name), np.uint8(image))
    edges = 4 * lens.height * np.prod(np.sin(np.pi * at / SQUARE), axis=2)
    board = np.clip(120 + edges, 20, 220)  # edges of equal width in px at all sizes
    write_png(Path("board/0.png"), np.uint8(np.where(on, board, 220)))


# The median error of a result.
def error(step, lens):
    u, v = (0.2 + 0.6 * pixel_grid(100, 100).T / 99) * [[lens.width], [lens.height]]
    u, v = u.astype(int), v.astype(int)
    if step == "decode":
        found = np.load("points/pose-3.npz")["points_px"][v, u]
        exact = positions(lens, 3, u, v)
    elif step == "corners":
        corners = read_json("corners")["images"][0]["corners"]
        found = positions(lens, 3, *np.transpose(list(filter(None, corners))))
        exact = SQUARE * np.rint(found / SQUARE)
    else:
        exact = lens.rays(u, v)
        found = load_camera(f"{step}/camera.npz").rays(np.transpose([u, v])).directions
        turn = nearest_rotation(exact.T @ np.nan_to_num(found))
        found, exact = lens.focal * found @ turn.T, lens.focal * exact
    return np.nanmedian(np.linalg.norm(found - exact, axis=-1))


def main(*words):
    costs = []
    for size in sorted(float(word) for word in words if word != "--keep") or SIZES:
        height = round(np.sqrt(size * 2e6 / 3))
        lens = Lens("barrel", 1.35 * height, height * 3 // 2, height)
        # Arrays are in another process: the peak of a child is at least its parent's.
        with TemporaryDirectory() as new, chdir(new), ProcessPoolExecutor(1) as work:
            work.submit(make, lens).result()
            for step in [*COMMANDS][: 4 if size <= MAX_TABLE else 3]:
                call = [sys.executable, "-m", "raxel", *COMMANDS[step].split(), "-q"]
                _, status, used = os.wait4(os.posix_spawn(call[0], call, os.environ), 0)
                assert not status, call
                seconds = used.ru_utime + used.ru_stime
                costs.append((size, step, seconds, used.ru_maxrss * 1024 / 1e6))
                print(*costs[-1], work.submit(error, step, lens).result())
    if "--keep" in words:
        rows = "".join(f"{a:g},{b},{c:.1f},{d:.0f}\n" for a, b, c, d in costs)
        IMAGES.write_text(f"megapixels,step,seconds,peak_mb\n{rows}")


if __name__ == "__main__":
    main(*sys.argv[1:])
