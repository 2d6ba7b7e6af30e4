"""What a record was made with."""

import platform
import subprocess

import cv2
import numpy as np


def versions():
    """{name: version} of the interpreter and of what the numbers rest on."""
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "opencv": cv2.__version__,
    }


def commit():
    """The commit of this repository, for people."""
    found = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return f"commit {found.stdout.strip()} of this repository"
