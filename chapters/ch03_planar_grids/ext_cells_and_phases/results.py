"""What cells and steps do to an active grid: measured, and by the theory."""

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.ext_cells_and_phases.trials import (
    BLACK,
    BUDGETS,
    LIGHTS,
    LINEAR,
    ORDINARY,
    OUR_BLUR_PX,
    OUR_CELLS,
    OUR_NOISE,
    OUR_STEPS,
    READINGS,
    WHITE,
    name_of,
    name_of_capture,
    period_px,
    pictures_of,
)
from repro.page.reader import value
from repro.run.outcomes import Measured

WAYS = SMOOTHED, BY_PIXEL = "smoothed", "by pixel"
WINDOW_PX = 7
# Windows whose mean sine is weaker than this are not smoothed (raxel's decoder).
WEAKEST_MEAN = 0.7
ROUNDING = 1 / 12  # variance of a grey value that is rounded
ENOUGH = 0.99  # share of the pixels that a grid has to decode to be advised
SWING = (WHITE - BLACK) / 2
PHASES = 720


class DecodedGrid:
    """How one grid was decoded in the trials of a plan: smoothed or by pixel."""

    def __init__(self, trials, name):
        self._trials, self._name = trials, name

    def column(self, key):
        """A value (trials,)."""
        return self._trials.column(f"{self._name}.{key}")

    def measured(self, key):
        """Median with its interval over the trials; None where none has the value."""
        trials = self.column(key)
        known = trials[np.isfinite(trials)]
        return Measured.median(known) if len(known) else None

    def median(self, key):
        """The median alone; nan where no trial has the value."""
        found = self.measured(key)
        return np.nan if found is None else found.value

    @property
    def readable(self):
        """Whether every trial decodes enough pixels, and none into a wrong cell."""
        share, gross = self.column("decoded"), self.column("gross")
        return bool(share.min() >= ENOUGH and gross.max() == 0)


def decoded(result, name, way):
    """(cells, steps) -> DecodedGrid, of every grid; name: as `name_of` gives."""
    return {
        grid: DecodedGrid(result.one(cells=grid[0], steps=grid[1]), f"{name}.{way}")
        for grid in grids(result)
    }


def read_twice(result):
    """(steps, reading, {gamma: {way: DecodedGrid}}) of pictures decoded both ways."""
    one = result.one()
    for steps, reading in product(result.conditions[0]["steps"], READINGS):
        names = {
            gamma: name_of_capture(steps, gamma, reading)
            for gamma in swept(result, "gammas")
        }
        yield (
            steps,
            reading,
            {
                gamma: {way: DecodedGrid(one, f"{name}.{way}") for way in WAYS}
                for gamma, name in names.items()
            },
        )


def linear_cases(result):
    """(blur, noise, way, grid, DecodedGrid) of all that a linear monitor shows."""
    cases = product(swept(result, "blurs_px"), swept(result, "noises"), WAYS)
    for blur, noise, way in cases:
        of_grid = decoded(result, name_of(LINEAR, blur, noise), way)
        yield from ((blur, noise, way, grid, one) for grid, one in of_grid.items())


def widest(result, names):
    """How far, in %, an end of an interval lies from its median RMS error at most.

    names: as `name_of` gives; for every grid that decodes anything, in both ways.
    """
    found = [
        one.measured("rms_px")
        for name, way in product(names, WAYS)
        for one in decoded(result, name, way).values()
    ]
    ends = [max(one.high / one.value, one.value / one.low) for one in found if one]
    return 100 * (max(ends) - 1)


def swept(result, name):
    """The different values of a list that conditions have, in order."""
    return sorted({x for c in result.conditions for x in c[name]})


def grids(result):
    """(cells, steps) of every condition."""
    return [(c["cells"], c["steps"]) for c in result.conditions]


def width_of(result):
    """Width of the pictures, px."""
    return result.conditions[0]["width_px"]


def sigma_px(period, blur, noise, steps, way=BY_PIXEL):
    """Standard deviation of a coordinate, px, by the theory of the page.

    Arrays or numbers; period in px of the camera.
    """
    period = np.asarray(period, float)
    swing = SWING * np.exp(-2 * (np.pi * blur / period) ** 2)
    grey = np.sqrt(noise**2 + ROUNDING)
    each = period * grey * np.sqrt(2 / steps) / (2 * np.pi * swing)
    if way == BY_PIXEL:
        return each
    mean = window_mean(1, period)
    spread = np.sqrt((1 + window_mean(2, period)) / 2)
    smooth = each * spread / (WINDOW_PX * mean)
    return np.where(mean >= WEAKEST_MEAN, smooth, each)


def window_mean(order, period):
    """Mean over a window of the cosine of `order` times the phase from its middle."""
    return np.sinc(order * WINDOW_PX / period) / np.sinc(order / period)


def bias_px(period, blur, gamma, steps):
    """RMS error of a coordinate, px, that the response alone makes, by the theory."""
    phase = 2 * np.pi * np.arange(PHASES) / PHASES
    orders = np.fft.rfft((0.5 + 0.5 * np.sin(phase)) ** gamma)
    k = np.arange(len(orders))
    orders = orders * np.exp(-2 * (np.pi * blur * k / period) ** 2)
    turned = orders * np.exp(2j * np.pi * np.outer(np.arange(steps), k) / steps)
    light = np.fft.irfft(turned, PHASES, axis=1)
    angle = 2 * np.pi * np.arange(steps)[:, None] / steps
    sine = np.sum(light * np.cos(angle), axis=0)
    cosine = np.sum(light * np.sin(angle), axis=0)
    off = np.angle(np.exp(1j * (np.arctan2(sine, cosine) - phase)))
    return float(np.sqrt(np.mean(off**2)) * period / (2 * np.pi))


def rounding_px(period, blur, steps):
    """What rounding to whole grey levels adds, px, if it were noise."""
    return float(sigma_px(period, blur, 0.0, steps))


def smoothed_px(period, gamma, steps, reading):
    """RMS error of a coordinate, px, by the theory, smoothed, with noise and response.

    The window averages the ripple, which has `steps` waves in a period.
    """
    noise = float(sigma_px(period, OUR_BLUR_PX, OUR_NOISE, steps, SMOOTHED))
    if not READINGS[reading]:
        return noise
    ripple = bias_px(period, OUR_BLUR_PX, gamma, steps) * window_mean(steps, period)
    return float(np.hypot(noise, ripple))


def best_cells(result, blur, noise, way):
    """(cells, their RMS error) of the readable grid with the least; None for none."""
    of_grid = decoded(result, name_of(LINEAR, blur, noise), way)
    found = [
        (one.median("rms_px"), cells)
        for (cells, _), one in of_grid.items()
        if one.readable
    ]
    return min(found)[::-1] if found else None


def rms(result, cells, steps, way, *, gamma=LINEAR, blur=OUR_BLUR_PX, noise=OUR_NOISE):
    """Median RMS error of one grid in one condition, px."""
    of_grid = decoded(result, name_of(gamma, blur, noise), way)
    return of_grid[cells, steps].median("rms_px")


def _ratio(result, cells, **where):
    """How many times the thesis's grid is worse than one of other cells."""
    ours = rms(result, OUR_CELLS, OUR_STEPS, SMOOTHED, **where)
    return ours / rms(result, cells, OUR_STEPS, SMOOTHED, **where)


def name_values(open_results):
    """Name what the prose quotes."""
    cells = open_results("ext_cells_runs")
    steps = open_results("ext_steps_runs")
    width, blurs = width_of(cells), swept(cells, "blurs_px")
    sharp, soft = min(blurs), max(blurs)
    best = best_cells(cells, sharp, OUR_NOISE, SMOOTHED)[0]
    within = [o.median("within") for *_, o in linear_cases(cells) if o.readable]
    quoted = {
        **of_blur(cells, "sharp", sharp),
        **of_blur(cells, "soft", soft),
        "trials": cells.trials_per_condition,
        "fewer": steps.trials_per_condition,
        "width": width,
        "height": width // 2,
        "sharp": sharp,
        "soft": soft,
        "noise": OUR_NOISE,
        "gain": _ratio(cells, best, blur=sharp),
        "more": pictures_of(best, OUR_STEPS) - pictures_of(8, OUR_STEPS),
        "theory": 100 * float(np.median(_off_theory(cells))),
        "gross": int(sum(o.column("gross").sum() for *_, o in linear_cases(cells))),
        "narrowest": _narrowest_smoothed(),
        "within.least": 100 * min(within),
        "within.most": 100 * max(within),
        **of_steps(steps),
        **of_correction(open_results("ext_corrected_runs")),
        **of_pictures(open_results("ext_pictures_runs")),
        **of_light(open_results("ext_light_runs")),
    }
    for name, number in quoted.items():
        value(name, number)


def of_blur(cells, name, blur):
    """The best cells under a blur, smoothed and by pixel, and the thesis's eight."""
    found = {
        f"{name}.ours": rms(cells, 8, 4, SMOOTHED, blur=blur),
        f"{name}.period": 2 * np.pi * blur,
    }
    for short, way in (("smooth", SMOOTHED), ("pixel", BY_PIXEL)):
        best, error = best_cells(cells, blur, OUR_NOISE, way)
        found[f"{name}.{short}.cells"] = best
        found[f"{name}.{short}.period"] = period_px(best, width_of(cells))
        found[f"{name}.{short}.rms"] = error
    return found


def of_steps(steps):
    """What the response leaves with each number of steps."""
    period, gammas = period_px(OUR_CELLS, width_of(steps)), swept(steps, "gammas")
    found = {
        "period": period,
        "gamma.least": min(gammas),
        "gamma.most": max(gammas),
        "noise_alone": float(sigma_px(period, OUR_BLUR_PX, OUR_NOISE, 4)),
    }
    for _, count in grids(steps):
        left = {
            g: rms(steps, OUR_CELLS, count, BY_PIXEL, gamma=g, noise=0.0)
            for g in gammas
        }
        found[f"bias.{count}"] = max(left.values())
        found[f"ordinary.{count}"] = left[ORDINARY]
    return found


def of_correction(result):
    """What the response does to places and stated SDs, left as it is and undone."""
    period, gamma = period_px(OUR_CELLS, width_of(result)), max(swept(result, "gammas"))
    found = {
        "strong": gamma,
        "strong.width": width_of(result),
        "strong.views": result.trials_per_condition,
        "strong.shift": bias_px(period, OUR_BLUR_PX, gamma, OUR_STEPS),
    }
    for steps, reading, of_gamma in read_twice(result):
        within = [100 * ways[SMOOTHED].median("within") for ways in of_gamma.values()]
        strong = of_gamma[gamma]
        found[f"{reading}.off.{steps}"] = strong[SMOOTHED].median("rms_px")
        found[f"{reading}.within.{steps}"] = 100 * strong[SMOOTHED].median("within")
        found[f"{reading}.pixels.{steps}"] = 100 * strong[BY_PIXEL].median("within")
        found[f"{reading}.least.{steps}"] = min(within)
        found[f"{reading}.most.{steps}"] = max(within)
        told = strong[SMOOTHED].median("told_px")
        if np.isfinite(told):  # who does not ask is not told
            found[f"{reading}.told.{steps}"] = told
    return found


def of_pictures(pictures):
    """The best of the grids that take equally many pictures."""
    found, blur = {}, min(swept(pictures, "blurs_px"))
    for total, tested in BUDGETS.items():
        errors = {
            rms(pictures, *grid, SMOOTHED, gamma=ORDINARY, blur=blur): grid
            for grid in tested
        }
        found[f"of{total}.cells"], found[f"of{total}.steps"] = errors[min(errors)]
        found[f"of{total}.rms"] = min(errors)
        found[f"of{total}.worst"] = max(errors)
    return found


def of_light(light):
    """How much the number of steps matters where pictures, or light, are shared."""

    def spread(which):
        of_grid = decoded(light, which, BY_PIXEL).values()
        medians = np.array([np.median(one.column("rms_px")) for one in of_grid])
        return 100 * (medians.max() / medians.min() - 1)

    return {"sines.spread": spread(LIGHTS[1]), "light.spread": spread(LIGHTS[2])}


def _off_theory(result):
    """Differences from the theory, as shares of it, of the grids that are readable."""
    width = width_of(result)
    return [
        abs(
            one.median("rms_px") / sigma_px(period_px(cells, width), blur, noise, steps)
            - 1
        )
        for blur, noise, way, (cells, steps), one in linear_cases(result)
        if way == BY_PIXEL and one.readable
    ]


def _narrowest_smoothed():
    """The narrowest period, px, whose windows are smoothed."""
    periods = np.linspace(WINDOW_PX + 1, 4 * WINDOW_PX, 2101)
    return float(periods[window_mean(1, periods) >= WEAKEST_MEAN][0])
