"""Fig. 3.5: best settings of two localisers over the inter-corner distance."""

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.results import BIN_EDGES_PX, Swept
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing


def frequencies(swept, best, levels):
    """Share (levels, bins) of the corners of a bin for which a level is best."""
    shares = np.full((len(levels), len(BIN_EDGES_PX) - 1), np.nan)
    for k, inside in zip(swept.bins, swept.by_bin(best), strict=True):
        shares[:, k] = np.mean(inside[:, None] == levels, axis=0)
    return shares


def medians(swept):
    """Median residual (windows[, blurs], bins) px."""
    shape = swept.error.shape[1:]
    out = np.full((*shape, len(BIN_EDGES_PX) - 1), np.nan)
    for k in swept.bins:
        out[..., k] = np.median(swept.error[swept.bin == k], axis=0)
    return out


@figure("fig_3_5", needs=("fig_3_5_derivative", "fig_3_5_saddle"), evidence="rendered")
def fig_3_5(results):
    """Histograms of the best setting, next to the median residual."""
    derivative = Swept(results["fig_3_5_derivative"])
    saddle = Swept(results["fig_3_5_saddle"])
    over = medians(saddle)
    rows = (
        (
            "(a) Derivative: window",
            "Window (px)",
            derivative.windows,
            frequencies(derivative, derivative.best_window, derivative.windows),
            medians(derivative),
        ),
        (
            "(b) Saddle point: window",
            "Window (px)",
            saddle.windows,
            frequencies(saddle, saddle.best_window, saddle.windows),
            over.min(axis=1),
        ),
        (
            "(b) Saddle point: blur",
            "Blur SD (px)",
            saddle.blurs,
            frequencies(saddle, saddle.best_blur, saddle.blurs),
            over.min(axis=0),
        ),
    )
    return _drawn(rows)


def _drawn(rows):
    from matplotlib.colors import LogNorm

    drawn, axes = new_figure(3, 2, height_in=9.0, sharex=True, sharey="row")
    cells = []
    all_medians = np.concatenate([row[4].ravel() for row in rows])
    norm = LogNorm(np.nanmin(all_medians), min(1.5, np.nanmax(all_medians)))
    sums = []
    for panels, (title, label, levels, share, median) in zip(axes, rows, strict=True):
        _slices(drawn, panels[0], levels, 100 * share, "Share of corners (%)")
        mesh = _slices(
            drawn, panels[1], levels, median, "Median residual (px)", norm=norm
        )
        mesh.set_cmap("viridis_r")
        middles = (BIN_EDGES_PX[1:] + BIN_EDGES_PX[:-1]) / 2
        filled = np.isfinite(median[0])
        lowest = np.nanargmin(median[:, filled], axis=0)
        panels[1].plot(middles[filled], levels[lowest], "wo", ms=5, mec="black", ls="")
        panels[0].set(title=title, ylabel=label)
        panels[1].set(title="Median residual")
        sums.append(np.nansum(share[:, filled], axis=0))
        cells += [
            (title, BIN_EDGES_PX[k], levels[i], part, median[i, k])
            for (i, k), part in np.ndenumerate(share)
        ]
    for panel in axes[-1]:
        panel.set_xlabel("Inter-corner distance (px)")
    off = float(np.abs(np.concatenate(sums) - 1).max())
    return Drawing(
        drawn,
        columns(("panel", "distance_from", "level", "share", "median_px"), cells),
        "Left: share of corners for which a setting has the smallest residual, "
        "normalised per bin of inter-corner distance, as in the thesis. Right: "
        "median residual of the same corners at every setting. For the saddle "
        "point method the other parameter has its best value. Dots mark the "
        "smallest median of a bin. (a) Window of the derivative method. "
        "(b) Window and blur of the saddle point method, which the thesis draws "
        "in one volume.",
        check=Check(off < 1e-9, "every slice of the histograms adds up to one"),
    )


def _slices(drawn, panel, levels, values, label, norm=None):
    """Draw one panel: levels over distance bins, with its colour bar."""
    steps = np.diff(levels) / 2
    edges = np.concatenate(
        [[levels[0] - steps[0]], levels[:-1] + steps, [levels[-1] + steps[-1]]]
    )
    mesh = panel.pcolormesh(BIN_EDGES_PX, edges, values, norm=norm, rasterized=True)
    panel.grid(False)
    panel.set_xticks(BIN_EDGES_PX[::2])
    drawn.colorbar(mesh, ax=panel, label=label, pad=0.02)
    return mesh
