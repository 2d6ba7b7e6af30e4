"""How well rays tell the length of a motion, foretold and found."""

from chapters.guides.rays_without_a_centre.results import STEPS, foretold, found
from chapters.guides.rays_without_a_centre.trials import DEFLECTIONS_MM
from repro.page.style import INK, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

PANELS = {
    "length_percent": "Length off (% of the one found)",
    "turn_deg": "Rotation off (degrees)",
}
FORETOLD = {"color": INK, "linestyle": ":", "marker": ""}


@figure("ext_ray_motion_told", needs=("ext_ray_motion_steps",), evidence="synthetic")
def ext_ray_motion_told(results):
    """Errors of length and rotation against the deflection of the mirror."""
    result, rows = results[STEPS], []
    drawn, axes = new_figure(1, 2, height_in=3.6)
    for panel, (name, label) in zip(axes, PANELS.items(), strict=True):
        ways = {"robust": "nothing known"}
        if name == "turn_deg":
            ways["held"] = "length given"
        for index, (way, words) in enumerate(ways.items()):
            rows += plot_estimates(
                panel,
                DEFLECTIONS_MM,
                found(result, f"{way}.{name}"),
                (name, words),
                look=series(index),
                label=words,
                bars=True,
            )
        told = foretold(result, name)
        panel.plot(DEFLECTIONS_MM, told, label="foretold", **FORETOLD)
        rows += [(name, "foretold", d, x, x, x) for d, x in
                 zip(DEFLECTIONS_MM, told, strict=True)]  # fmt: skip
        panel.set(xlabel="Deflection (mm)", ylabel=label, xscale="log")
        panel.set_xticks(DEFLECTIONS_MM, [f"{d:g}" for d in DEFLECTIONS_MM])
        panel.minorticks_off()
        panel.set_ylim(bottom=0)
        panel.legend()
    return Drawing(
        drawn,
        columns(("error", "way", "deflection_mm", "median", "low", "high"), rows),
        "How far length and rotation of a step of 25 mm are off, by how far the mirror "
        f"is bent: medians over {result.trials_per_condition} scenes with 95 % "
        "intervals. *Foretold*: the medians that the information of the rays gives, "
        "nothing known.",
    )
