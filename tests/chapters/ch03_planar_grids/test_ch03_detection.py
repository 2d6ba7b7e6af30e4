"""The claim that CELECT's corners are less than 8 px off."""

import numpy as np
import pytest

from chapters.ch03_planar_grids.s3_1_robustness.claims import judge_detect_8px
from chapters.ch03_planar_grids.s3_1_robustness.report import SWEEPS
from tests.judged_claims import readings_of
from tests.made_results import OfLaw


@pytest.mark.parametrize(
    ("largest", "verdict", "count"),
    [
        ([7.9] * 80, "reproduced", 400),
        ([7.9] * 79 + [8.1], "undecided", 400),
        ([7.9] * 70 + [8.1] * 10, "differs", 400),
        ([7.9] * 80 + [np.nan] * 40, "reproduced", 400),  # not in order: not counted
        ([7.9] * 20, "undecided", 100),
    ],
)
def test_8_px_claim_counts_complete_grids_only(largest, verdict, count):
    def law(name, condition):
        assert name.endswith("ordered_px")
        return largest

    results = {
        f"fig_3_11_{s}": OfLaw(
            [{"level": s, "levels": "full range"}], law, len(largest)
        )
        for s in SWEEPS
    }
    readings = readings_of(judge_detect_8px, results)
    assert {r.verdict for r in readings} == {verdict}
    assert f"of {count} complete grids" in readings[0].reason
    assert readings[0].regenerated == pytest.approx(
        np.mean(np.array(largest)[np.isfinite(largest)] < 8)
    )
