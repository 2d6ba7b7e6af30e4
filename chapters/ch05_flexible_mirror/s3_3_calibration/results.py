"""Results of the primary calibration and of the views of the mirror."""

import numpy as np

from chapters.shared.mirror_bench import BENCHES, FIRST, SECOND
from chapters.shared.mirror_rigs import STAGES_MM
from repro.judge.statistics import median_and_range
from repro.page.reader import value

RUNS = "table_5_1_runs"
# The experiment that solved each level.
JOBS = {FIRST: "bench_mirror", SECOND: "bench_mirror_second"}
FANS = "fig_5_10_fans"
MOVED = "fig_5_10_moved"
PICTURES, TRUST = "fig_5_10_pictures", "ext_mirror_trust_runs"
SURFACES = {"smooth": 0.0, "uneven by 10 µm": 10.0}
LAST = len(STAGES_MM) - 1
# Runs whose range is compared with a printed number.
RANGE_OF = 20
# The 32 measured numbers of 5.3.3's text and Tables 5.2 to 5.4: id -> its name in the
# results, and words.
CELLS = {
    "s5_3_3_pos_mean": ("miss_mm", "Distance of mirror points from rays (mm)"),
    "s5_3_3_pos_sd": ("miss_sd_mm", "SD of this distance (mm)"),
    "s5_3_3_ag_t": ("stage0.shift_mm", "Travel of the monitor, stage 0 (mm)"),
    "s5_3_3_ag_r": ("stage0.turn_deg", "Rotation of the monitor, stage 0 (°)"),
}
CELLS |= {
    f"t5_2_s{k}_{end}": (f"stage{k}.{name}", f"{words}, stage {k} ({unit})")
    for k in (1, 2, 3)
    for end, name, words, unit in (
        ("t", "shift_mm", "Travel of the monitor", "mm"),
        ("r", "turn_deg", "Rotation of the monitor", "°"),
    )
}
CELLS |= {
    f"t5_3_s{k}_{end}": (f"stage{k}.{name}", f"{words}, stage {k} (°)")
    for k in (0, 1, 2, 3)
    for end, name, words in (
        ("mean", "measured_deg", "Angle to measured rays"),
        ("sd", "measured_sd_deg", "SD of the angle"),
    )
}
CELLS |= {
    f"t5_4_s{k}_{end}": (f"stage{k}.{name}", f"{words}, stage {k} (mm)")
    for k in (0, 1, 2, 3)
    for end, name, words in (
        ("bp_mean", "back_mm", "Back-projection"),
        ("bp_sd", "back_sd_mm", "SD of back-projection"),
        ("res_mean", "residual_mm", "Residual"),
        ("res_sd", "residual_sd_mm", "SD of the residual"),
    )
    if k or end.startswith("bp")
}


def of_cell(result, level, name):
    """Median and range (3,) of a number in the first RANGE_OF runs of a level."""
    found = result.column(f"{level}.{name}")[:RANGE_OF]
    return median_and_range(found)


def within(result, level, published):
    """Whether each printed number of CELLS is in the range of the runs, {id: bool}."""
    found = {}
    for cell, (name, _) in CELLS.items():
        middle = of_cell(result, level, name)
        found[cell] = bool(middle.low <= published[cell] <= middle.high)
    return found


def fan_ratios(result, geometry, bench):
    """Angle of the fan at the last stage over that at stage 0, (seeds,)."""
    fans = np.array(result.arrays(bench, geometry=geometry))
    return fans[:, LAST] / fans[:, 0]


def moved_px(result, geometry):
    """Mean displacement of the corners, (seeds, deflections) px."""
    return np.array(result.arrays("moved_px", geometry=geometry))


def trust_trials(result, geometry, surface):
    """The trials of one geometry and one of SURFACES."""
    return result.select(geometry=geometry, aberration_um=SURFACES[surface])


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    first, runs = open_results(JOBS[FIRST]), open_results(RUNS)
    quoted = {
        "miss.clean": np.median([v[0] for v in first.arrays("miss_mm")]),
        f"{FIRST}.factor": BENCHES[FIRST].factor,
        f"{SECOND}.factor": BENCHES[SECOND].factor,
        f"{SECOND}.aberration": BENCHES[SECOND].aberration_um,
        f"{SECOND}.miss": of_cell(runs, SECOND, "miss_mm").value,
        f"{SECOND}.residual": of_cell(runs, SECOND, "stage1.residual_mm").value,
    }
    for name, number in quoted.items():
        value(name, float(number))
