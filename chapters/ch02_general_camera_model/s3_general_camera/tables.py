"""What two known grids give for three cameras, as a table."""

from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Table


@table("ext_any_camera", needs=("exp_c2_nonparam_any",), evidence="synthetic")
def any_camera(results):
    """Largest errors of the rays, and how far neighbours differ."""
    largest = ("angle_rad", "gap_mm", "jump_deg")
    rows = [
        [camera, *(float(rays.column(name).max()) for name in largest)]
        for camera, rays in results["exp_c2_nonparam_any"].by("camera").items()
    ]
    names = (
        "Camera",
        "Ray, largest error (rad)",
        "Distance from the true ray (mm)",
        "Largest jump between neighbours (deg)",
    )
    return Table(
        columns(names, rows),
        "Every pixel of three cameras, calibrated by two known grids without "
        "noise. The errors are rounding, whether the rays of neighbouring "
        "pixels jump or not.",
    )
