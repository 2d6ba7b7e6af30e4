"""The printed numbers of 5.3.3 compared with the three error levels."""

from chapters.ch05_flexible_mirror.s3_3_calibration.results import (
    CELLS,
    RANGE_OF,
    RUNS,
    of_cell,
    within,
)
from chapters.shared.mirror_sweep import LEVELS
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

# The cells of Tables 5.2 to 5.4 and of the text, as literals: marks are read unrun.
PRINTED = (
    "s5_3_3_pos_mean", "s5_3_3_pos_sd", "s5_3_3_ag_t", "s5_3_3_ag_r",
    "t5_2_s1_t", "t5_2_s1_r", "t5_2_s2_t", "t5_2_s2_r", "t5_2_s3_t", "t5_2_s3_r",
    "t5_3_s0_mean", "t5_3_s0_sd", "t5_3_s1_mean", "t5_3_s1_sd",
    "t5_3_s2_mean", "t5_3_s2_sd", "t5_3_s3_mean", "t5_3_s3_sd",
    "t5_4_s0_bp_mean", "t5_4_s0_bp_sd",
    "t5_4_s1_bp_mean", "t5_4_s1_bp_sd", "t5_4_s1_res_mean", "t5_4_s1_res_sd",
    "t5_4_s2_bp_mean", "t5_4_s2_bp_sd", "t5_4_s2_res_mean", "t5_4_s2_res_sd",
    "t5_4_s3_bp_mean", "t5_4_s3_bp_sd", "t5_4_s3_res_mean", "t5_4_s3_res_sd",
)  # fmt: skip
# Numbers that the levels are solved from: near the printed ones by construction.
SET = {
    "first solved level": ("s5_3_3_pos_mean", "t5_4_s1_res_mean"),
    "second solved level": ("t5_3_s0_mean", "t5_4_s0_bp_mean"),
}


@table(
    "ext_mirror_levels",
    needs=("table_5_1_runs",),
    evidence="rendered",
    published=PRINTED,
)
def levels_table(results, published):
    """Median and range of each measure at each level, and where the range contains the
    printed number."""
    result = results[RUNS]
    inside = {level: within(result, name, published) for level, name in LEVELS.items()}
    rows = []
    for cell, (name, words) in CELLS.items():
        there = [
            f"{level.split()[0]}{' (set)' if cell in SET.get(level, ()) else ''}"
            for level in LEVELS
            if inside[level][cell]
        ]
        middles = [of_cell(result, level, name) for level in LEVELS.values()]
        rows.append((words, *(Measured(*m[:3]) for m in middles), ", ".join(there)))
    counts = ", ".join(
        f"{level} {sum(inside[level].values())} "
        f"({sum(inside[level][cell] for cell in SET.get(level, ()))} of them set)"
        for level in LEVELS
    )
    heads = [level[0].upper() + level[1:] for level in LEVELS]
    return Table(
        columns(("Measure", *heads, "Range contains the printed number at"), rows),
        "The measured numbers of 5.3.3 and of Tables 5.2 to 5.4 at the three error "
        f"levels: median and range of {RANGE_OF} runs, rig A. Number of the "
        f"{len(CELLS)} printed values inside the range: {counts}. The form of the "
        "levels was chosen after all of them were known, so these counts do not test "
        "it.",
        printed={heads[0]: list(CELLS)},
    )
