"""The active grid of section 3.2.2 at work, its patterns, and the imaged sine."""

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
    """The patterns of the vertical axis, as the monitor is sent them."""
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
        "The ten patterns that encode the vertical location: (a) three bits of a Gray "
        "code for eight cells, each with its inverse; (b) the sine, moved by 90° from "
        "one to the next.",
        Check(
            bool(right),
            f"{len(binary)} binary and {len(sines)} sinusoidal patterns along one "
            f"axis, {both:.0f} along both",
        ),
    )


@figure("fig_3_9", needs=("fig_3_9",), evidence="rendered")
def fig_3_9(results):
    """A period of the rectified picture with its fits, and misfits over gamma."""
    ran = results["fig_3_9"]
    profile = ran.arrays("linear.profile")[0]
    place = (np.arange(len(profile)) + 0.5) / len(profile)
    drawn, (left, right) = new_figure(1, 2, height_in=3.4)
    left.plot(
        place[::3],
        profile[::3],
        linestyle="",
        marker=".",
        color="#4a4a4a",
        label="column means",
    )
    data = {"place": place.tolist(), "profile": profile.tolist()}
    gammas = ran.conditions[0]["gammas"]
    for k, name in zip(HARMONICS, MODELS, strict=True):
        fit = ran.arrays(f"linear.fit_{k}")[0]
        left.plot(place, fit, **series(k) | {"marker": ""}, label=name)
        data[name] = fit.tolist()
        rms = [np.median(profile_column(ran, "linear", g, f"rms_{k}")) for g in gammas]
        right.plot(gammas, rms, **series(k), label=name)
    left.set(
        xlabel="Place in the period (periods)",
        ylabel="Mean grey level (grey levels)",
        title=f"(a) gamma {DATA_SHEET_GAMMA}",
    )
    left.legend(fontsize=8)
    for gamma, name, line in (
        (DATA_SHEET_GAMMA, "judged: data sheet", "--"),
        (CHOSEN_GAMMA, "set: d200-lens", ":"),
    ):
        right.axvline(gamma, color="#4a4a4a", linewidth=1, linestyle=line, label=name)
    right.legend(handles=right.get_lines()[len(MODELS) :], fontsize=8)
    right.set(
        yscale="log",
        xlabel="Gamma of the monitor (1)",
        ylabel="RMS misfit (grey levels)",
        title="(b) misfit against gamma",
    )
    return Drawing(
        drawn,
        data,
        "One sine does not fit the imaged profile, one harmonic more does. (a) One of "
        "eight periods: means over the columns of a rendered picture, undistorted and "
        "rectified, with a camera that answers in proportion; (b) RMS misfit of the "
        "same models for other gammas, medians over the views. The gamma of rig "
        "d200-lens was chosen from the thesis's figure: what comes out there is set.",
    )
