"""All rigs in one table."""

from chapters.guides.rigs.trials import NAMES
from repro.run.experiment import table
from repro.run.outcomes import Table


@table("ext_rigs_in_numbers", needs=("ext_rigs",), evidence="analytic")
def ext_rigs_in_numbers(results):
    """Field of view, picture and poses of every rig."""
    ran = results["ext_rigs"].select()
    distances = ran.arrays("distance_mm")
    return Table(
        {
            "Rig": NAMES,
            "Field of view (deg)": ran.column("seen_deg").tolist(),
            "Width (px)": ran.column("width_px").astype(int).tolist(),
            "Height (px)": ran.column("height_px").astype(int).tolist(),
            "Poses": [len(poses) for poses in distances],
            "Nearest (mm)": [float(poses.min()) for poses in distances],
            "Farthest (mm)": [float(poses.max()) for poses in distances],
            "Largest tilt (deg)": [float(t.max()) for t in ran.arrays("tilt_deg")],
            "Whole target in view": ran.column("whole").astype(int).tolist(),
        },
        "Each rig here: how wide it sees, its picture, and where its targets "
        "stand. Distances from the point that is nearest to all rays.",
    )
