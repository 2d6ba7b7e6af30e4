"""What the steps of the mirror's camera left: errors by deflection, facts for prose."""

import numpy as np

from chapters.guides.rays_without_a_centre.trials import DEFLECTIONS_MM
from repro.judge.statistics import median_interval

STEPS = "ext_ray_motion_steps"
# Of a normal error the median of its size, in standard deviations.
MIDDLE = 0.6745
WAYS = {
    "linear": "linear, right pairs",
    "robust": "robust, refined",
    "held": "the same, length given",
}


def sizes(result, name, deflection):
    """Sizes (trials,) of an error at a deflection."""
    return np.abs(result.column(name, deflection_mm=deflection))


def found(result, name):
    """[Estimate, ...] over the deflections: median sizes of an error."""
    return [median_interval(sizes(result, name, d)) for d in DEFLECTIONS_MM]


def foretold(result, name):
    """(deflections,): median size of an error that the information foretells."""
    return [
        MIDDLE * np.median(result.column(f"told.{name}", deflection_mm=d))
        for d in DEFLECTIONS_MM
    ]


def facts(result):
    """Names and texts for the prose."""
    least, most = DEFLECTIONS_MM[0], DEFLECTIONS_MM[-1]
    told = {
        d: np.median(result.column("told.length_percent", deflection_mm=d))
        for d in (least, most)
    }
    turn = {way: np.median(sizes(result, f"{way}.turn_deg", most)) for way in WAYS}
    every = result.select()
    return {
        "deflection.least": f"{least:g}",
        "deflection.most": f"{most:g}",
        "told.least": f"{told[least]:.0f}",
        "told.most": f"{told[most]:.0f}",
        "spread.least": _spread(result, least),
        "spread.most": _spread(result, most),
        "turn.linear": f"{turn['linear']:.2g}",
        "turn.robust": f"{turn['robust']:.2g}",
        "turn.held": f"{turn['held']:.2g}",
        "kept": f"{100 * np.mean(every.column('kept')):.1f}",
        "let_in": f"{100 * np.mean(every.column('let_in')):.1f}",
        "product": f"{every.column('product_mm').max():.0e}",
        "mixed": f"{np.median(every.column('mixed_mm')):.2g}",
    }


def _spread(result, deflection):
    return f"{np.median(result.column('spread_mm', deflection_mm=deflection)):.1f}"
