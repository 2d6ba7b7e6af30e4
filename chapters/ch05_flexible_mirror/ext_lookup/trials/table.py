"""The mirror bent beforehand, once for each entry: what a table of boundaries needs.

Every entry is calibrated with a monitor in two places, as the first shape of 5.3.3:
that is the equipment which this method asks for. Knots are the same for all entries,
over all that the mirror ever covers of the picture.
"""

from typing import NamedTuple

import numpy as np

from chapters.shared.gaussian_errors import CORNER_PX, DECODED_MM, GaussianErrors
from chapters.shared.mirror_rigs import DYNAMIC_MM, mirror_rig
from chapters.shared.mirror_runs import (
    CLAMP_PICKS,
    CLAMP_SD_PX,
    calibrated_viewer,
    decoded,
    outline,
    poses_in_platter,
)
from raxel.calibration.mirror.clamp_line import clamp_line, fixed_line
from raxel.calibration.mirror.lookup import BoundaryTable
from raxel.calibration.mirror.primary import primary_from_points
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.update import MirrorSettings
from raxel.geometry import transform
from raxel.geometry.spline_grid import spline_grid

# Deflections of the table's entries, mm, and the entries of a poor man's table.
ENTRIES_MM, EVERY, FEW = (0.0, 5.0, 10.0, 15.0), (0, 1, 2, 3), (0, 3)
# Standard deviations of a traced point of the boundary along each axis, px.
TRACED_PX = {"exact": 0.0, "traced": 0.5}
# Points that are traced along each edge.
ALONG_EDGE = 33
ERRORS = GaussianErrors()
METHOD = MirrorSettings(prior_sd=0.1)
SETTINGS = {
    "entries_mm": list(ENTRIES_MM),
    "traced_px": TRACED_PX["traced"],
    "corner_px": CORNER_PX,
    "decoded_mm": DECODED_MM,
    "grid_mm": DYNAMIC_MM,
    "prior_mm": METHOD.prior_sd,
}


class Prepared(NamedTuple):
    """rig: MirrorRig; cameras: SplineMirrorCameras of ENTRIES_MM; boundaries: their
    edges (4, ALONG_EDGE, 2) px, exact; clamp: FixedLine of the first."""

    rig: object
    cameras: list
    boundaries: list
    clamp: object

    def table(self, noise_px, rng, kept=EVERY):
        """BoundaryTable of the entries `kept`, boundaries traced with an error."""
        traced = [
            edges + noise_px * rng.normal(0, 1, edges.shape)
            for edges in self.boundaries
        ]
        return BoundaryTable([traced[k] for k in kept], [self.cameras[k] for k in kept])


def prepared(geometry, rng):
    """Prepared of geometry "A" or "B"."""
    rig = mirror_rig(geometry)
    true = [rig.camera(deflection) for deflection in ENTRIES_MM]
    viewer = calibrated_viewer(rig, ERRORS, rng)
    monitor = rig.monitor_poses(rng)
    poses = poses_in_platter(rig, viewer, monitor, ERRORS, rng)
    picks = rig.clamp_pixels(true[0], CLAMP_PICKS, rng, CLAMP_SD_PX)
    line = clamp_line(viewer, picks)
    outlines = [normalised(viewer, outline(camera)) for camera in true]
    span = np.vstack([line.points(CLAMP_PICKS), *outlines])
    box = spline_grid(span, METHOD.shape, angle=line.angle)
    cameras = [
        primary_from_points(
            viewer,
            *within(box, viewer, decoded(rig, camera, monitor, ERRORS, rng)),
            poses,
            shape=METHOD.shape,
            angle=line.angle,
            quantity="inverse depth",
            span=box.corners,
        ).camera
        for camera in true
    ]
    held = fixed_line(cameras[0], line)
    return Prepared(rig, cameras, [edges_of(camera) for camera in true], held)


def within(box, viewer, seen):
    """Of (pixels (N, 2), points (n, N, 2)) those whose viewing ray lies in the box of a
    SplineGrid."""
    pixels, points = seen
    inside = box.inside(normalised(viewer, pixels))
    return pixels[inside], points[:, inside]


def edges_of(camera):
    """Edges (4, ALONG_EDGE, 2) px of a true camera's mirror: the two along the sheet,
    its clamped one and its free one."""
    mirror = camera.mirror
    along = mirror.end * np.linspace(0, 1, ALONG_EDGE)
    across = mirror.half_width * np.linspace(-1, 1, ALONG_EDGE)
    half = np.full(ALONG_EDGE, mirror.half_width)
    places = ((along, -half), (along, half), (0 * along, across),
              (0 * along + mirror.end, across))  # fmt: skip
    edges = []
    for x, y in places:
        points = np.column_stack([x, y, mirror.height(x, y)[0]])
        points = transform(camera.T_viewer_mirror, points)
        edges.append(camera.viewer.project(points).pixels)
    return np.stack(edges)
