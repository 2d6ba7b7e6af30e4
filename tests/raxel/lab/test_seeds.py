"""What a seed decides: the noise of each image, and the spots of a specimen."""

import numpy as np
import pytest

from raxel.lab import load_rig, render_patterns, render_set
from raxel.sets import read_image
from tests.raxel.lab.test_rig import changed, leaf

POSE = {"translation": leaf([-15, -10, 120], "mm"), "rotation": leaf([0, 20, 0], "deg")}
# The same pose twice: only what is drawn for an image can differ between the two.
TWICE = {
    "kind": "listed",
    "list": [POSE, POSE],
    "margin": leaf(3, "px"),
    "least_spacing": leaf(1, "px"),
}
# So many electrons that the noise of light is below a grey level.
WITHOUT_NOISE = {"sensor__white": leaf(4e8, "e"), "sensor__full_well": leaf(5e8, "e")}
SPOTS = {
    "spots": leaf(40, "1"),
    "spot_radius": leaf([1.5, 3], "px"),
    "spot_cover": leaf([0.9, 0.9], "1"),
    "spot_radiance": leaf([0, 0], "1"),
}
MONITOR = {
    "kind": "active_grid",
    "monitor_px": leaf([32, 24], "px"),
    "monitor_mm": leaf([32, 24], "mm"),
    "gamma": leaf(2.2, "1"),
    "gray_bits": leaf([1, 0], "1"),
}


@pytest.fixture
def rendered(tmp_path):
    """Renders the small rig, changed, from a seed; its images (n, H, W) as int."""

    def render(seed, **changes):
        rig = load_rig(changed(tmp_path / "rig.yaml", poses=TWICE, **changes))
        image_set = render_set(rig, tmp_path / f"set-{seed}", seed)
        names = [view.image or view.white for view in image_set.views]
        return np.array([read_image(image_set, name) for name in names], int)

    return render


def test_noise_differs_by_image_and_seed(rendered):
    (one, two), (other, _) = rendered(0), rendered(1)
    for noise in (one - two, one - other):
        # The scene is the same: what differs has no mean, and is nowhere alike.
        assert abs(noise.mean()) < 0.1
        assert noise[one > 100].std() > 1
        assert np.mean(noise[one > 100] != 0) > 0.5


def test_spots_depend_on_seed_only(rendered):
    few, many = ({"blemishes": SPOTS | {"spots": leaf(n, "1")}} for n in (0, 40))
    clean, _ = rendered(0, **few, **WITHOUT_NOISE)
    one, two = rendered(5, **many, **WITHOUT_NOISE)
    other, _ = rendered(6, **many, **WITHOUT_NOISE)
    spotted, elsewhere = (np.abs(p - clean) > 30 for p in (one, other))
    assert spotted.sum() > 200
    assert np.abs(one - two).max() <= 1
    # Spots of two specimens meet by chance alone.
    assert (spotted & elsewhere).sum() < 0.5 * spotted.sum()


def test_monitor_noise_differs_by_pose_pattern_and_seed(rendered, tmp_path):
    (one, two), (other, _) = (rendered(seed, target=MONITOR) for seed in (0, 1))
    for noise in (one - two, one - other):
        assert abs(noise.mean()) < 0.1
        assert noise[one > 100].std() > 1
    fine = {"sensor__bits": leaf(16, "bit"), "target": MONITOR}
    rig = load_rig(changed(tmp_path / "fine.yaml", poses=TWICE, **fine))
    T = rig.draw_poses(np.random.default_rng(0), 1)[0]
    images = [image for _, image in render_patterns(rig, T, [0, 1, 0])]
    # The first rows show the room around the monitor, equal except for noise.
    rows = np.array(images, int)[:, :10].reshape(len(images), -1)
    assert np.abs(np.corrcoef(rows) - np.eye(len(rows))).max() < 0.1
