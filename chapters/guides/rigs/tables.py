"""All rigs in one table."""

from chapters.guides.rigs.results import pose_numbers
from chapters.guides.rigs.trials import NAMES
from repro.run.experiment import table
from repro.run.outcomes import Table


@table("ext_rigs_in_numbers", needs=("ext_rigs",), evidence="analytic")
def ext_rigs_in_numbers(results):
    """Field of view, picture and poses of every rig."""
    ran, rows = results["ext_rigs"], []
    for name in NAMES:
        distances, tilts = pose_numbers(ran, name)
        width, height, seen = (
            float(ran.column(value, rig=name)[0])
            for value in ("width_px", "height_px", "seen_deg")
        )
        rows.append(
            {
                "Rig": name,
                "Field of view (deg)": seen,
                "Width (px)": int(width),
                "Height (px)": int(height),
                "Poses": len(distances),
                "Nearest (mm)": float(distances.min()),
                "Farthest (mm)": float(distances.max()),
                "Largest tilt (deg)": float(tilts.max()),
                "Whole target in view": int(ran.column("whole", rig=name)[0]),
            }
        )
    return Table(
        {key: [row[key] for row in rows] for key in rows[0]},
        "Every rig: how wide it sees, its picture, and where its targets "
        "stand. Distances from the point that is nearest to all rays.",
    )
