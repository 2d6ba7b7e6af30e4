"""Section 5.3.5, the tin: its geometry, its planes, and claims that can fail."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_5_tin import experiment, report
from chapters.shared.mirror.levels import BENCHES, SWEPT
from chapters.shared.mirror.rigs import mirror_rig
from raxel.errors import InputError
from raxel.geometry import transform
from tests.judged_claims import of_rejected, verdicts
from tests.made_results import of_levels

SEEDS = 40


def made(off=(0.1, -0.2, 0.3), normal=0.996, refused=0, swept=None):
    """Results of both experiments: angles with errors `off`, some runs rejected."""

    def columns(errors):
        angles = dict(
            zip(experiment.PAIRS, experiment.ANGLES_DEG + errors, strict=True)
        )
        found = {f"angle.{pair}": angle for pair, angle in angles.items()}
        found |= {f"qq.{face}": normal for face in experiment.FACES}
        found |= {f"qq_all.{face}": normal - 0.02 for face in experiment.FACES}
        found |= {"off_deg": np.abs(errors).max()}
        return lambda level: {
            f"{level}.{way}.{key}": np.where(np.arange(SEEDS) < refused, np.nan, value)
            for way in report.WAYS
            for key, value in found.items()
        }

    return of_levels(
        (report.RUNS, BENCHES, columns(off)),
        (report.SWEPT_RUNS, SWEPT, columns(off if swept is None else swept)),
    )


@pytest.mark.parametrize(
    ("judge", "results", "verdict"),
    [
        (report.judge_angles, made(), "reproduced"),
        (report.judge_angles, made(off=(0.1, -2.6, 0.3)), "differs"),
        (report.judge_normal, made(), "reproduced"),
        (report.judge_normal, made(normal=0.985), "differs"),
    ],
)
def test_tin_claim_holds_and_fails(judge, results, verdict):
    assert verdicts(judge, results) == (verdict, {verdict})


def test_sweep_and_rejected_runs_enter_the_verdict():
    turned = made(swept=(3.0, 0, 0))
    assert verdicts(report.judge_angles, turned) == ("undecided", {"reproduced"})
    found = of_rejected(report.judge_angles, made(refused=12))
    assert found == {("reproduced", "12 of 40", "differs")}


def test_faces_meet_at_the_reference_angles():
    normals = experiment.outward_normals()
    found = [
        experiment.angle_inside(normals[a], normals[b])
        for a, b in experiment.PAIRS.values()
    ]
    assert np.allclose(found, experiment.ANGLES_DEG, atol=1e-9)
    for face, normal in zip(experiment.faces(), normals, strict=True):
        R = face.T_tin_face[:3, :3]
        assert np.allclose(R.T @ R, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) > 0
        assert np.allclose(R[:, 2], -normal, atol=1e-12)
        # The body is on the inner side of each face.
        assert np.all(normal @ np.array([-20.0, -20.0, -20.0]) < 0)


def test_exact_matches_give_the_exact_tin():
    camera = mirror_rig("A").camera(15.0)
    rng = np.random.default_rng(4)
    T = experiment.two_places(camera, rng)
    shift = T[1][:3, 3] - T[0][:3, 3]
    assert np.isclose(np.linalg.norm(shift), experiment.SHIFT_MM)
    points, face = experiment.tin_points(rng, 120)
    pixels = np.stack([camera.project(transform(one, points)).pixels for one in T])
    found = experiment.scored(camera, pixels, face, experiment.motion_of(T))
    assert found["points"] == 120
    assert found["off_deg"] < 1e-4
    assert found["rms_mm"] < 1e-4


def test_image_matches_lie_on_the_tin():
    """Each image has a window of its own; what the truth says of a match holds."""
    rig, rng = mirror_rig("A", small=True), np.random.default_rng(2)
    camera = rig.camera(15.0)
    taken = experiment.taken_images(rig, camera, 4, rng)
    assert not np.allclose(*taken.first)
    on = taken.face >= 0
    assert np.count_nonzero(on) > 300
    assert np.median(np.abs(taken.off[on])) < 0.2
    found = experiment.model(camera, taken)
    assert found["off_deg"] < 1.0
    assert found["wrong_kept"] <= 2
    # The sheets are the planes: they meet in one corner, at the angles found.
    sheets = [found[f"sheet.{name}"] for name in experiment.FACES]
    assert np.allclose([one[0, 0] for one in sheets], sheets[0][0, 0], atol=1e-6)
    normals = [np.cross(one[0, 1] - one[0, 0], one[1, 0] - one[0, 0]) for one in sheets]
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    for pair, (first, second) in experiment.PAIRS.items():
        cosine = np.cos(np.radians(found[f"angle.{pair}"]))
        assert np.isclose(abs(normals[first] @ normals[second]), abs(cosine), atol=1e-6)


def test_normality_detects_outliers_and_other_laws():
    rng = np.random.default_rng(1)
    distances = rng.normal(0, 0.2, 150)
    assert experiment.normality(distances) > 0.99
    distances[:3] = [3.0, -4.0, 5.0]
    assert np.count_nonzero(~experiment.usual(distances)) >= 3
    assert (
        experiment.normality(distances)
        > 0.985
        > experiment.normality(distances, np.inf)
    )
    assert experiment.normality(rng.exponential(1.0, 150)) < 0.985


def test_face_without_points_is_rejected():
    points, face = experiment.tin_points(np.random.default_rng(0), 90)
    with pytest.raises(InputError, match="top face"):
        experiment.tin_through(points[face > 0], face[face > 0])
