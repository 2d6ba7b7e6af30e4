"""What the walk through a calibration found, and the numbers of the prose."""

import numpy as np

from chapters.guides.fisheye_in_ten_minutes.trials.boards import (
    SIZES,
    inner_boards,
    places_of,
)
from chapters.guides.fisheye_in_ten_minutes.trials.commands import ASIDE_DEG
from chapters.guides.fisheye_in_ten_minutes.trials.models import MODELS, lit

NAMES = {"zhang": "Zhang", "opencv_fisheye": "OpenCV fisheye", "generic": "Generic"}
SETS = ("inner", "all")
GOAL = 0.9
CAMERA, VIEWS = "ext_fisheye_camera", "ext_fisheye_look"
FOUND, SCORES = "ext_fisheye_found", "ext_fisheye_scores"
RECORD = "ext_calibration_record"
FISHEYES = ("wide-", "fisheye-")  # how names of the record begin
OPENED = (FOUND, CAMERA, VIEWS, SCORES, RECORD)
COMMANDS = (FOUND, CAMERA, VIEWS)


def said(result, command):
    """What a command printed."""
    return result.texts(f"said.{command}")[0]


def numbers(results, effort):
    """Numbers and texts of the prose: name -> value."""
    size = SIZES[effort]
    found, camera, views, scores = (results[n] for n in (FOUND, CAMERA, VIEWS, SCORES))
    right, pictures = (int(found.column(name)[0]) for name in ("right", "boards"))
    warnings = said(camera, "calibrate").count("warning:")
    circle = float(np.mean(lit(size)))
    ray_share, fitted, kept = (
        camera.column(name)[0] for name in ("ray_share", "fitted_px", "kept_out_px")
    )
    out = {
        "boards": len(places_of(size.plan)),
        "inner": inner_boards(size.plan),
        "half_boards": size.plan[1].boards,
        "half_deg": size.plan[1].polar_deg,
        "rim_boards": len(places_of(size.plan)) - inner_boards(size.plan),
        "rim_deg": size.plan[-1].polar_deg,
        "columns": size.columns,
        "rows": size.rows,
        "pitch": size.pitch_mm,
        "aside": ASIDE_DEG,
        "circle": percent(circle),
        "goal": percent(GOAL * circle),
        "ray_share": percent(ray_share),
        "found_of": f"{right} of {pictures}",
        "warnings": str(warnings) if warnings else "none",
        "fitted_px": f"{fitted:.2g} px",
        "kept_px": f"{kept:.2g} px",
        "difference": int(views.column("largest_difference")[0]),
    }
    for name in MODELS:
        for use in SETS:
            for what, words in told_scores(scores, name, use).items():
                out[f"{name}.{use}.{what}"] = words
    return out | recorded(results[RECORD])


def recorded(kept):
    """Errors of the generic camera on the real cameras of the record, in words."""
    errors = kept.select().column("models.generic.px")
    fisheyes = [
        f"{px:.2g}"
        for px, one in zip(errors, kept.conditions, strict=True)
        if one["set"].startswith(FISHEYES)
    ]
    known = errors[np.isfinite(errors)]
    return {
        "real.px": f"{known.min():.2g} to {known.max():.2g} px",
        "real.fisheyes": f"{', '.join(fisheyes)} px",
    }


def told_scores(scores, name, use):
    """Error in the pictures kept out, share with rays, and ray error of a model."""
    if scores.texts(f"{name}.reason", boards=use)[0]:
        return dict.fromkeys(("px", "image", "ray"), "refused")
    kept, image, ray = (
        float(scores.column(f"{name}.{what}", boards=use)[0])
        for what in ("kept_out_px", "image_with_ray", "ray_deg")
    )
    return {"px": f"{kept:.2g} px", "image": percent(image), "ray": f"{ray:.2g}°"}


def percent(share):
    """A share in words."""
    return f"{100 * share:.0f} %"
