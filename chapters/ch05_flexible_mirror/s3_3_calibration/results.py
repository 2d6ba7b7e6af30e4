"""What the primary stage and the views of the mirror gave."""

import numpy as np

from chapters.shared.mirror_bench import ABERRATION_UM, FACTOR
from chapters.shared.mirror_rigs import STAGES_MM
from repro.page.reader import value

ERRORS, BENCH = "sec_5_3_3_errors", "bench_mirror"
FANS = "fig_5_10_fans"
MOVED = "fig_5_10_moved"
PICTURES, TRUST = "fig_5_10_pictures", "ext_mirror_trust_runs"
SURFACES = {"smooth": 0.0, "uneven by 10 µm": 10.0}
LAST = len(STAGES_MM) - 1


def fan_ratios(result, geometry, bench):
    """Angle of the fan at the last stage over that at stage 0, (seeds,)."""
    fans = np.array(result.arrays(bench, geometry=geometry))
    return fans[:, LAST] / fans[:, 0]


def moved_px(result, geometry):
    """Mean way of the corners, (seeds, deflections) px."""
    return np.array(result.arrays("moved_px", geometry=geometry))


def trust_trials(result, geometry, surface):
    """The trials of one geometry and one of SURFACES."""
    return result.select(geometry=geometry, aberration_um=SURFACES[surface])


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    fans, bench = open_results(FANS), open_results(BENCH)
    trust = trust_trials(open_results(TRUST), "A", "uneven by 10 µm")
    errors = open_results(ERRORS)
    of_a = fans.arrays("laboratory", geometry="A")[0]
    way = np.median(moved_px(open_results(MOVED), "A"), axis=0)
    quoted = {
        "factor": FACTOR,
        "aberration": ABERRATION_UM,
        "miss.clean": np.median([v[0] for v in bench.arrays("miss_mm")]),
        "miss.bench": np.median(bench.column("chosen_miss_mm")),
        "residual.bench": np.nanmedian(bench.column("chosen_residual_mm")),
        "residual.smooth": np.nanmedian([v[0] for v in bench.arrays("residual_mm")]),
        "fan.first": of_a[0],
        "fan.last": of_a[LAST],
        "fan.ratio.a": np.median(fan_ratios(fans, "A", "laboratory")),
        "fan.ratio.b": np.median(fan_ratios(fans, "B", "laboratory")),
        "moved.first": way[0],
        "moved.last": way[-1],
        "trust.true": np.nanmedian(trust.column("stage3.true_deg")),
        "trust.predicted": np.nanmedian(trust.column("stage3.predicted_deg")),
        "trust.without": np.nanmedian(trust.column("stage3.without_deg")),
        "corner_px": np.median(errors.column("corner_px_rms", geometry="A")),
        "decoded_mm": np.median(errors.column("mirror_mm_rms", geometry="A")),
    }
    for name, number in quoted.items():
        value(name, float(number))
