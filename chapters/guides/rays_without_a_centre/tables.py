"""Motion of a step, by how far the mirror is bent."""

import numpy as np

from chapters.guides.rays_without_a_centre.results import STEPS, WAYS, sizes
from chapters.guides.rays_without_a_centre.trials import DEFLECTIONS_MM
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table("ext_ray_motion", needs=("ext_ray_motion_steps",), evidence="synthetic")
def ext_ray_motion(results):
    """Spread of the rays, rotation of each way, length, at every deflection."""
    result, rows = results[STEPS], []
    for d in DEFLECTIONS_MM:
        spread = float(np.median(result.column("spread_mm", deflection_mm=d)))
        turns = (Measured.median(sizes(result, f"{way}.turn_deg", d)) for way in WAYS)
        length = Measured.median(sizes(result, "robust.length_percent", d))
        rows.append((d, spread, *turns, length))
    names = (f"Rotation off (deg), {words}" for words in WAYS.values())
    return Table(
        columns(
            ("Deflection (mm)", "Spread of the rays (mm)", *names, "Length off (%)"),
            rows,
        ),
        "A step aside between two pictures, and the motion found from matched rays of "
        f"which three in ten are wrong: medians over {result.trials_per_condition} "
        "scenes with 95 % intervals. *Spread*: RMS distance of the rays from the point "
        "next to all of them. *Length off*: robust and refined, where nothing is known "
        "of it, in percent of the length found, so that one without end is 100 % off.",
    )
