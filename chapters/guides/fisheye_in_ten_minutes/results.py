"""What the walk through a calibration found, and the numbers of the prose."""

import json

import numpy as np

from chapters.guides.fisheye_in_ten_minutes.trials.boards import (
    SIZES,
    inner_boards,
    places_of,
)
from chapters.guides.fisheye_in_ten_minutes.trials.commands import ASIDE_DEG
from chapters.guides.fisheye_in_ten_minutes.trials.models import (
    ANYWHERE,
    MODELS,
    PLANNED,
    lit,
)
from chapters.shared.photographs.compared import compared_sets
from repro.judge.statistics import median_interval
from repro.page.wording import literal

NAMES = {"zhang": "Zhang", "opencv_fisheye": "OpenCV fisheye", "generic": "Generic"}
SETS = ("inner", "all")
GOAL = 0.9
CAMERA, VIEWS = "ext_fisheye_camera", "ext_fisheye_look"
FOUND, SCORES = "ext_fisheye_found", "ext_fisheye_scores"
DRAWN, RECORD = "ext_fisheye_draws", "ext_calibration_record"
STUDY = "photograph_study"
WIDE_DEG = 50.0  # from the axis
SEVERAL = 3.0
FISHEYES = ("wide-", "fisheye-")  # how names of the record begin
OPENED = (FOUND, CAMERA, VIEWS, SCORES, DRAWN, RECORD)
COMMANDS = (FOUND, CAMERA, VIEWS)


def said(result, command):
    """What a command printed."""
    return result.texts(f"said.{command}")[0]


def corner_file(found):
    """The content of corners.json."""
    return json.loads(found.arrays("corners")[0].tobytes())["images"]


def residual_rms(camera, kept_out):
    """RMS (px) of the residuals of the boards kept out, or of the others."""
    use = camera.arrays("kept_out")[0] == kept_out
    lengths = np.linalg.norm(camera.arrays("residuals")[0][use], axis=1)
    return float(np.sqrt(np.nanmean(lengths**2)))


def shares(drawn, held):
    """Coverage (draws, boards) of one way of holding the boards."""
    return np.array(drawn.arrays("shares", held=held))


def boards_for(drawn, held, goal):
    """Boards until the goal is covered, one number a draw; NaN where never."""
    reached = shares(drawn, held) >= goal
    return np.where(reached.any(axis=1), reached.argmax(axis=1) + 1.0, np.nan)


def numbers(results, effort):
    """Numbers and texts of the prose: name -> value."""
    size = SIZES[effort]
    found, camera, views, scores, drawn = (
        results[name] for name in (FOUND, CAMERA, VIEWS, SCORES, DRAWN)
    )
    right, pictures = (int(found.column(name)[0]) for name in ("right", "boards"))
    warnings = said(camera, "calibrate").count("warning:")
    circle = float(np.mean(lit(size)))
    planned, random = shares(drawn, PLANNED), shares(drawn, ANYWHERE)
    needed = boards_for(drawn, PLANNED, GOAL)
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
        "ray_share": percent(np.mean(camera.arrays("mask")[0])),
        "found_of": f"{right} of {pictures}",
        "warnings": str(warnings) if warnings else "none",
        "fitted_px": f"{residual_rms(camera, False):.2g} px",
        "kept_px": f"{residual_rms(camera, True):.2g} px",
        "difference": int(views.column("largest_difference")[0]),
        "draws": drawn.trials_per_condition,
        "most": random.shape[1],
        "planned": percent(np.median(planned[:, -1])),
        "needed": told_boards(needed),
        "random_same": percent(np.median(random[:, planned.shape[1] - 1])),
        "random_most": percent(np.median(random[:, -1])),
        "random_needed": told_reached(boards_for(drawn, ANYWHERE, GOAL)),
        "opencv_inner": outcomes(drawn, PLANNED, "inner"),
        "opencv_all": outcomes(drawn, PLANNED, "all"),
        "opencv_anywhere": outcomes(drawn, ANYWHERE, "all"),
        "reach_all": reach(drawn, PLANNED, "all"),
        "reach_inner": reach(drawn, PLANNED, "inner"),
        "reach_anywhere": reach(drawn, ANYWHERE, "all"),
    }
    for name in MODELS:
        for use in SETS:
            for what, words in told_scores(scores, name, use).items():
                out[f"{name}.{use}.{what}"] = words
    return out | recorded(results[RECORD])


def recorded(kept):
    """What the record of real cameras says, in words."""

    of_sets = kept.select().column
    errors = {model: of_sets(f"models.{model}.px") for model in NAMES}
    fisheyes = [
        f"{px:.2g}"
        for px, one in zip(errors["generic"], kept.conditions, strict=True)
        if one["set"].startswith(FISHEYES)
    ]
    generic = errors["generic"][np.isfinite(errors["generic"])]
    far = np.count_nonzero(errors["opencv_fisheye"] > SEVERAL * errors["generic"])
    without = of_sets("models.opencv_fisheye.parts_without_camera")
    parts = of_sets("parts")
    found, pictures = of_sets("boards_found"), of_sets("pictures")
    return {
        "real.sets": len(kept.conditions),
        "real.found_of": f"{found.sum():.0f} of {pictures.sum():.0f}",
        "real.px": f"{generic.min():.2g} to {generic.max():.2g} px",
        "real.fisheyes": f"{', '.join(fisheyes)} px",
        "real.without": f"{without.sum():.0f} of {parts.sum():.0f}",
        "real.best": ", ".join(best_of(errors)),
        "real.far": f"{far} of {len(kept.conditions)} sets",
    }


def best_of(errors):
    """In how many sets each model has the smallest median, in words."""
    first = np.nanargmin(list(errors.values()), axis=0)
    return [
        f"{NAMES[model]} in {np.count_nonzero(first == place)}"
        for place, model in enumerate(errors)
    ]


def told_scores(scores, name, use):
    """Error in the pictures kept out, share with rays, and ray error of a model."""
    if scores.texts(f"{name}.reason", boards=use)[0]:
        return dict.fromkeys(("px", "image", "ray"), "refused")
    kept, image, ray = (
        float(scores.column(f"{name}.{what}", boards=use)[0])
        for what in ("kept_out_px", "image_with_ray", "ray_deg")
    )
    return {"px": f"{kept:.2g} px", "image": percent(image), "ray": f"{ray:.2g}°"}


def reach(drawn, held, boards):
    """Median of the largest angle (deg) of a corner from the axis, in words."""
    found = drawn.column(f"{boards}.reach_deg", held=held)
    return f"{median_interval(found).value:.0f}°"


def percent(share):
    """A share in words."""
    return f"{100 * share:.0f} %"


def told_boards(needed):
    """How many boards it took, in words; a draw that never got there is said."""
    got = needed[np.isfinite(needed)]
    if not len(got):
        return "more pictures than the plan has"
    low, high = int(got.min()), int(got.max())
    text = f"{low} pictures" if low == high else f"{low} to {high} pictures"
    missed = len(needed) - len(got)
    return text + (f" (not reached in {missed} draws)" if missed else "")


def told_reached(needed):
    """In how many draws the goal was reached, in words."""
    return f"{int(np.isfinite(needed).sum())} of {len(needed)} draws"


def outcomes(drawn, held, boards):
    """How often OpenCV's model was right, lost or refused, in words."""
    count = drawn.texts(f"{boards}.outcome", held=held).count
    return (
        f"right in {count('right')}, far off in {count('lost')}, and "
        f"refused in {count('refused')}"
    )


def steps_taken(seconds):
    """The steps, with what, and seconds by the records of the runs."""
    return [
        ("install", "`pip install .`", "once, some minutes"),
        ("print and glue", "the script above", "5 min"),
        ("photograph, write `set.yaml`", "a camera, an editor", "5 min"),
        ("find corners", "`raxel corners`", seconds(FOUND)),
        ("calibrate, evaluate", "`raxel calibrate`, `raxel evaluate`", seconds(CAMERA)),
        ("correct", "`raxel undistort`, `cv2.remap`", seconds(VIEWS)),
    ]


def wide_sets(study):
    """The image sets of this build whose lens is wide, as `compared_sets` has them."""
    return [one for one in compared_sets(study) if one.widest_deg > WIDE_DEG]


def photographs(study):
    """Which image sets of this build are of wide lenses, in words."""
    links = [
        f"[{literal(one.name)}](../photographs/{one.name}.ipynb)"
        for one in wide_sets(study)
    ]
    if not links:
        return (
            "This build has no photographs of a wide lens; name a set of "
            "yours, and it gets a page."
        )
    return f"In this build: {', '.join(links)}."
