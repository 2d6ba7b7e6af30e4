"""What the figures of 4.3 say about what they leave out, and in which units."""

import numpy as np

from chapters.ch04_central_generic.s3_2_results import figures as scatter
from chapters.ch04_central_generic.s3_3_correction.figures import difference
from chapters.ch04_central_generic.s3_4_motion.figures import path_of
from chapters.ch04_central_generic.s3_4_motion.results import SCALE
from tests.made_results import of_columns


def crossing(reach):
    """x, y and 1 for each of points up to so many mm beside the centre."""
    along = np.linspace(-reach, reach, 201)
    return np.column_stack([along, 0 * along, np.ones(201)])


def test_both_panels_of_a_camera_hold_the_wider_scatter():
    result = of_columns(
        (
            {"camera": "fisheye"},
            {
                "bench.as_printed.crossing": [crossing(10.0)],
                "bench.cgsp.crossing": [crossing(1.0)],
            },
        )
    )
    reach = scatter.shown_reach(result, "fisheye")
    x, _, _ = scatter.crossings(result, "fisheye", "as_printed")
    assert np.mean(abs(x) <= reach) >= scatter.SHOWN
    assert 10 < reach < 12


def test_a_difference_is_known_where_both_have_a_ray():
    printed = np.array([[0, 10, 200]], np.uint8)
    cgsp = np.array([[7, 0, 190]], np.uint8)
    np.testing.assert_array_equal(difference(printed, cgsp), [[np.nan, np.nan, -10.0]])


def test_the_path_goes_aside_in_millimetres_as_found():
    shifts = np.array([[20.0, 0.3, 0], [22.0, -0.3, 0]])
    path = path_of(shifts, np.array([0.0, 1, 0]))
    np.testing.assert_allclose(path[:, 1], [0, 0.3, 0], atol=1e-12)
    np.testing.assert_allclose(path[:, 0], [0, 21 - SCALE, 42], atol=1e-12)
