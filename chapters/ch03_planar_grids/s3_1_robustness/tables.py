"""Limits and losses of the sweeps of section 3.3.1, in numbers."""

from chapters.ch03_planar_grids.s3_1_robustness.results import (
    Under,
    blur_that_hurts,
    limit,
    losses,
    smallest_square,
    sweeps_under,
)
from chapters.ch03_planar_grids.s3_1_robustness.trials import OUT_OF_SIGHT, SMOOTHINGS
from chapters.shared.scoring import CORNER_OFF
from raxel.features.celect import OUTER_CORNER, TOO_FEW, TOO_MANY, TRACING
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Table

NAMES = {
    "noise": "noise",
    "blur": "blur",
    "square": "size of squares",
    "fov": "fisheye",
    "yaw": "perspective",
}
STAGES = (OUTER_CORNER, TRACING, TOO_FEW, TOO_MANY, CORNER_OFF, OUT_OF_SIGHT)
SWEPT = (
    "fig_3_11_noise",
    "fig_3_11_blur",
    "fig_3_11_square",
    "fig_3_11_fov",
    "fig_3_11_yaw",
)


@table(
    "ext_celect_bounds",
    needs=SWEPT,
    evidence="rendered",
    published=(
        "s3_3_1_noise_fail",
        "s3_3_1_blur_fail",
        "s3_3_1_pitch_ok",
        "s3_3_1_yaw_fail",
    ),
)
def ext_celect_bounds(results, published):
    """How far CELECT gets along each sweep, with both smoothings."""
    printed = (
        published["s3_3_1_noise_fail"],
        None,
        published["s3_3_1_blur_fail"],
        published["s3_3_1_pitch_ok"],
        None,
        published["s3_3_1_yaw_fail"],
    )
    names = (
        "noise SD, first loss (grey levels)",
        "the same with half the contrast",
        "blur SD, first worse than at 1 px (px)",
        "smallest square without a loss (px)",
        "field of view, first loss (deg)",
        "yaw, first loss (deg)",
    )
    found = {name: _limits(sweeps_under(results, name)) for name in SMOOTHINGS}
    return Table(
        {"limit": names, "thesis": printed} | found,
        "Where CELECT begins to fail along the sweeps of Fig. 3.11, with "
        "each smoothing of its gradients. Limits are levels of the sweeps; "
        "nothing: no such level.",
    )


def _limits(sweeps):
    first = (
        limit(sweeps["noise"], "noise_sd", levels="full range")[1],
        limit(sweeps["noise"], "noise_sd", levels="half range")[1],
        blur_that_hurts(sweeps["blur"])[1],
        smallest_square(sweeps["square"])[0],
        limit(sweeps["fov"], "fov_deg")[1],
        limit(sweeps["yaw"], "yaw_deg")[1],
    )
    return [round(float(x), 1) if 0 < x < float("inf") else None for x in first]


@table("ext_celect_losses", needs=SWEPT, evidence="rendered")
def ext_celect_losses(results):
    """How many trials of each sweep were lost, and where CELECT gave them up."""
    rows = []
    for smoothing in SMOOTHINGS:
        for sweep, result in sweeps_under(results, smoothing).items():
            lost = losses(result)
            run = sum(c["levels"] == "full range" for c in result.conditions)
            rows.append(
                (
                    NAMES[sweep],
                    smoothing,
                    run * result.trials_per_condition,
                    sum(lost.values()),
                    *(lost[stage] for stage in STAGES),
                )
            )
    return Table(
        columns(("sweep", "smoothing", "trials", "lost", *STAGES), rows),
        "Lost trials of the sweeps of Fig. 3.11, at full contrast, by the "
        "stage at which CELECT gave up.",
    )


@table("ext_celect_columns", needs=("ext_celect_columns",), evidence="rendered")
def ext_celect_columns(results):
    """Which columns break when the sides are known."""
    result = results["ext_celect_columns"]
    names = [n for n in result.names() if n.startswith("column ")]
    rows = [
        (
            condition["fov_deg"],
            smoothing,
            result.trials_per_condition,
            *(
                int(Under(result, smoothing).column(name, **condition).sum())
                for name in names
            ),
        )
        for smoothing in SMOOTHINGS
        for condition in result.conditions
    ]
    return Table(
        columns(("FOV (deg)", "smoothing", "trials", *names), rows),
        "Beyond 134°, with the corners of the four sides given by hand: in "
        "how many trials each column between them is lost. Column 5 is the "
        "middle one, columns 2 and 8 stand next to the rim.",
    )
