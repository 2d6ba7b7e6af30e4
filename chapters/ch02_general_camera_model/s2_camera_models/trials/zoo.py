"""One room rendered by eight cameras of the collection."""

import numpy as np

from chapters.shared.zoo import camera

# Viewing directions: ahead, up into a mirror, away from plane mirrors.
AHEAD = np.eye(3)
UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
BACK = np.diag([-1.0, 1.0, -1.0])
ROOM = {
    "radial": AHEAD,
    "field of view": AHEAD,
    "equidistance": AHEAD,
    "stereographic": AHEAD,
    "hyperboloid mirror": UP,
    "two plane mirrors": BACK,
    "X-slits": AHEAD,
    "pushbroom": AHEAD,
}


def room_trial(condition, rng):
    """Render the room with one camera: image (h, w, 3) uint8."""
    from raxel.geometry import pose
    from raxel.lab.render import render
    from raxel.lab.room import room

    model = camera(condition["model"])
    T_world_camera = pose(ROOM[condition["model"]], np.zeros(3))
    radiance = render(
        model, T_world_camera, room(), colour=True, samples=condition["samples"]
    )
    # Display response of an ordinary screen.
    shown = 255 * np.clip(radiance / 1.1, 0, 1) ** (1 / 2.2)
    return {
        "picture": np.round(shown).astype(np.uint8),
        "mean": float(radiance.mean()),
        "seen": float(np.mean(radiance.max(axis=2) > 0)),
    }
