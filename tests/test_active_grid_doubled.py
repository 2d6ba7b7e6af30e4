"""A bit of the code that was photographed in another's place, and so is there twice."""

import pytest

from tests.test_active_grid_doubts import first, number, scene


@pytest.mark.parametrize(
    ("bit", "other", "opposite"),
    [("x-02", "x-01", False), ("y-01", "x-01", False), ("x-01", "x-00", True)],
)
def test_a_bit_that_is_there_twice(bit, other, opposite):
    """In the place of another of its axis, of the other axis, or of its inverse."""
    images = scene().images.copy()
    for end in "", "-inverse":
        turned = "" if opposite and end else "-inverse" if opposite else end
        shown = scene(seed=1).images[number(f"gray-{other}{turned}")]
        images[number(f"gray-{bit}{end}")] = shown
    doubt = first(images)
    assert doubt.spoils
    (one, two) = sorted((bit, other))
    pairs = [f"gray-{k}.png and gray-{k}-inverse.png" for k in (two, one)]
    assert doubt.text.startswith(f"{pairs[0]}: the same stripes as of {pairs[1]}; ")
