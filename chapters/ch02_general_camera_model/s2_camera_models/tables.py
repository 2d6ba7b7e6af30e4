"""What the zoo of section 2.2 counts and measures of every camera, as tables."""

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.results import (
    FEWEST,
    NONE_MM,
    NONE_PX,
    fits_of,
)
from chapters.ch02_general_camera_model.s2_camera_models.trials.zoo import FAMILIES
from chapters.shared.zoo import ZOO
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table


@table("ext_zoo", needs=("exp_zoo",), evidence="analytic")
def ext_zoo(results):
    """Counts and measures of every camera."""
    ran = results["exp_zoo"].select()
    ends, trips, returned, centres = (
        ran.column(name)
        for name in ("model_end_deg", "round_trip_px", "returned", "centrality_mm")
    )
    stated = np.array(ran.texts("central"), dtype=bool)
    return Table(
        {
            "model": list(ZOO),
            "section": [model.section for model in ZOO.values()],
            "kind in the library": ran.texts("kind"),
            "parameters": [int(n) for n in ran.column("parameters")],
            "central": ["yes" if c else "no" for c in stated],
            "projects": ["yes" if p else "no" for p in ran.texts("projects")],
            "widest ray (deg)": list(ran.column("widest_deg")),
            "law ends (deg)": [x if np.isfinite(x) else None for x in ends],
            "from central (mm)": [0.0 if x < NONE_MM else x for x in centres],
            "round trip (px)": list(trips),
        },
        "One example camera of every model, 200 × 200 pixels. Widest ray: "
        "from the middle ray, within the image. Law ends: where the formula "
        "with the example's parameters stops. From central: smallest RMS "
        "distance of the rays from one point. Round trip: largest distance "
        "of a pixel from the projection of a point on its ray.",
        Check(
            bool(
                (returned == 1).all()
                and (trips < NONE_PX).all()
                and ((centres < NONE_MM) == stated).all()
            ),
            f"{100 * returned.min():.3g} % of the pixels come back (least "
            f"of all cameras), to {trips.max():.1g} px, and just the cameras "
            "that say so are central",
        ),
    )


@table("ext_zoo_scope", needs=("exp_zoo", "exp_zoo_mirrors"), evidence="analytic")
def ext_zoo_scope(results):
    """What each model can and cannot represent, with how many numbers."""
    ran, mirrors = (results[name].select() for name in ("exp_zoo", "exp_zoo_mirrors"))
    worst = mirrors.column("rms_px").max()
    return Table(
        {
            "model": list(ZOO),
            "parameters": [int(n) for n in ran.column("parameters")],
            "represents": [model.can for model in ZOO.values()],
            "does not represent": [m.cannot for m in ZOO.values()],
        },
        "What each model can and cannot represent. Parameters are those of "
        "the example camera.",
        Check(
            bool(worst < NONE_PX),
            f"the unified sphere is each central mirror, to {worst:.1g} px",
        ),
    )


@table("ext_zoo_few", needs=("exp_zoo_fits",), evidence="synthetic")
def ext_zoo_few(results):
    """How well models with few numbers follow the fisheye lens."""
    ran = results["exp_zoo_fits"]
    rows = []
    for family, free in FEWEST.items():
        counts, rms = fits_of(ran, "FC-E8", family)
        widest = float(np.degrees(FAMILIES[family][0]))
        rows.append((family, free, widest, float(rms[counts == free][0])))
    return Table(
        columns(("Model", "Radial numbers", "Fitted to (deg)", "RMS (px)"), rows),
        "Models with few numbers, fitted to the FC-E8 fisheye: what each "
        "leaves. Radial numbers include the focal length. Models of the "
        "image plane are fitted to 70° from the axis, the others to the "
        "lens's edge.",
    )
