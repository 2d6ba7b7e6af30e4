"""Whether scenes can be drawn here: pyvista is there, and OpenGL for pictures.

VTK without OpenGL does not raise, it ends the process. So it is tried out in a process
of its own. Pages need no OpenGL: the reader's browser draws them.
"""

import ctypes
import functools
import importlib.util
import os
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
    """works: whether pictures can be made; reason: why not, and the command that mends
    it, '' where they can.
    """

    works: bool
    reason: str


@functools.cache
def available():
    """Whether pictures can be made on this machine: an Availability.

    The first call starts a process that draws a ball, unless a file `rendering` in the
    virtual environment remembers that this went well.
    """
    reason = _packages_missing()
    if not reason and not (_remembered() or _renders()):
        reason = f"3-D pictures need OpenGL, which does not work here; run: {MEND_GL}"
    return Availability(not reason, reason)


def need_rendering():
    """Raise RenderingError, one line with its remedy, unless pictures can be made."""
    found = available()
    if not found.works:
        raise RenderingError(found.reason)
    if sys.platform == "linux" and not os.environ.get("DISPLAY") and _loads_egl():
        # Else VTK tries a window first, and complains.
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def need_packages():
    """Raise RenderingError unless pages can be made, which takes no OpenGL."""
    reason = _packages_missing()
    if reason:
        raise RenderingError(reason)


def _packages_missing():
    absent = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    if not absent:
        return ""
    return (
        f"3-D scenes need {', '.join(absent)}, not installed here; run: {MEND_PACKAGES}"
    )


def _remembered():
    """What an earlier trial found, where the library it needs is still there."""
    record = Path(sys.prefix) / "rendering"
    works = record.is_file() and record.read_text() == "works"
    return works and (sys.platform != "linux" or _loads_egl())


def _loads_egl():
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return False
    return True


def _renders():
    """Whether a ball can be drawn."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", PROBE], capture_output=True, timeout=PATIENCE_S
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0
