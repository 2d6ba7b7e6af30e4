"""An Evaluation as JSON and as a line for people, and numbers in words."""

import math


def as_json(evaluation):
    """{images, rms_px, median_px, mean_deg, share_with_ray}; None for unknown."""
    return {
        "images": [
            {
                "file": image.name,
                "n_corners": int(image.n_corners),
                "n_without_ray": int(image.n_without_ray),
                **_errors(image),
                "T_camera_grid": _plain_pose(image.T_camera_grid),
                "T_camera_grid_by_angle": _plain_pose(image.T_camera_grid_by_angle),
                "reason": image.reason,
            }
            for image in evaluation.images
        ],
        **summary(evaluation),
    }


def summary(evaluation):
    """{rms_px, median_px, mean_deg, share_with_ray}"""
    return {**_errors(evaluation), "share_with_ray": known(evaluation.share_with_ray)}


def line(name, evaluation, point="corner"):
    """One line for people; what is not known is said in words. point: what is scored,
    as `raxel.sets.model` calls it."""
    if not evaluation.n_scored and not math.isfinite(evaluation.mean_deg):
        return f"{name}: no {point} could be scored"
    return (
        f"{name}: {told('mean angle', evaluation.mean_deg, '.4f', 'deg')}, "
        f"{told('rms', evaluation.rms_px, '.3f', 'px')}, "
        f"{told('median', evaluation.median_px, '.3f', 'px')}, "
        f"{100 * evaluation.share_with_ray:.1f} % of {point}s with a ray"
    )


def told(what, number, form, unit):
    """'rms 0.1 px', or 'rms unknown' for a number that is not finite."""
    return (
        f"{what} {number:{form}} {unit}" if math.isfinite(number) else f"{what} unknown"
    )


def known(number):
    """A float for JSON: None where it is not finite."""
    return float(number) if math.isfinite(number) else None


def _errors(scored):
    keys = "rms_px", "median_px", "mean_deg"
    return {key: known(getattr(scored, key)) for key in keys}


def _plain_pose(T):
    return None if T is None else T.tolist()
