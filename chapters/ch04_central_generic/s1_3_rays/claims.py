"""Test of the claim of section 4.1.3, as the registry states it."""

from repro.run.experiment import claim
from repro.run.outcomes import Reading

EQUAL = 1e-12


@claim("c4_mats_intersection", needs=("exp_c4_mats_intersection",), evidence="analytic")
def judge_mats_intersection(results):
    """-M^T S, stacked, equals M_i S ray by ray, sign included."""
    result = results["exp_c4_mats_intersection"]
    largest = max(float(result.column(name).max()) for name in ("printed", "stacked"))
    return Reading.of(
        largest < EQUAL,
        largest,
        reason="largest difference of a homogeneous coordinate, as a "
        "share of the point's largest; points differ from rays met with "
        f"the plane directly by {result.column('on_grid_mm').max():.1g} "
        "mm at most",
    )
