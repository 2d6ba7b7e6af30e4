"""Small rigs in which every section and every kind of poses occurs."""

from tests.raxel.lab.test_rig import MIRROR, leaf, small_rig

BLEMISHES = {
    "spots": leaf(3, "1"),
    "spot_radius": leaf([1, 2], "px"),
    "spot_cover": leaf([0.5, 1], "1"),
    "spot_radiance": leaf([0, 1], "1"),
    "glare": leaf([0, 2], "1"),
    "glare_radius": leaf([5, 9], "px"),
    "glare_radiance": leaf([0.3, 1], "1"),
    "glare_within": leaf([0, 40], "px"),
    "haze": leaf(0.1, "1"),
}
LIGHT = {
    "tint": leaf([1, 0.9, 0.8], "1"),
    "level": leaf([0.5, 1], "1"),
    "slope": leaf([0, 0.3], "1"),
    "shadow_chance": leaf(0.5, "1"),
    "shadow_depth": leaf([0.2, 0.6], "1"),
    "shadow_radius": leaf([5, 9], "mm"),
    "shadow_edge": leaf([1, 3], "mm"),
    "surround": leaf(0.2, "1"),
}
OPTICS = {
    "blur_sd": leaf([0.6, 0.9], "px"),
    "exit_pupil": leaf(200, "px"),
    "falloff": {"radius": leaf([0, 90], "px"), "light": leaf([1, 0.6], "1")},
    "chromatic_scale": leaf([1.001, 1, 0.999], "1"),
    "centre": leaf([80, 60], "px"),
}
SENSOR = {
    "read_noise": leaf(20, "e"),
    "blooming": leaf(0.3, "1"),
    "response": {"charge": leaf([0, 0.3, 1], "1"), "value": leaf([0, 0.5, 1], "1")},
    "black_level": leaf(0.02, "1"),
    "bayer": "RGGB",
    "jpeg": leaf(80, "1"),
}
GRID = {
    "kind": "active_grid",
    "monitor_px": leaf([64, 48], "px"),
    "monitor_mm": leaf([64, 48], "mm"),
    "gamma": leaf(2.2, "1"),
    "black_level": leaf(0.02, "1"),
    "falloff_exponent": leaf(2, "1"),
    "white": leaf(1, "1"),
    "background": leaf(0.05, "1"),
    "gray_bits": leaf([2, 1], "1"),
    "gray_inverse": True,
    "phase_steps": leaf(3, "1"),
    "phase_periods": leaf([4, 2], "1"),
}
AROUND = {
    "kind": "around",
    "count": leaf(2, "1"),
    "evaluate": leaf(1, "1"),
    "centre": leaf([0, 0, 0], "mm"),
    "axis": leaf([0, 0, 1], "1"),
    "polar": leaf([0, 10], "deg"),
    "tilt": leaf([5, 30], "deg"),
    "subtense": leaf([30, 45], "deg"),
    "turn": leaf([-20, 20], "deg"),
    "margin": leaf(3, "px"),
    "least_spacing": leaf(4, "px"),
}
POSE = {"translation": leaf([-15, -10, 120], "mm"), "rotation": leaf([0, 20, 0], "deg")}
LISTED = {
    "kind": "listed",
    "margin": leaf(3, "px"),
    "least_spacing": leaf(4, "px"),
    "evaluate": leaf(1, "1"),
    "list": [POSE, POSE],
}


def rigs():
    """Plain data of the rigs."""
    plain = small_rig()
    far = plain["poses"] | {"distance": leaf([90, 110], "mm")}
    beside = plain["poses"] | {
        "distance": leaf([60, 90], "mm"),
        "off_axis": leaf([90, 120], "deg"),
        "margin": leaf(1, "px"),
        "least_spacing": leaf(1, "px"),
    }
    return [
        plain,
        plain | {"optics": OPTICS, "light": LIGHT, "blemishes": BLEMISHES},
        plain | {"sensor": plain["sensor"] | SENSOR, "poses": AROUND},
        plain | {"target": GRID, "poses": far},
        plain | {"poses": LISTED},
        plain | {"camera": MIRROR, "poses": beside},
    ]
