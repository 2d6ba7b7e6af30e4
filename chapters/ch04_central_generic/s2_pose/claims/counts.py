"""The claim that the linear pose is fast, by what it solves."""

from chapters.ch04_central_generic.s2_pose.trials.counted import POINTS
from repro.judge.statistics import FAILS, HOLDS, all_of, median_interval
from repro.run.experiment import claim
from repro.run.outcomes import Reading

# Option of the ledger -> what the standard pose solves.
SOLVED = {"refined": "refined.systems", "as it comes out": "three_points.polynomials"}
MORE_THAN = 2


@claim(
    "c4_pose_linear_fast",
    needs=("exp_c4_pose_linear_fast",),
    evidence="synthetic",
    readings=("standard_pose",),
)
def judge_fast(results, options):
    """One system of all points and no iteration; the standard pose solves more."""
    result = results["exp_c4_pose_linear_fast"]
    systems, calls = (
        result.select().column(f"linear.{name}") for name in ("systems", "calls")
    )
    at_once = set(systems) == {1} and len(set(calls)) == 1
    solved = [
        median_interval(result.column(SOLVED[options["standard_pose"]], points=count))
        for count in POINTS
    ]
    return Reading.of(
        all_of([HOLDS if at_once else FAILS, *(n.above(MORE_THAN) for n in solved)]),
        min(solved, key=lambda n: n.value),
        "count",
        "what the standard pose solves in a scene, the smaller median of "
        f"{POINTS[0]} and {POINTS[1]} points; the linear pose solves "
        f"{min(systems):g} to {max(systems):g} systems of all points, in "
        f"{min(calls):g} to {max(calls):g} calls of solvers",
    )
