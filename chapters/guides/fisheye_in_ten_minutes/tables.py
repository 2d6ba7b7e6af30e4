"""The three calibrations in numbers, and the steps with what they print."""

import textwrap
from math import isfinite

from chapters.guides.fisheye_in_ten_minutes.results import (
    NAMES,
    RECORD,
    SCORES,
    SETS,
    STUDY,
    said,
    wide_sets,
)
from chapters.shared.photographs.reading import PEER
from chapters.shared.run_times import rounded_seconds
from repro.page.reader import Shown, pipe_table
from repro.page.wording import literal
from repro.run.columns import cell, in_columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

QUANTITIES = {
    "Fitted boards: RMS (px)": ("fitted_px", 1),
    "Kept out: RMS (px)": ("kept_out_px", 1),
    "Kept out: angle (deg)": ("kept_out_deg", 1),
    "Corners with a ray (%)": ("corners_with_ray", 100),
    "Image circle with a ray (%)": ("image_with_ray", 100),
    "Error of the rays (deg)": ("ray_deg", 1),
}
WIDTH = 68  # characters of a line of output
WHICH = {"inner": "inner rings", "all": "all"}


@table("ext_fisheye_models", needs=("ext_fisheye_scores",), evidence="rendered")
def ext_fisheye_models(results):
    """Zhang, OpenCV's fisheye model and the generic camera on the same corners."""
    scores = results[SCORES]
    refused = [
        f" No camera: {name}, boards: {WHICH[use]} ({literal(reason)})."
        for use in SETS
        for model, name in NAMES.items()
        if (reason := scores.texts(f"{model}.reason", boards=use)[0])
    ]
    return Table(
        in_columns(_scored_row(scores, use, model) for use in SETS for model in NAMES),
        "Three models from the same corners. Kept out: boards that no "
        "calibration saw, only their pose being fitted. Error of the rays: "
        "median angle to the true rays, over the pixels where the model has "
        "one, after the best rotation." + "".join(refused),
    )


def _scored_row(scores, use, model):
    found = scores.one(boards=use)
    errors = {
        title: cell(unit * found.column(f"{model}.{quantity}")[0])
        for title, (quantity, unit) in QUANTITIES.items()
    }
    boards = f"{WHICH[use]} ({found.column('boards')[0]:.0f})"
    return {"Boards": boards, "Model": NAMES[model], **errors}


@table(
    "ext_fisheye_photographs",
    needs=("ext_calibration_record", "photograph_study"),
    evidence="photograph",
)
def ext_fisheye_photographs(results):
    """The three models on photographs: of the record, and wide ones of the build."""
    kept = results[RECORD]
    rows = [_recorded_row(kept, c) for c in kept.conditions]
    rows += [_built_row(one) for one in wide_sets(results[STUDY])]
    return Table(
        in_columns(rows),
        "Real cameras: errors in photographs kept out, medians with 95 % "
        "intervals, on corners that Zhang's and the generic camera both have "
        "a ray for. Boards compared: those that have such corners (not known "
        "for sets of this build). Parts: of the cross-validation, and from how "
        "many of them OpenCV's fisheye model gave no camera. With a ray: of the "
        f"generic camera. Record: of {kept.settings['date']}, which the build does "
        "not make again (data/records).",
        texts=("Set",),
    )


def _recorded_row(kept, condition):
    def of(name, kind=float):
        x = kept.column(name, **condition)[0]
        return kind(x) if isfinite(x) else None

    def interval(model):
        ends = [of(f"models.{model}.{x}") for x in ("px", "px_low", "px_high")]
        return None if None in ends else Measured(*ends)

    return {
        "Set": condition["set"],
        "From": "record",
        "Widest angle (deg)": of("widest_deg"),
        "Pictures": of("pictures", int),
        "Boards found": of("boards_found", int),
        "Boards compared": of("compared", int),
        **{f"{name} (px)": interval(model) for model, name in NAMES.items()},
        "Parts": of("parts", int),
        "without OpenCV fisheye": of("models.opencv_fisheye.parts_without_camera", int),
        "Corners with a ray (%)": of("corners_with_ray", _percent),
        "Picture with a ray (%)": of("image_with_ray", _percent),
    }


def _built_row(one):
    errors = [one.errors["rms_px"].get(m) for m in ("zhang", PEER, "general")]
    cells = [None if e is None else Measured(*e[:3]) for e in errors]
    return {
        "Set": one.name,
        "From": "this build",
        "Widest angle (deg)": float(one.widest_deg),
        "Pictures": len(one.study.images),
        "Boards found": len(one.study.found),
        "Boards compared": None,
        **dict(zip((f"{n} (px)" for n in NAMES.values()), cells, strict=True)),
        "Parts": len(one.study.folds),
        "without OpenCV fisheye": len(one.study.fold_refusals(PEER)),
        "Corners with a ray (%)": _percent(one.share),
        "Picture with a ray (%)": _percent(one.image_share),
    }


def _percent(share):
    return 100 * float(share)


def transcript(result, *commands):
    """Commands as typed, each with what it printed when it was run."""
    text = "\n".join(
        folded(f"$ raxel {' '.join(typed)}", " \\\n")
        + f"\n{folded(said(result, typed[0]).rstrip())}\n"
        for typed in commands
    )
    return Shown(f"````text\n{text}````", f"<pre>{text}</pre>")


def folded(text, end="\n"):
    """Long lines go on in the next one, further in, so that none is cut off."""
    return "\n".join(
        f"{end}    ".join(
            textwrap.wrap(line, WIDTH, break_long_words=False, break_on_hyphens=False)
        )
        if len(line) > WIDTH
        else line
        for line in text.split("\n")
    )


def steps(took):
    """Table of the steps: [(step, command, seconds or words)]."""
    rows = [
        [step, command, x if isinstance(x, str) else rounded_seconds(x)]
        for step, command, x in took
    ]
    text = pipe_table(["Step", "With", "Takes"], rows, [False] * 3)
    return Shown(text, f"<pre>{text}</pre>")
