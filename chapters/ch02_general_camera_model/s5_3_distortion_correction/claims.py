"""The claim of section 2.5.3, tested as the ledger words it."""

from __future__ import annotations

from chapters.shared.zoom_readings import OF_SEEDS, generic_wins, judged
from chapters.shared.zoom_rigs import FACADE_ZOOM
from repro.run.experiment import claim


@claim("c2_periphery", needs=OF_SEEDS, evidence="rendered")
def judge_periphery(results):
    """Near the edge, generic lines are straighter than parametric ones."""

    def judge(case):
        place = f"lines.{case.method('generic')}"
        generic, parametric = (
            case.column(f"{place}.{name}.{case.scale}", FACADE_ZOOM)
            for name in ("generic", "parametric")
        )
        return generic_wins(generic, parametric, "RMS distance from straight lines")

    questions = ("standard_method", "residual_scale", "interpolation")
    return judged(results, questions, judge)
