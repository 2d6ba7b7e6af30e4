"""The words of a calibration: one table of diagnoses, one of summary lines.

Terminal, JSON and report page take their text from here. A diagnosis is a warning with
a code; a summary line has a label. Fields of the templates are values of the result.
"""

import math
from collections.abc import Iterable, Iterator
from string import Formatter
from typing import Any

from raxel.sets.model import BOARDS, Words

CORRECT_FIRST = "correct what the first warning names"  # where it explains a misfit
MISFIT = (
    "RMS {rms_px:.2f| px} ({point} scatter {scatter_px:.2g| px}, predicted "
    "{stated_sd_px:.2g| px})"
)
PHRASES = ("scope", "bent", "untried", "subject", "points", "shape")  # words, no values
# Code -> (problem, what to do), from the strongest diagnosis to the weakest.
DIAGNOSES = {
    "point-order": (
        "{subject}{scope}: " + MISFIT,
        "check columns, rows and the order of {point}s (row by row)",
    ),
    "mixed-handedness": (
        "{mirrored} shows the grid mirrored, {upright} does not: one has a reversed "
        "axis",
        "check axis, and inverse of bit 0",
    ),
    "monitor-pixels-not-square": (
        "the monitor's pixels would be {width_mm:.3g} x {height_mm:.3g} mm, not square",
        "check monitor_px and monitor_mm (width first)",
    ),
    "small-pitch": (
        "target.pitch_mm: {pitch_mm:g} mm is below 1 mm (metres?)",
        "give the side of a square in mm",
    ),
    "outlier-image": (
        "{file}: inconsistent with the other images: {times:.1f} times their scatter, "
        "moves rays by {rays_px:.2g} px RMS (p = {p_value:.2g})",
        "check it for cropping, zoom, focus",
    ),
    "focal-length-varies": (
        "focal length varies between images: SD {sd_percent:.2g} %, {times:.1f} times "
        "the expected (p = {p_value:.2g})",
        "fix focus and zoom, check for two cameras ({files}) or rolling shutter",
    ),
    "inconsistent-halves": (
        "halves of the {target}s ('{divided_by}') give different cameras: rays differ "
        "by {disagreement_px:.2g} px RMS (p = {p_value:.2g})",
        "check for mixed cameras, zoom, bent {target}s",
    ),
    "point-positions": (
        "{point}s deviate from their nominal positions{scope}: column {column}, row "
        "{row} by {offset:.2g} +- {sd:.1g} {unit} (rays: {rays_px:.2g} px RMS, p = "
        "{p_value:.2g})",
        "measure the {target}, use a stiff one",
    ),
    "non-central-rays": (
        "rays miss a common point by {distance:.2g} {unit} RMS (at least "
        "{at_least:.2g} {unit}, p = {p_value:.2g})",
        "{untried}check for bent or moving {target}s",
    ),
    "outlier-residuals": (
        "{files}: worse than the other {target}s: total " + MISFIT,
        "check their {point}s (if right: {subject})",
    ),
    "focal-undetermined": (
        "nearly parallel {target}s: their tilts determine the focal length only to "
        "{sd_percent:.2g} % (SD)",
        "tilt them by 20 to 45 degrees in different directions",
    ),
    "parametric-misfit": (
        "{model} does not fit{scope}: " + MISFIT,
        "{untried}check for {bent}, rolling shutter, mixed cameras",
    ),
    "central-misfit": (
        "no central camera fits{scope}: " + MISFIT,
        "check for non-central rays, {bent}, rolling shutter, mixed cameras",
    ),
    "all-models-misfit": (
        "no tested model fits{scope}: " + MISFIT,
        "{untried}check for {bent}, rolling shutter, mixed cameras",
    ),
    "camera-misfit": (
        "this camera does not fit{scope}: " + MISFIT,
        "check that camera, zoom and focus are those of the set",
    ),
    "bent-board": (
        "a bent {target} does not fit a flat one",
        "give its shape with --board (the JSON file of raxel calibrate)",
    ),
    "inconsistent-images": (
        "images differ {factor:.1f} times as much as {point} scatter explains (rays of "
        "halves: {disagreement_px:.2g} px)",
        "check for rolling shutter, bent {target}s, mixed cameras",
    ),
    "displaced-points": (
        "the {target}'s {point}s are off by up to {offset:.2g} +- {sd:.1g} {unit} "
        "(column {column}, row {row}), the fit estimates them (other half: RMS "
        "{displaced:.3g| px}, {nominal:.3g| px} without)",
        "use a stiff {target}",
    ),
    "board-shape": (
        "the {target} is {shape}, the fit estimates this (held-out RMS "
        "{shaped_px:.3g| px}, {flat_px:.3g| px} without)",
        "use a flat {target}",
    ),
    "outlier-points": (
        "{count} {points} ({percent:.1f} %) excluded as outliers: {files}",
        "check the worst, number {number} of {file} ({worst_px:g} px, others "
        "{others_px:.2f} px RMS)",
    ),
    "extrapolated-area": (
        "{percent:.0f} % of the image is outside all {target}s: SD of rays up to "
        "{largest_sd_px:.2g} px ({under_sd_px:.2g} px inside)",
        "add images with the {target} at the edges and in the corners",
    ),
    "small-table": (
        "the table has rays for only {percent:.0f} % of the image (none where no "
        "{target} was)",
        "add images with the {target} there",
    ),
    "few-boards": (
        "only {count} {target}s: residuals do not bound errors elsewhere, flatness and "
        "split-half agreement are untested",
        "use {needed} or more, tilted, all over the image",
    ),
    "cut-boards": (
        "{count} of {n_views} images show a board that the image's edge cuts (such as "
        "{file})",
        "use a ChArUco board, of which a part is enough",
    ),
    "same-pose": (
        "{count} of {n_views} images show the {target} in the pose of another (such as "
        "{file} and {original})",
        "keep one image of each pose, add images of other poses",
    ),
    "no-monitor-size": (
        "target.monitor_mm: null: lengths are in pitches of the monitor's pixels "
        "(assumed square)",
        "give width and height in mm for metric lengths",
    ),
    "cross-validation-incomplete": (
        "{model}: {count} parts of the cross-validation gave no camera: {reason}",
        "",
    ),
    "no-pose": ("{file}: no pose from the rays: {reason}", ""),
    "view-excluded": ("{file}: excluded: {reason}", ""),
}
# Codes with which --strict ends with another exit status.
STRICT = (
    *("parametric-misfit", "central-misfit", "all-models-misfit", "camera-misfit"),
    *("point-order", "focal-undetermined"),
)
OVERVIEW_SCORE = "RMS {rms_px:.3f| px}, mean angle {mean_deg:.4f| deg}"
SECOND = " (second: {model}, {rms_px:.3f| px})"
MAX_N_MISSED, MAX_REASON = 2, 60  # excluded images in the overview; characters
SCORE = (
    "mean angle {mean_deg:.4f| deg}, RMS {rms_px:.3f| px}, median {median_px:.3f| px}, "
    "{share_with_ray:%.1} of {point}s with a ray"
)
PUPIL_SHIFT = "{shift:.3g} +- {shift_sd:.2g} {unit} over the field of view"
PUPIL_GAIN = (
    "held-out {target}s: RMS {central_px:.3g} px without it, {moving_px:.3g} px with it"
)
UNSCORED = "no {point} could be scored"
# Code -> (label, text).
SUMMARY = {
    "held-out": ("{model}, held-out {target}s", "{score}"),
    "common": ("{model}, {point}s scored by all models", "{score}"),
    "no-camera": ("{model}", "not possible: {refused}"),
    "chosen": ("{model} chosen", "{chosen_because}"),
    "fit": ("{model}, fitted {target}s", "{score}"),
    "smooth-rays": (
        "rays",
        "smooth field where {target}s were, extrapolated to the parametric trend "
        "elsewhere (not tested); the parameters are those of the trend",
    ),
    "parameters": (
        "camera",
        "focal lengths {focal_px[0]:.2f} and {focal_px[1]:.2f} px, principal point "
        "({principal_point_px[0]:.2f}, {principal_point_px[1]:.2f}) px, radial terms "
        "{radial:.4g}",
    ),
    "xi": ("xi", "{xi:.4g}"),
    "tangential": ("tangential terms", "{tangential:.4g}"),
    "prism": ("prism terms", "{prism:.4g}"),
    "pupil_shift": ("pupil shift terms", "{pupil_shift:.4g}"),
    "table": (
        "rays",
        "for {share_of_image_with_ray:%.1} of the image, through one centre (the "
        "origin), lengths in {units}",
    ),
    "field-of-view": (
        "field of view",
        "{horizontal:.1f} x {vertical:.1f| deg}, up to {from_axis:.1f| deg} from the "
        "axis",
    ),
    "coverage": (
        "coverage",
        "{target}s cover {share_of_image_under_boards:%.1} of the image",
    ),
    "deviations": (
        "standard deviations",
        "focal lengths {fx[sd]:.2g} and {fy[sd]:.2g} px, principal point "
        "({cx[sd]:.2g}, {cy[sd]:.2g}) px; {sd_over_independent:.2g} times those of "
        "independent {point} errors",
    ),
    "pupil-moves": (
        "entrance pupil",
        "shifts by " + PUPIL_SHIFT + ", so rays have no common point; " + PUPIL_GAIN,
    ),
    "pupil-undecided": (
        "entrance pupil",
        "undecided, taken as fixed (possible shift "
        + PUPIL_SHIFT
        + "); "
        + PUPIL_GAIN
        + " (p = {chance:.2g})",
    ),
    "pupil-contradicted": (
        "entrance pupil",
        "undecided, taken as fixed (possible shift "
        + PUPIL_SHIFT
        + "); "
        + PUPIL_GAIN
        + ", but {against}, which fits better, contradicts it",
    ),
    "pupil-fixed": (
        "entrance pupil",
        "fixed: a shift fits better (p = {p_value:.2g}), but not held-out {target}s "
        "(RMS {moving_px:.3g} px with it, {central_px:.3g} px without)",
    ),
    "noise": (
        "{point} noise",
        "scatter {scatter_px:.3f| px}, predicted {stated_sd_px:.3f| px}",
    ),
    "shape-untested": (
        "{target} shape",
        "taken as specified; estimating it requires {needed} {target}s in different "
        "poses and a parametric or smooth model",
    ),
    "bends": (
        "{target} shape",
        "over {size[0]:.4g} x {size[1]:.4g} {unit}, ends of x {bend_x:1} {unit} behind "
        "the centre, ends of y {bend_y:1} {unit}, twist {twist:1} {unit} ({state})",
    ),
    "stretch": ("{target} stretch", "x against y {stretch:100} % ({state})"),
    "central": (
        "central camera",
        "{rays} rays with three {target}s or more miss a common point by "
        "{distance:.2g} {unit} RMS (95 % bounds {at_least:.2g} and {at_most:.2g} "
        "{unit}; p = {p_value:.2g} if central)",
    ),
    "central-untested": (
        "central camera",
        "not tested (too few pixels with three {target}s, or too many outliers)",
    ),
    "points-untested": (
        "{point} positions",
        "taken as specified; a test requires {needed} chessboards",
    ),
    "points-nominal": (
        "{point} positions",
        "no significant deviation from the nominal positions (p = {p_value:.2g})",
    ),
    "points-deviate": (
        "{point} positions",
        "{point} {worst} (row by row, from 0) deviates by {offset:.2g} {unit}, all by "
        "{rms:.2g} {unit} RMS; this moves rays by {rays_px:.2g} px RMS (p = "
        "{p_value:.2g}); {state}: RMS of boards predicted by the other half of the "
        "images {held_out_px[nominal]:.3g| px}, {held_out_px[displaced]:.3g| px} with "
        "it, rays of halves differ by {halves_px[nominal]:.2g| px}, "
        "{halves_px[displaced]:.2g| px} with it",
    ),
    "halves": (
        "split-half test",
        "worst of {count} divisions, '{divided_by}': rays differ by "
        "{disagreement_px:.2g} px RMS; expected {scatter_px:.2g} px from {point} "
        "scatter, {allowed_px:.2g} px from differences between images (p = "
        "{p_value:.2g})",
    ),
    "halves-untested": (
        "split-half test",
        "not tested; it requires {needed} {target}s whose halves overlap in the image",
    ),
    "images": ("images", "{used} of {count} used{missed}"),
    "model": ("model", "{model}{pupil}{reason}"),
    "error": ("error", "{held}{score}{second}"),
    "lens": (
        "camera",
        "focal lengths {fx:1}, {fy:1} px, principal point ({cx:1}, {cy:1}) px, field "
        "of view {horizontal:.1f} x {vertical:.1f| deg}",
    ),
    "rays": (
        "camera",
        "rays for {share_of_image_with_ray:%.1} of the image, field of view "
        "{horizontal:.1f} x {vertical:.1f| deg}",
    ),
    "area": (
        "coverage",
        "{target}s cover {share_of_image_under_boards:%.1} of the image{outside}",
    ),
    "outside": (
        "",
        "; SD of rays {sd_under_boards_px:.2g| px} there, up to "
        "{largest_sd_px:.2g| px} outside",
    ),
    "next": (
        "next image",
        "{target} in the {place} of the image, where rays are least certain",
    ),
    "viewer": ("camera", "{viewer}"),
    "clamp": (
        "clamp line",
        "{count} points, {rms_px:.2f| px} RMS from a straight line, {hidden_mm:g} mm "
        "of the mirror hidden",
    ),
    "first-shape": (
        "first shape",
        "rays meet within {points_from_rays_mm:.3f| mm} (mean)",
    ),
    "flat-mirror": ("flat mirror", "{point}s: RMS {platter_rms_px:.3f| px}"),
    "monitor": (
        "monitor, {first} to {second}",
        "{distance_mm:.2f| mm} (SD {distance_sd_mm:.2f| mm}), rotated by "
        "{angle_deg:.3f| deg}",
    ),
    "bundle": (
        "all stages",
        "{freedom} degrees of freedom, variance {corners_variance:.2f}, {state}",
    ),
    "stage": (
        "stage {stage}",
        "{deflection}residual {residual_mm[mean]:.3f| mm} (SD "
        "{residual_mm[sd]:.3f| mm}), predicted ray error "
        "{predicted_ray_error_deg[median]:.3f| deg} (median), "
        "{predicted_ray_error_deg[largest]:.3f| deg} (largest){viewer}",
    ),
}


class _Text(Formatter):
    """Templates: `{x:.2g| px}` has a unit, which 'unknown' lacks; `{x:%.1}` is a share
    in per cent; a list is joined; {value, sd} has as many digits as its SD allows."""

    def format_field(self, value: Any, format_spec: str) -> str:
        form, _, unit = format_spec.partition("|")
        if value is None or (isinstance(value, float) and not math.isfinite(value)):
            return "unknown"
        if isinstance(value, (list, tuple)):
            return ", ".join(format(each, form) for each in value)
        if isinstance(value, dict):
            number, sd = (float(form) * value[name] for name in ("value", "sd"))
            digits = max(0, 1 - math.floor(math.log10(max(sd, 1e-9))))
            return f"{number:.{digits}f} +- {sd:.{digits}f}"
        if form.startswith("%"):
            return f"{100 * value:{form[1:]}f} %"
        return format(value, form) + unit


TEXT = _Text()
number = TEXT.format_field


def known(number: float) -> float | None:
    """Return a float for JSON: None where it is not finite."""
    return float(number) if math.isfinite(number) else None


class Diagnosis(str):
    """A warning: its text is `problem; what to do`.

    Attributes
    ----------
    code : str
        Key in DIAGNOSES, or of the part that reported it.
    problem, what_to_do : str
        The two parts of the text.
    values : dict
        Values in the text, by name.
    """

    code: str
    problem: str
    what_to_do: str
    values: dict[str, Any]

    @classmethod
    def reported(cls, code: str, text: str, **values: Any) -> "Diagnosis":
        """Return the Diagnosis of a text whose parts are separated by '; '."""
        self = cls(text)
        self.code, self.values = code, values
        self.problem, _, self.what_to_do = text.partition("; ")
        return self

    def fields(self) -> dict[str, Any]:
        """Return code, text (the problem), what_to_do and values, for JSON."""
        own = {"code": self.code, "text": self.problem, "what_to_do": self.what_to_do}
        return own | {
            name: known(value) if isinstance(value, float) else value
            for name, value in self.values.items()
            if name not in PHRASES
        }


def diagnosis(code: str, words: Words = BOARDS, /, **values: Any) -> Diagnosis:
    """Return the Diagnosis of a code in DIAGNOSES.

    Parameters
    ----------
    code : str
        The code.
    words : Words
        Words of the target.
    **values
        Values of the template's fields.
    """
    parts = (TEXT.format(part, **words._asdict() | values) for part in DIAGNOSES[code])
    return Diagnosis.reported(code, "; ".join(filter(None, parts)), **values)


def strongest_first(found: Iterable[Diagnosis]) -> list[Diagnosis]:
    """Return diagnoses in the order of DIAGNOSES.

    Significant causes come by their p-values, but after a misfit that they do not
    explain.

    Parameters
    ----------
    found : iterable of Diagnosis
        The diagnoses; those of other parts keep their order and come last.
    """
    found, order = list(found), {code: place for place, code in enumerate(DIAGNOSES)}
    excess_px = max((each.values.get("rms_px", 0.0) for each in found), default=0.0)

    def strength(each: Diagnosis) -> tuple[int, float]:
        code, p_value = each.code, each.values.get("p_value")
        if p_value is None:
            return order.get(code, len(order)), 0.0
        explains = explained(each, excess_px)
        return order["outlier-image" if explains else "inconsistent-images"], p_value

    return sorted(found, key=strength)


def explained(cause: Diagnosis, excess_px: float) -> bool:
    """Return whether a significant cause moves rays by half of the residuals or more.

    Parameters
    ----------
    cause : Diagnosis
        The diagnosis of a test.
    excess_px : float
        RMS residual of a camera that does not fit, px.
    """
    moved = cause.values.get("rays_px", cause.values.get("disagreement_px", math.inf))
    return "p_value" in cause.values and moved >= excess_px / 2


def line(code: str, words: Words, *values: dict[str, Any]) -> tuple[str, str]:
    """Return (label, text) of a code in SUMMARY; values: dicts, the last one counts."""
    fields = {k: v for each in (words._asdict(), *values) for k, v in each.items()}
    label, text = (TEXT.format(part, **fields) for part in SUMMARY[code])
    return label, text


def score_text(scores: dict[str, Any], words: Words = BOARDS) -> str:
    """Return the text of the totals of an Evaluation, as in JSON."""
    scored = scores["rms_px"] is not None or scores["mean_deg"] is not None
    return TEXT.format(SCORE if scored else UNSCORED, **words._asdict() | scores)


def overview(result: dict[str, Any], words: Words) -> Iterator[tuple[str, str]]:
    """Yield the six (label, text) of a calibration that matter most to its user.

    Parameters
    ----------
    result : dict
        JSON of `raxel calibrate`.
    words : Words
        Words of the target.
    """
    camera, tried = result["camera"], result.get("cross_validation", {})
    scored = {m: each for m, each in tried.items() if "own" in each}
    missed = [f"{e['file']} ({_shortened(e['reason'])})" for e in result["left_out"]]
    more = len(missed) - MAX_N_MISSED
    text = "; not: " + ", ".join(missed[:MAX_N_MISSED]) if missed else ""
    text += f" and {more} more" * (more > 0)
    unused = {entry["file"] for entry in result["left_out"]}
    used = len({image["file"] for image in result["images"]} - unused)
    counts = {"used": used, "count": used + len(unused)}
    yield line("images", words, counts, {"missed": text})
    moves = (result.get("pupil") or {}).get("moves")
    about = {"pupil": ", its entrance pupil moves" if moves else ""}
    because = result.get("chosen_because")
    about["reason"] = f": {because}" if because else ", as requested"
    yield line("model", words, result, about)
    own = scored.get(result["model"])
    others = {m: e["counted_rms_px"] for m, e in scored.items() if m != result["model"]}
    others = {m: error for m, error in others.items() if error is not None}
    second = min(others, key=others.__getitem__, default=None)
    score = TEXT.format(OVERVIEW_SCORE, **(own["own"] if own else result))
    rival = TEXT.format(SECOND, model=second, **scored[second]["own"]) if second else ""
    held = f"{'held-out' if own else 'fitted'} {words.target}s, "
    yield line("error", words, {"held": held, "score": score, "second": rival})
    lens = dict.fromkeys(("fx", "fy"), None) | dict.fromkeys(("cx", "cy"), None)
    if "focal_px" in camera:
        numbers = *camera["focal_px"], *camera["principal_point_px"]
        values = [round(number, 2) for number in numbers]
        lens = dict(zip(lens, values, strict=True)) | result.get("terms", {})
    code = "lens" if "focal_px" in camera else "rays"
    yield line(code, words, camera, camera["field_of_view_deg"], lens)
    area = result.get("beyond_boards")
    outside = line("outside", words, area)[1] if area else ""
    yield line("area", words, camera, {"outside": outside})
    if result["next_image"]:
        yield line("next", words, {"place": result["next_image"]})


def _shortened(reason):
    reason = reason.partition(";")[0]
    return reason if len(reason) <= MAX_REASON else reason[: MAX_REASON - 3] + "..."


def comparison_lines(tried: dict[str, Any], words: Words) -> Iterator[tuple[str, str]]:
    """Yield (label, text) of each model of a cross-validation; tried: its JSON."""
    for key, code in (("own", "held-out"), ("common", "common")):
        for model, found in tried.items():
            if key in found:
                score = score_text(found[key], words)
                yield line(code, words, {"model": model, "score": score})
    for model, found in tried.items():
        if "refused" in found:
            yield line("no-camera", words, {"model": model}, found)


def camera_lines(result: dict[str, Any], words: Words) -> Iterator[tuple[str, str]]:
    """Yield (label, text) of the fitted camera; result: JSON of `raxel calibrate`."""
    camera = result["camera"]
    yield line("fit", words, result, {"score": score_text(result, words)})
    if camera["kind"] == "ray spline":
        yield line("smooth-rays", words)
    yield line("parameters" if "focal_px" in camera else "table", words, camera)
    for term in ("xi", "tangential", "prism", "pupil_shift"):
        if term in camera:
            yield line(term, words, camera)
    yield line("field-of-view", words, camera["field_of_view_deg"])
    yield line("coverage", words, camera)
    if "terms" in result:
        yield line("deviations", words, result, result["terms"])
    pupil = result.get("pupil")
    if pupil and pupil["central_px"] is not None:
        yield pupil_line(pupil, result["unit"], words)


def pupil_line(pupil: dict[str, Any], unit: str, words: Words) -> tuple[str, str]:
    """Return (label, text) of the test of the entrance pupil."""
    code = "pupil-moves" if pupil["moves"] else "pupil-fixed"
    if pupil["verdict"] == "undecided":
        code = "pupil-contradicted" if pupil["against"] else "pupil-undecided"
    return line(code, words, pupil, {"unit": unit})


def summary(
    result: dict[str, Any], words: Words, needed: int
) -> Iterator[tuple[str, str]]:
    """Yield (label, text) of what was tested; needed: boards that the tests require."""
    lengths = {"unit": result["unit"], "needed": needed}
    yield line("noise", words, result["misfit"])
    yield from shape_lines(result["board_shape"], words, lengths)
    if "one_centre" in result:
        found = result["one_centre"]
        code = "central" if found else "central-untested"
        yield line(code, words, found or {}, lengths)
    yield points_line(result["board_corners"], words, lengths)
    found = result["stability"]
    if found is None:
        yield line("halves-untested", words, lengths)
    else:
        yield line("halves", words, found, {"count": len(found["divisions"])})


def shape_lines(
    shape: dict[str, Any] | None, words: Words, lengths: dict[str, Any]
) -> Iterator[tuple[str, str]]:
    """Yield (label, text) of the shape of the board, as in JSON."""
    if shape is None:
        yield line("shape-untested", words, lengths)
        return
    for code, term in (("bends", "bend_x"), ("stretch", "stretch")):
        state = "used" if shape[term]["used"] else "not significant, not used"
        yield line(code, words, shape, lengths, {"state": state})


def points_line(
    found: dict[str, Any] | None, words: Words, lengths: dict[str, Any]
) -> tuple[str, str]:
    """Return (label, text) of the positions of the corners on the board."""
    if found is None:
        return line("points-untested", words, lengths)
    sizes = [math.hypot(*offset) for offset in found["offsets"]]
    rms = math.sqrt(sum(size**2 for size in sizes) / len(sizes))
    code = "points-nominal" if found["as_stated"] else "points-deviate"
    deviation = {"offset": sizes[found["worst"]], "rms": rms}
    deviation["state"] = "used" if found["used"] else "not used"
    return line(code, words, found, lengths, deviation)


def mirror_lines(result: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield (label, text) of a mirror's calibration; result: its JSON."""
    clamp, primary, bundle = result["clamp"], result["primary"], result["bundle"]
    yield line("viewer", BOARDS, result)
    yield line("clamp", BOARDS, clamp, {"count": len(clamp["points"])})
    yield line("first-shape", BOARDS, primary)
    yield line("flat-mirror", BOARDS, primary)
    for motion in primary["grids"]:
        yield line("monitor", BOARDS, motion)
    state = "converged" if bundle["converged"] else "stopped before convergence"
    yield line("bundle", BOARDS, bundle, {"state": state})


def stage_lines(result: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield (label, text) of each stage of a mirror; result: its JSON."""
    counted = result["viewer_error_counted"]
    viewer = "" if counted else ", without the error of the camera (unknown)"
    for number, stage in enumerate(result["stages"]):
        mm = stage.get("deflection_mm")
        deflection = "" if mm is None else f"specified deflection {mm:g} mm, "
        more = {"stage": number, "deflection": deflection, "viewer": viewer}
        yield line("stage", BOARDS, stage, more)
