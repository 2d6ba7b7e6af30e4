"""Where a deflection scatters, and where a scene ray turns."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.curvature import ray_turns
from chapters.ch05_flexible_mirror.s3_3_deflections.results.tips import Tips
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.tip import ALONG_MM
from chapters.shared.mirror_bench import ABERRATION_UM, BENCHES
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from repro.page.style import INK, legend_below, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing


@figure(
    "ext_tip_scatter",
    needs=("exp_c5_extrapolated_tip", "exp_c5_extrapolated_tip_swept"),
    evidence="rendered",
)
def ext_tip_scatter(results):
    """SD of the deflection's error along the mirror, on both benches."""
    drawn, axes = new_figure(height_in=3.6)
    rows = []
    for k, bench in enumerate(BENCHES):
        sd = Tips.on(results, bench).along_sd
        known = np.isfinite(sd)
        every = series(k) | {"markevery": 3}
        axes.plot(ALONG_MM[known], 1000 * sd[known], label=bench, **every)
        rows += [
            (bench, x, 1000 * one)
            for x, one in zip(ALONG_MM[known], sd[known], strict=True)
        ]
    last = float(np.median(Tips.on(results, "bench").of("last_mm")))
    for x, line, name in (
        (last, "--", "last corner"),
        (mirror_rig("A").load_mm, ":", "load"),
    ):
        axes.axvline(x, color=INK, linestyle=line, marker="", label=name)
    axes.set(yscale="log", xlabel="Distance from the clamp (mm)")
    axes.set_ylabel("SD of the deflection (µm)")
    legend_below(drawn, axes, ncols=4)
    seeds = results["exp_c5_extrapolated_tip"].trials_per_condition
    return Drawing(
        drawn,
        columns(("bench", "along_mm", "sd_um"), rows),
        "How far the error of a deflection of 5 mm scatters over "
        f"{seeds} seeds, along the mirror's middle line. The last corner that both "
        f"pictures show is {last:.0f} mm from the clamp (median), the load acts beyond "
        "it, and what is found there is carried on by the spline.",
    )


@figure("ext_ray_turns", needs=(), evidence="analytic")
def ext_ray_turns(results):
    """Turn of the scene ray for each mm of the mirror, even and uneven."""
    drawn, panels = new_figure(1, 2, height_in=3.6, sharey=True)
    rows = []
    for panel, (title, uneven) in zip(
        panels, {"even": 0.0, "uneven": ABERRATION_UM}.items(), strict=True
    ):
        turns = ray_turns(mirror_rig("A").camera(STAGES_MM[-1], uneven, 0))
        twice = np.degrees(2 * np.abs(turns.curvature))
        mirror, whole = np.degrees(turns.mirror), np.degrees(turns.whole)
        look = {"linestyle": "", "markevery": 3}
        panel.plot(turns.x, twice, color=INK, marker="", label="twice the curvature")
        panel.plot(turns.x, mirror, label="viewing ray kept", **series(0) | look)
        every = series(1) | {"markevery": 6}
        panel.plot(turns.x, whole, label="viewing ray of each place", **every)
        panel.set(title=title, xlabel="Distance from the clamp (mm)")
        rows += [
            (title, *row) for row in zip(turns.x, twice, mirror, whole, strict=True)
        ]
    panels[0].set_ylabel("Turn of the scene ray (deg/mm)")
    legend_below(drawn, panels[0], ncols=3)
    return Drawing(
        drawn,
        columns(
            ("mirror", "along_mm", "twice_deg_mm", "kept_deg_mm", "own_deg_mm"), rows
        ),
        "How far the scene ray turns if its reflection point lies 1 mm farther along "
        f"the mirror of geometry A, pushed by {STAGES_MM[-1]:g} mm: twice the "
        "curvature by the mirror alone, and more with the viewing ray that belongs to "
        f"each place. Right: a mirror uneven by {ABERRATION_UM:g} µm (RMS), one seed.",
    )
