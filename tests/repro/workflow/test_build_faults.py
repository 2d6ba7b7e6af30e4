"""Faults around a build are named in one line, and the next build repairs them."""

import fcntl
import os
import subprocess
from contextlib import contextmanager

import pytest

from tests.repro.workflow.test_workflow import build, dice_checkout, made
from tests.verify import products


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The products of a build that nothing disturbed."""
    root = dice_checkout(tmp_path_factory.mktemp("undisturbed"))
    made(root)
    return products(root)


@pytest.fixture
def checkout(tmp_path):
    return dice_checkout(tmp_path)


@contextmanager
def small_disk(folder, *options):
    """A disk in memory at a folder; without the right to mount, the test is skipped."""
    folder.mkdir(exist_ok=True)
    size = ",".join(("size=40k", *options))
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", size, "raxel", folder],
        check=False, capture_output=True,
    )  # fmt: skip
    if done.returncode:
        pytest.skip("needs the right to mount a file system")
    try:
        yield lambda option: subprocess.run(
            ["mount", "-o", f"remount,{option}", folder], check=True
        )
    finally:
        subprocess.run(["umount", folder], check=True)


def last_line(checkout):
    status, text = build(checkout)
    assert status == 1
    return text.strip().splitlines()[-1]


def test_full_disk_is_named_and_then_continued(checkout, undisturbed):
    with small_disk(checkout / "figures") as remount:
        line = last_line(checkout)
        assert line.startswith(f"make ch02: {checkout}/figures/quick: No space left")
        remount("size=100m")
        made(checkout)
        assert products(checkout) == undisturbed


def test_read_only_folder_is_named_and_then_continued(checkout, undisturbed):
    with small_disk(checkout / "figures", "ro") as remount:
        line = last_line(checkout)
        assert line.startswith(f"make ch02: {checkout}/figures/quick: Read-only file")
        remount("rw,size=100m")
        made(checkout)
        assert products(checkout) == undisturbed


def test_second_build_in_checkout_is_rejected(checkout):
    (checkout / ".cache").mkdir()
    with (checkout / ".cache" / "build.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        line = last_line(checkout)
    assert line == "make ch02: another build runs in this folder; wait for it"


def test_damaged_result_is_made_again(checkout, undisturbed):
    made(checkout)
    result = checkout / "figures/quick/results/dice_spread.json"
    content, stat = bytearray(result.read_bytes()), result.stat()
    content[len(content) // 2] ^= 1
    result.write_bytes(content)
    os.utime(result, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    tasks, text = made(checkout)
    assert tasks == {"experiment/dice_spread"}
    assert "results/dice_spread.json: damaged; it will be made again" in text
    assert products(checkout) == undisturbed
