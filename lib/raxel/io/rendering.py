"""Availability of 3-D rendering: pyvista, and OpenGL for images.

VTK without OpenGL does not raise, it ends the process. So it is tried out in a process
of its own. Pages need no OpenGL: the reader's browser draws them.
"""

from __future__ import annotations

import functools
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

from raxel.errors import InputError

PACKAGES = ("pyvista", "trame_pyvista", "trame_vtk", "nest_asyncio2")
GL_PACKAGES = "libegl1 libgl1 libxrender1"
PROBE_S = 120  # time limit, since a driver can hang
PROBE = (
    "import pyvista as pv; p = pv.Plotter(off_screen=True, window_size=(64, 64)); "
    "p.add_mesh(pv.Sphere()); image = p.screenshot(return_img=True); "
    "assert image.std() > 1"
)


class RenderingError(InputError):
    """Report that scenes cannot be rendered on this machine.

    The message names what is missing and the remedy.
    """


def packages_missing() -> str:
    """Return one line on the packages that pages need and that are missing, or ''."""
    absent = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    if not absent:
        return ""
    return (
        f"3-D scenes require {', '.join(absent)} (not installed); run: pip install "
        "raxel[show]"
    )


@functools.cache
def rendering_missing() -> str:
    """Return one line on what images need and that is missing, or ''.

    The first call starts a process that draws a sphere, unless a file `rendering` in
    the virtual environment records that this succeeded.

    Returns
    -------
    str
        What is missing and the remedy, or ''.
    """
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        # Otherwise VTK tries a window first, and prints an error.
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    if packages_missing() or (Path(sys.prefix) / "rendering").is_file():
        return packages_missing()
    if not _draws():
        return (
            "3-D images require OpenGL (not working); run: apt-get install "
            f"{GL_PACKAGES}"
        )
    return ""


def _draws():
    """Whether a separate process renders a sphere within the time limit."""
    order = [sys.executable, "-c", PROBE]
    try:
        found = subprocess.run(order, capture_output=True, timeout=PROBE_S)
    except subprocess.TimeoutExpired:
        return False
    return found.returncode == 0


def need(missing: str) -> None:
    """Raise RenderingError where `missing`, of a function above, is not ''."""
    if missing:
        raise RenderingError(missing)
