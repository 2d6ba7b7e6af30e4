"""Names, medians over trials, and the numbers that the page quotes."""

import numpy as np

from chapters.ch04_central_generic.ext_lens_formula.trials import LENSES, MODELS
from chapters.shared.photographs.reading import EVERY, Study, counted
from raxel.evaluation.comparison import MISSED_PX
from repro.judge.statistics import median_interval
from repro.page.reader import value
from repro.page.wording import literal

NAMES = {
    "zhang": "pinhole, two radial terms",
    "kannala-brandt": "Kannala-Brandt",
    "unified": "unified sphere",
    "pupil": "Kannala-Brandt, pupil by test",
}
TITLES = {
    "fisheye": "fisheye of 183°",
    "mirror": "mirror, decentred",
    "pupil": "fisheye, moving pupil",
}
# Of the photographs' models, those that this page is about.
SHOWN = ("zhang", "kannala_brandt", "unified", "general")


def error(result, lens, model):
    """Median kept-out error (px) over trials, an Estimate."""
    return median_interval(result.column(f"{model}.rms_px", lens=lens))


def ring_errors(result, lens, model):
    """Medians over trials (px) for each ring about the middle; NaN where none."""
    rings = np.array(result.arrays(f"{model}.ring_px", lens=lens))
    if not len(rings):
        return None
    known = np.isfinite(rings).any(axis=0)
    return np.where(known, np.nanmedian(np.where(known, rings, 0.0), axis=0), np.nan)


def moved(result, lens):
    """In how many trials the test found a pupil that moves."""
    return int(np.nansum(result.column("pupil.test.moves", lens=lens)))


def shift(result, lens):
    """Median shift of the pupil (mm), an Estimate."""
    return median_interval(result.column("pupil.test.shift_mm", lens=lens))


def first_study(results):
    """(name, Study) of the build's first set of photographs, or None."""
    for name, result in results.items():
        study = Study(result)
        if study.held_out:
            return name, study
    return None


def residuals_by_radius(study, model):
    """(radius, distance), (N,) px each, of all corners kept out with a ray."""
    size = study.settings["width_px"], study.settings["height_px"]
    middle = (np.array(size) - 1) / 2
    radius, off = [], []
    for row in study.held_out:
        if score := row.own.get(model):
            radius.append(np.linalg.norm(row.image.corners - middle, axis=1))
            off.append(np.linalg.norm(score.residuals_px, axis=1))
    if not off:
        return None
    radius, off = np.concatenate(radius), np.concatenate(off)
    seen = np.isfinite(off)
    return radius[seen], off[seen]


def name_values(open_results, results_behind):
    """Name the numbers of the prose."""
    result = open_results("ext_lens_known")
    behind = results_behind("ext_lens_formula_figure")
    found = {
        "trials": result.trials_per_condition,
        **{f"moved.{lens}": moved(result, lens) for lens in LENSES},
        **{
            f"{lens}.{model}": error(result, lens, model).value
            for lens in LENSES
            for model in MODELS
        },
        "shift": shift(result, "pupil").value,
        "photographs": said_of(first_study(behind["photograph_study"])),
    }
    for name, number in found.items():
        value(name, number)


def said_of(found):
    """What the photographs say of the models, in a sentence."""
    if found is None:
        return "No set of photographs in this build has one kept out."
    name, study = found
    errors = {model: counted(study, model)["rms_px"] for model in SHOWN}
    general = errors.pop("general")
    best = min(errors, key=errors.get)
    return (
        f"On the photographs of {literal(name)} the best formula, "
        f"{EVERY[best]}, leaves {errors[best]:.3f} px, the table of rays "
        f"{general:.3f} px. Every corner counts, one without a ray as "
        f"{MISSED_PX:g} px."
    )
