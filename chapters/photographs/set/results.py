"""What a study says in words. Every sentence is complete whatever happened."""

from collections import Counter

import numpy as np

from chapters.shared.photographs.reading import (
    NAMES,
    PEER,
    column,
    decided,
    paired,
    share_with_ray,
)
from repro.judge.statistics import median_interval, wins
from repro.page.wording import literal


def about(study):
    """What was photographed, with what, and in which unit lengths come out."""
    s = study.settings
    camera = literal(s["camera"])
    text = f"The camera: {camera}. " if camera else ""
    text += f"Its images are {s['width_px']} × {s['height_px']} px. "
    counted = s["columns"] and s["rows"]
    size = f"{s['columns']} × {s['rows']}" if counted else "an unknown number of"
    text += f"The chessboard has {size} interior corners"
    if s["pitch_mm"] is None:
        return text + (
            "; its pitch is not known, so lengths come out in units of the pitch."
        )
    return text + f" at a pitch of {s['pitch_mm']:g} mm."


def found(study):
    """How many boards were found, and why the others were not."""
    count = len(study.images)
    text = (
        f"The detector {study.settings['detector']} found the board in "
        f"{len(study.found)} of {_photographs(count)}."
    )
    reasons = Counter(i.reason for i in study.images if not i.found)
    if reasons:
        text += f" What it said of the others: {_counted(reasons)}."
    evaluated = sum(image.use == "evaluate" for image in study.images)
    if evaluated:
        text += f" {_photographs(evaluated).capitalize()} only judged the calibration."
    return text


def zhang(study):
    """The camera of Zhang's method, or why there is none."""
    why = study.refusal("zhang")
    if why:
        return f"Zhang's method gave no camera ({literal(why)})."
    n = {
        name: study.fit(f"zhang.{name}")
        for name in ("fx_px", "fy_px", "u0_px", "v0_px", "k1", "k2", "rms_px")
    }
    return (
        f"Zhang's method gives focal lengths of {n['fx_px']:.1f} and "
        f"{n['fy_px']:.1f} px, the principal point ({n['u0_px']:.1f}, "
        f"{n['v0_px']:.1f}) px, and radial terms of {n['k1']:.3f} and "
        f"{n['k2']:.3f}. Its own adjustment leaves {n['rms_px']:.3g} px RMS."
    )


def general(study):
    """The camera of the generic method, or why there is none."""
    why = study.refusal("general")
    if why:
        return f"The generic method gave no general camera ({literal(why)})."
    boards = len(study.in_sample)
    used = int(study.fit("general.boards"))
    text = (
        f"The generic method took in {used} of {boards} boards and gives a ray to "
        f"{study.fit('general.rays'):,.0f} pixels, "
        f"{100 * study.fit('general.share_with_ray'):.0f} % of the image."
    )
    reasons = Counter(study.left_out.values())
    if reasons:
        text += f" Why it left boards out: {_counted(reasons)}."
    return text


def peer(study):
    """What OpenCV's fisheye model makes of the same corners, or why it does not."""
    name = "OpenCV's fisheye model"
    why = study.refusal(PEER)
    if why:
        return f"{name} gave no camera ({literal(why)})."
    if not np.isfinite(study.fit(f"{PEER}.image_with_ray")):
        return f"{name} was not tried."
    rows = study.held_out
    parts, refused = len(study.folds), len(study.fold_refusals(PEER))
    text = f"{name} gave a camera in {parts - refused} of {parts} parts."
    for quantity, unit in (("rms_px", " px"), ("mean_deg", "°")):
        errors = {
            model: column(rows, "same", model, quantity) for model in (PEER, *NAMES)
        }
        known = np.all([np.isfinite(e) for e in errors.values()], axis=0)
        if not known.any():
            continue
        told = [
            f"{np.median(e[known]):.2g}{unit} with {model_name}"
            for e, model_name in zip(
                errors.values(), (name, "Zhang's", "the general camera"), strict=True
            )
        ]
        text += f" The median error kept out is {', '.join(told)}."
    return text


def kept_out(study):
    """How many photographs were kept out, in how many parts, with what failures."""
    rows = [row for row in study.held_out if row.own]
    if not rows:
        whys = {literal(study.why_nothing_kept_out(m)) for m in NAMES}
        return (
            "No photograph could be judged by a camera that was calibrated without "
            f"it ({'; '.join(sorted(whys))})."
        )
    count, parts = len(rows), len(study.folds)
    text = (
        f"{_photographs(count).capitalize()} were judged by cameras calibrated "
        f"without them: the set was cut into {parts} parts, and each part was kept "
        "out once."
    )
    for model, name in (("zhang", "Zhang's"), ("general", "the generic")):
        reasons = Counter(study.fold_refusals(model))
        if reasons:
            text += (
                f" From what was left beside {reasons.total()} of the parts {name} "
                f"method gave no camera: {_counted(reasons)}."
            )
    return text


def coverage(study):
    """For which share of the corners kept out each model could answer."""
    rows = study.held_out
    if not any(row.own for row in rows):
        return "Neither model answered for a corner that was kept out."
    shares = {m: 100 * share_with_ray(rows, m) for m in NAMES}
    text = (
        f"Zhang's camera answers for {shares['zhang']:.0f} % of the corners kept "
        f"out, the general camera for {shares['general']:.0f} %"
    )
    image = study.fit("general.share_with_ray")
    if image == image:
        text += f", with a ray for {100 * image:.0f} % of the image"
    return f"{text}."


def comparison(study):
    """Which model predicts better: the rule stands on the page below this sentence."""
    zhangs, generals = paired(study.held_out, "rms_px")
    if not len(zhangs):
        return (
            "The two models cannot be compared here: no photograph that was kept "
            "out has corners for which both have a ray."
        )
    for_general = wins([(generals, zhangs)])[0]
    for_zhang = wins([(zhangs, generals)])[0]
    ratio = for_general.ratio
    better = int(np.sum(generals < zhangs))
    text = (
        f"The general camera has the smaller error in {better} of "
        f"{_photographs(len(zhangs))}. The ratio of the medians, Zhang over "
        f"general camera, is {ratio.value:.3g} ({ratio.low:.3g} to "
        f"{ratio.high:.3g}). "
    )
    if decided(for_general):
        return text + "**The general camera predicts these corners better.**"
    if decided(for_zhang):
        return text + "**Zhang's model predicts these corners better.**"
    return text + "**These photographs do not decide between the two.**"


def angles(study):
    """Median angular errors over photographs kept out."""
    pairs = dict(zip(NAMES, paired(study.held_out, "mean_deg"), strict=True))
    if len(pairs["zhang"]):
        where = "on the corners that both have a ray for"
    else:
        where = "on all corners it has a ray for"
        rows = study.held_out
        pairs = {m: column(rows, "own", m, "mean_deg") for m in NAMES}
    parts = []
    for model, values in pairs.items():
        values = values[np.isfinite(values)]
        if len(values):
            e = median_interval(values)
            parts.append(
                f"{NAMES[model]} {e.value:.2g}° ({e.low:.2g}° to {e.high:.2g}°)"
            )
    if not parts:
        return "There is no angular error to report."
    return (
        f"As angles at the rays, {where}, the medians over photographs are: "
        f"{', '.join(parts)}."
    )


def straightness(study):
    """Distortion left in the board of the undistorted photograph."""
    names = {
        "taken": "as taken",
        "zhang": "through Zhang's model",
        "general": "through the general camera",
    }
    left = {
        name: study.fit(f"undistorted.{key}.distortion_px")
        for key, name in names.items()
    }
    parts = [f"{name} {value:.3g} px" for name, value in left.items() if value == value]
    if len(parts) < 2:
        return "There is no undistorted board to measure."
    if study.refusal("general"):
        shared = "its corners"
    else:
        shared = "its corners that have a ray"
    return (
        "How far the board is from a perspective picture of a flat lattice, RMS "
        f"over {shared} after the best homography: {', '.join(parts)}."
    )


def exercise(study):
    """Which camera the exercises take."""
    if study.refusal("zhang"):
        return "This set has no Zhang camera; the exercises take a made-up one."
    return "The exercises take the Zhang camera of this set."


def _photographs(count):
    return "1 photograph" if count == 1 else f"{count} photographs"


def _counted(reasons):
    return "; ".join(
        literal(reason) + (f" ({count} times)" if count > 1 else "")
        for reason, count in reasons.most_common()
    )
