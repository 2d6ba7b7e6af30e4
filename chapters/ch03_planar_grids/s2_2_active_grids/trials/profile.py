"""One period of the imaged sine, rectified as in 3.2.2, and harmonic fits."""

from dataclasses import replace

import cv2
import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.trials.view import CELLS, MonitorView
from chapters.shared.phase_steps import orders, power_law, srgb

GAMMAS = {"quick": [1.0, 2.2], "full": [round(1.0 + 0.2 * k, 1) for k in range(9)]}
DATA_SHEET_GAMMA = 2.2
CAMERAS = ("linear", "sRGB")
AMPLITUDE_GREY = 80.0
# Scale of the rectified image.
MM_PER_PX = 0.25
PERIOD = 3
HARMONICS = (0, 1, 2)


def fitted(profile, harmonics):
    """(fit (n,), RMS misfit, amplitudes) of a mean and orders 1 to harmonics + 1.

    profile: grey values (n,) of one period; harmonics: further ones, as the thesis
    counts: its first harmonic is order 2.
    """
    phase = 2 * np.pi * (np.arange(len(profile)) + 0.5) / len(profile)
    waves = [f(n * phase) for n in range(1, harmonics + 2) for f in (np.cos, np.sin)]
    basis = np.column_stack([np.ones_like(phase), *waves])
    terms = np.linalg.lstsq(basis, profile, rcond=None)[0]
    fit = basis @ terms
    rms = float(np.sqrt(np.mean((profile - fit) ** 2)))
    return fit, rms, np.hypot(terms[1::2], terms[2::2])


def rectifying_map(view, rng):
    """Pixels (2, h, w) of the camera for a rectified image of the monitor.

    The known lens turns pixels into points of a plane; a homography from there to
    the monitor is fitted to what the decoder finds.
    """
    patterns, light = view.radiances()
    found = view.decoded(view.photographed(light, rng), patterns)
    v, u = (axis[::97] for axis in np.nonzero(found.mask))
    toward = view.rig.camera.rays(np.column_stack([u, v]).astype(float)).directions
    plane = toward[:, :2] / toward[:, 2:]
    points = found.location[v, u].astype(float)
    H_plane_monitor = cv2.findHomography(points, plane)[0]
    width, height = view.rig.target.monitor_mm
    x, y = np.meshgrid(
        np.arange(MM_PER_PX / 2, width, MM_PER_PX),
        np.arange(MM_PER_PX / 2, height, MM_PER_PX),
    )
    flat = np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])
    seen = view.rig.camera.project(flat @ H_plane_monitor.T).pixels
    return np.float32(seen.T.reshape(2, *x.shape))


def column_means(picture, seen):
    """Mean grey value of every column of the rectified image."""
    return cv2.remap(picture.astype(np.float32), *seen, cv2.INTER_CUBIC).mean(
        axis=0, dtype=float
    )


def exposed(sensor, gamma, response, share):
    """The sensor, exposed so that order 1 has AMPLITUDE_GREY grey levels.

    response: "linear" or "sRGB", the camera's tone curve; share: of the monitor's
    light that arrives. The exposure is found by bisection, since a tone curve has it
    on both sides.
    """
    level = np.linspace(0, 1, 256)
    curve = None if response == "linear" else (srgb(level), level)
    light = power_law(gamma)

    def amplitude(well):
        def grey(phase):
            charge = np.minimum(well * light(phase), 1)
            return 255 * (charge if curve is None else np.interp(charge, *curve))

        a, b = orders(grey, 1)
        return np.hypot(a[1], b[1])

    low, high = 0.0, 1.0
    for _ in range(30):
        middle = (low + high) / 2
        too_low = amplitude(middle) < AMPLITUDE_GREY
        low, high = (middle, high) if too_low else (low, middle)
    curve = curve and tuple(map(tuple, curve))
    return replace(sensor, white_e=low / share * sensor.full_well_e, response=curve)


def profile_trial(condition, rng):
    """Misfits of a period of the rectified image, for every gamma and camera."""
    view = MonitorView.drawn(rng, condition["coarseness"])
    seen = rectifying_map(view, rng)
    lit = view.rig.optics.apply(view.white())
    share = np.array_split(column_means(lit, seen), CELLS)[PERIOD].mean()
    sine = next(p for p in view.patterns() if p.kind == "phase" and p.axis == "x")
    values, shown = {}, {}
    for gamma in condition["gammas"]:
        monitor = replace(view.rig.monitor, gamma=gamma)
        light = view.radiance(sine, monitor)
        for camera in CAMERAS:
            sensor = exposed(view.rig.sensor, gamma, camera, share)
            picture = view.photographed([light], rng, sensor=sensor)[0]
            means = column_means(picture, seen)
            period = np.array_split(means, CELLS)[PERIOD]
            fits = {count: fitted(period, count) for count in HARMONICS}
            sizes = enumerate(fits[HARMONICS[-1]][2], 1)
            values[f"{camera}.{gamma}"] = {
                **{f"rms_{count}": rms for count, (_, rms, _) in fits.items()},
                **{f"order_{n}": float(size) for n, size in sizes},
            }
            if gamma == DATA_SHEET_GAMMA:
                lines = {f"fit_{count}": fit for count, (fit, _, _) in fits.items()}
                lines |= {"profile": period, "means": means}
                shown |= {f"{camera}.{name}": line for name, line in lines.items()}
    return {**values, **shown}
