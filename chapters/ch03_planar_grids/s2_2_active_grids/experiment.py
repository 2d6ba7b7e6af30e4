"""Trials of this page, their conditions and constants."""

import itertools
from dataclasses import replace

import cv2
import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.scenes import (
    RIGS,
    VIEW_CELLS,
    MonitorView,
    rig,
)
from chapters.shared.grids import (
    decoder_error,
    largest,
    orders,
    phase_of,
    power_law,
    srgb,
    stepped,
    sum_of_orders,
    wrapped,
)
from raxel.features.active_grid import WINDOW_RADIUS, decode
from raxel.sets import (
    ActiveGrid,
    Pattern,
    PatternPlan,
    pattern_image,
    patterns_of,
    plan_of_cells,
)
from repro.run import Plan, experiment

# Bits: effect of a wrong one, methods of detection, and a whole display.


ROWS = 64
EDGE_PX = 32
NEAR_PX = 2
LEVELS_GREY = (40.0, 200.0)
SINE_STEPS = 4
# How far edges shift over the rows: anywhere in a pixel, or between two of them.
SLANT_PX = {"anywhere": 1.0, "between pixels": 0.0}
# Wide enough for a window of cells on either side of an edge.
CELL_PX = 4
STRIP_ROWS = 8


def displayed(plan, monitor_px):
    """(patterns, images (n, H, W) uint16) as sent to the monitor."""
    patterns = patterns_of(plan)
    images = [pattern_image(p, monitor_px) for p in patterns]
    return patterns, np.array(images).astype(np.uint16)


def whole_display_trial(condition, rng):
    """Decode every monitor pixel from the patterns as sent."""
    size = tuple(condition["monitor_px"])
    plan = plan_of_cells(size, phase_steps=4)
    patterns, images = displayed(plan, size)
    found = decode(
        images, patterns, ActiveGrid(size), smooth=False, margin_px=0,
        noise=0.3, linear=True, threads=1,
    )  # fmt: skip
    place = np.indices(size[::-1])[::-1].transpose(1, 2, 0)
    own = np.all(np.floor(found.location) == place, axis=-1)
    off = found.location - (place + 0.5)
    return {
        "patterns": len(patterns),
        "binary": sum(p.kind == "gray" for p in patterns),
        "sinusoidal": sum(p.kind == "phase" for p in patterns),
        "bits": plan.gray_bits[0],
        "phase_step_deg": 360 / plan.phase_steps,
        "window_px": 2 * WINDOW_RADIUS + 1,
        "pixels": own.size,
        "not_own": int((~own).sum()),
        "largest_px": float(np.nanmax(np.abs(off))),
    }


def wrong_bit_trial(condition, rng):
    """Error in cells by one wrong bit next to an edge: Gray and plain binary.

    At every edge the image of each bit in turn is exchanged with its inverse in the
    pixel left of it; the decoder reads the cells.
    """
    bits = condition["bits"]
    cells = 2**bits
    size = (CELL_PX * cells, STRIP_ROWS)
    patterns, images = displayed(PatternPlan((bits, 0), True), size)
    adjacent = CELL_PX * np.arange(1, cells) - 1
    cell = np.arange(cells)
    changed = (cell ^ cell >> 1)[1:] ^ (cell ^ cell >> 1)[:-1]
    at_edge, elsewhere = [], []
    for bit in range(bits):
        wrong = images.copy()
        pair = [2 * bit, 2 * bit + 1]
        wrong[np.ix_(pair, range(STRIP_ROWS), adjacent)] = images[
            np.ix_(pair[::-1], range(STRIP_ROWS), adjacent)
        ]
        found = decode(
            wrong, patterns, ActiveGrid(size),
            margin_px=0, noise=1.0, linear=True, threads=1,
        )  # fmt: skip
        shift = np.abs(found.cells[STRIP_ROWS // 2, adjacent, 0] - cell[:-1])
        changes = changed >> (bits - 1 - bit) & 1
        at_edge += shift[changes == 1].tolist()
        elsewhere += shift[changes == 0].tolist()
    plain = cell[1:] ^ cell[:-1]
    return {
        "bits_changed": max(int(c).bit_count() for c in changed),
        "shift": max(at_edge),
        "shift_elsewhere": max(elsewhere, default=0),
        "binary_bits_changed": max(int(c).bit_count() for c in plain),
        "binary_shift": 2 ** (bits - 1),
        "tested": len(at_edge),
    }


def bit_images(condition, rng):
    """(place (ROWS, W) from the first edge in cells, image, inverse, white, black,
    mean of sines): noisy, 8 bits.

    Edges fall between pixels, or anywhere: then they cross the rows at a slant.
    Light that falls off does so along the row.
    """
    width = 8 * EDGE_PX
    slant = np.arange(ROWS)[:, None] / ROWS * condition["slant_px"]
    border = (np.arange(width + 1) - slant) / EDGE_PX
    low, high = LEVELS_GREY
    sharp = low + (high - low) * EDGE_PX * np.diff(_lit_length(border), axis=1)
    place = (np.arange(width) + 0.5 - slant) / EDGE_PX

    light = light_along(width, condition["light"])

    def taken(image):
        soft = cv2.GaussianBlur(
            image * light, (0, 0), condition["blur_px"],
            borderType=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        noisy = soft + rng.normal(0, condition["noise_grey"], soft.shape)
        return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)

    even = np.ones((ROWS, width))
    pair = taken(sharp), taken(low + high - sharp)
    white, black = taken(high * even), taken(low * even)
    flat = 0.5 * (low + high) * even
    sines = np.mean([taken(flat) for _ in range(SINE_STEPS)], axis=0)
    return place, *pair, white, black, sines


def light_along(width, light):
    """Share of light (width,) from the middle of the rig's monitor to its corner.

    The monitor is upright at the rig's mean distance, so that the camera's field
    angle, of which the light falls as cos^4, is the monitor's viewing angle too.
    """
    if light == "even":
        return np.ones(width)
    own = rig(1)
    reach_mm = np.hypot(*own.target.monitor_mm) / 2
    tangent = np.linspace(0, 1, width) * reach_mm / np.mean(own.poses.distance_mm)
    return np.cos(np.arctan(tangent)) ** (4 + own.monitor.falloff_exponent)


def _lit_length(x):
    """Length of odd cells from 0 to x, in cells."""
    whole = np.floor(x / 2)
    return whole + np.maximum(x - 2 * whole - 1, 0)


def wrong_bits(images, patterns, bit, white=None, black=None):
    """Flags (ROWS, W) of pixels that the decoder reads wrong."""
    found = decode(
        images, patterns, ActiveGrid(bit.shape[::-1]), white=white, black=black,
        margin_px=0, noise=1.0, linear=True, threads=1,
    )  # fmt: skip
    return found.cells[..., 0] != bit


def bits_trial(condition, rng):
    """Wrong bits within 2 px of edges: with an inverse, and with three thresholds."""
    place, image, inverse, white, black, sines = bit_images(condition, rng)
    bit = np.floor(place).astype(int) % 2 == 1
    inner = (place > 0.5) & (place < place.max() - 0.5)
    near = inner & (EDGE_PX * np.abs(place - np.rint(place)) < NEAR_PX)
    patterns = [Pattern("", "x", "gray", of=1, bit=0, inverse=i) for i in (False, True)]
    mean = light_along(image.shape[1], condition["light"]).mean()
    levels = [np.full(image.shape, mean * level) for level in LEVELS_GREY]
    thresholds = {
        "one grey value": levels,
        "white and black": (white, black),
        "mean of the sines": (sines, sines),
    }
    paired = wrong_bits(np.array([image, inverse]), patterns, bit)[near]

    def beside_paired(light, dark):
        wrong = wrong_bits(image[None], patterns[:1], bit, light, dark)[near]
        return {
            "wrong": int(wrong.sum()),
            "only_threshold": int((wrong & ~paired).sum()),
            "only_inverse": int((paired & ~wrong).sum()),
        }

    counted = {"pixels": paired.size, "inverse.wrong": int(paired.sum())}
    return counted | {name: beside_paired(*pair) for name, pair in thresholds.items()}


MONITORS_PX = {
    "quick": ((1024, 768),),
    "full": ((1024, 768), (1280, 1024), (1920, 1080)),
}


@experiment("exp_c3_20_patterns", artefact="fig_3_8")
def whole_displays(effort):
    """Every pixel of a monitor, decoded from the patterns as sent."""
    sizes = MONITORS_PX[effort]
    return Plan(whole_display_trial, [{"monitor_px": list(m)} for m in sizes], 1)


@experiment("exp_c3_gray_single", artefact="sec_3_2_2")
def wrong_bits_at_edges(effort):
    """One wrong bit next to every edge of codes of 1 to 8 bits."""
    return Plan(wrong_bit_trial, [{"bits": bits} for bits in range(1, 9)], 1)


# Uneven light is tested with edges anywhere only.
EDGES_AND_LIGHT = (
    ("anywhere", "even"),
    ("between pixels", "even"),
    ("anywhere", "falls off"),
)
BIT_TRIALS = {"quick": 2, "full": 20}


@experiment("exp_c3_inverse_helps", artefact="sec_3_2_2", inputs=RIGS)
def bits_near_edges(effort):
    """Bits near edges, by an inverse and by three thresholds."""
    conditions = [
        {
            "slant_px": SLANT_PX[edges],
            "light": light,
            "blur_px": blur,
            "noise_grey": noise,
        }
        for edges, light in EDGES_AND_LIGHT
        for blur in (1, 2, 3)
        for noise in (4, 8)
    ]
    return Plan(bits_trial, conditions, BIT_TRIALS[effort])


# One period of the imaged sine, rectified as in 3.2.2, and harmonic fits.


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


def column_means(image, seen):
    """Mean grey value of every column of the rectified image."""
    return cv2.remap(image.astype(np.float32), *seen, cv2.INTER_CUBIC).mean(
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
    share = np.array_split(column_means(lit, seen), VIEW_CELLS)[PERIOD].mean()
    sine = next(p for p in view.patterns() if p.kind == "phase" and p.axis == "x")
    values, shown = {}, {}
    for gamma in condition["gammas"]:
        monitor = replace(view.rig.monitor, gamma=gamma)
        light = view.radiance(sine, monitor)
        for camera in CAMERAS:
            sensor = exposed(view.rig.sensor, gamma, camera, share)
            image = view.photographed([light], rng, sensor=sensor)[0]
            means = column_means(image, seen)
            period = np.array_split(means, VIEW_CELLS)[PERIOD]
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


# Effect of an offset, a gain and a nonlinear response on a decoded phase.


MAX_OFFSET_GREY = 50
MIN_GAIN = 0.2
STEPS = 4
LIGHT_ROWS = 8
# The misfits of Fig. 3.9 with orders up to 1, 2 and 3, grey levels (thesis lines 1010
# to 1015). They set the sizes of the orders here. Nothing is compared with them.
MISFITS_GREY = (9.839, 1.309, 1.308)
MEAN_GREY = 120.0


def some_profile(rng):
    """A profile with orders up to 5, within 40 to 160 grey levels."""
    sines = dict(enumerate(rng.uniform(-1, 1, 5) * [40, 8, 4, 4, 4], 1))
    sines[1] = 40.0
    return sum_of_orders(sines, mean=100.0)


def _phases(count):
    return 2 * np.pi * (np.arange(count) + 0.5) / count


def _found(lines):
    """Locations (n,) by the decoder of one period's steps (4, n)."""
    plan = PatternPlan(phase_steps=STEPS, phase_periods=(1.0, 0.0))
    images = np.repeat(lines[:, None], LIGHT_ROWS, axis=1)
    monitor = ActiveGrid((lines.shape[1], LIGHT_ROWS))
    found = decode(
        images, patterns_of(plan), monitor, smooth=False, margin_px=0, noise=0.3,
        linear=True, threads=1,
    )  # fmt: skip
    return found.location[LIGHT_ROWS // 2, :, 0].astype(float)


def _turned(found, others):
    """Largest change of the decoded phase, rad, between locations (n,)."""
    return largest(wrapped(2 * np.pi * (others - found) / len(found)))


def offset_trial(condition, rng):
    """Largest phase change by an offset, by (3.23) and by the decoder, rad."""
    steps = stepped(some_profile(rng), STEPS, _phases(condition["phases"]))
    grey = np.rint(steps).astype(np.uint8)
    found = _found(grey)
    offsets = range(1, MAX_OFFSET_GREY + 1)
    return {
        "formula_rad": max(
            largest(wrapped(phase_of(steps + n) - phase_of(steps))) for n in offsets
        ),
        "decoder_rad": max(_turned(found, _found(grey + np.uint8(n))) for n in offsets),
    }


def gain_trial(condition, rng):
    """Largest phase change by a gain of each pixel, by (3.23) and decoded, rad."""
    steps = stepped(some_profile(rng), STEPS, _phases(condition["phases"]))
    gain = rng.uniform(MIN_GAIN, 1, steps.shape[1])
    change = wrapped(phase_of(gain * steps) - phase_of(steps))

    def turned(factor, depth):
        """Decode images with this number of grey levels per step."""
        both = (factor * steps, factor * gain * steps)
        return _turned(*(_found(np.rint(one).astype(depth)) for one in both))

    return {
        "formula_rad": largest(change),
        "decoder_16_rad": turned(250, np.uint16),
        "decoder_8_rad": turned(1, np.uint8),
    }


def order_sizes():
    """Amplitudes of orders 2, 3, and of one that is all the rest, grey levels.

    An order reduces the squared misfit by half its squared amplitude.
    """
    return np.sqrt(-2 * np.diff(np.square([*MISFITS_GREY, 0.0])))


def response_trial(condition, rng):
    """Largest error of the decoder on a profile with the sizes of Fig. 3.9."""
    two, three, rest = order_sizes()
    five = rest if condition["rest"] == "order 5" else 0.0
    worst, misfit = 0.0, []
    around = 2 * np.pi * np.arange(condition["positions"]) / condition["positions"]
    alone = around if five else around[:1]
    for p2, p3, p5 in itertools.product(around, around, alone):
        profile = _shifted({2: (two, p2), 3: (three, p3), 5: (five, p5)})
        _, error = decoder_error(profile, STEPS, condition["phases"])
        worst = max(worst, largest(error))
        misfit.append(fitted(profile(_phases(360)), 0)[1])
    return {"largest_rad": worst, "misfit_grey": float(np.median(misfit))}


def _shifted(sizes):
    """Order 1 with AMPLITUDE_GREY, and orders {n: (amplitude, position rad)}."""
    sines = {n: size * np.cos(at) for n, (size, at) in sizes.items()}
    cosines = {n: size * np.sin(at) for n, (size, at) in sizes.items()}
    return sum_of_orders({1: AMPLITUDE_GREY} | sines, cosines, MEAN_GREY)


PHASES = {"quick": 90, "full": 360}
# Of an order within the period.
POSITIONS = {"quick": 4, "full": 8}
DRAWS = {"quick": 2, "full": 10}


@experiment("exp_c3_radiometric_ok", artefact="fig_3_9")
def published_orders(effort):
    """The decoder on profiles with the orders that Fig. 3.9's misfits imply."""
    given = {"phases": PHASES[effort], "positions": POSITIONS[effort]}
    conditions = [{"rest": rest, **given} for rest in ("noise", "order 5")]
    return Plan(response_trial, conditions, 1, {"misfits_grey": list(MISFITS_GREY)})


@experiment("exp_c3_offset_cancels", artefact="sec_3_2_2")
def offsets(effort):
    """Offsets of up to 50 grey levels."""
    return Plan(offset_trial, [{"phases": PHASES[effort]}], DRAWS[effort])


@experiment("exp_c3_vignetting", artefact="sec_3_2_2")
def gains(effort):
    """A gain of 0.2 to 1 for every pixel."""
    return Plan(gain_trial, [{"phases": PHASES[effort]}], DRAWS[effort])
