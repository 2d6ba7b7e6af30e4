"""The claim of section 1.1.2, tested as registered."""

from chapters.ch01_introduction.s1_1_panorama.trials import MIN_RATIO, RIG_MIRROR
from repro.run.experiment import claim
from repro.run.outcomes import Reading


@claim("c1_unwrap_resolution", needs=("fig_1_1_resolution",), evidence="analytic")
def judge_unwrap_resolution(results):
    """Source pixels in the top and the bottom row, more than 1.5 apart."""
    ran = results["fig_1_1_resolution"]

    def of(name):
        return float(ran.column(name, mirror=RIG_MIRROR).max())

    ratio = of("ratio")
    apart = max(ratio, 1 / ratio)
    least = ran.select().column("ratio").min()
    return Reading.of(
        apart > MIN_RATIO,
        apart,
        unit="1",
        reason="area of the picture per unwrapped pixel, top row to "
        f"bottom row: {of('top'):.2f} to {of('bottom'):.3f} px²; "
        f"{of('ratio_row'):.1f} along the row, "
        f"{of('ratio_column'):.1f} along the column; "
        f"{least:.0f} or more with all mirrors tried",
    )
