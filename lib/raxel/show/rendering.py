"""Whether pictures can be made here: pyvista is there, and OpenGL works.

VTK without OpenGL does not raise, it ends the process. So it is tried out in a process
of its own, once, and what works is remembered in the environment.
"""

import functools
import importlib.util
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from raxel.errors import InputError

GL_PACKAGES = ("libegl1", "libgl1", "libxrender1")
MEND_GL = f"apt-get install {' '.join(GL_PACKAGES)}"
MEND_PACKAGES = "pip install raxel[show]"
PACKAGES = ("pyvista", "trame_pyvista", "trame_vtk", "nest_asyncio2")
PROBE = (
    "import pyvista as pv; p = pv.Plotter(off_screen=True, window_size=(64, 64)); "
    "p.add_mesh(pv.Sphere()); image = p.screenshot(return_img=True); "
    "assert image.std() > 1"
)
PATIENCE_S = 120


class RenderingError(InputError):
    """Nothing can be drawn in three dimensions here; one line says what mends it."""


class Availability(NamedTuple):
    """works: whether pictures can be made; reason: why not and the command that mends
    it, '' where they can.
    """

    works: bool
    reason: str


@functools.cache
def available():
    """Whether pictures and pages can be made on this machine: an Availability.

    The first call in an environment starts a process that draws a ball. A file
    `rendering` in the environment remembers that this went well.
    """
    absent = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    if absent:
        return Availability(
            False,
            f"3-D pictures need {', '.join(absent)}, not installed here; run: "
            f"{MEND_PACKAGES}",
        )
    if _remembered() or _renders():
        return Availability(True, "")
    return Availability(
        False,
        f"3-D pictures need OpenGL, which does not work here; run: {MEND_GL}",
    )


def need_rendering():
    """Raise RenderingError, one line with its remedy, unless pictures can be made."""
    found = available()
    if not found.works:
        raise RenderingError(found.reason)


def _remembered():
    record = Path(sys.prefix) / "rendering"
    return record.is_file() and record.read_text() == "works"


def _renders():
    """Whether a ball can be drawn; remembered in a virtual environment that does."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", PROBE], capture_output=True, timeout=PATIENCE_S
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0
