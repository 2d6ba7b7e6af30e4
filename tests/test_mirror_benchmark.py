"""Scores of mirror results: none for the truth, the known ones for known errors."""

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.evaluation.mirror_benchmark import (
    CELL_MM,
    NEAR_MM,
    STEP_PX,
    _error_at,
    score_mirror,
    scored_pixels,
)
from raxel.evaluation.mirror_mistakes import check_points
from raxel.evaluation.mirror_result import (
    SampledRays,
    StageAnswer,
    read_mirror_result,
    write_mirror_result,
)
from raxel.geometry import pose, rotation_from_vector, transform
from tests.scored_mirrors import STAGES, true_mirror, true_result, write_scored_set


@pytest.fixture(scope="module")
def mirror_set(tmp_path_factory):
    return write_scored_set(tmp_path_factory.mktemp("scored") / "set")


@pytest.fixture(scope="module")
def truth(mirror_set):
    return true_result(mirror_set)


def changed(result, change, stages=(0, 1, 2)):
    """The result with change(pixels, origins, directions, points) in some stages."""
    found = list(result.stages)
    for k in stages:
        *rays, points = change(*found[k].rays, found[k].points)
        found[k] = StageAnswer(SampledRays(*rays), points)
    return result._replace(stages=tuple(found))


def moved(T, result):
    """The result in a frame that has the pose T of the viewer's."""

    def change(pixels, origins, directions, points):
        turned = directions @ T[:3, :3].T
        return pixels, transform(T, origins), turned, transform(T, points)

    pixels, directions = result.viewer
    result = changed(result, change)
    return result._replace(viewer=(pixels, directions @ T[:3, :3].T))


def test_the_truth_has_no_errors(mirror_set, truth):
    scores = score_mirror(mirror_set, truth)
    assert (scores["method"], scores["seconds"]) == ("the truth", 1.5)
    assert scores["turned_deg"] < 1e-9
    for stage in [*scores["stages"], scores["all"]]:
        rays, height = stage["rays"], stage["height"]
        assert rays["share_with_ray"] == rays["share_right"] == 1
        assert rays["max_deg"] < 1e-9
        assert rays["max_mm"] < 1e-9
        assert height["max_mm"] < 1e-9
        assert height["share_covered"] > 0.5
    assert scores["all"]["deflection_rms_mm"] < 1e-9
    assert [stage["stage"] for stage in scores["stages"]] == [0, 1, 2]
    for stage, set_to in zip(scores["stages"], STAGES, strict=True):
        for load, moved in zip(stage["deflections"], set_to, strict=True):
            assert load["read_at_mm"] == 0.75 * load["load_mm"]
            assert load["found_mm"] == pytest.approx(load["true_mm"], abs=1e-9)
            assert 0.4 * moved <= load["true_mm"] <= moved
    pixels = [stage["rays"]["pixels"] for stage in scores["stages"]]
    assert scores["all"]["rays"]["pixels"] == sum(pixels) > 1000


def test_known_errors_of_rays_have_their_sizes(mirror_set, truth):
    rng = np.random.default_rng(1)
    angle, aside = np.radians(0.25), 0.4

    def change(pixels, origins, directions, points):
        across = np.cross(directions, rng.normal(size=directions.shape))
        across /= np.linalg.norm(across, axis=1)[:, None]
        turned = np.cos(angle) * directions + np.sin(angle) * across
        normal = np.cross(directions, across)
        # Along its ray an origin may lie anywhere.
        along = rng.uniform(-50, 50, (len(pixels), 1)) * turned
        return pixels, origins + aside * normal + along, turned, points

    scores = score_mirror(mirror_set, changed(truth, change, [1]))
    rays = scores["stages"][1]["rays"]
    for name in ("rms_deg", "median_deg", "max_deg"):
        assert rays[name] == pytest.approx(0.25, rel=1e-6)
    assert rays["rms_mm"] == pytest.approx(aside, rel=1e-6)
    assert (rays["share_with_ray"], rays["share_right"]) == (1, 0)
    assert scores["stages"][2]["rays"]["max_deg"] < 1e-9
    n = [stage["rays"]["pixels"] for stage in scores["stages"]]
    rms = 0.25 * np.sqrt(n[1] / sum(n))
    assert scores["all"]["rays"]["rms_deg"] == pytest.approx(rms, rel=1e-6)


def test_known_errors_of_the_shape_have_their_sizes(mirror_set, truth):
    camera = true_mirror(STAGES[2])
    R, t = camera.T_viewer_mirror[:3, :3], camera.T_viewer_mirror[:3, 3]

    def lifted(pixels, origins, directions, points):
        place = (points - t) @ R
        # A sheet whose heights are 2 % too large, from the clamp on.
        place[:, 2] += 0.02 * place[:, 0]
        return pixels, origins, directions, place @ R.T + t

    scores = score_mirror(mirror_set, changed(truth, lifted, [2]))
    stage = scores["stages"][2]
    x, _, _ = camera.mirror.point(camera.mirror.nodes().reshape(-1, 2))[0].T
    assert stage["height"]["max_mm"] == pytest.approx(0.02 * x.max(), abs=0.15)
    even = 0.02 * camera.mirror.end * np.array([1 / 2, 1 / np.sqrt(3)])
    covered = stage["height"]["mean_mm"], stage["height"]["rms_mm"]
    np.testing.assert_allclose(covered, even, rtol=0.05)
    errors = []
    for load in stage["deflections"]:
        # The bent sheet has come back a little towards the clamp.
        errors.append(load["error_mm"])
        assert 0.99 < errors[-1] / (0.02 * load["read_at_mm"]) < 1
    assert scores["stages"][1]["deflections"][0]["error_mm"] == pytest.approx(0)
    expected = np.sqrt(np.mean(np.square(errors)) / 2)
    assert scores["all"]["deflection_rms_mm"] == pytest.approx(expected)


def test_heights_towards_the_light_are_negative(mirror_set, truth):
    away = true_mirror(STAGES[1]).T_viewer_mirror[:3, 2]

    def sunk(pixels, origins, directions, points):
        return pixels, origins, directions, points - 0.3 * away

    height = score_mirror(mirror_set, changed(truth, sunk, [1]))["stages"][1]["height"]
    assert height["mean_mm"] == pytest.approx(-0.3, abs=1e-6)
    assert height["rms_mm"] == pytest.approx(0.3, abs=1e-6)


def test_many_points_in_one_place_count_once(mirror_set, truth):
    camera = true_mirror(STAGES[1])
    away = camera.T_viewer_mirror[:3, 2]

    def crowded(pixels, origins, directions, points):
        corner = np.repeat(points[:1], 5000, axis=0) + 0.3 * away
        return pixels, origins, directions, np.concatenate([points, corner])

    height = score_mirror(mirror_set, changed(truth, crowded, [1]))["stages"][1][
        "height"
    ]
    assert height["max_mm"] == pytest.approx(0.3, rel=0.01)
    cells = height["cells"] * height["share_covered"]
    assert height["rms_mm"] == pytest.approx(0.3 / np.sqrt(cells), rel=0.01)
    assert height["cells"] == pytest.approx(160 * 100 / CELL_MM**2, rel=0.03)


def test_the_choice_of_the_viewers_axes_costs_nothing(mirror_set, truth):
    R = rotation_from_vector(np.radians([0.2, -0.1, 0.3]))
    scores = score_mirror(mirror_set, moved(pose(R, np.zeros(3)), truth))
    assert scores["turned_deg"] == pytest.approx(np.sqrt(0.14), rel=1e-6)
    assert scores["viewer_rms_deg"] < 1e-9
    assert scores["all"]["rays"]["max_deg"] < 1e-9
    assert scores["all"]["rays"]["max_mm"] < 1e-9
    assert scores["all"]["height"]["max_mm"] < 1e-9
    bare = moved(pose(R, np.zeros(3)), truth)._replace(viewer=None)
    scores = score_mirror(mirror_set, bare)
    assert scores["viewer_rms_deg"] is None
    assert 0.2 < scores["all"]["rays"]["rms_deg"] < 0.4


def test_stages_may_be_left_open_and_pixels_left_out(mirror_set, truth):
    none = StageAnswer(SampledRays(np.empty((0, 2)), *np.empty((2, 0, 3))), None)
    half = changed(truth, lambda *parts: (*(part[::2] for part in parts[:3]), parts[3]))
    result = half._replace(stages=(*half.stages[:2], none))
    scores = score_mirror(mirror_set, result)
    shares = [stage["rays"]["share_with_ray"] for stage in scores["stages"]]
    assert shares == pytest.approx([0.5, 0.5, 0], abs=0.01)
    assert scores["stages"][0]["rays"]["share_right"] == shares[0]
    last = scores["stages"][2]
    assert last["rays"]["share_right"] == last["height"]["share_covered"] == 0
    assert last["rays"]["rms_deg"] is last["height"]["rms_mm"] is None
    assert last["deflections"][0]["found_mm"] is None
    assert scores["all"]["deflection_rms_mm"] is None
    points = truth._replace(
        stages=tuple(stage._replace(rays=None) for stage in truth.stages)
    )
    scores = score_mirror(mirror_set, points)
    assert scores["all"]["rays"]["share_with_ray"] == 0
    assert scores["all"]["deflection_rms_mm"] < 1e-9


def test_pixels_that_are_not_scored_change_nothing(mirror_set, truth):
    def more(pixels, origins, directions, points):
        beside = pixels[:40] + 3.0
        wrong = np.tile([0.0, 0.0, -1.0], (40, 1))
        rays = [pixels, beside], [origins, origins[:40]], [directions, wrong]
        return *map(np.concatenate, rays), points

    scores = score_mirror(mirror_set, changed(truth, more))
    assert scores["all"]["rays"]["max_deg"] < 1e-9


def test_what_is_written_is_read(mirror_set, truth, tmp_path):
    path = tmp_path / "result.npz"
    write_mirror_result(path, truth)
    again = read_mirror_result(path)
    for name in ("set", "size", "seconds", "method"):
        assert getattr(again, name) == getattr(truth, name)
    for one, other in zip(again.stages, truth.stages, strict=True):
        for mine, its in zip(one.rays, other.rays, strict=True):
            np.testing.assert_allclose(mine, its, atol=1e-15)
        np.testing.assert_array_equal(one.points, other.points)
    write_mirror_result(
        path,
        truth._replace(
            viewer=None,
            seconds=None,
            method="",
            stages=tuple(stage._replace(points=None) for stage in truth.stages),
        ),
    )
    again = read_mirror_result(path)
    assert (again.viewer, again.seconds, again.method) == (None, None, "")
    assert again.stages[0].points is None


FLIPPED = np.array([1.0, -1.0, -1.0])
MISTAKES = {
    "metres": (
        lambda p, o, d, s: (p, o / 1000, d, s / 1000),
        "stage0.directions': the rays fit as ones given in metres; give mm",
    ),
    "inches of points alone": (
        lambda p, o, d, s: (p, o, d, s / 25.4),
        "stage0.points': the points fit as ones given in inches; give mm",
    ),
    "reversed": (
        lambda p, o, d, s: (p, o, -d, s),
        "from the scene towards the mirror; give directions from the mirror towards",
    ),
    "another frame": (
        lambda p, o, d, s: (p, o * FLIPPED, d * FLIPPED, s),
        "with y up and z towards the viewer; give mm in the viewer's frame",
    ),
    "the mirror's frame": (
        lambda p, o, d, s: (
            *(p, o, d),
            transform(np.linalg.inv(true_mirror(STAGES[0]).T_viewer_mirror), s),
        ),
        "stage0.points': the points fit as ones given in the mirror's frame",
    ),
    "far away": (
        lambda p, o, d, s: (p, o, d, s + [0, 0, 900.0]),
        "stage0.points': the points lie about (8.02, 0.665",
    ),
    "nonsense": (
        lambda p, o, d, s: (p, o, np.tile([0, 0, 1.0], (len(p), 1)), s),
        "degrees from the true ones and pass their places on the mirror by",
    ),
    "too few": (
        lambda p, o, d, s: (p[:20], o[:20], d[:20], s),
        "stage0.pixels': 20 of 20 are scored; give every 8th each way, from (0, 0)",
    ),
    "pixels from 1": (
        lambda p, o, d, s: (p + 1, o, d, s),
        "are scored; give every 8th each way, from (0, 0), 30 at least",
    ),
    "few points": (
        lambda p, o, d, s: (p, o, d, s[:7]),
        "stage0.points': found 7; give 30 or more",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_what_is_told_otherwise_than_asked_for_is_refused(name, mirror_set, truth):
    change, fault = MISTAKES[name]
    with pytest.raises(InputError) as refused:
        score_mirror(mirror_set, changed(truth, change))
    assert fault in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("way", np.vstack([np.eye(3), -np.eye(3)]).tolist())
def test_points_beside_the_sheet_are_refused_on_every_side(way):
    camera = true_mirror(STAGES[0])
    sheet = camera.mirror.point(camera.mirror.nodes().reshape(-1, 2))[0]
    aside = sheet + 1.5 * camera.mirror.size.max() * np.array(way)
    with pytest.raises(InputError, match=r"a: the points lie about .* and the mirror"):
        check_points("a", transform(camera.T_viewer_mirror, aside), camera)


def test_a_poor_result_is_scored(mirror_set, truth):
    R = rotation_from_vector(np.radians([0.0, 4.0, 0.0]))

    def change(pixels, origins, directions, points):
        return pixels, origins, directions @ R.T, points

    rays = score_mirror(mirror_set, changed(truth, change))["all"]["rays"]
    assert 2 < rays["median_deg"] <= 4


def test_rows_and_columns_exchanged_are_refused(mirror_set, truth):
    # Only of a mirror that is seen about the middle of the picture does enough remain.
    def change(pixels, origins, directions, points):
        inside = pixels[:, 0] < mirror_set.size[1]
        rays = pixels[inside][:, ::-1], origins[inside], directions[inside]
        return *rays, points

    with pytest.raises(InputError, match=r"as ones given at pixels \(row, column\)"):
        score_mirror(mirror_set, changed(truth, change))


def test_results_of_other_sets_are_refused(mirror_set, truth, tmp_path):
    for change, fault in (
        ({"set": "other"}, "field 'set': found 'other', and the set is 'bent'"),
        ({"size": (640, 480)}, "field 'size': found 640 x 480 px, and the set has 320"),
        ({"stages": truth.stages[:2]}, "field 'stages': found 2, and the set has 3"),
        ({"viewer": tuple(v[:9] for v in truth.viewer)}, "viewer.pixels': found 9"),
        (
            {"viewer": (truth.viewer[0], truth.viewer[1] * [1, -1, -1])},
            "viewer.directions': turned by 180 degrees",
        ),
        (
            {"viewer": (truth.viewer[0], 0 * truth.viewer[1] + [0, 0, 1])},
            "field 'viewer.directions': parallel",
        ),
    ):
        with pytest.raises(InputError) as refused:
            score_mirror(mirror_set, truth._replace(**change))
        assert fault in str(refused.value)


def test_scored_pixels_are_every_eighth():
    pixels = scored_pixels((20, 17))
    assert STEP_PX == 8
    assert pixels.tolist() == [[u, v] for v in (0, 8, 16) for u in (0, 8, 16)]


def test_a_deflection_is_that_of_a_sloping_face_at_the_force_itself():
    x, y = np.random.default_rng(2).uniform(0, 0.7 * NEAR_MM, (2, 40))
    assert _error_at(x, y, 0.3 + 0.02 * x - 0.05 * y) == pytest.approx(0.3)
    assert np.isnan(_error_at(x + NEAR_MM, y, x))
