"""Set up `.venv` from environment.txt, on a machine with Python, git and make only.

`make` runs it with the system's Python and only the standard library. It prints one
line per step, and one line with the remedy if a step fails.
"""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

VENV = Path(".venv")
PYTHON = VENV / "bin" / "python"
CRATE = VENV / "crate"
OLDEST, NEWEST = (3, 11), (3, 13)
PROBE = (
    "import pyvista as pv; p = pv.Plotter(off_screen=True, window_size=(64, 64)); "
    "p.add_mesh(pv.Sphere()); image = p.screenshot(return_img=True); "
    "assert image.std() > 1"
)
GL_PACKAGES = ("libegl1", "libgl1", "libxrender1")


def main(options):
    """Run the missing steps of the set-up; a failing step ends the process."""
    if not PYTHON.is_file() or run(PYTHON, "-c", "").returncode:
        (VENV / "packages-installed").unlink(missing_ok=True)
    once(Path("environment.txt"), "packages-installed", install_packages)
    once(Path("pyproject.toml"), "project-installed", install_project)
    for name in ("lab", "bench"):
        if f"--{name}" in options:
            once(Path(f"lib/repro/{name}.txt"), f"{name}-installed", install_pins)
    if "--slurm-plugin" in options:
        once(Path("lib/repro/slurm.txt"), "slurm-installed", install_slurm_plugin)
    if "--crate" in options:
        once(Path("lib/repro/crate.txt"), "crate-installed", install_crate)
    if "--rendering" in options:
        probe_rendering()


def once(source, record, step):
    """Run ``step`` on a file, unless it was run for this content in this folder."""
    wanted = hashlib.sha256(source.read_bytes() + os.getcwd().encode()).hexdigest()
    done = VENV / record
    if not done.is_file() or done.read_text() != wanted:
        step(source)
        done.write_text(wanted)


def install_packages(pins):
    """Make a new .venv of the base Python, with the pinned packages."""
    version = sys.version_info[:2]
    if not OLDEST <= version <= NEWEST:
        sys.exit(
            f"set-up: {sys.executable}: Python {version[0]}.{version[1]}, 3.11 to 3.13 "
            "needed; run `make PYTHON=python3.12 ...` with one of those"
        )
    must(
        run(
            getattr(sys, "_base_executable", sys.executable),
            *("-m", "venv", "--clear", VENV),
        ),
        f"python -m venv (Debian: apt-get install python3.{version[1]}-venv)",
    )
    install_pins(pins)


def install_slurm_plugin(pins):
    """Install it next to the other packages: Snakemake imports what is among them."""
    install_pins(pins, "--upgrade", "--target", VENV / "slurm-plugin")


def install_pins(pins, *options):
    """Install the pinned packages of a file by hash; further files agree with the
    first."""
    say(f"packages from {pins} (environment.txt: about 1.5 GB, a minute or two)")
    pip("--require-hashes", "--no-deps", *options, "-r", pins)


def install_crate(pins):
    """Make the environment of `make crate`, whose packages do not fit the others."""
    must(run(PYTHON, "-m", "venv", "--clear", CRATE), "python -m venv")
    say(f"packages from {pins} (30 MB)")
    pip("--require-hashes", "--no-deps", "-r", pins, python=CRATE / "bin" / "python")


def install_project(_):
    """Install the project in editable mode and compile the loops of the library."""
    pip("--no-deps", "--no-build-isolation", "--editable", ".")
    say("compiled loops of the library (one to two minutes, once)")
    for index in Path("lib/raxel").rglob("*.nbi"):
        index.unlink()  # an index from before a module moved cannot be read
    must(run(PYTHON, "-m", "raxel.compile_loops"), "python -m raxel.compile_loops")


def pip(*arguments, python=PYTHON):
    """Install with an environment's pip, quietly."""
    options = "--quiet", "--disable-pip-version-check", "--no-input", *arguments
    must(run(python, "-m", "pip", "install", *options), "pip install")


def probe_rendering():
    """Test 3-D rendering once, in a separate process: VTK without OpenGL ends it."""
    record = VENV / "rendering"
    if record.is_file():
        return
    may_install = os.geteuid() == 0 and shutil.which("apt-get")
    if run(PYTHON, "-c", PROBE).returncode and may_install:
        say(f"OpenGL libraries for 3-D figures: {' '.join(GL_PACKAGES)}")
        run("apt-get", "update")
        run("apt-get", "install", "-y", "--no-install-recommends", *GL_PACKAGES)
    if run(PYTHON, "-c", PROBE).returncode == 0:
        record.write_text("works")
    else:
        say(f"no 3-D figures; run: apt-get install {' '.join(GL_PACKAGES)}")


def run(*command):
    """Run a command and keep its output."""
    return subprocess.run(command, capture_output=True, text=True, check=False)


def must(done, step):
    """End the process with the last line of a command that failed."""
    if done.returncode:
        lines = (done.stderr or done.stdout or "no output").strip().splitlines()
        errors = [line for line in lines if line.startswith("ERROR")]
        sys.exit(f"set-up: {step} failed: {(errors or lines)[-1].strip()}")


def say(text):
    """One line of progress."""
    print(f"set-up: {text}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    main(sys.argv[1:])
