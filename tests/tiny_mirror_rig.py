"""A mirror rig of the repository, so small that its set renders in a second."""

from dataclasses import replace
from pathlib import Path

from raxel.cameras import FlexibleMirrorCamera, PerspectiveCamera
from raxel.lab import Optics, Visibility
from raxel.lab.mirror_set_rig import load_mirror_set_rig
from raxel.sets import PatternPlan

RIGS = Path(__file__).resolve().parents[1] / "data" / "rigs" / "mirror-sets"
SETS = "clean", "aberrated", "twisted", "two-loads"
FEW = PatternPlan(phase_steps=3, phase_periods=(8, 0))
SMALLER = 6


def tiny_rig(name="clean", stages=2):
    """The MirrorSetRig of that name with 128 x 96 px, three images of a monitor and
    two boards for the viewer."""
    rig = load_mirror_set_rig(RIGS / f"{name}.yaml")
    large = rig.viewer.camera
    K = large.K / SMALLER
    K[2, 2] = 1
    size = large.width // SMALLER, large.height // SMALLER
    viewer = PerspectiveCamera(K, large.radial, *size)
    fields = rig.grids.camera.arguments() | {"viewer": viewer}
    cameras = {"viewer": viewer, "plate": viewer}
    cameras |= dict.fromkeys(("grids", "steps"), FlexibleMirrorCamera(**fields))
    rigs = {
        key: replace(
            getattr(rig, key),
            camera=camera,
            optics=Optics(),
            visibility=Visibility(whole=key in ("viewer", "plate")),
        )
        for key, camera in cameras.items()
    }
    rigs["viewer"] = replace(rigs["viewer"], count=2)
    rigs["grids"] = replace(rigs["grids"], patterns=FEW)
    return replace(rig, stages=rig.stages[:stages], **rigs)
