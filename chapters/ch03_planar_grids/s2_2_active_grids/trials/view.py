"""One view of an active grid with the simulator's small camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from raxel.cameras import PerspectiveCamera
from raxel.features.active_grid import decode
from raxel.lab import Optics, load_rig, monitor_scene, trace
from raxel.lab.monitor_views import points_seen
from raxel.lab.patterns import MonitorLevel, MonitorPattern
from raxel.sets import patterns_of, plan_of_cells

RIGS = ("data/rigs/active-grid-demo.yaml",)
ROOT = Path(__file__).resolve().parents[4]
CELLS, STEPS = 8, 4
# Pixels of the rig's camera per pixel of an image, in both directions.
COARSENESS = {"quick": 2, "full": 1}


@lru_cache(maxsize=2)
def rig(coarseness):
    """The rig, with larger pixels for short runs."""
    plain = load_rig(ROOT / RIGS[0])
    camera, scale = (plain.camera, np.diag([1 / coarseness, 1 / coarseness, 1]))
    scale[:2, 2] = (1 / coarseness - 1) / 2
    camera = PerspectiveCamera(
        scale @ camera.K,
        camera.radial,
        camera.width // coarseness,
        camera.height // coarseness,
    )
    optics = replace(
        plain.optics, exit_pupil_px=plain.optics.exit_pupil_px / coarseness
    )
    return replace(plain, camera=camera, optics=optics)


@dataclass
class MonitorView:
    """A pose of the monitor in front of the camera, and its view."""

    T_camera_target: np.ndarray
    coarseness: int = 1

    @classmethod
    def drawn(cls, rng, coarseness):
        """From the rig's poses."""
        return cls(rig(coarseness).draw_poses(rng, 1)[0], coarseness)

    @property
    def rig(self):
        """The rig of the view."""
        return rig(self.coarseness)

    @cached_property
    def traced(self):
        """Rays and intersections of every pixel."""
        scene = monitor_scene(
            self.rig.target, self.T_camera_target, **self.rig.radiances
        )
        return trace(self.rig.camera, np.eye(4), scene)

    @cached_property
    def truth(self):
        """Points (H, W, 2) mm that the pixels see; NaN outside the monitor."""
        size = self.rig.target.monitor_mm
        return points_seen(self.rig.camera, self.T_camera_target, size)

    def white(self):
        """Radiance (H, W) of the monitor at full light."""
        return self.traced.shade({0: MonitorLevel(1.0, self.rig.monitor.radiance)})

    def radiance(self, pattern, monitor):
        """Radiance (H, W) of one pattern on a monitor."""
        target = self.rig.target
        texture = MonitorPattern(
            target.monitor_px, target.monitor_mm, pattern, monitor.radiance
        )
        return self.traced.shade({0: texture})

    def radiances(self, cells=CELLS, steps=STEPS):
        """(patterns, their radiance (n, H, W)), all of a grid."""
        patterns = self.patterns(cells, steps)
        shown = [self.radiance(p, self.rig.monitor) for p in patterns]
        return patterns, np.array(shown)

    def patterns(self, cells=CELLS, steps=STEPS):
        """The patterns of a grid."""
        size = self.rig.target.monitor_px
        return patterns_of(plan_of_cells(size, cells, steps))

    def photographed(self, radiances, rng, sensor=None, optics: Optics | None = None):
        """The images (n, H, W), by the rig's sensor and lens or by others."""
        lab = self.rig.laboratory()
        lab = replace(lab, sensor=sensor or lab.sensor, optics=optics or lab.optics)
        return np.array([lab.develop(one, rng) for one in radiances])

    def decoded(self, pictures, patterns, **given):
        """`decode` of images of the rig's monitor, as if it were linear."""
        settings = {"linear": True, "threads": 1, **given}
        return decode(pictures, patterns, self.rig.target, **settings)
