"""What the page of all image sets says in words, whatever sets there are."""

from collections import Counter

import numpy as np

from chapters.shared.photographs.compared import FEWEST_DECIDING, twins
from chapters.shared.photographs.reading import MODELS, NAMES, PEER
from repro.page.wording import literal

OVERLAP = "overlap"
_CALLED = {"zhang": "Zhang", "general": "the general camera"}


def brought(results, sets):
    """Which sets this build has, and which of them compare the models."""
    if not results:
        return (
            "This build has no image set: the photographs could not be brought, "
            "or none were given."
        )
    usable = comparable(sets)
    text = f"This build has {_sets(len(results))}: {_listed(results)}."
    for later, first in twins(results).items():
        text += f" The photographs of {later} are those of {first}; they count once."
    text += f" {_judged(len(usable), len(sets))}"
    for one in sets:
        if not one.comparable:
            text += f" {one.name}: {literal(one.outcome)}."
    return text


def comparable(sets):
    """The sets that compare the models."""
    return [one for one in sets if one.comparable]


def trend(sets):
    """How both errors change from the least distorted set to the most distorted."""
    usable = comparable(sets)
    if not usable:
        return "There is nothing to compare."
    if len(usable) == 1:
        one = usable[0]
        return (
            f"One set cannot show a trend. At its level of {one.level:.2g}, "
            f"{_both(one)}. More sets come in with `RECORDED`, see [your own "
            "photographs](../your_photographs.md)."
        )
    first, last = usable[0], usable[-1]
    return (
        f"From the least distorted set to the most distorted, level "
        f"{first.level:.2g} to {last.level:.2g}: in {first.name} "
        f"{_both(first)}; in {last.name} {_both(last)}. The ratio of "
        f"Zhang's error to the general camera's goes from {_ratio(first):.2g} to "
        f"{_ratio(last):.2g}."
    )


def _medians(one):
    return [one.errors["rms_px"][model].value for model in MODELS]


def _both(one):
    zhang, general = _medians(one)
    return (
        f"Zhang's model leaves {zhang:.2g} px and the general camera {general:.2g} px"
    )


def _ratio(one):
    zhang, general = _medians(one)
    return zhang / general


def winners(sets):
    """In how many sets which model is the better one."""
    usable = comparable(sets)
    if not usable:
        return "No set decides between the models."
    found = Counter(one.outcome for one in usable)
    parts = [
        f"{_said_better(outcome)} in {_sets(count)}"
        for outcome, count in found.most_common()
    ]
    return (
        f"By the rule of the sets' own pages: {'; '.join(parts)}. With fewer "
        f"than {FEWEST_DECIDING} photographs that test cannot decide."
    )


def _said_better(outcome):
    said = {
        NAMES["general"]: "the general camera predicts better",
        NAMES["zhang"]: "Zhang's model predicts better",
    }
    return said.get(outcome, literal(outcome))


def peer(sets):
    """Where OpenCV's fisheye model does better or worse, beyond the intervals."""
    usable = comparable(sets)
    if not usable:
        return "OpenCV's fisheye model has nothing to be compared with."
    said = {}
    for one in usable:
        errors = one.errors["rms_px"]
        name = one.name
        if PEER not in errors:
            said.setdefault("no camera", []).append(name)
            continue
        if one.of_peer < one.photographs:
            name += f" ({one.of_peer} of {one.photographs} photographs)"
        said.setdefault(_beside(errors), []).append(name)
    return f"OpenCV's fisheye model leaves {_sorted_out(said)}."


def _beside(errors):
    """The error of OpenCV's model beside those whose intervals it does not meet."""
    parts = []
    for model in MODELS:
        if errors[PEER].high < errors[model].low:
            parts.append(f"less than {_CALLED[model]}")
        elif errors[PEER].low > errors[model].high:
            parts.append(f"more than {_CALLED[model]}")
    return " and ".join(parts) or "no error that can be told from the others"


def corrected(sets):
    """What the thesis's own measure says, where the intervals are apart."""
    usable = [one for one in sets if one.comparable and one.errors["corrected_px"]]
    if not usable:
        return "No set has a corrected view to measure."
    said = {}
    for one in usable:
        zhang, general = (one.errors["corrected_px"][model] for model in MODELS)
        words = OVERLAP
        if general.high < zhang.low:
            words = "with the general camera"
        elif zhang.high < general.low:
            words = "with Zhang"
        said.setdefault(words, []).append(one.name)
    same = said.pop(OVERLAP, [])
    parts = [f"less is left {_sorted_out(said)}"] if said else []
    parts += [f"the intervals overlap on {_listed(same)}"] if same else []
    return f"After correction {'; '.join(parts)}."


def recorded(kept):
    """Zhang and the general camera on the record's real cameras."""

    of_sets = kept.select().column
    widest = of_sets("widest_deg")
    (zhang_low, zhang_high), (generic_low, generic_high) = (
        [of_sets(f"models.{model}.px_{end}") for end in ("low", "high")]
        for model in ("zhang", "generic")
    )
    generic = np.count_nonzero(generic_high < zhang_low)
    zhang = np.count_nonzero(zhang_high < generic_low)
    return (
        f"In a record of {_sets(len(widest))} from real cameras, "
        f"{widest.min():.0f}° to {widest.max():.0f}° from the axis, the "
        f"general camera's interval lies below Zhang's in {generic} and above "
        f"it in {zhang}; elsewhere the two overlap."
    )


def _sorted_out(said):
    """{words: names of sets} as a phrase, without the words that hold for none."""
    parts = [f"{words} on {_listed(names)}" for words, names in said.items() if names]
    return "; ".join(parts)


def axis(sets):
    """How well a radial curve describes each table of rays."""
    known = [one for one in sets if one.level == one.level]
    if not known:
        return "No set of this build has a table of rays."
    parts = [
        f"{one.name} {one.study.fit('general.distortion.fit_px'):.2g} px"
        for one in known
    ]
    return (
        "Median distance of the pixels from the fitted curve: "
        f"{', '.join(parts)}. Where that is much, the camera is not round, or "
        "its rays do not meet, and its level is rough."
    )


def _sets(count):
    return "1 image set" if count == 1 else f"{count} image sets"


def _judged(count, of):
    if of == 1:
        return f"On it, {'both' if count else 'not both'} models could be judged."
    return f"On {count if count else 'none'} of them both models could be judged."


def _listed(names):
    *head, last = names
    return f"{', '.join(head)} and {last}" if head else last
