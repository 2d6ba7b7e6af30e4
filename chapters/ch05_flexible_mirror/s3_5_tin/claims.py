"""Claims about the tin, tested as registered."""

from chapters.ch05_flexible_mirror.s3_5_tin.results import predicates
from chapters.ch05_flexible_mirror.s3_5_tin.results.runs import JUDGED, TinRuns
from repro.run.experiment import claim

BENCHES = ("mirror_bench",)


@claim("c5_tin_angles", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_angles(results, options):
    """The largest of three differences from the reference is 2.5 degrees at most.

    Fixed before the run: the calibration is the published one, stage by stage; the
    motion between the pictures is known; seed by seed.
    """
    return TinRuns.judged_by_seed(results, options, predicates.angles_found)


@claim("c5_tin_normal", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_normal(results, options):
    """Correlation with a normal law of 0.99 or more, on each of the three faces.

    Fixed before the run: outliers, which the thesis sets apart, are distances beyond
    3.5 robust standard deviations of a face; published calibration, known motion.
    """
    return TinRuns.judged_by_seed(results, options, predicates.distances_normal)
