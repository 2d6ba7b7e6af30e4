"""Share of correct grids by set and range of poses."""

import numpy as np
from matplotlib.ticker import FixedFormatter, FixedLocator

from chapters.ch03_planar_grids.s3_2_grid_sets.results.pictures import (
    CLEAN,
    EXPERIMENTS,
    GRIDS,
    TITLES,
    Which,
    right,
)
from chapters.shared.grid_detectors import CELECT, CLICKLESS, OPENCV, OPENCV_SB
from chapters.shared.grid_rigs import HARD, WHOLE
from repro.judge.statistics import proportion
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_interval
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

SHOWN = {
    CELECT: "CELECT",
    OPENCV: "findChessboardCorners",
    OPENCV_SB: "findChessboardCornersSB",
    CLICKLESS: "without clicks (ours)",
}
SPOTLESS_TITLE = "Spherical,\nno spots"
OFFSET = 0.16
HEADS = ("series", "x", "correct", "images", "low", "high")


def plot_shares(panel, at, trials, label):
    """Draw the shares (%) of correct grids of one detector.

    Returns the figure's data of each: correct, images, ends of the interval.
    """
    found = [proportion(right_of) for right_of in trials]
    shares = 100 * np.array([share[:3] for share in found])
    plot_interval(panel, at, *shares.T, look=look_of(label), label=label, bars=True)
    return [
        (int(right_of.sum()), len(right_of), share.low, share.high)
        for right_of, share in zip(trials, found, strict=True)
    ]


@figure("ext_grid_rates", needs=GRIDS, evidence="rendered")
def ext_grid_rates(results):
    """Draw the share of correct grids of four detectors by set, in both ranges."""
    drawn, panels = new_figure(2, 1, height_in=6.4, sharex=True)
    titles = [*TITLES.values(), SPOTLESS_TITLE]
    rows = []
    for panel, poses in zip(panels, (WHOLE, HARD), strict=True):
        for index, (method, label) in enumerate(SHOWN.items()):
            found = [
                right(results[e], method, Which(poses)) for e in EXPERIMENTS.values()
            ]
            if method != CLICKLESS:
                ball = results[EXPERIMENTS["spherical"]]
                found.append(right(ball, method, Which(poses, CLEAN)))
            at = np.arange(len(found)) + OFFSET * (index - 1.5)
            shares = plot_shares(panel, at, found, label)
            rows += [
                (poses, label, title.replace("\n", " "), *share)
                for title, share in zip(titles, shares, strict=False)
            ]
            for line in panel.lines:
                line.set_linestyle("none")
        panel.set(ylim=(-3, 103), ylabel="Correct grids (%)", title=f"poses: {poses}")
    panels[-1].xaxis.set_major_locator(FixedLocator(range(len(titles))))
    panels[-1].xaxis.set_major_formatter(FixedFormatter(titles))
    legend_below(drawn, panels[0], ncols=2)
    return Drawing(
        drawn,
        columns(("poses", *HEADS), rows),
        "Share of correct grids by camera and detector, with exact 95 % "
        "intervals. Above: whole range of poses, three simulated runs. Below: "
        "hard range, one run. Last column: the mirror ball again without "
        "spots, one run.",
    )
