"""Set up `.venv` from environment.txt, on a machine with Python, git and make only.

Run by `make` with the system's Python; uses the standard library alone. Prints one line
per step, and one line saying what to do when a step cannot be done.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

OLDEST, NEWEST = (3, 11), (3, 13)
VENV = Path(".venv")
PYTHON = VENV / "bin" / "python"
PACKAGES, PACKAGES_DONE = Path("environment.txt"), VENV / "packages-installed"
LAB, LAB_DONE = Path("lib/repro/lab.txt"), VENV / "lab-installed"
BENCH, BENCH_DONE = Path("lib/repro/bench.txt"), VENV / "bench-installed"
PROJECT, PROJECT_DONE = Path("pyproject.toml"), VENV / "project-installed"
RENDERING = VENV / "rendering"
GL_PACKAGES = ("libegl1", "libgl1", "libxrender1")
PROBE = (
    "import pyvista as pv; p = pv.Plotter(off_screen=True, window_size=(64, 64)); "
    "p.add_mesh(pv.Sphere()); image = p.screenshot(return_img=True); "
    "assert image.std() > 1"
)


class SetUpError(Exception):
    """A step that cannot be done; the message says what to do about it."""


def main(arguments=None):
    """Set up whatever is not set up yet; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rendering", action="store_true", help="probe 3-D as well")
    parser.add_argument("--lab", action="store_true", help="install JupyterLab as well")
    parser.add_argument("--bench", action="store_true", help="install peers as well")
    options = parser.parse_args(arguments)
    try:
        set_up()
        if options.lab:
            add("JupyterLab", LAB, LAB_DONE)
        if options.bench:
            add_peers()
        if options.rendering:
            probe_rendering()
    except SetUpError as error:
        print(f"set-up: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("set-up: interrupted; run it again to go on", file=sys.stderr)
        return 130
    return 0


def set_up():
    """Create .venv and install what environment.txt pins, unless that is done."""
    packages = fingerprint(PACKAGES)
    if not (recorded(PACKAGES_DONE) == packages and works()):
        install_packages()
        PACKAGES_DONE.write_text(packages)
    project = fingerprint(PROJECT)
    if recorded(PROJECT_DONE) != project:
        pip("install", "--no-deps", "--no-build-isolation", "--editable", ".")
        compile_loops()
        PROJECT_DONE.write_text(project)


def install_packages():
    """A fresh .venv with exactly the pinned packages."""
    version = sys.version_info[:2]
    if not OLDEST <= version <= NEWEST:
        raise SetUpError(
            f"Python {version[0]}.{version[1]} found at {sys.executable}, 3.11 to 3.13 "
            "needed; run `make PYTHON=python3.12 ...` with one of those"
        )
    say("a virtual environment in .venv")
    make_venv()
    say("packages from environment.txt (about 1.5 GB on disk, a minute or two)")
    pip("install", "--require-hashes", "--no-deps", "-r", str(PACKAGES))


def add(what, pins, done):
    """Add what a file pins to .venv, unless that is done.

    Its pins agree with those of environment.txt, so nothing else changes.
    """
    wanted = fingerprint(pins)
    if recorded(done) != wanted:
        say(f"{what} from {pins} (half a minute, once)")
        pip("install", "--require-hashes", "--no-deps", "-r", str(pins))
        done.write_text(wanted)


def add_peers():
    """Add what `make bench` compares with; without it, it compares with the others."""
    try:
        add("fringes and PoseLib to compare with", BENCH, BENCH_DONE)
    except SetUpError as error:
        say(f"no fringes and no PoseLib to compare with: {error}")


def compile_loops():
    """Let numba compile the library's loops, so that the first build need not."""
    say("compiled loops of the library (half a minute, once)")
    done = run([str(PYTHON), "-m", "raxel.compile_loops"])
    if done.returncode:
        raise SetUpError(f"`python -m raxel.compile_loops` failed: {last_line(done)}")


def fingerprint(path):
    """What an installation depends on: a file's content, and where the checkout is."""
    return hashlib.sha256(path.read_bytes() + os.getcwd().encode()).hexdigest()


def recorded(path):
    """What a finished step left behind; empty when it has not finished."""
    return path.read_text() if path.is_file() else ""


def works():
    """Whether the environment's Python still starts."""
    return run([str(PYTHON), "-c", "import sys"]).returncode == 0


def make_venv():
    """Create .venv with pip; on Debian as root, fetch the package venv needs."""
    shutil.rmtree(VENV, ignore_errors=True)
    # Started from inside the environment being replaced: use the Python below it.
    base = getattr(sys, "_base_executable", sys.executable)
    made = run([base, "-m", "venv", str(VENV)])
    if made.returncode == 0:
        return
    shutil.rmtree(VENV, ignore_errors=True)
    package = f"python3.{sys.version_info[1]}-venv"
    if "ensurepip" not in made.stdout + made.stderr:
        raise SetUpError(f"`python -m venv` failed: {last_line(made)}")
    if not may_use_apt():
        raise SetUpError(f"Python has no ensurepip; run: apt-get install {package}")
    apt(package)
    made = run([base, "-m", "venv", str(VENV)])
    if made.returncode:
        raise SetUpError(f"`python -m venv` failed: {last_line(made)}")


def probe_rendering():
    """See in a process of its own whether 3-D rendering works; mend it where we may.

    VTK without OpenGL libraries does not raise, it ends the process.
    """
    if RENDERING.is_file() and RENDERING.read_text() == "works":
        return
    if not renders() and may_use_apt():
        say("OpenGL libraries for 3-D figures")
        apt(*GL_PACKAGES)
    if renders():
        RENDERING.write_text("works")
        return
    RENDERING.write_text("missing")
    print(
        "set-up: 3-D rendering does not work here; 2-D figures do. To mend it: "
        f"apt-get install {' '.join(GL_PACKAGES)}",
        file=sys.stderr,
    )


def renders():
    """Whether a sphere can be drawn off screen."""
    return run([str(PYTHON), "-c", PROBE]).returncode == 0


def may_use_apt():
    """Root on Debian or Ubuntu: the one case in which system packages are installed."""
    release = Path("/etc/os-release")
    text = release.read_text() if release.is_file() else ""
    debian = any(f"ID={name}\n" in text + "\n" for name in ("debian", "ubuntu"))
    return os.geteuid() == 0 and debian and shutil.which("apt-get") is not None


def apt(*packages):
    """Install system packages without a question."""
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    run(["apt-get", "update"], environment)
    done = run(
        ["apt-get", "install", "-y", "--no-install-recommends", *packages], environment
    )
    if done.returncode:
        raise SetUpError(f"apt-get install {' '.join(packages)}: {last_line(done)}")


def pip(*arguments):
    """Run the environment's pip, quietly."""
    options = ["--quiet", "--disable-pip-version-check", "--no-input"]
    environment = {**os.environ, **package_cache()}
    done = run([str(PYTHON), "-m", "pip", *arguments, *options], environment)
    if done.returncode:
        raise SetUpError(
            f"pip {' '.join(arguments)}: {last_line(done)} (is the network there?)"
        )


def package_cache():
    """pip's own cache; one in the checkout where the home directory takes no files."""
    if os.environ.get("PIP_CACHE_DIR"):
        return {}
    try:
        (Path.home() / ".cache" / "pip").mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return {"PIP_CACHE_DIR": str(Path(".cache", "pip").resolve())}
    return {}


def run(command, environment=None):
    """Run a command and keep what it says."""
    try:
        return subprocess.run(
            command, env=environment, capture_output=True, text=True, check=False
        )
    except FileNotFoundError as error:
        return subprocess.CompletedProcess(command, 127, "", str(error))


def last_line(done):
    """The last line a command said, as its reason."""
    lines = (done.stderr or done.stdout or "no output").strip().splitlines()
    errors = [line for line in lines if line.startswith("ERROR")]
    return (errors or lines)[-1].strip()


def say(text):
    """One line of progress."""
    print(f"set-up: {text}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
