"""Claims of 5.3.4, tested as registered."""

from dataclasses import replace

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.report import (
    FIRST,
    JUDGED,
    LAST,
    CircleRuns,
    conic_departs,
    conic_of_flat_mirror,
    exact_radii,
    face_corrected,
    no_common_error,
    radii_agree,
)
from chapters.shared.mirror import READINGS, over_completed
from repro.run import Case, Reading, claim, ratio_of

LEVELS = ("mirror_bench",)
EXACT_MM, EXACT_PX = 1e-6, 1e-6
MAX_GROWTH = 1.1


@claim("c5_planar_exact", needs=(), evidence="analytic")
def judge_exact(results):
    """Radius of the corrected circle with the true mirror, its pose known, no noise.

    Fixed before the run: all four stages, an even mirror and one as uneven as at
    the primary level.
    """
    off = np.abs(exact_radii())
    return Reading.of(
        bool(off.max() < EXACT_MM),
        float(off.max()),
        "mm",
        f"largest error of the radius of {len(off)} mirrors",
    )


@claim("c5_circle_radius", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_radius(results, options):
    """The radius within 1.5 % at all four stages."""
    return CircleRuns.judged_by_seed(results, options, radii_agree)


@claim("c5_circle_conic", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_conic(results, options):
    """Distance from a conic grows stage by stage, and is nothing for a flat mirror.

    Fixed before the run: the conic of least algebraic error, mean distances from it
    in the image as recorded; the flat mirror has no lens distortion, which
    alone would bend a conic.
    """
    found = CircleRuns.judged_by_seed(results, options, conic_departs)
    flat = conic_of_flat_mirror()
    reason = f"{found.reason}; a flat mirror leaves {flat:.0e} px"
    if flat >= EXACT_PX:
        return replace(found, verdict="differs", reason=reason)
    return replace(found, reason=reason)


@claim("c5_circle_no_system", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_system(results, options):
    """Mean correlation of the residuals around the circle between stages below 0.3.

    Fixed before the run: 90 places at the same angles of the board at all stages, mean
    of the six pairs of stages.
    """
    return CircleRuns.judged_by_seed(results, options, no_common_error)


@claim("c5_face", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_face(results, options):
    """What a plane leaves of the distortion of a relief of 5 % of its depth.

    Fixed before the run: root mean squares of the landmarks after the homography of
    least distances to the image of the view's own pinhole, which has the relief's
    parallax and no distortion.
    """
    return CircleRuns.judged_by_seed(results, options, face_corrected)


@claim("c5_circle_no_accum", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_growth(results, options):
    """The circle's residual grows by 10 % at most, with its whole interval.

    Fixed before the run: stage 3 over stage 1, the first and the last that dynamic
    calibration was applied to, medians, paired by run; stage 3 over stage 0 is
    reported.
    """

    def ratio(level, seeds, name="residual_mm", before=FIRST):
        runs = CircleRuns(results, options, level)
        pair = (runs.of(stage, name)[seeds] for stage in (LAST, before))
        return ratio_of("median", *pair, paired=True)

    def reading_of(level, seeds):
        growth = ratio(level, seeds)
        return Reading.of(
            growth.below(np.nextafter(MAX_GROWTH, 2)),
            growth,
            "x",
            "stage 3 over stage 1; over stage 0 "
            f"{ratio(level, seeds, before=0).value:.2f}; angles to the true rays grow "
            f"{ratio(level, seeds, 'angle_deg').value:.2f} times",
        )

    def done_at(level):
        runs = CircleRuns(results, options, level)
        return np.isfinite(runs.of(LAST, "residual_mm"))

    return over_completed(
        Case(READINGS, options),
        done_at,
        reading_of,
        lambda level, seeds: ratio(level, seeds).value <= MAX_GROWTH,
    )
