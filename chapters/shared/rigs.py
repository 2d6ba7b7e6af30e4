"""The rigs of the virtual laboratory, by name: the files of data/rigs."""

from functools import lru_cache
from pathlib import Path

from raxel.lab import load_rig

RIGS = Path(__file__).resolve().parents[2] / "data" / "rigs"


@lru_cache(maxsize=8)
def rig_named(name):
    """The rig of `data/rigs/<name>.yaml`."""
    return load_rig(RIGS / f"{name}.yaml")
