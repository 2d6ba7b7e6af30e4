"""Blooming of 3.2.2: corners and edges of the code in made-up images, and claims."""

import numpy as np
import pytest

from chapters.ch03_planar_grids.s2_2_active_grids import report, scenes
from raxel.sets.patterns import pattern_image, patterns_of, plan_of_cells
from tests.judged_claims import readings, verdict

SIZE, CELLS, CELL_PX = 144, 6, 24
PATTERNS = patterns_of(plan_of_cells((SIZE, SIZE), CELLS))
SPREAD = np.linspace(0.9, 1.1, 50)


def points_seen():
    """A image (H, W, 2) mm whose pixels are those of the monitor, a mm each."""
    v, u = np.indices((SIZE, SIZE))
    return np.stack([u + 0.5, v + 0.5], axis=-1)


def widened(pattern, by):
    """A pattern (H, W) uint8 whose bright stripes reach `by` px further up and down."""
    image = pattern_image(pattern, (SIZE, SIZE))
    moved = [np.roll(image, shift, axis=0) for shift in range(-by, by + 1)]
    return np.max(moved, axis=0)


@pytest.mark.parametrize("by", [(0, 0), (2, 2), (3, 1)])
def test_wide_stripes_shift_edges_but_not_their_midpoint(by):
    images = [widened(one, by[bool(one.inverse)]) for one in PATTERNS]
    found = scenes.edge_errors(images, PATTERNS, points_seen(), CELL_PX)
    assert found["one picture"] == pytest.approx(np.hypot(*by) / np.sqrt(2))
    assert found["midpoint"] == pytest.approx(abs(by[0] - by[1]) / 2)


def test_changing_bit_matches_the_gray_code():
    for bits in (3, 4):
        for edge in range(1, 2**bits):
            cells = np.array([edge - 1, edge])
            gray = cells ^ (cells >> 1)
            changed = [bits - 1 - k for k in range(bits) if np.ptp(gray >> k & 1)]
            assert changed == [scenes.changing_bit(edge, bits)]


def test_rows_near_the_monitor_edge_are_no_code_edges():
    seen = points_seen()[..., 1]
    seen[:20] = np.nan
    assert np.isnan(scenes.true_rows(seen, 30.0)).all()
    np.testing.assert_allclose(scenes.true_rows(seen, 40.0), 39.5)


def test_grid_error_is_measured_at_corners():
    light = scenes.light_of(scenes.drawn_pose(np.random.default_rng(0)))
    whole = scenes.corner_error_in_grid(light.points, light)
    assert whole["share"] == 1
    # Places are known to float32, and squares are bent by their perspective alone.
    assert whole["rms_px"] < 0.005
    half = light.points.copy()
    half[:, : SIZE // 2] = np.nan
    assert 0.3 < scenes.corner_error_in_grid(half, light)["share"] < 0.7
    moved = light.points + [0.5, 0.0]
    # Half a mm at 400 mm before a lens of 400 px.
    found = scenes.corner_error_in_grid(moved, light)["rms_px"]
    assert found == pytest.approx(0.5, rel=0.1)


def columns(sizes, growth):
    """The experiment's columns, of 50 trials each.

    sizes: {(what, which value): its size}; growth: by what overflow multiplies it.
    """
    return {
        f"{what}.{exposure}.{share}.{kind}": SPREAD * size * (growth if share else 1)
        for exposure in scenes.EXPOSURES
        for share in scenes.SHARES
        for (what, kind), size in sizes.items()
    }


def by_clipped(grid, masked, growth=1.0):
    """Verdicts of c3_blooming with sines kept and left out; corner methods have errors
    of 0.02 px, which overflow doubles.
    """
    made = columns({(name, "rms_px"): 0.02 for name in scenes.CORNER_METHODS}, 2.0)
    sizes = {"active grid": grid, "masked": masked}
    made |= columns({(name, "rms_px"): sizes[name] for name in sizes}, growth)
    made |= columns({(name, "share"): 1.0 for name in sizes}, 1.0)
    found = readings(report.judge_blooming, "exp_c3_blooming", made)
    return [(one.reading["clipped_sines"], one.verdict) for one in found]


def test_blooming_claim_depends_on_clipped_sines():
    better, worse = ("kept", "reproduced"), ("left out", "differs")
    assert by_clipped(0.01, 0.05) == [better, worse]
    assert by_clipped(0.01, np.nan) == [better, worse]
    assert by_clipped(0.05, 0.01) == [("kept", "differs"), ("left out", "reproduced")]
    # Smaller, and growing by more.
    assert by_clipped(0.005, 0.005, growth=7.0) == [("kept", "differs"), worse]


def test_midpoint_claim_uses_error_and_growth():
    def judged(midpoint, growth=2.0):
        one = columns({("edges", "one picture"): 1.0}, 2.0)
        made = one | columns({("edges", "midpoint"): midpoint}, growth)
        return verdict(report.judge_midpoints, "exp_c3_blooming", made)

    assert judged(0.3) == "reproduced"
    assert judged(1.0) == "differs"
    assert judged(0.3, growth=5.0) == "differs"
