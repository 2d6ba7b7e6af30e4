"""The table of section 4.1.3: two forms of a ray."""

from repro.run.experiment import table
from repro.run.outcomes import Table

PIXELS = 3008 * 2000


@table("ext_ray_forms", needs=("exp_c4_mats_intersection",), evidence="analytic")
def ray_forms(results):
    """What a ray costs as a matrix and as a direction."""
    result = results["exp_c4_mats_intersection"]
    found = [
        float(result.column(name)[0]) for name in ("bytes_a_ray", "least_bytes_a_ray")
    ]
    return Table(
        {
            "Ray as": ["Plücker matrix (2.11)", "direction, one centre for all"],
            "Bytes (1)": found,
            "3008 × 2000 pixels (MB)": [round(size * PIXELS / 1e6) for size in found],
            "Largest difference (1)": [float(result.column("printed").max()), None],
        },
        "What a ray of a central camera costs in two forms. The difference "
        "is that of (4.15) from each ray's own product with the plane, as a "
        "share of the point's largest coordinate.",
    )
