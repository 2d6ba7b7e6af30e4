"""Active grids of many cell and phase counts, photographed and decoded alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raxel.cameras import PerspectiveCamera
from raxel.features.active_grid import decode
from raxel.geometry import pose, rotation_from_vector
from raxel.lab import Monitor, MonitorPattern, Optics, Sensor, monitor_scene, trace
from raxel.lab.monitor_views import points_seen
from raxel.sets import ActiveGrid
from raxel.sets.patterns import patterns_of, plan_of_cells

MONITOR = ActiveGrid((1152, 1152), (301.5, 301.5))
FOCAL_SHARE = 1.25  # of the picture's width
DISTANCE_MM = 300.0
TILT_DEG, TURN_DEG, SHIFT_MM = 12.0, 5.0, 5.0
BLACK, WHITE = 20, 220  # grey levels
LINEAR, ORDINARY = 1.0, 2.2
# Around the picture: no blur can reach into it from beyond what was rendered.
BORDER_PX = 20
# Not scored: no window of the smoothing fits there, and in a small picture its pixels
# would weigh more than in a large one.
RING_PX = 4
WIDTH_PX = {"quick": 128, "full": 256}
CELLS = {"quick": (4, 8, 32), "full": (4, 8, 12, 16, 24, 32)}
BLURS_PX = {"quick": (0.5, 4.0), "full": (0.5, 1.0, 2.0, 4.0)}
NOISES = {"quick": (3.0,), "full": (1.0, 3.0, 8.0)}
STEPS = {"quick": (3, 4, 6), "full": (3, 4, 5, 6, 8)}
GAMMAS = {"quick": (LINEAR, ORDINARY), "full": (LINEAR, 1.4, 1.8, ORDINARY, 2.6)}
SHARED_BLURS_PX = {"quick": (0.5,), "full": (0.5, 2.0, 4.0)}
# (cells, steps) of grids with the same number of pictures.
BUDGETS = {20: ((4, 6), (8, 4)), 28: ((4, 10), (8, 8), (16, 6), (32, 4))}
TRIALS = {"quick": 1, "full": 4}
OTHER_TRIALS = {"quick": 1, "full": 3}
# The grid of the thesis, and the picture that is changed in one thing at a time.
OUR_CELLS, OUR_STEPS, OUR_NOISE, OUR_BLUR_PX = 8, 4, 3.0, 1.0
WAYS = {"smoothed": True, "by pixel": False}
# Of the experiment on light: a camera that is set to be so sensitive that rounding to
# grey levels is small beside its noise, even in a mean of 24 pictures.
FULL_WELL_E, READ_NOISE_E = 2000.0, 5.0
LIGHTS = ("each picture alike", "24 sines", "the light of 4 steps")
SINES = 24
# Of the experiment on correction: with six steps a ripple is 5 px or wider, which the
# decoder asks for, and gammas go up to what it is made for. READINGS: whether `decode`
# takes the response as linear, as the thesis does.
CORRECTED_WIDTH_PX = {"quick": 256, "full": 384}
CORRECTED_STEPS = (4, 6)
CORRECTED_GAMMAS = {
    "quick": (LINEAR, ORDINARY),
    "full": (LINEAR, 1.4, 1.8, 2.0, ORDINARY, 2.4),
}
CORRECTED_TRIALS = {"quick": 1, "full": 6}
READINGS = {"seen": True, "corrected": False}
SETTINGS = {
    "monitor_px": MONITOR.monitor_px,
    "monitor_mm": MONITOR.monitor_mm,
    "distance_mm": DISTANCE_MM,
    "focal_px_per_width": FOCAL_SHARE,
    "tilt_deg": TILT_DEG,
    "turn_deg": TURN_DEG,
    "shift_mm": SHIFT_MM,
    "grey_levels": (BLACK, WHITE),
    "border_px": BORDER_PX,
    "ring_px": RING_PX,
    "full_well_e": FULL_WELL_E,
    "read_noise_e": READ_NOISE_E,
}


@dataclass(frozen=True)
class FilledView:
    """A monitor that fills the picture: its rays, and the point of each pixel, mm.

    points: (H, W, 2) of the pixels inside the ring that is not scored.
    """

    traced: object
    points: np.ndarray
    mm_per_px: float

    def values(self, plan):
        """What the monitor is sent, seen without a lens: (n, H, W), 0 to 1."""
        size = MONITOR.monitor_px, MONITOR.monitor_mm
        shown = [MonitorPattern(*size, p) for p in patterns_of(plan)]
        return np.stack([self.traced.shade({0: one}) for one in shown])


def light_of(values, plan, gamma):
    """The light of a monitor of this gamma; a Gray code has only black and white."""
    light = values.copy()
    sines = [p.kind == "phase" for p in patterns_of(plan)]
    light[sines] = Monitor(gamma=gamma).radiance(values[sines], 1.0)
    return light


def drawn_view(width, rng):
    """A FilledView before a pinhole camera, tilted, turned and shifted at random."""
    focal = FOCAL_SHARE * width
    width, height = width + 2 * BORDER_PX, width // 2 + 2 * BORDER_PX
    middle = (width - 1) / 2, (height - 1) / 2
    K = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])
    camera = PerspectiveCamera(K, (), width, height)
    towards = rng.uniform(0, 2 * np.pi)
    tilt = np.radians(rng.uniform(0, TILT_DEG))
    turn = np.radians(rng.uniform(-TURN_DEG, TURN_DEG))
    R = rotation_from_vector(
        [tilt * np.cos(towards), tilt * np.sin(towards), 0]
    ) @ rotation_from_vector([0, 0, turn])
    centre = np.array([*rng.uniform(-SHIFT_MM, SHIFT_MM, 2), DISTANCE_MM])
    corner = np.array([*(-np.divide(MONITOR.monitor_mm, 2)), 0])
    T = pose(R, centre + R @ corner)
    traced = trace(camera, np.eye(4), monitor_scene(MONITOR, T))
    points = _inside(points_seen(camera, T, MONITOR.monitor_mm), BORDER_PX + RING_PX)
    return FilledView(traced, points, DISTANCE_MM / focal)


def _inside(picture, border):
    """A picture (H, W, ...) without its border."""
    return picture[border:-border, border:-border]


def through_lens(light, blur_px):
    """The patterns' light (n, H, W) on the sensor, behind a Gaussian blur."""
    lens = Optics(blur_sd_px=(blur_px, blur_px))
    return np.stack([_inside(lens.apply(one), BORDER_PX) for one in light])


def photographs(light, noise, rng):
    """Pictures (n, H, W) uint8 with additive Gaussian noise, as in 3.3.3."""
    grey = BLACK + (WHITE - BLACK) * light
    grey += noise * rng.standard_normal(grey.shape, dtype=np.float32)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def period_px(cells, width):
    """Width of a cell in px of the camera, in the middle of the picture."""
    cell = -(-MONITOR.monitor_px[0] // cells) / MONITOR.monitor_px[0]
    return cell * MONITOR.monitor_mm[0] * FOCAL_SHARE * width / DISTANCE_MM


def scores(view, plan, pictures, *, linear):
    """Errors of the decoded pictures, in px of the camera, smoothed and by pixel.

    linear: as `decode` has it; no response is measured and corrected.
    """
    patterns = patterns_of(plan)
    found, noise = {}, None
    for name, smooth in WAYS.items():
        decoded = decode(
            pictures, patterns, MONITOR,
            smooth=smooth, noise=noise, linear=linear, threads=1,
        )  # fmt: skip
        noise = decoded.noise
        found[name] = _scored(view, plan, decoded)
    return found


def _scored(view, plan, decoded):
    mask, location, sigma = (
        _inside(one, RING_PX) for one in (decoded.mask, decoded.location, decoded.sigma)
    )
    seen = mask & np.isfinite(view.points[..., 0])
    values = {"decoded": float(seen.mean()), "gross": 0}
    if not seen.any():
        return values
    error = np.abs(location[seen] - view.points[seen])
    sigma = sigma[seen]
    pitch = np.divide(MONITOR.monitor_mm, MONITOR.monitor_px)
    gross = np.any(error >= np.multiply(plan.cell_px, pitch) / 2, axis=1)
    px = error / view.mm_per_px
    return values | {
        "gross": int(gross.sum()),
        "pixels": int(seen.sum()),
        "rms_px": float(np.sqrt(np.mean(px**2))),
        "median_px": float(np.median(px)),
        "p95_px": float(np.quantile(px, 0.95)),
        "sigma_px": float(np.sqrt(np.mean(sigma**2)) / view.mm_per_px),
        "within": float(np.mean(error <= sigma)),
        "within_2": float(np.mean(error <= 2 * sigma)),
        "within_3": float(np.mean(error <= 3 * sigma)),
        **_told(view, decoded),
    }


def _told(view, decoded):
    """RMS shift by the response, px, where the decoder was asked and could tell it."""
    sizes = [one.size for one in decoded.response if one.size is not None]
    if not sizes:
        return {}
    return {"told_px": float(np.sqrt(np.mean(np.square(sizes))) / view.mm_per_px)}


def pictures_in_light(light, plan, which, rng):
    """Pictures (n, H, W) taken with one of LIGHTS, with the noise of a sensor.

    A mean of r pictures has the noise of one with r times the charge, and sqrt(r)
    times the read noise.
    """
    charge = {
        LIGHTS[0]: 1.0,
        LIGHTS[1]: SINES / plan.phase_steps,
        LIGHTS[2]: OUR_STEPS / plan.phase_steps,
    }[which]
    averaged = which == LIGHTS[1]
    sensor = Sensor(
        white_e=FULL_WELL_E * charge,
        full_well_e=FULL_WELL_E * charge,
        read_noise_e=READ_NOISE_E * (np.sqrt(charge) if averaged else 1),
    )
    shares = (BLACK + (WHITE - BLACK) * light) / 255
    return np.stack([sensor.expose(one, rng) for one in shares])


def plan_for(cells, steps):
    """The PatternPlan of a condition."""
    return plan_of_cells(MONITOR.monitor_px, cells, steps)


def pictures_of(cells, steps):
    """How many pictures a grid takes: Gray code with inverse, sines, both axes."""
    return 4 * (cells - 1).bit_length() + 2 * steps


def condition_of(effort, cells, steps, **changed):
    """A grid, and the responses, blurs and noises under which it is decoded."""
    usual = {"gammas": [LINEAR], "blurs_px": [OUR_BLUR_PX], "noises": [OUR_NOISE]}
    grid = {"cells": cells, "steps": steps, "width_px": WIDTH_PX[effort]}
    return grid | usual | {name: list(v) for name, v in changed.items()}


def name_of(gamma, blur_px, noise):
    """How the values of one response, blur and noise are called."""
    return f"gamma {gamma:g}, blur {blur_px:g}, noise {noise:g}"


def name_of_capture(steps, gamma, reading):
    """How the values of these steps, decoded in one of READINGS, are called."""
    return f"{steps} steps, gamma {gamma:g}, {reading}"


def corrected_trial(condition, rng):
    """The same pictures of one view, decoded as the thesis does and corrected."""
    view = drawn_view(condition["width_px"], rng)
    found = {}
    for steps in condition["steps"]:
        plan = plan_for(condition["cells"], steps)
        sent = view.values(plan)
        for gamma in condition["gammas"]:
            seen = through_lens(light_of(sent, plan, gamma), OUR_BLUR_PX)
            pictures = photographs(seen, OUR_NOISE, rng)
            for reading, linear in READINGS.items():
                name = name_of_capture(steps, gamma, reading)
                found[name] = scores(view, plan, pictures, linear=linear)
    return found
