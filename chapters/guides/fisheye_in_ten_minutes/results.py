"""What the walk through a calibration found, and the numbers of the prose."""

from chapters.guides.fisheye_in_ten_minutes.trials.boards import (
    SIZES,
    inner_boards,
    places_of,
)

NAMES = {"zhang": "Zhang", "opencv_fisheye": "OpenCV fisheye", "generic": "Generic"}
SETS = ("inner", "all")
CAMERA, VIEWS = "ext_fisheye_camera", "ext_fisheye_look"
FOUND, SCORES = "ext_fisheye_found", "ext_fisheye_scores"
COMMANDS = (FOUND, CAMERA, VIEWS)


def said(result, command):
    """What a command printed."""
    return result.texts(f"said.{command}")[0]


def numbers(results, effort):
    """Numbers and texts of the prose: name -> value."""
    size = SIZES[effort]
    found, camera = results[FOUND], results[CAMERA]
    seen, pictures = (int(found.column(name)[0]) for name in ("found", "boards"))
    warnings = said(camera, "calibrate").count("warning:")
    ray_share, fitted, kept = (
        camera.column(name)[0] for name in ("ray_share", "fitted_px", "kept_out_px")
    )
    return {
        "boards": len(places_of(size.plan)),
        "inner": inner_boards(size.plan),
        "half_boards": size.plan[1].boards,
        "half_deg": size.plan[1].polar_deg,
        "rim_boards": len(places_of(size.plan)) - inner_boards(size.plan),
        "rim_deg": size.plan[-1].polar_deg,
        "columns": size.columns,
        "rows": size.rows,
        "pitch": size.pitch_mm,
        "ray_share": percent(ray_share),
        "found_of": f"{seen} of {pictures}",
        "warnings": str(warnings) if warnings else "none",
        "fitted_px": f"{fitted:.2g} px",
        "kept_px": f"{kept:.2g} px",
    }


def percent(share):
    """A share in words."""
    return f"{100 * share:.0f} %"
