"""What the page of all image sets says in words, whatever sets there are."""

from __future__ import annotations

from collections import Counter

from chapters.shared.photographs.compared import FEWEST_DECIDING, twins
from chapters.shared.photographs.reading import MODELS, NAMES, PEER
from repro.page.wording import literal


def brought(results, sets):
    """Which sets this build has, and which of them compare the models."""
    if not results:
        return (
            "This build has no image set: the photographs could not be brought, "
            "or none were given."
        )
    usable = [one for one in sets if one.comparable]
    text = f"This build has {_sets(len(results))}: {_listed(results)}."
    for later, first in twins(results).items():
        text += (
            f" The photographs of {later} are those of {first}; they count "
            "once."
        )
    text += f" {_judged(len(usable), len(sets))}"
    for one in sets:
        if not one.comparable:
            text += f" {one.name}: {literal(one.outcome)}."
    return text


def trend(sets):
    """How both errors change from the least distorted set to the most distorted."""
    usable = [one for one in sets if one.comparable]
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


def _both(one):
    zhang, general = (one.errors["rms_px"][model].value for model in MODELS)
    return (
        f"Zhang's model leaves {zhang:.2g} px and the general camera "
        f"{general:.2g} px"
    )


def _ratio(one):
    zhang, general = (one.errors["rms_px"][model].value for model in MODELS)
    return zhang / general


def winners(sets):
    """In how many sets which model is the better one."""
    usable = [one for one in sets if one.comparable]
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
    """Where OpenCV's fisheye model does better and worse than the other two."""
    usable = [one for one in sets if one.comparable]
    if not usable:
        return "OpenCV's fisheye model has nothing to be compared with."
    said = {
        "less than both": [],
        "more than one of them": [],
        "no camera": [],
    }
    for one in usable:
        errors = {m: e.value for m, e in one.errors["rms_px"].items()}
        if PEER not in errors:
            said["no camera"].append(one.name)
            continue
        best = min(errors[model] for model in MODELS)
        name = one.name
        if one.of_peer < one.photographs:
            name += f" ({one.of_peer} of {one.photographs} photographs)"
        kind = (
            "less than both"
            if errors[PEER] < best
            else "more than one of them"
        )
        said[kind].append(name)
    return f"OpenCV's fisheye model leaves {_sorted_out(said)}."


def corrected(sets):
    """What the thesis's own measure says beside the residual."""
    usable = [
        one for one in sets if one.comparable and one.errors["corrected_px"]
    ]
    if not usable:
        return "No set has a corrected view to measure."
    said = {"with the general camera": [], "with Zhang": []}
    for one in usable:
        zhang, general = (
            one.errors["corrected_px"][model].value for model in MODELS
        )
        said[list(said)[int(zhang < general)]].append(one.name)
    return f"After correction less is left {_sorted_out(said)}."


def _sorted_out(said):
    """{words: names of sets} as a phrase, without the words that hold for none."""
    parts = [
        f"{words} on {_listed(names)}"
        for words, names in said.items()
        if names
    ]
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
