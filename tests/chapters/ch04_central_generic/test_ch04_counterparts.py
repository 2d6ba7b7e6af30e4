"""Section 4.3.2: claims that are judged seed by seed can hold and can fail."""

import numpy as np
import pytest

from chapters.ch04_central_generic.s3_2_results import claims
from chapters.ch04_central_generic.s3_3_correction import report
from tests.bench_noises import at_every_noise
from tests.judged_claims import readings_of, verdict
from tests.made_results import as_planned, flat, of_columns

STAGE = {"ray_mean_mm": 0.1, "ba_mean_mm": 0.05}
SCATTER = {
    "rms_mm": 1.0, "eigenvalues": 0.8, "kurtosis": 1.0, "inside": 1.0,
    "tilted_over_facing": 1.2,
}  # fmt: skip
PARAMETERS = dict.fromkeys(("cx", "cy", "cz", "r2", "t2", "r3", "t3"), 100.0)


def method(stage=STAGE, scatter=SCATTER, parameters=PARAMETERS):
    return dict(flat({**stage, "all": scatter, "apart": scatter, **parameters}))


def camera(standard, cgsp):
    made = {"as_printed": standard, "well_conditioned": standard, "cgsp": cgsp}
    return {f"{name}.{key}": v for name, one in made.items() for key, v in one.items()}


# What the standard method has where every claim holds.
OMNI_STANDARD = method(
    {"ray_mean_mm": 1.0, "ba_mean_mm": 0.4},
    SCATTER | {"rms_mm": 3.0, "eigenvalues": 0.1, "kurtosis": 9.0},
    PARAMETERS | {"cz": 120.0},
)
FISH_STANDARD = method(
    {"ray_mean_mm": 0.2, "ba_mean_mm": 0.11},
    SCATTER | {"rms_mm": 1.2, "kurtosis": 1.5, "inside": 0.0},
)
OMNI, FISH = camera(OMNI_STANDARD, method()), camera(FISH_STANDARD, method())
ORDERS = {
    "cgsp.linear.own_ray_mm": 1.0,
    **{f"{m}.linear.own_ray_mm": 3.0 for m in ("as_printed", "well_conditioned")},
    **{f"{m}.ba.own_ray_mm": 2.0 for m in ("as_printed", "well_conditioned")},
}


def made(omni, fish):
    """Both experiments of 4.3.2 and the simulation, every seed alike."""

    def values(condition):
        one = omni if condition["camera"] == "omnidirectional" else fish
        return at_every_noise(one)

    return {
        "table_4_3_rendered": as_planned("table_4_3_rendered", values),
        "table_4_3_redrawn": of_columns(
            *(
                (
                    {"camera": name},
                    {k: np.full(50, v) for k, v in values({"camera": name}).items()},
                )
                for name in ("omnidirectional", "fisheye")
            )
        ),
        "fig_4_2_redrawn": of_columns(
            *(({"domain": "px", "noise": level}, ORDERS) for level in (0.1, 1.0))
        ),
    }


MARKS = {
    mark["id"]: (judge, mark)
    for room in (claims, report)
    for judge in vars(room).values()
    for mark in getattr(judge, "repro_marks", ())
    if mark["kind"] == "claim"
}
JUDGES = {name: judge for name, (judge, _) in MARKS.items()}


def changed(one, **columns):
    """A camera's values with some of them changed, a dot for each double line."""
    renamed = {name.replace("__", "."): value for name, value in columns.items()}
    assert set(renamed) <= set(one)
    return one | renamed


BROKEN = {
    "c4_omni_order_mag": (changed(OMNI, as_printed__ba_mean_mm=0.2), FISH),
    "c4_fish_smaller_gap": (OMNI, changed(FISH, as_printed__ray_mean_mm=0.09)),
    "c4_ba_reduces": (OMNI, changed(FISH, as_printed__ba_mean_mm=0.13)),
    "c4_raypoint_similar_cams": (OMNI, changed(FISH, cgsp__ray_mean_mm=0.25)),
    "c4_accuracy_not_needed_ba": (changed(OMNI, cgsp__ray_mean_mm=0.5), FISH),
    "c4_agrees_simulated": (OMNI, changed(FISH, as_printed__ba_mean_mm=0.09)),
    "c4_params_fish_agree": (OMNI, changed(FISH, cgsp__t3=90.0)),
    "c4_centrality_omni": (changed(OMNI, cgsp__all__kurtosis=10.0), FISH),
    "c4_centrality_fish": (OMNI, changed(FISH, cgsp__all__kurtosis=2.0)),
    "c4_hull": (OMNI, changed(FISH, as_printed__all__inside=1.0)),
    "c4_scatter_plane": (OMNI, changed(FISH, cgsp__all__tilted_over_facing=0.99)),
    "c6_centrality_both": (OMNI, changed(FISH, cgsp__all__rms_mm=1.3)),
}


@pytest.mark.parametrize("claim", BROKEN)
def test_claim_by_run_holds_and_fails(claim):
    holding = readings_of(JUDGES[claim], made(OMNI, FISH))
    assert {one.verdict for one in holding} == {"reproduced"}
    assert {one.reading["decoding_noise"] for one in holding} == {
        "bench, 7 x 7", "bench, white", "laboratory",
    }  # fmt: skip
    failing = readings_of(JUDGES[claim], made(*BROKEN[claim]))
    assert failing[0].verdict == "differs"


def test_primary_reading_uses_the_thesis_matched_noise():
    results = made(OMNI, FISH)
    laboratory = results["table_4_3_redrawn"]
    poor = at_every_noise(OMNI, laboratory=BROKEN["c4_omni_order_mag"][0])
    results["table_4_3_redrawn"] = of_columns(
        ({"camera": "omnidirectional"}, {k: np.full(50, v) for k, v in poor.items()}),
        (
            {"camera": "fisheye"},
            {
                name: laboratory.column(name, camera="fisheye")
                for name in at_every_noise(FISH)
            },
        ),
    )
    found = readings_of(JUDGES["c4_omni_order_mag"], results)
    verdicts = {
        one.reading["decoding_noise"]: one.verdict
        for one in found
        if one.reading["standard_method"] == "as printed"
    }
    assert verdicts == {
        "bench, 7 x 7": "reproduced", "bench, white": "reproduced",
        "laboratory": "differs",
    }  # fmt: skip
    assert found[0].reading["decoding_noise"] == "bench, 7 x 7"


BOARD = {"mean_mm": 1.0, "sd_mm": 0.5, "radial_bias": 0.1, "seam_ratio": 1.1}
LINE = {"worst_share": 0.004, "vertical_deg": 82.0}
POOR = {"mean_mm": 2.0, "sd_mm": 1.0, "radial_bias": 0.2, "seam_ratio": 2.0}
RIGHT = {
    "omnidirectional": camera(
        POOR | LINE | {"worst_share": 0.006, "vertical_deg": 80.0}
        | {"equal_depth_deg": 81.9},
        BOARD | LINE,
    ),
    "fisheye": camera(
        BOARD | LINE | {"mean_mm": 1.05, "skew_spearman": 0.5},
        BOARD | LINE | {"skew_spearman": 0.4},
    ),
}  # fmt: skip
WRONG = {
    "c4_unwrap_fov": ("omnidirectional", "printed.equal_depth_deg", 81.0),
    "c4_t44_omni": ("omnidirectional", "cgsp.sd_mm", 0.9),
    "c4_t44_fish": ("fisheye", "cgsp.mean_mm", 0.7),
    "c4_no_radial_bias": ("omnidirectional", "cgsp.radial_bias", 0.3),
    "c4_seams": ("omnidirectional", "cgsp.seam_ratio", 2.5),
    "c4_skew_amplifies": ("fisheye", "cgsp.skew_spearman", 0.2),
    "c4_lines_straight": ("fisheye", "printed.worst_share", 0.02),
}
NAMES = {"as_printed": "printed", "well_conditioned": "conditioned", "cgsp": "cgsp"}


def renamed(values):
    """Values by the names that the trials of corrected images use for methods."""
    return {
        ".".join([NAMES[name.split(".")[0]], *name.split(".")[1:]]): value
        for name, value in values.items()
    }


def trials(right):
    """Both experiments of corrected images, every trial alike."""
    result = of_columns(
        *(
            (
                {"camera": name},
                {k: np.full(50, v) for k, v in at_every_noise(one).items()},
            )
            for name, one in right.items()
        )
    )
    return {"fig_4_9_boards": result, "fig_4_7_lines": result}


def test_every_claim_with_noise_readings_is_tested():
    judged = {
        name
        for name, (_, mark) in MARKS.items()
        if "decoding_noise" in mark["readings"]
    }
    assert judged == {*BROKEN, *WRONG}


@pytest.mark.parametrize("claim", WRONG)
def test_corrected_image_claim_holds_and_fails(claim):
    right = {name: renamed(one) for name, one in RIGHT.items()}
    holding = readings_of(JUDGES[claim], trials(right))
    assert {one.verdict for one in holding} == {"reproduced"}
    name, column, value = WRONG[claim]
    assert column in right[name]
    broken = right | {name: right[name] | {column: value}}
    assert readings_of(JUDGES[claim], trials(broken))[0].verdict == "differs"


@pytest.mark.parametrize(
    ("below", "outcome"), [(0, "reproduced"), (2, "undecided"), (12, "differs")]
)
def test_caustic_claim_bounds_the_scatter_from_below(below, outcome):
    scatter = np.where(np.arange(50) < below, 0.19, 0.7)
    found = {"scatter_mm": scatter, "caustic_mm": np.full(50, 0.2)}
    assert verdict(JUDGES["c4_caustic_floor"], "exp_c4_caustic_floor", found) == outcome
