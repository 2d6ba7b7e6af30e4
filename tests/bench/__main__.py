"""`python -m tests.bench [SET ...]`: detectors, decoders, calibrations beside others.

Sets of boards are for the detectors, those of active grids for the decoder; without
any, the photographs of the repository and a drawn grid are taken, and the linear stage
of CGSP, the consistent adjustment and motions without a centre compute from drawn rays.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from raxel.cli import main as raxel
from raxel.errors import InputError
from raxel.sets import ActiveGrid, load_set
from tests.bench.adjusters import adjusted_table, bench_adjusters
from tests.bench.calibrators import RAYS, bench_calibrators, calibrators_table
from tests.bench.decoders import (
    agreement,
    bench_decoders,
    scene_of_set,
    scene_to_bench,
    table,
)

BOARDS = Path("data/recorded/opencv-left")
# Linear algebra uses as many cores as there are, unless told before it is loaded.
ONE_CORE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def main(folders):
    """Print the tables; return the exit status."""
    try:
        grids, boards = [], []
        for folder in folders:
            kind = load_set(folder).target
            (grids if isinstance(kind, ActiveGrid) else boards).append(folder)
        failed = raxel(["bench", *boards]) if boards else 0
        for folder in grids:
            image_set = load_set(folder)
            _bench(image_set.name, scene_of_set(image_set))
    except InputError as fault:
        print(fault, file=sys.stderr)
        return 2
    if not folders:
        failed = raxel(["bench", str(BOARDS)])
        _bench("a drawn active grid", scene_to_bench())
        for rays in RAYS:
            print(f"\nthree grids of {rays} rays, one core, best of three")
            print("\n".join(calibrators_table(bench_calibrators(rays))))
        _bench_adjusters()
        print("\na mirror that bends, best of five")
        _bench_apart("mirrors")
        print("\na film of a mirror that bends, best of five")
        _bench_apart("films")
        _bench_apart("motions")
    return failed


def _bench(name, scene):
    height, width = scene.images[0].shape
    print(f"\n{name}: {len(scene.images)} pictures of {width} x {height}, best of five")
    print("\n".join(table(bench_decoders(scene))))
    found = agreement(scene)
    print(
        f"against plain array arithmetic, {found.pixels} pixels: {found.masks} masks "
        f"and {found.cells} cells differ, places by {found.location:.1e} cells at most"
    )


def _bench_adjusters():
    rng = np.random.default_rng(0)
    print("\nconsistent adjustment of three grids")
    for rays, plainly in ((200_000, True), (2_000_000, False)):
        print("\n".join(adjusted_table(bench_adjusters(rays, rng, plainly))))


def _bench_apart(name):
    """A benchmark of one core, in a process of its own."""
    sys.stdout.flush()
    command = [sys.executable, "-m", f"tests.bench.{name}"]
    subprocess.run(command, env=os.environ | ONE_CORE, check=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
