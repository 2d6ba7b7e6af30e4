"""One mutant on trial: its tests, run in a copy of the checkout with its fault."""

import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from contextlib import contextmanager

from tests.import_graph import arrows_between, modules_below

CAUGHT, SURVIVED, STALE = "caught", "NOT CAUGHT", "stale"
OVERTIME, BROKEN = "over time", "broken"
# Some tests compile every loop of the library anew, on a machine that may be busy.
LIMIT_S = 600
# Photographs, and all that is built, are large and no matter of these tests.
PARTS = ("lib", "chapters", "tests", "data/published", "data/rigs", "report/source")
NUMBA = re.compile(r"^\s*(import|from) numba", re.M)
LATER_NS = 2_000_000_000
PASSED, FAILED = 0, 1  # of pytest's exit statuses; the others mean that none ran
ENVIRONMENT = {
    "PYTHONHASHSEED": "0",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
}


class Copies:
    """Copies of a checkout below `room`, one for each core, and one to copy from.

    The first is made at once and the others from it, so that they share what its tests
    have compiled.
    """

    def __init__(self, root, room, cores):
        self.first = room / "unchanged"
        self._copied(root, self.first)
        self.compiled = compiled_files(self.first)
        self._room, self._cores, self._free = room, cores, None

    @staticmethod
    def _copied(root, copy):
        copy.mkdir()
        for part in PARTS:
            if (root / part).is_dir():
                shutil.copytree(root / part, copy / part)
        for path in root.iterdir():
            if path.is_file():
                shutil.copy2(path, copy)

    def spread(self):
        """Make the copies for the cores."""
        self._free = queue.SimpleQueue()
        for core in range(self._cores):
            copy = self._room / str(core)
            self._copied(self.first, copy)
            self._free.put(copy)

    @contextmanager
    def with_fault(self, mutant):
        """A copy with the mutant's fault in it, as it was before when left."""
        copy = self._free.get()
        path = copy / mutant.file
        text, times = path.read_bytes(), path.stat()
        try:
            path.write_text(mutant.mutated(copy), "utf-8")
            # Python takes compiled code for its source's where second and length agree.
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns + LATER_NS))
            yield copy
        finally:
            path.write_bytes(text)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
            self._free.put(copy)


def outcome(copies, mutant):
    """(CAUGHT, "") where one of its tests fails, else what happened, and a remark."""
    stale = mutant.stale(copies.first)
    if stale:
        return STALE, stale
    with copies.with_fault(mutant) as copy, tempfile.TemporaryDirectory() as cache:
        kept = {"PYTHONDONTWRITEBYTECODE": "1"}
        if mutant.file in copies.compiled:
            # numba looks at a loop's own file alone, not at what the loop calls.
            kept["NUMBA_CACHE_DIR"] = cache
        status, _ = run_tests(copy, mutant.tests, kept)
    said = {PASSED: SURVIVED, FAILED: CAUGHT, None: OVERTIME}.get(status, BROKEN)
    return said, "" if said == CAUGHT else mutant.why


def fault_without(copies, mutants):
    """What pytest says where the tests fail on unchanged code; '' where they pass."""
    good = [mutant for mutant in mutants if not mutant.stale(copies.first)]
    tests = dict.fromkeys(test for mutant in good for test in mutant.tests)
    status, said = run_tests(copies.first, tests) if tests else (PASSED, "")
    if status != PASSED:
        return said or f"they ran for more than {LIMIT_S} s"
    copies.spread()
    return ""


def run_tests(copy, tests, more=None):
    """(exit status, output) of pytest in a copy; the status is None past LIMIT_S."""
    environment = os.environ | ENVIRONMENT | {"PYTHONPATH": f"{copy}/lib:{copy}"}
    order = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider"]
    order += ["--hypothesis-seed=0", *tests]
    process = subprocess.Popen(
        order, cwd=copy, env=environment | (more or {}), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
    )  # fmt: skip
    try:
        said, _ = process.communicate(timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return None, ""
    return process.returncode, said


def compiled_files(root):
    """The files of a checkout whose code or constants numba compiles."""
    modules = modules_below(root, ("lib/raxel",))
    loops = {n for n, path in modules.items() if NUMBA.search(path.read_text("utf-8"))}
    read = {a.imported for a in arrows_between(modules, root) if a.importer in loops}
    return {modules[name].relative_to(root).as_posix() for name in loops | read}
