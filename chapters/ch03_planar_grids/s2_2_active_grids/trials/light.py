"""Effect of an offset, a gain and a nonlinear response on a decoded phase."""

import itertools

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.trials.profile import (
    AMPLITUDE_GREY,
    fitted,
)
from chapters.shared.phase_steps import (
    decoder_error,
    largest,
    phase_of,
    stepped,
    sum_of_orders,
    wrapped,
)
from raxel.features.active_grid import decode
from raxel.sets import ActiveGrid, PatternPlan, patterns_of
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

MAX_OFFSET_GREY = 50
MIN_GAIN = 0.2
STEPS = 4
ROWS = 8
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
    pictures = np.repeat(lines[:, None], ROWS, axis=1)
    monitor = ActiveGrid((lines.shape[1], ROWS))
    found = decode(
        pictures, patterns_of(plan), monitor, smooth=False, margin_px=0, noise=0.3,
        linear=True, threads=1,
    )  # fmt: skip
    return found.location[ROWS // 2, :, 0].astype(float)


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
