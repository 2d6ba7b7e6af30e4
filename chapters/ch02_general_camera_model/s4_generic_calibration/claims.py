"""The claim about Table 2.1, tested as the registry words it."""

from chapters.ch02_general_camera_model.s4_generic_calibration.results import summary_of
from chapters.ch02_general_camera_model.s4_generic_calibration.trials import VECTORS
from repro.run.experiment import claim
from repro.run.outcomes import Reading


@claim("c2_table_coefficients", needs=("table_2_1_sums",), evidence="analytic")
def judge_table_coefficients(results):
    """Relative residual below 1e-12 corrected, above 1e-3 as printed."""
    ran = results["table_2_1_sums"]
    corrected = max(
        ran.column(f"corrected.{vector}.relative").max() for vector in VECTORS
    )
    exact = all(ran.column(f"corrected.{vector}.zero").all() for vector in VECTORS)
    printed = [summary_of(ran, vector) for vector in ("W", "N")]
    few = sum(
        int((ran.column(f"printed.{vector}.relative") <= 1e-3).sum())
        for vector in ("W", "N")
    )
    return Reading.of(
        exact and corrected < 1e-12 and min(printed) > 1e-3,
        f"{corrected:.1g} corrected; {printed[0]:.2g} (W), "
        f"{printed[1]:.2g} (N) as printed",
        reason="row 3 of W and N carries a superscript one too low as "
        "printed (E-2.08); largest residual of all scenes corrected, "
        "medians over scenes as printed, where "
        f"{few} of {2 * ran.trials_per_condition} are at most 1e-3",
    )
