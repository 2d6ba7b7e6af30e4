"""Figs. 3.8 and 3.9: patterns of an active grid, and the imaged sine."""

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.results import profile_column
from chapters.ch03_planar_grids.s2_2_active_grids.trials.profile import (
    DATA_SHEET_GAMMA,
    HARMONICS,
)
from raxel.sets import patterns_of, plan_of_cells
from raxel.sets.patterns import pattern_picture
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

SHOWN_PX = (512, 384)
# Of rig d200-lens, chosen from the published fits of Fig. 3.9.
CHOSEN_GAMMA = 2.0
MODELS = ("one sine", "one harmonic", "two harmonics")


@figure("fig_3_8", needs=("exp_c3_20_patterns",), evidence="analytic")
def fig_3_8(results):
    """Patterns of the vertical axis, as sent to the monitor."""
    counted = results["exp_c3_20_patterns"]
    patterns = [
        p for p in patterns_of(plan_of_cells(SHOWN_PX, phase_steps=4)) if p.axis == "y"
    ]
    drawn, axes = new_figure(2, 6, height_in=2.9)
    binary, sines = (
        [p for p in patterns if p.kind == kind] for kind in ("gray", "phase")
    )
    data = {"row": list(range(SHOWN_PX[1]))}
    for cell in axes.ravel():
        cell.axis("off")
    for panel, row, group in (("a", axes[0], binary), ("b", axes[1], sines)):
        for cell, pattern in zip(row, group, strict=False):
            picture = pattern_picture(pattern, SHOWN_PX)
            cell.imshow(picture, cmap="gray", vmin=0, vmax=255)
            name = (
                f"bit {pattern.bit}" + ("\ninverse" if pattern.inverse else "")
                if pattern.kind == "gray"
                else f"sine\n{360 * pattern.step // pattern.of}°"
            )
            cell.set_title(name, fontsize=8, loc="center", fontweight="normal")
            data[name.replace("\n", ", ")] = picture[:, 0].tolist()
        row[0].text(-0.25, 0.5, f"({panel})", transform=row[0].transAxes, ha="right")
    both = counted.column("patterns", **counted.conditions[0])[0]
    right = (len(binary), len(sines)) == (6, 4) and both == 2 * len(patterns)
    return Drawing(
        drawn,
        data,
        "The ten patterns of an active grid that encode the vertical location. "
        "(a) Three bits of a Gray code for eight cells, each with its inverse. "
        "(b) Four sines, shifted by 90° each.",
        Check(
            bool(right),
            f"{len(binary)} binary and {len(sines)} sinusoidal patterns along one "
            f"axis, {both:.0f} along both",
        ),
    )


@figure("fig_3_9", needs=("fig_3_9",), evidence="rendered")
def fig_3_9(results):
    """A period of the rectified image with its fits, and misfits over gamma."""
    ran = results["fig_3_9"]
    profile = ran.arrays("linear.profile")[0]
    position = (np.arange(len(profile)) + 0.5) / len(profile)
    drawn, (left, right) = new_figure(1, 2, height_in=3.4)
    left.plot(
        position[::3],
        profile[::3],
        linestyle="",
        marker=".",
        color="#4a4a4a",
        label="column means",
    )
    data = {"place": position.tolist(), "profile": profile.tolist()}
    gammas = ran.conditions[0]["gammas"]
    for k, name in zip(HARMONICS, MODELS, strict=True):
        fit = ran.arrays(f"linear.fit_{k}")[0]
        left.plot(position, fit, **series(k) | {"marker": ""}, label=name)
        data[name] = fit.tolist()
        rms = [np.median(profile_column(ran, "linear", g, f"rms_{k}")) for g in gammas]
        right.plot(gammas, rms, **series(k), label=name)
    left.set(
        xlabel="Position (periods)",
        ylabel="Mean grey level (grey levels)",
        title=f"(a) Gamma {DATA_SHEET_GAMMA}",
    )
    left.legend(fontsize=8)
    for gamma, name, line in (
        (DATA_SHEET_GAMMA, "judged (data sheet)", "--"),
        (CHOSEN_GAMMA, "rig d200-lens", ":"),
    ):
        right.axvline(gamma, color="#4a4a4a", linewidth=1, linestyle=line, label=name)
    right.legend(handles=right.get_lines()[len(MODELS) :], fontsize=8)
    right.set(
        yscale="log",
        xlabel="Gamma of the monitor",
        ylabel="RMS misfit (grey levels)",
        title="(b) Misfit over gamma",
    )
    return Drawing(
        drawn,
        data,
        "Imaged sinusoidal pattern and fits of Fourier series. (a) One of eight "
        "periods: column means of a rendered, undistorted and rectified image of a "
        "linear camera. (b) RMS misfit of the same models over the gamma of the "
        "monitor, medians over the views. The gamma of rig d200-lens was chosen from "
        "the figure of the thesis, so the misfit there is no result.",
    )
