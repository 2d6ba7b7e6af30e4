"""What the trials of this page share: scenes, cameras and measures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from pathlib import Path

import numpy as np

from raxel.cameras import PerspectiveCamera
from raxel.features.active_grid import decode, pixels_of
from raxel.features.localise import derivative, saddle_point
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.lab import (
    Laboratory,
    Monitor,
    MonitorLevel,
    MonitorPattern,
    Optics,
    Sensor,
    board_scene,
    load_rig,
    monitor_scene,
    points_seen,
    trace,
)
from raxel.sets import ActiveGrid, Chessboard, patterns_of, plan_of_cells
from repro.run import Plan, experiment

# Edges of the Gray code in one image, and midpoints with its inverse.


REACH_PX = 14  # along a column; the next edge of a bit is two cells away


def edge_errors(images, patterns, points, cell_mm):
    """RMS distances (px), along columns, of the code's edges from the true ones.

    Charge flows along columns, so the edges across them are measured, of the code
    along y. images: (n, H, W) grey values; patterns: n `Pattern`, what each shows;
    points: (H, W, 2) mm, what each pixel sees of the monitor; cell_mm: width of a cell.
    """
    own = {
        (pattern.bit, pattern.inverse): image
        for image, pattern in zip(images, patterns, strict=True)
        if (pattern.kind, pattern.axis) == ("gray", "y")
    }
    bits = 1 + max(bit for bit, _ in own)
    alone, midway = [], []
    for edge in range(1, round(np.nanmax(points[..., 1]) / cell_mm)):
        rows = true_rows(points[..., 1], edge * cell_mm)
        bit = changing_bit(edge, bits)
        off = [crossing(own[bit, inverse], rows) - rows for inverse in (False, True)]
        alone.append(np.concatenate(off))
        midway.append(np.mean(off, axis=0))
    return {"one picture": rms_known(alone), "midpoint": rms_known(midway)}


def changing_bit(edge, bits):
    """The bit, 0 the coarsest, in which the codes of cells edge - 1 and edge differ."""
    before, after = (cell ^ (cell >> 1) for cell in (edge - 1, edge))
    return bits - (before ^ after).bit_length()


def true_rows(seen, place):
    """Row (W,) px at which each column sees a position along y.

    seen: (H, W) mm, NaN outside the monitor; place: mm. NaN where REACH_PX of a column
    about the place are not all on the monitor.
    """
    rows = np.full(seen.shape[1], np.nan)
    for u, along in enumerate(seen.T):
        known = np.flatnonzero(np.isfinite(along))
        if len(known):
            row = np.interp(place, along[known], known)
            if known[0] <= row - REACH_PX and row + REACH_PX <= known[-1]:
                rows[u] = row
    return rows


def crossing(image, rows):
    """Row (W,) px where each column of an image is midway between dark and bright.

    Of its darkest and brightest grey value within REACH_PX of `rows`; between the
    pixels it is a straight line.
    """
    found = np.full(len(rows), np.nan)
    columns = np.flatnonzero(np.isfinite(rows))
    around = np.arange(-REACH_PX + 1, REACH_PX)
    v = np.rint(rows[columns, None]).astype(int) + around
    grey = image[v, columns[:, None]].astype(float)
    above = grey - (grey.min(axis=1) + grey.max(axis=1))[:, None] / 2
    last = np.argmax((above[:, 1:] > 0) != (above[:, :1] > 0), axis=1)
    each = np.arange(len(columns))
    before, after = above[each, last], above[each, last + 1]
    found[columns] = v[each, last] + before / (before - after)
    return found


def rms_known(off):
    """RMS of the finite distances in lists."""
    off = np.concatenate(off)
    return float(np.sqrt(np.mean(off[np.isfinite(off)] ** 2)))


# A chessboard and an active grid at overexposure, on a sensor with blooming.


SIZE_PX = 144
FOCAL_PX = 400.0
DISTANCE_MM = 400.0
LIT_MM = 120.0
LIT_PX = 480
SQUARES = 6
CELLS = 6
MAX_TILT_DEG = 20.0
START_SD_PX = 1.0
BLUR_PX = (0.7, 0.7)
WELL_E = 20000.0
BLACK = 0.004
EXPOSURES = (1.05, 1.2)
SHARES = (0.0, 1.0)
CORNER_METHODS = {"saddle point": saddle_point, "derivative": derivative}
# Excluded border of the lit area, as in sharp images (3.3.3).
MARGIN_PX = 6


def filling_sensor(exposure, share):
    """A sensor filled `exposure` times by white, with an overflow of `share`."""
    return Sensor(
        white_e=exposure * WELL_E, full_well_e=WELL_E, read_noise_e=20.0, blooming=share
    )


def drawn_pose(rng):
    """T_camera_target (4, 4) of the lit area, tilted about a random axis."""
    around = rng.uniform(0, 2 * np.pi)
    angle = np.radians(rng.uniform(0, MAX_TILT_DEG))
    R = rotation_from_vector(angle * np.array([np.cos(around), np.sin(around), 0.0]))
    middle = R @ np.array([LIT_MM / 2, LIT_MM / 2, 0.0])
    return pose(R, np.array([*rng.uniform(-2, 2, 2), DISTANCE_MM]) - middle)


def rms_and_share(off, wanted, focal_px=1.0, distance_mm=1.0):
    """RMS length (px) of errors (n, 2), and the located share.

    off: px; or mm on a target at a distance in front of a lens.
    """
    if not len(off):
        return {"rms_px": np.nan, "share": 0.0}
    rms = np.sqrt(np.mean(np.sum(off**2, axis=1))) * focal_px / distance_mm
    return {"rms_px": float(rms), "share": float(len(off) / wanted)}


def grid_error(found, truth):
    """RMS error in px of decoded pixels, and their share of the monitor's pixels."""
    on = np.isfinite(truth).all(axis=-1)
    off = (found.location - truth)[on & found.mask]
    return rms_and_share(off, on.sum(), FOCAL_PX, DISTANCE_MM)


def corner_error(found, truth):
    """RMS error in px of converged corners, and their share."""
    return rms_and_share((found.corners - truth)[found.converged], len(truth))


def corner_error_in_grid(location, light):
    """The same for corners located in a decoded grid (H, W, 2) mm."""
    off = pixels_of(location, light.corner_points) - light.corners
    return rms_and_share(off[np.isfinite(off).all(axis=1)], len(off))


def decoded_as_text(images, light):
    """Locations (H, W, 2) mm by the filters of 3.2.2, without masking clipped sines.

    In 16-bit images no 8-bit value counts as clipped.
    """
    return decode(
        images.astype(np.uint16), light.patterns, light.monitor,
        neighbours=True, fill=True, margin_px=MARGIN_PX, linear=True, threads=1,
    ).location  # fmt: skip


@dataclass(frozen=True)
class Light:
    """Light from both targets in one pose, and the true positions.

    board: (H, W); grid: (20, H, W) with its patterns; corners: (N, 2) px, and
    corner_points: (N, 2) mm, where they are on the monitor; points: (H, W, 2) mm.
    """

    board: np.ndarray
    grid: np.ndarray
    patterns: list
    monitor: ActiveGrid
    corners: np.ndarray
    corner_points: np.ndarray
    points: np.ndarray


def light_of(T):
    """The Light of a pose T_camera_target (4, 4) of the lit area."""
    middle = (SIZE_PX - 1) / 2
    K = [[FOCAL_PX, 0, middle], [0, FOCAL_PX, middle], [0, 0, 1]]
    camera = PerspectiveCamera(K, [], SIZE_PX, SIZE_PX)
    lab = Laboratory(camera, filling_sensor(1, 0), Optics(blur_sd_px=BLUR_PX))
    monitor = ActiveGrid((LIT_PX, LIT_PX), (LIT_MM, LIT_MM))
    size = monitor.monitor_px, monitor.monitor_mm
    patterns = patterns_of(plan_of_cells(monitor.monitor_px, CELLS, phase_steps=4))
    response = Monitor(black_level=BLACK).radiance
    traced = trace(camera, np.eye(4), monitor_scene(monitor, T))
    shown = [
        traced.shade({0: MonitorPattern(*size, one, response)}) for one in patterns
    ]
    pitch = LIT_MM / SQUARES
    board = Chessboard(SQUARES - 1, SQUARES - 1, pitch)
    T_board = T @ pose(np.eye(3), [pitch, pitch, 0.0])
    scene = board_scene(
        board, T_board, border_mm=0, black=BLACK, white=1.0, background=0.2
    )
    return Light(
        lab.irradiance(scene, np.eye(4)),
        np.array([lab.optics.apply(one) for one in shown]),
        patterns,
        monitor,
        camera.project(transform(T_board, on_plane(board.points()))).pixels,
        board.points() + pitch,
        points_seen(camera, T, monitor.monitor_mm),
    )


def bloom_trial(condition, rng):
    """Errors of both corner methods and the active grid, with and without blooming.

    The grid's are those at the corners, with clipped sines and (masked) without, and
    those of all pixels; and the errors of the code's edges.
    """
    light = light_of(drawn_pose(rng))
    start = light.corners + rng.normal(0, START_SD_PX, light.corners.shape)
    found = {}
    for exposure, share in product(EXPOSURES, SHARES):
        spilling, name = filling_sensor(exposure, share), f"{exposure}.{share}"
        image = spilling.expose(light.board, rng)
        for corner, method in CORNER_METHODS.items():
            found[f"{corner}.{name}"] = corner_error(
                method(image, start), light.corners
            )
        images = np.array([spilling.expose(one, rng) for one in light.grid])
        location = decoded_as_text(images, light)
        masked = decode(images, light.patterns, light.monitor, linear=True, threads=1)
        found[f"active grid.{name}"] = corner_error_in_grid(location, light)
        found[f"masked.{name}"] = corner_error_in_grid(masked.location, light)
        found[f"all pixels.{name}"] = grid_error(masked, light.points)
        found[f"edges.{name}"] = edge_errors(
            images, light.patterns, light.points, LIT_MM / CELLS
        )
    return found


BLOOM_TRIALS = {"quick": 1, "full": 50}


@experiment("exp_c3_blooming", artefact="sec_3_2_2")
def too_much_light(effort):
    """A chessboard and an active grid on a sensor with blooming."""
    settings = {"exposures": list(EXPOSURES), "shares": list(SHARES)}
    return Plan(bloom_trial, [{}], BLOOM_TRIALS[effort], settings)


# One view of an active grid with the simulator's small camera.


RIGS = ("data/rigs/active-grid-demo.yaml",)
ROOT = Path(__file__).resolve().parents[3]
VIEW_CELLS, STEPS = 8, 4
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

    def radiances(self, cells=VIEW_CELLS, steps=STEPS):
        """(patterns, their radiance (n, H, W)), all of a grid."""
        patterns = self.patterns(cells, steps)
        shown = [self.radiance(p, self.rig.monitor) for p in patterns]
        return patterns, np.array(shown)

    def patterns(self, cells=VIEW_CELLS, steps=STEPS):
        """The patterns of a grid."""
        size = self.rig.target.monitor_px
        return patterns_of(plan_of_cells(size, cells, steps))

    def photographed(self, radiances, rng, sensor=None, optics: Optics | None = None):
        """The images (n, H, W), by the rig's sensor and lens or by others."""
        lab = self.rig.laboratory()
        lab = replace(lab, sensor=sensor or lab.sensor, optics=optics or lab.optics)
        return np.array([lab.develop(one, rng) for one in radiances])

    def decoded(self, images, patterns, **given):
        """`decode` of images of the rig's monitor, as if it were linear."""
        settings = {"linear": True, "threads": 1, **given}
        return decode(images, patterns, self.rig.target, **settings)
