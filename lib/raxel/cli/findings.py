"""What a calibration found, as JSON and as warnings.

Commands collect their warnings, print them last, and write them into their JSON file.
"""

import math
from collections import Counter

import numpy as np
from scipy.spatial import cKDTree

from raxel.calibration.views.correspondence import BENDS, TERMS, near_copies
from raxel.evaluation.diagnoses import (
    CORRECT_FIRST,
    DIAGNOSES,
    Diagnosis,
    diagnosis,
    strongest_first,
)
from raxel.evaluation.distortion import MIN_N_BOARDS

MIN_TABLE_SHARE = 1 / 3  # of the image's pixels; less is a small part of a camera
RECOMMENDED_N_BOARDS = 10
# RMS distance by which single corners scatter that are in another order than stated.
OTHER_ORDER_PX = 10.0
MAX_NAMES = 5  # in a warning
MIN_PITCH_MM = 1.0
RAYS_PX = 0.1  # a cause that moves rays by less is no warning
MIN_CUT_FRACTION, MIN_N_CUT = 0.25, 2  # of the images of a set
NOT_SQUARE_TOL = 0.05  # of a side: pixels of monitors are square to far less


def reported(warnings):
    """Print the warnings, the strongest first; return them for JSON."""
    result = sorted_fields(warnings)
    for text in result["warnings"]:
        print(f"warning: {text}")
    return result


def sorted_fields(warnings):
    """The warnings for JSON, the strongest first."""
    warnings = strongest_first(warnings)
    return {"warnings": warnings, "diagnoses": [each.fields() for each in warnings]}


def of_handedness(mirrored):
    """A warning where some views are mirrored and others are not.

    mirrored: [(name of the view, whether it is, None where that is unknown)].
    """
    names = {is_so: name for name, is_so in mirrored}
    if not {True, False} <= set(names):
        return []
    return [diagnosis("mixed-handedness", mirrored=names[True], upright=names[False])]


def of_left_out(left_out):
    """A warning for each image that went into no result: [{file, reason}]."""
    return [diagnosis("view-excluded", **entry) for entry in left_out]


def of_unused(image_set):
    """A warning for each image of the set's folder that is no view."""
    return of_left_out([{"file": f, "reason": why} for f, why in image_set.unused])


def of_pixels(monitor):
    """A warning where the pixels of an ActiveGrid's monitor would not be square."""
    size, n_pixels = monitor.monitor_mm, monitor.monitor_px
    if size is None or _elongation(size, n_pixels) < NOT_SQUARE_TOL:
        return []
    width, height = (mm / px for mm, px in zip(size, n_pixels, strict=True))
    return [diagnosis("monitor-pixels-not-square", width_mm=width, height_mm=height)]


def of_pitch(target):
    """A warning where the pitch of a chessboard is stated in metres, it seems."""
    pitch = getattr(target, "pitch_mm", None) or MIN_PITCH_MM
    return [diagnosis("small-pitch", pitch_mm=pitch)] * (pitch < MIN_PITCH_MM)


def of_cut_boards(boards, image_set):
    """A warning where the image's edge cuts many of the Boards, which are rejected."""
    size = image_set.width, image_set.height
    cut = [board.view.label for board in boards if _is_cut(board.detection, size)]
    if len(cut) < max(MIN_CUT_FRACTION * len(boards), MIN_N_CUT):
        return []
    return [diagnosis("cut-boards", count=len(cut), n_views=len(boards), file=cut[0])]


def _is_cut(detection, size):
    """Whether corners of a rejected board are within a square of the image's edge."""
    corners = detection.partial.corners if detection.partial else np.empty((0, 2))
    square = cKDTree(corners).query(corners, k=2)[0][:, 1]
    to_edge = np.minimum(corners, np.array(size) - 1 - corners).min(axis=1)
    return bool(np.any(to_edge < square))


def of_swapped_sides(monitor):
    """That warning where width and height in mm, exchanged, give squarer pixels."""
    size, n_pixels = monitor.monitor_mm, monitor.monitor_px
    swapped = size and _elongation(size[::-1], n_pixels) < _elongation(size, n_pixels)
    return of_pixels(monitor) if swapped else []


def _elongation(size, n_pixels):
    """Logarithm of the ratio of the longer to the shorter side of a pixel."""
    return abs(math.log(size[0] / n_pixels[0] / (size[1] / n_pixels[1])))


def listed(names, limit=MAX_NAMES):
    """The first of several names, and how many more there are."""
    rest = len(names) - limit
    text = ", ".join(names[:limit])
    return f"{text} and {rest} more" if rest > 0 else text


def unused_text(image_set):
    """The images of a folder that are no views, in an error of too few images."""
    reasons = {}
    for name, reason in image_set.unused:
        reasons.setdefault(reason, []).append(name)
    texts = [f"{listed(names, 2)}: {reason}" for reason, names in reasons.items()]
    return f", not used: {', '.join(texts)}" * bool(texts)


def misfit_warnings(
    found, code, words, *, scope="", bent="", untried="", explained=False, **model
):
    """Yield the warning of a Misfit, if there is one.

    code: of the DIAGNOSES for large residuals; scope: which boards; bent: the cause
    that depends on the number of boards; untried: advice of another model; explained:
    whether another warning explains it; model: its name, if the code requires it.
    """
    values = {
        "rms_px": found.rms_px,
        "scatter_px": found.scatter_px,
        "stated_sd_px": found.sd_px,
        "scope": scope,
        "subject": DIAGNOSES[code][0].partition("{scope}")[0].format(**model),
    }
    if found.odd_boards:
        files = {"file": found.odd_boards[0], "files": listed(found.odd_boards, 2)}
        yield diagnosis("outlier-residuals", words, **values, **files)
    elif found.large and found.scatter_px > OTHER_ORDER_PX:
        yield diagnosis("point-order", words, **values)
    elif found.large:
        values |= {"bent": bent or f"bent {words.target}", "untried": untried}
        large = diagnosis(code, words, **model, **values)
        text = f"{large.problem}; {CORRECT_FIRST}"
        yield Diagnosis.reported(code, text, **large.values) if explained else large


def warnings_of(result, right_px, words, untried=""):
    """Yield the warnings of excluded points, of rays without a common point and of a
    bent board; result: as in JSON; right_px: RMS distance of the other points; untried:
    advice of another model."""
    unit, test, shape = map(result.get, ("unit", "one_centre", "board_shape"))
    if wrong := result["wrong_points"]:
        worst = max(wrong, key=lambda entry: entry["distance_px"])
        counts = Counter(result["wrong_points_of"]).most_common()
        yield diagnosis(
            "outlier-points",
            words,
            count=len(wrong),
            points=words.point + "s" * (len(wrong) > 1),
            percent=100 * result["share_of_wrong_points"],
            files=listed([f"{name} ({n})" for name, n in counts]),
            file=worst["file"],
            number=worst["corner"],
            worst_px=math.ceil(10 * worst["distance_px"]) / 10,
            others_px=right_px,
        )
    if test and not test["central"]:
        yield diagnosis("non-central-rays", words, unit=unit, untried=untried, **test)
    parts = []
    if shape and shape["twist"]["used"]:
        most = max(abs(shape[name]["value"]) for name in BENDS)
        parts.append(f"bent by up to {most:.2g} {unit}")
    if shape and shape["stretch"]["used"]:
        parts.append(f"stretched by {100 * shape['stretch']['value']:.2g} % (x/y)")
    if parts and _moves_rays(shape["flat_px"], shape["shaped_px"]):
        yield diagnosis(
            "board-shape",
            words,
            shape=", ".join(parts),
            **{name: shape[name] for name in (*TERMS, "flat_px", "shaped_px")},
        )


def _moves_rays(without_px, with_px):
    """Whether the difference of two RMS errors matters to rays; unknown: it does."""
    if without_px is None or with_px is None:
        return True
    return without_px**2 - with_px**2 >= RAYS_PX**2


def agreement_warnings(corners, halves, fitted, unit, words):
    """Yield the warnings of BoardCorners that deviate, of a SplitHalf that disagrees,
    and of the area outside the boards."""
    if corners and not corners.as_stated:
        row, column = divmod(corners.worst, corners.columns)
        offset, sd = corners.distance
        tests = {"rays_px": corners.rays_px, "p_value": corners.p_value}
        if corners.used:
            tests = corners.fields()["held_out_px"]
        yield diagnosis(
            "displaced-points" if corners.used else "point-positions",
            words,
            scope=" on the fitted shape" if fitted.board and fitted.board.used else "",
            column=column,
            row=row,
            offset=offset,
            sd=sd,
            unit=unit,
            **tests,
        )
    if halves and not halves.stable:
        yield _instability(halves, words)
    area = halves and halves.beyond
    if area and area.matters:
        yield diagnosis(
            "extrapolated-area",
            words,
            percent=100 * area.share,
            unknown_percent=100 * area.unknown,
            largest_sd_px=area.largest_px,
            under_sd_px=area.under_px,
        )


def _instability(found, words):
    """The warning of a camera that depends on the images: of the least p-value."""
    tested, outlier, focal = [], found.outlier, found.focal
    if outlier:
        values = outlier._asdict()
        file = values.pop("name")
        tested.append(diagnosis("outlier-image", words, file=file, **values))
    if not found.one_focal:
        values = focal._asdict() | {"sd_percent": 100 * focal.sd}
        files = listed(min(focal.shorter, focal.longer, key=len), 2)
        tested.append(diagnosis("focal-length-varies", words, files=files, **values))
    if not found.same_camera:
        values = found.divisions[0].fields() | {"p_value": found.p_value}
        tested.append(diagnosis("inconsistent-halves", words, **values))
    if tested:
        return min(tested, key=lambda each: each.values["p_value"])
    largest = max(each.disagreement_px for each in found.divisions)
    return diagnosis(
        "inconsistent-images", words, factor=found.factor, disagreement_px=largest
    )


def coverage_warnings(camera, views, words):
    """Yield the warnings of a small table and of few boards; camera: as in JSON."""
    share = camera.get("share_of_image_with_ray", 1.0)
    if share < MIN_TABLE_SHARE:
        yield diagnosis("small-table", words, percent=100 * share)
    boards = [view for view in views if not view.every_pixel]
    count = len(set(near_copies(boards)))
    if 0 < count < MIN_N_BOARDS:
        yield diagnosis("few-boards", words, count=count, needed=RECOMMENDED_N_BOARDS)
