"""The active grid of section 3.2.2 at work, its patterns, and the imaged sine."""

import numpy as np
from matplotlib.ticker import FixedFormatter, FixedLocator

from chapters.ch03_planar_grids.s2_2_active_grids.results import CAMERAS, profile_column
from chapters.ch03_planar_grids.s2_2_active_grids.trials.decoding import (
    PIXEL_SHARE,
    SHOWN_EVERY,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.profile import (
    DATA_SHEET_GAMMA,
    HARMONICS,
)
from chapters.shared.phase_steps import power_law_orders
from raxel.sets import patterns_of, plan_of_cells
from raxel.sets.patterns import pattern_picture
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

SHOWN_PX = (512, 384)
# Of rig d200-lens, chosen from the published fits of Fig. 3.9.
CHOSEN_GAMMA = 2.0
NAMES = ("bit 0", "bit 1", "bit 2")
MODELS = ("one sine", "one harmonic", "two harmonics")


@figure("ext_active_grid", needs=("ext_active_grid",), evidence="rendered")
def ext_active_grid(results):
    """Patterns along a row, what they decode to, and how far that is off."""
    strip, row, place, error = (
        results["ext_active_grid"].arrays(name)[0]
        for name in ("strip", "decoded_row", "location", "error")
    )
    drawn, axes = new_figure(2, 2, height_in=5.2)
    (top, along), (where, wrong) = axes
    height, width = np.array(place.shape) * SHOWN_EVERY
    top.imshow(
        strip,
        cmap="gray",
        vmin=0,
        vmax=255,
        aspect="auto",
        extent=(-0.5, width - 0.5, len(strip) - 0.5, -0.5),
        interpolation="nearest",
    )
    labels = [f"{n}{end}" for n in NAMES for end in ("", ", inverse")]
    labels += [f"sine, {90 * k}°" for k in range(4)]
    top.yaxis.set_major_locator(FixedLocator(range(len(labels))))
    top.yaxis.set_major_formatter(FixedFormatter(labels))
    top.tick_params(axis="y", labelsize=7)
    for axis in (top, where, wrong):
        axis.grid(False)
    top.set(title="(a) one row of ten pictures", xlabel="Column u (px)")
    along.plot(np.arange(len(row)), row, **series(0) | {"marker": ""})
    along.set(
        title="(b) decoded from it",
        xlim=(-0.5, width - 0.5),
        xlabel="Column u (px)",
        ylabel="Location along x (mm)",
    )
    extent = (-0.5, width - 0.5, height - 0.5, -0.5)
    for axis, picture, title, name, look in (
        (where, place, "(c) location along x", "x (mm)", {"cmap": "cividis"}),
        (
            wrong,
            1000 * error,
            "(d) distance from the truth",
            "error (µm)",
            {"cmap": "magma", "vmin": 0, "vmax": 100},
        ),
    ):
        shown = axis.imshow(
            np.ma.masked_invalid(picture),
            extent=extent,
            interpolation="nearest",
            **look,
        )
        axis.set_facecolor("#bbbbbb")
        axis.set(title=title, xlabel="Column u (px)", ylabel="Row v (px)")
        drawn.colorbar(shown, ax=axis, shrink=0.85, label=name)
    where.axhline(
        int(PIXEL_SHARE[1] * height), color="white", linewidth=1, linestyle="--"
    )
    data = {"u": list(range(len(row))), "x (mm)": row.tolist()}
    data |= {label: line.tolist() for label, line in zip(labels, strip, strict=True)}
    return Drawing(
        drawn,
        data,
        "Ten pictures tell every pixel where on the monitor it looks. (a) One row of "
        "the pictures that encode x; (b) what the decoder makes of it; (c) the whole "
        "view, with that row dashed; (d) what is left wrong, whose ripple is that of "
        "the monitor's gamma. Grey: masked.",
    )


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


@figure("ext_harmonics_gamma", needs=("fig_3_9",), evidence="rendered")
def ext_harmonics_gamma(results):
    """Orders 2 and 3 in the picture, beside those of a power law."""
    ran = results["fig_3_9"]
    gammas = ran.conditions[0]["gammas"]
    drawn, both = new_figure(1, 2, height_in=3.0, sharey=True)
    data = {"gamma": list(gammas)}
    fine = np.linspace(gammas[0], gammas[-1], 81)
    law = np.abs([power_law_orders(g, 3) for g in fine])
    for axes, camera in zip(both, CAMERAS, strict=True):
        for k, n in enumerate((2, 3)):
            ratios = [
                profile_column(ran, camera, g, f"order_{n}")
                / profile_column(ran, camera, g, "order_1")
                for g in gammas
            ]
            percent = 100 * np.median(ratios, axis=1)
            points = series(k) | {"linestyle": "", "label": f"order {n}, imaged"}
            axes.plot(gammas, percent, **points)
            if camera == "linear":
                line = series(k) | {"marker": "", "label": f"order {n}, power law"}
                axes.plot(fine, 100 * law[:, n - 1], **line)
            data[f"{camera}, order {n} (%)"] = percent.tolist()
        axes.set(title=f"camera: {camera}", xlabel="Gamma of the monitor (1)")
    both[0].set(ylabel="Amplitude (% of order 1)")
    both[0].legend(fontsize=8)
    return Drawing(
        drawn,
        data,
        "Order 3 of a power law vanishes at gammas of 1 and 2, where order 2 grows. "
        "Orders in the imaged period for two cameras, beside the closed form of "
        "Appendix A.",
    )


@figure("ext_cell_edge", needs=("ext_wrap_rule",), evidence="rendered")
def ext_cell_edge(results):
    """The edge of a cell along a row: bits, place in the cell, and location."""
    ran = results["ext_wrap_rule"]
    names = ("u", "pattern", "inverse", "d", "printed", "decoder", "true")
    row = {name: ran.arrays(f"edge.{name}")[0].astype(float) for name in names}
    drawn, (left, middle, right) = new_figure(1, 3, height_in=3.0)
    for axes, k, name, label in (
        (left, 0, "pattern", "pattern"),
        (left, 1, "inverse", "inverse"),
        (middle, 2, "d", None),
        (right, 1, "printed", "(3.24) alone"),
        (right, 0, "decoder", "decoder"),
    ):
        axes.plot(row["u"], row[name], **series(k), markersize=3, label=label)
    for axes in (left, right):
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.4 * (high - low))
        axes.legend(fontsize=8, loc="upper left")
    for axes, title, quantity in (
        (left, "(a) the bit that changes", "Grey value (grey levels)"),
        (middle, "(b) place in the cell, d", "d (1)"),
        (right, "(c) location", "Location along x (mm)"),
    ):
        axes.set(title=title, xlabel="Column u (px)", ylabel=quantity)
    off = np.abs(row["decoder"] - row["true"]).max()
    width = ran.column("edge.width_mm")[0]
    return Drawing(
        drawn,
        {name: values.tolist() for name, values in row.items()},
        "At the edge of a cell the bit and the phase need not change in one pixel; "
        "then (3.24) alone jumps by a cell. (a) A pattern and its inverse cross in the "
        "middle, however blurred; (b) the phase has an edge of its own; (c) the "
        "decoder goes by the phase. Blur of 2 px.",
        Check(
            bool(off < width / 4),
            f"along this row the decoder is off by {off:.2f} mm at most, where a cell "
            f"has {width:.0f} mm",
        ),
    )
