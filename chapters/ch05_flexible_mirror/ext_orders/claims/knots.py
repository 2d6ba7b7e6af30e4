"""The claims about the number of knots."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_orders.results.knots import Knots
from chapters.ch05_flexible_mirror.ext_orders.results.relief import ReliefRuns
from chapters.ch05_flexible_mirror.ext_orders.trials.knots import SHAPES
from chapters.ch05_flexible_mirror.ext_orders.trials.shapes import name_of
from repro.judge.statistics import all_of
from repro.run.experiment import claim
from repro.run.outcomes import Reading

LEAST_REMOVED = 50.0


@claim("c5_knot_tradeoff", needs=("exp_c5_knot_tradeoff",), evidence="rendered")
def judge_knot_tradeoff(results):
    """The largest step that is borne, and the error without noise, as knots are added.

    Fixed before: the step never grows from one number of knots to the next and is
    smaller in the end; the median error of the shape without noise falls every time. A
    refused seed is not below one degree, and has the worst error.
    """
    knots = Knots.of(results)
    steps = np.array([knots.largest_step(shape) for shape in SHAPES])
    off = np.array([knots.noise_free(shape).value for shape in SHAPES])
    shrinks = np.all(np.diff(steps) <= 0) and steps[-1] < steps[0]
    falls = np.all(off[1:] < off[:-1])
    said = ", ".join(
        f"{name_of(shape)}: {step:g} mm and {1000 * error:.2g} um"
        for shape, step, error in zip(SHAPES, steps, off, strict=True)
    )
    return Reading.of(
        bool(shrinks and falls),
        float(steps[0] - steps[-1]),
        "mm",
        "largest step borne with the fewest knots less that with the most; step, and "
        f"error of the shape without noise, for functions along u x v: {said}",
    )


@claim("c5_high_order", needs=("exp_c5_high_order",), evidence="rendered")
def judge_high_order(results):
    """Relief raises the residual at stage 0, and more functions take half of that away.

    Fixed before: the residual is that of Fig. 5.13(a), the mean back-projection error
    on a board at 400 mm in the pose that the calibration finds; relief is the bench's;
    what is taken away is told of the rise over a smooth mirror, which keeps its own
    residual with either number of functions.
    """
    relief = ReliefRuns.of(results)
    rise, removed = relief.rise(), relief.removed()
    other = relief.rise("residual_mm"), relief.removed("residual_mm")
    return Reading.of(
        all_of([rise.above(1.0), removed.above(np.nextafter(LEAST_REMOVED, 0))]),
        removed,
        "%",
        f"of the rise by relief; with few functions it is {rise.value:.2f} times the "
        f"smooth mirror's ({rise.low:.2f} to {rise.high:.2f}); of the refinement's own "
        f"distances {other[1].value:.0f} %, raised {other[0].value:.2f} times; of the "
        f"angles to the true rays {relief.removed('angle_deg').value:.0f} %",
    )
