"""Whether a pupil moves: not for want of a law, not by chance, not by one law alone."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration import calibrate_lens
from raxel.calibration.parametric import lens_formula as lens_pupil
from raxel.calibration.parametric.lens_bundle import stacked
from raxel.calibration.parametric.lens_formula import (
    MOVES,
    RESTS,
    UNDECIDED,
    PupilTest,
    TestedLaw,
    _pupil_verdict,
    _ratio_test,
    _rms,
    agreed,
)
from raxel.evaluation.diagnoses import pupil_line
from raxel.sets.model import BOARDS
from tests.lens_scenes import SIZE, DrawnLens, boards


def bent(theta):
    """A radius with an even term, which no formula has."""
    return theta * (1 - 0.1 * theta + 0.02 * theta**3)


def test_unsuitable_law_shows_no_pupil_shift():
    views = boards(DrawnLens(bent, 300.0, (640, 480), 2.5), 8, (0.0, 1.2), seed=3)
    test = calibrate_lens(views, *SIZE, "kannala-brandt").pupil
    assert test.verdict == RESTS
    assert test.p_value > 0.01


@pytest.mark.parametrize(
    ("gain", "chance"),
    [
        ([1.0] * 6, 1 / 64),
        ([1.0] * 5, 1 / 32),
        # What one board gains is no gain of boards.
        ([100.0, -1, -2, -4], 0.5),
        ([1.0] * 28, 2.0**-14),
        ([-1.0, -1.0, -1.0], 1.0),
    ],
)
def test_randomisation_p_value_counts_sign_exchanges(gain, chance):
    assert lens_pupil._chance(np.array(gain)) == pytest.approx(chance, rel=0.2)


@pytest.mark.parametrize(
    ("gain", "chance", "verdict"),
    [
        (0.051, 0.01, MOVES),
        (0.049, 0.01, UNDECIDED),
        (0.051, 0.03, UNDECIDED),
        (0.5, 0.03, UNDECIDED),
        (-0.001, 0.01, RESTS),
    ],
)
def test_pupil_shift_must_lower_held_out_error_by_5_percent(gain, chance, verdict):
    for central_px in (0.02, 2.0):
        assert _pupil_verdict(central_px, (1 - gain) * central_px, chance) == verdict


def reported(verdict, central_px, moving_px):
    return PupilTest(1e-9, central_px, moving_px, 0.01, 2.0, 0.1, verdict)


def law(name, *test):
    return TestedLaw(name, None, None, reported(*test))


@pytest.mark.parametrize(
    ("own", "other", "verdict"),
    [
        ((MOVES, 0.30, 0.25), (RESTS, 0.20, 0.21), UNDECIDED),
        ((MOVES, 0.30, 0.15), (RESTS, 0.20, 0.21), MOVES),
        ((MOVES, 0.30, 0.25), (MOVES, 0.20, 0.19), MOVES),
        ((RESTS, 0.30, 0.31), (MOVES, 0.20, 0.19), UNDECIDED),
        ((UNDECIDED, 0.30, 0.29), (MOVES, 0.20, 0.19), UNDECIDED),
    ],
)
def test_better_law_must_agree_on_pupil(own, other, verdict):
    boards_seen = stacked([(np.zeros((4, 2)), np.zeros((4, 2)))])
    found = agreed(law("unified", *own), law("kannala-brandt", *other), boards_seen)
    assert found.verdict == verdict
    assert found.moves == (verdict == MOVES)
    against = own[0] != other[0] and verdict == UNDECIDED
    assert found.against == ("kannala-brandt" if against else "")


def test_undecided_pupil_shift_is_printed():
    pupil = reported(UNDECIDED, 0.3, 0.29)._asdict() | {"moves": False, "against": None}
    assert pupil_line(pupil, "mm", BOARDS) == (
        "entrance pupil",
        "undecided, taken as fixed (possible shift 2 +- 0.1 mm over the field of "
        "view); held-out boards: RMS 0.3 px without it, 0.29 px with it (p = 0.01)",
    )
    _, text = pupil_line(pupil | {"against": "unified"}, "mm", BOARDS)
    assert text.endswith(
        "0.29 px with it, but unified, which fits better, contradicts it"
    )


def test_pupil_false_positive_rate_follows_f_distribution():
    """Few corners: of 32 coordinates two poses and seven parameters leave thirteen."""
    rng, boards = np.random.default_rng(30), SimpleNamespace(seen=np.ones((2, 8), bool))
    formula = SimpleNamespace(names=tuple("abcdefg"), pupil=2)
    p_values = []
    for _ in range(1000):
        more, taken = 0.01 * rng.chisquare([13, 2])
        central, moving = (
            SimpleNamespace(formula=formula, result=SimpleNamespace(cost=cost))
            for cost in (more + taken, more)
        )
        p_values.append(_ratio_test(central, moving, boards))
    # Uniform: of a thousand, the mean is known to 0.009.
    assert np.mean(p_values) == pytest.approx(0.5, abs=0.03)
    assert np.mean(np.less(p_values, 0.1)) == pytest.approx(0.1, abs=0.03)


def test_held_out_error_pools_all_corners():
    rng, seen = np.random.default_rng(31), np.arange(20) < [[20], [3], [8], [5]]
    squares = rng.uniform(0, 1, seen.shape) * [[1], [9], [4], [1]]
    of_boards = np.array(
        [own[there].mean() for own, there in zip(squares, seen, strict=True)]
    )
    of_boards[3], known = np.nan, seen.copy()
    known[3] = False
    found = _rms(of_boards, SimpleNamespace(seen=seen))
    assert found == pytest.approx(np.sqrt(squares[known].mean()))
