"""The rigs of the virtual laboratory, by name: the files of data/rigs."""

from __future__ import annotations

from pathlib import Path

from raxel.lab import load_rig

RIGS = Path(__file__).resolve().parents[2] / "data" / "rigs"


def rig_named(name):
    """The rig of `data/rigs/<name>.yaml`."""
    return load_rig(RIGS / f"{name}.yaml")
