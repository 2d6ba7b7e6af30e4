"""Result files of mirror sets that are wrong in one way each, and the command."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.cameras import Rays
from raxel.errors import InputError
from raxel.evaluation.mirror_result import read_mirror_result, sampled_result

ROWS = 40
LINES = np.arange(ROWS)


def fields(**changed):
    """The fields of a result of one stage; None takes one out."""
    along = np.column_stack([LINES, LINES, LINES]).astype(float)
    given = {
        "raxel_mirror_result": 1,
        "set": "bent",
        "size": [320, 240],
        "unit": "mm",
        "frame": "viewer",
        "stages": 1,
        "stage0.pixels": 4.0 * along[:, :2],
        "stage0.origins": along,
        "stage0.directions": np.tile([0.0, 0.6, 0.8], (ROWS, 1)),
        "stage0.points": along,
        "seconds": 2.5,
        "method": "by hand",
    }
    given |= {name.replace("__", "."): value for name, value in changed.items()}
    return {name: value for name, value in given.items() if value is not None}


def with_row(values, row, k=7):
    changed = np.array(values, float)
    changed[k] = row
    return changed


SOUND = fields()
NOT_UNIT = with_row(SOUND["stage0.directions"], [0, 0, 3.2])
FAULTS = {
    "another file": ({"raxel_mirror_result": None}, "raxel_mirror_result': missing"),
    "a later version": ({"raxel_mirror_result": 2}, "found 2; give 1 of this format"),
    "metres": ({"unit": "m"}, "'unit': found 'm'; give 'mm' for all lengths"),
    "no unit": ({"unit": None}, "'unit': missing; give it as"),
    "a frame": ({"frame": "mirror"}, "'frame': found 'mirror'; give 'viewer' with its"),
    "no stages": ({"stages": 0}, "found 0; give a whole number, 1 to 1001"),
    "a stage and a half": ({"stages": 1.5}, "found 1.5; give a whole number"),
    "a missing stage": ({"stages": 2}, "'stage1': missing; give its pixels, origins"),
    "no pixels": ({"stage0__pixels": None}, "'stage0.pixels': missing"),
    "no directions": ({"stage0__directions": None}, "'stage0.directions': missing"),
    "fewer origins": (
        {"stage0__origins": np.zeros((3, 3))},
        "'stage0.origins': shape (3, 3) found; (40, 3) needed",
    ),
    "flat points": (
        {"stage0__points": np.zeros(12)},
        "'stage0.points': shape (12,) found; (N, 3) needed",
    ),
    "NaN": (
        {"stage0__origins": with_row(SOUND["stage0.origins"], np.nan)},
        "found 1 of 40 rows with numbers that are not finite; leave such",
    ),
    "infinity": (
        {"stage0__points": with_row(SOUND["stage0.points"], np.inf)},
        "'stage0.points': found 1 of 40 rows",
    ),
    "complex": (
        {"stage0__points": np.zeros((5, 3), complex)},
        "numbers of at most 64 bit",
    ),
    "texts": ({"stage0__points": [["a", "b", "c"]]}, "found <U1; numbers are needed"),
    "far away": (
        {"stage0__origins": with_row(SOUND["stage0.origins"], [0, 0, 2e6])},
        "found 2e+06 mm; nothing is so far",
    ),
    "not unit": ({"stage0__directions": NOT_UNIT}, "found one 3.2 long; give unit"),
    "beyond all numbers": (
        {"stage0__directions": 1e300 * NOT_UNIT},
        "long; give unit vectors",
    ),
    "outside": (
        {"stage0__pixels": with_row(SOUND["stage0.pixels"], [320, 0])},
        "found [320.0, 0.0] outside a picture of 320 x 240 px; give (column, row)",
    ),
    "twice": (
        {"stage0__pixels": with_row(SOUND["stage0.pixels"], [0, 0])},
        "'stage0.pixels': found a pixel twice",
    ),
    "no seconds": (
        {"seconds": -1.0},
        "'seconds': found -1.0; give a number, 0 or more",
    ),
    "endless": ({"seconds": np.inf}, "'seconds': found inf; give a finite number"),
    "two lines": ({"method": "a\nb"}, "'method': found 'a b'; give a text of one line"),
    "long": ({"method": "a" * 101}, "or a short text, are needed"),
    "no name": ({"set": 3}, "'set': found '3'; give a text of one line"),
    "two names": ({"set": ["a", "b"]}, "'set': found no single number or text"),
    "no size": ({"size": [320.5, 240]}, "give the width and height in pixels"),
    "no picture": ({"size": [3.2e5, 240]}, "no picture is so large"),
    "half a viewer": (
        {"viewer__pixels": np.zeros((1, 2))},
        "'viewer.directions': missing",
    ),
}


def test_a_sound_file_is_read(tmp_path):
    path = tmp_path / "result.npz"
    np.savez(path, **SOUND)
    found = read_mirror_result(path)
    assert (found.set, found.size, found.seconds) == ("bent", (320, 240), 2.5)
    assert (found.method, found.viewer) == ("by hand", None)
    np.testing.assert_array_equal(found.stages[0].rays.pixels, SOUND["stage0.pixels"])


@pytest.mark.parametrize("name", FAULTS)
def test_what_is_wrong_is_said_in_a_line(name, tmp_path):
    changes, fault = FAULTS[name]
    path = tmp_path / "result.npz"
    np.savez(path, **fields(**changes))
    with pytest.raises(InputError) as refused:
        read_mirror_result(path)
    line = str(refused.value)
    assert line.startswith(f"{path}: field '")
    assert fault in line
    assert line.isprintable()


def test_a_picture_ends_half_a_pixel_beyond_its_outermost_centres(tmp_path):
    ends = np.array([[-0.5, -0.5], [319.5, 239.5], [-0.5, 239.5], [319.5, -0.5]])
    given = SOUND["stage0.pixels"].copy()
    given[:4] = ends
    path = tmp_path / "ends.npz"
    np.savez(path, **fields(stage0__pixels=given))
    read = read_mirror_result(path).stages[0].rays.pixels
    np.testing.assert_array_equal(read[:4], ends)
    for end in ends:
        beyond = end + 0.01 * np.sign(end - [160, 120])
        np.savez(path, **fields(stage0__pixels=with_row(given, beyond)))
        with pytest.raises(InputError, match="outside a picture of 320 x 240 px"):
            read_mirror_result(path)


def test_a_result_has_of_each_pixel_its_own_ray_and_its_viewers_own():
    """Every second pixel has a ray, and every third a viewer's."""
    pixels = np.column_stack([np.arange(30.0), 2 * np.arange(30.0)])

    def camera(every):
        own = np.arange(30) % every == every - 1
        at = np.where(own[:, None], np.column_stack([pixels, np.arange(30)]), np.nan)
        return SimpleNamespace(rays=lambda _: Rays(at, at + 1, own))

    seen = camera(2)
    seen.viewer = camera(3)
    found = sampled_result(SimpleNamespace(name="a", size=(40, 80)), [seen], pixels)
    rays = found.stages[0].rays
    assert len(rays.pixels) == 15
    np.testing.assert_array_equal(rays.pixels, rays.origins[:, :2])
    np.testing.assert_array_equal(rays.pixels, rays.directions[:, :2] - 1)
    assert len(found.viewer[0]) == 10
    np.testing.assert_array_equal(found.viewer[0], found.viewer[1][:, :2] - 1)
