"""Results of the commands, and the numbers of the prose."""

NAMES = {"zhang": "Zhang", "opencv_fisheye": "OpenCV fisheye", "generic": "Generic"}
SETS = ("inner", "all")
CAMERA, VIEWS = "ext_fisheye_camera", "ext_fisheye_look"
FOUND, SCORES = "ext_fisheye_found", "ext_fisheye_scores"
COMMANDS = (FOUND, CAMERA, VIEWS)


def output_of(result, command):
    """Return what a command printed."""
    return result.texts(f"said.{command}")[0]


def numbers(results):
    """Return the texts of the prose: name -> value."""
    found, camera = results[FOUND], results[CAMERA]
    detected, boards = (int(found.column(name)[0]) for name in ("found", "boards"))
    warnings = output_of(camera, "calibrate").count("warning:")
    ray_share, fitted, kept = (
        camera.column(name)[0] for name in ("ray_share", "fitted_px", "kept_out_px")
    )
    return {
        "ray_share": percent(ray_share),
        "found_of": f"{detected} of {boards}",
        "warnings": str(warnings) if warnings else "none",
        "fitted_px": f"{fitted:.2g} px",
        "kept_px": f"{kept:.2g} px",
    }


def percent(share):
    """Return a share as text."""
    return f"{100 * share:.0f} %"
