"""Run the steps of the Containerfile in a bare Debian: `make test-container`.

Neither Podman nor Apptainer is necessary: debootstrap makes the base image in a folder,
where chroot runs the steps. Then a chapter of the quick report is built. As root.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from tests.checkout_copies import ROOT, copy_checkout

IMAGE = ROOT / ".cache" / "container"
OF_NETWORK = ("etc/resolv.conf", "etc/pip.conf", "etc/ssl/certs/ca-certificates.crt")
"""Files of this machine without which it may reach no package."""
INSIDE = (
    'mount --bind /dev "$0/dev" && mount -t proc proc "$0/proc" && '
    'exec chroot "$0" env -i HOME=/root PATH=/usr/bin:/bin:/usr/sbin:/sbin sh -c "$1"'
)
CHECK = "make ch02 EFFORT=quick"
SKIPPED = 77


def main(order: str = CHECK) -> int:
    """Build the image and run a command in it; return the first status above 0."""
    if os.geteuid() != 0 or not has_debootstrap():
        print("make test-container: skipped (not root, or no debootstrap)")
        return SKIPPED
    shutil.rmtree(IMAGE, ignore_errors=True)
    folder = "/"
    for word, given in instructions((ROOT / "Containerfile").read_text("utf-8")):
        if word == "FROM":
            make_base(given.rpartition(":")[2].removesuffix("-slim"))
        elif word == "WORKDIR":
            folder = given
        elif word == "COPY":
            copy_checkout(IMAGE / folder[1:])
        elif word == "RUN" and (status := run(folder, given)):
            return status
    return run(folder, order)


def has_debootstrap() -> bool:
    """Return whether it is there, or could be installed."""
    if not shutil.which("debootstrap") and shutil.which("apt-get"):
        install = ["apt-get", "install", "-y", "--no-install-recommends", "debootstrap"]
        subprocess.run(install, check=False, capture_output=True)
    return shutil.which("debootstrap") is not None


def instructions(text: str) -> Iterator[tuple[str, str]]:
    """Return the instructions of a Containerfile, each in one line."""
    for line in text.replace("\\\n", " ").splitlines():
        word, _, given = line.partition(" ")
        if word.isupper():
            yield word, given.strip()


def make_base(suite: str) -> None:
    """Make the base image of a release of Debian."""
    base = ["debootstrap", "--variant=minbase", suite, str(IMAGE)]
    subprocess.run(base, check=True, stdout=subprocess.DEVNULL)
    for name in OF_NETWORK:
        if Path("/", name).is_file():
            (IMAGE / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(Path("/", name), IMAGE / name)


def run(folder: str, order: str) -> int:
    """Run a command in the image, with mounts that end with it; return its status."""
    print(f"{folder}: {order}", flush=True)
    inside = ["unshare", "--mount", "sh", "-c", INSIDE, str(IMAGE)]
    return subprocess.run([*inside, f"cd {folder} && {order}"], check=False).returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
