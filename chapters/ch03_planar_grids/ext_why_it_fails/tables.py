"""The drawn levels of all cases, counted by the stage that lost them."""

from collections import Counter

from chapters.ch03_planar_grids.ext_why_it_fails.results import stages_of
from chapters.ch03_planar_grids.ext_why_it_fails.trials.cases import CASES
from chapters.ch03_planar_grids.ext_why_it_fails.trials.stages import DONE, STAGES
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Table

WRONG = "returned, but wrong"
TITLES = {
    "clearance": "clearance",
    "first_corner": "first corner, (a)",
    "wrong_contour": "first corner, (b)",
    "direction": "direction",
    "window": "window",
    "curvature": "curvature",
    "size_variation": "size variation",
    "blur_noise": "blur and noise",
}


@table(
    "ext_why_stages",
    needs=(
        "ext_why_clearance",
        "ext_why_first_corner",
        "ext_why_wrong_contour",
        "ext_why_direction",
        "ext_why_window",
        "ext_why_curvature",
        "ext_why_size_variation",
        "ext_why_blur_noise",
    ),
    evidence="rendered",
)
def ext_why_stages(results):
    """The drawn levels of all cases, by the stage that lost them."""
    rows = []
    for case, title in TITLES.items():
        result = results[f"ext_why_{case}"]
        for name, level in CASES[case]["drawn"].items():
            stages = stages_of(result)[level]
            lost = Counter(stages)
            wrong = int(result.column(f"{level}.silently_wrong").sum())
            counts = (lost[stage] for stage in (DONE, *STAGES))
            rows.append((title, name, len(stages), *counts, wrong))
    heads = ("condition", "level", "trials", DONE, *STAGES, WRONG)
    may_be_empty = (*STAGES, WRONG)
    kept = {
        name: cells
        for name, cells in columns(heads, rows).items()
        if name not in may_be_empty or any(cells)
    }
    return Table(
        kept,
        "Random variations of every drawn pair, counted by the stage that lost "
        "them. Columns without any board are left out.",
    )
