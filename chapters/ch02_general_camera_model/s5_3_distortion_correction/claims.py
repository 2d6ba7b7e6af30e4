"""The claim of section 2.5.3, tested as the registry words it."""

from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase, generic_wins
from chapters.shared.zoom_rigs import FACADE_ZOOM
from repro.run.experiment import claim


@claim(
    "c2_periphery",
    needs=OF_SEEDS,
    evidence="rendered",
    readings=("standard_method", "residual_scale", "interpolation"),
)
def judge_periphery(results, options):
    """Near the edge, generic lines are straighter than parametric ones."""
    case = ZoomCase(results, options)
    place = f"lines.{case.method('generic')}"
    generic, parametric = (
        case.column(f"{place}.{name}.{case.scale}", FACADE_ZOOM)
        for name in ("generic", "parametric")
    )
    return generic_wins(generic, parametric, "RMS distance from straight lines")
