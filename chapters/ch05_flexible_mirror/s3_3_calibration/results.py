"""What the primary stage and the views of the mirror gave."""

import numpy as np

from chapters.shared.mirror_bench import BENCHES, FIRST, LABORATORY, SECOND
from chapters.shared.mirror_rigs import STAGES_MM
from repro.judge.statistics import median_and_range
from repro.page.reader import value

ERRORS, RUNS = "sec_5_3_3_errors", "table_5_1_runs"
# What each level was solved by.
JOBS = {FIRST: "bench_mirror", SECOND: "bench_mirror_second"}
FANS = "fig_5_10_fans"
MOVED = "fig_5_10_moved"
PICTURES, TRUST = "fig_5_10_pictures", "ext_mirror_trust_runs"
SURFACES = {"smooth": 0.0, "uneven by 10 µm": 10.0}
LAST = len(STAGES_MM) - 1
# Seeds whose range a printed number is held against.
RANGE_OF = 20
# The 32 numbers that 5.3.3's text and Tables 5.2 to 5.4 print of measurements: id ->
# what the runs call it, and words.
CELLS = {
    "s5_3_3_pos_mean": ("miss_mm", "Mirror points from their rays (mm)"),
    "s5_3_3_pos_sd": ("miss_sd_mm", "SD of these (mm)"),
    "s5_3_3_ag_t": ("stage0.shift_mm", "Travel of the monitor, stage 0 (mm)"),
    "s5_3_3_ag_r": ("stage0.turn_deg", "Its turn, stage 0 (°)"),
}
CELLS |= {
    f"t5_2_s{k}_{end}": (f"stage{k}.{name}", f"{words}, stage {k} ({unit})")
    for k in (1, 2, 3)
    for end, name, words, unit in (
        ("t", "shift_mm", "Travel of the monitor", "mm"),
        ("r", "turn_deg", "Its turn", "°"),
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
    """Median and range (3,) of a number in the first RANGE_OF seeds of a level."""
    found = result.column(f"{level}.{name}")[:RANGE_OF]
    return median_and_range(found)


def within(result, level, published):
    """Which of CELLS lie in the range of the seeds, {id: bool}, given what is
    printed."""
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
    """Mean way of the corners, (seeds, deflections) px."""
    return np.array(result.arrays("moved_px", geometry=geometry))


def trust_trials(result, geometry, surface):
    """The trials of one geometry and one of SURFACES."""
    return result.select(geometry=geometry, aberration_um=SURFACES[surface])


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    fans = open_results(FANS)
    first, second = (open_results(JOBS[level]) for level in (FIRST, SECOND))
    trust = trust_trials(open_results(TRUST), "A", "uneven by 10 µm")
    errors, runs = open_results(ERRORS), open_results(RUNS)
    of_a = fans.arrays(LABORATORY, geometry="A")[0]
    way = np.median(moved_px(open_results(MOVED), "A"), axis=0)
    quoted = {
        "miss.clean": np.median([v[0] for v in first.arrays("miss_mm")]),
        "angle.second": np.median(second.column("chosen_angle_deg")),
        "back.second": np.median(second.column("chosen_back_mm")),
        "fan.first": of_a[0],
        "fan.last": of_a[LAST],
        "moved.first": way[0],
        "moved.last": way[-1],
        "trust.true": np.nanmedian(trust.column("stage3.true_deg")),
        "trust.predicted": np.nanmedian(trust.column("stage3.predicted_deg")),
        "trust.without": np.nanmedian(trust.column("stage3.without_deg")),
        "corner_px": np.median(errors.column("corner_px_rms", geometry="A")),
        "decoded_mm": np.median(errors.column("mirror_mm_rms", geometry="A")),
    }
    for geometry in "ABC":
        ratios = fan_ratios(fans, geometry, LABORATORY)
        quoted[f"fan.ratio.{geometry.lower()}"] = np.median(ratios)
    for level in (FIRST, SECOND):
        quoted[f"{level}.factor"] = BENCHES[level].factor
        quoted[f"{level}.aberration"] = BENCHES[level].aberration_um
        for short, name in (("miss", "miss_mm"), ("residual", "stage1.residual_mm")):
            quoted[f"{level}.{short}"] = of_cell(runs, level, name).value
    for name, number in quoted.items():
        value(name, float(number))
