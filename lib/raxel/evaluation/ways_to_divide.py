"""Ways to divide photographs into halves in which a camera's faults may show.

By their order, and by where the board was and how it was turned: by nothing that the
fitted corners say, so halves of a sound set differ in no way by more than by chance.
"""

import numpy as np

from raxel.geometry.planes import on_plane
from raxel.geometry.poses import rotate, transform


def ways_to_divide(pairs):
    """Yields (by what boards are divided, (n,) bool: which are the first half).

    pairs: [(ImageScore, BoardView), ...], whose poses are known.
    """
    n = len(pairs)
    T = np.array([score.T_camera_grid for score, _ in pairs])
    middles = np.array([np.nanmean(view.pixels, axis=0) for _, view in pairs])
    centres = np.array([view.points.mean(axis=0) for _, view in pairs])
    at = transform(T, on_plane(centres)[:, None])[:, 0]
    distance = np.linalg.norm(at, axis=1)
    # How the board is looked at, in its own frame.
    x, y, _ = rotate(np.swapaxes(T, 1, 2), at[:, None])[:, 0].T / distance
    along, normal = T[:, :3, 0], T[:, :3, 2]
    yield "order of the photographs", np.arange(n) < n // 2
    yield "every other photograph", np.arange(n) % 2 == 0
    for name, values in (
        ("left and right in the image", middles[:, 0]),
        ("top and bottom in the image", middles[:, 1]),
        ("near and far", distance),
        ("tilted much and little", np.hypot(x, y)),
        ("tilted about one side of the board and the other", np.abs(x) - np.abs(y)),
        ("tilted about one diagonal of the board and the other", x * y),
        ("turned in the image", np.abs(along[:, 1]) - np.abs(along[:, 0])),
        ("leaning to the left and to the right", normal[:, 0]),
        ("leaning up and down", normal[:, 1]),
    ):
        yield name, np.argsort(np.argsort(values, kind="stable")) < n // 2
