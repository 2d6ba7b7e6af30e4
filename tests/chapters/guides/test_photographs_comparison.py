"""Comparison of image sets: medians of their errors, and sets that are twins."""

import json
from pathlib import Path

import numpy as np
import pytest

from chapters.guides.choose_a_method.report import compared_sets, twins
from chapters.shared.images.reading import PEER
from repro.run.results import Result


def write_study(folder, name, *, ratio, images, seed, of_peer=0):
    """A result with the shape of the study's: one part keeps all images out.

    OpenCV's fisheye model answers in the first `of_peer`, with 0.5 px.
    """
    rng = np.random.default_rng(seed)
    count = max(images, 2)
    conditions = [
        {"part": "image", "view": i, "image": f"{i}.png"} for i in range(count)
    ]
    conditions += [{"part": "fit"}, {"part": "fold", "fold": 0}]
    arrays = {f"{i}/0/corners": rng.uniform(0, 100, (20, 2)) for i in range(count)}
    fold = {"kept_out": count}
    for i in range(images):
        general = rng.uniform(0.2, 0.25)
        fold |= {f"views.{i}.corners": 20}
        models = [("zhang", ratio * general), ("general", general)]
        models += [(PEER, 0.5)] * (i < of_peer)
        for model, px in models:
            for kind in ("own", "same"):
                stem = f"views.{i}.{model}.{kind}"
                fold |= {f"{stem}.corners": 18, f"{stem}.rms_px": px}
                fold |= {f"{stem}.mean_deg": px / 10, f"{stem}.reason": ""}
                arrays[f"{count + 1}/0/{stem}.residuals_px"] = np.full((20, 2), px)
    why = "" if images else "generic calibration: no board overlaps two others"
    fit = {"general.reason": why, "zhang.reason": ""}
    if images:
        fit["general.image_with_ray"] = 0.75
    values = [{"found": True, "columns": 5, "reason": ""}] * count + [fit, fold]
    names = [f"{i}.png" for i in range(count)]
    content = {
        "experiment": f"photograph_study@{name}",
        "effort": "quick",
        "settings": {"images": names, "uses": ["calibrate"] * count},
        "conditions": conditions,
        "trials_per_condition": 1,
        "first_trial": 0,
        "trials": [{"condition": i, "values": v} for i, v in enumerate(values)],
    }
    path = Path(folder) / f"{name}.json"
    path.write_text(json.dumps(content))
    np.savez(path.with_suffix(".npz"), **arrays)
    return Result(path)


@pytest.fixture
def sets(tmp_path):
    def study(name, **about):
        return name, write_study(tmp_path, name, **about)

    return dict(
        [
            study("strong", ratio=9, images=12, seed=1, of_peer=9),
            study("none", ratio=1, images=0, seed=2),
            study("weak", ratio=0.7, images=12, seed=3),
            study("few", ratio=3, images=4, seed=4),
            study("again", ratio=9, images=12, seed=1),
        ]
    )


def test_identical_image_sets_count_once(sets):
    found = compared_sets(sets)
    assert [one.name for one in found] == ["few", "none", "strong", "weak"]
    assert twins(sets) == {"again": "strong"}
    strong, weak = (one for one in found if one.name in ("strong", "weak"))
    assert strong.errors[PEER].value == 0.5
    assert PEER not in weak.errors
    ratio = weak.errors["zhang"].value / weak.errors["general"].value
    assert ratio == pytest.approx(0.7)
    assert strong.image_share == 0.75
    assert found[1].errors == {}
