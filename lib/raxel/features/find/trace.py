"""Following the four edges of every corner to the next corner.

No model and no prediction: one step along the edge, then across to the strongest
gradient. Along an edge the same side is bright; where it passes a corner the sides
change, so a trace knows that it has passed one even if nobody found it.
"""

from typing import NamedTuple

import numpy as np

from raxel.features.find.ring import paint, pixels_of, remapped

STEP = 2.0
START = 3.0
ACROSS, REACH = 0.6, 3
CAUGHT = 2.6
# After so many steps a trace goes on in the next halved copy.
STEPS_PER_LEVEL = 30
WEAK = 0.22
WEAK_STEPS = 5
TURNING = 0.3
MEMORY = 4
ARRIVAL = np.radians(38)
# Slope across an edge (grey levels over 2 ACROSS) as a share of the ring's contrast.
USUAL_SLOPE = 0.12


class Atlas(NamedTuple):
    """All levels in one picture: grey and the known corners (index + 1, 0 for none).

    left, top, width, height, scale: (levels,) where each lies and what it shows.
    """

    grey: np.ndarray
    known: np.ndarray
    left: np.ndarray
    top: np.ndarray
    width: np.ndarray
    height: np.ndarray
    scale: np.ndarray


def atlas_of(levels, points):
    """The Atlas of the levels with corners `points` (N, 2) of the image."""
    sizes = np.array([level.grey.shape for level in levels])
    height, width = sizes.T
    top = np.concatenate([[0, 0], np.cumsum(height[1:-1])])[: len(levels)]
    left = np.where(np.arange(len(levels)) == 0, 0, width[0])
    shape = (top + height).max(), (left + width).max()
    grey, known = np.zeros(shape, np.float32), np.zeros(shape, np.int32)
    numbers = np.arange(1, len(points) + 1)
    for level, x, y, w, h in zip(levels, left, top, width, height, strict=True):
        room = slice(y, y + h), slice(x, x + w)
        grey[room] = level.grey
        place = pixels_of(points / level.scale, (h, w))
        paint(known[room], place, numbers, CAUGHT)
    scale = np.array([level.scale for level in levels], np.float32)
    left, top = left.astype(np.float32), top.astype(np.float32)
    sizes = width.astype(np.float32), height.astype(np.float32)
    return Atlas(grey, known, left, top, *sizes, scale)


class Arms(NamedTuple):
    """Edges to follow: from points (N, 2) px at angles (N,); signs (N,), contrast (N,)
    and level (N,) as of `ring.Nodes`; own (N,): index of the corner each leaves."""

    points: np.ndarray
    angles: np.ndarray
    signs: np.ndarray
    contrast: np.ndarray
    level: np.ndarray
    own: np.ndarray


def links_of(nodes, levels):
    """Index (N, 4, 2) of (node, arm) that each arm leads to and back; -1 for none."""
    arms = Arms(
        np.repeat(nodes.points, 4, axis=0),
        nodes.angles.ravel(),
        nodes.signs.ravel(),
        np.repeat(nodes.contrast, 4),
        np.repeat(nodes.level, 4),
        np.repeat(np.arange(len(nodes.points)), 4),
    )
    ends, heading = _traced(arms, atlas_of(levels, nodes.points))
    return _mutual(nodes, ends.reshape(-1, 4), heading.reshape(-1, 4))


def _traced(arms, atlas):
    """(corner reached (N,) or -1, heading there (N,)) of Arms in the Atlas."""
    count, angle = len(arms.points), arms.angles
    end, heading = np.full(count, -1), angle.copy()
    own, level = arms.own, arms.level
    sign = arms.signs.astype(np.float32)[:, None]
    d = np.stack([np.cos(angle), np.sin(angle)], axis=1).astype(np.float32)
    p = (arms.points / atlas.scale[level][:, None] + START * d).astype(np.float32)
    reference = (USUAL_SLOPE * arms.contrast).astype(np.float32)
    past = np.repeat(p[None], MEMORY, axis=0)
    weak = np.zeros(count, int)
    arm = np.arange(count)
    for step in range(1, STEPS_PER_LEVEL * len(atlas.scale) + 1):
        at, strength, back = _stepped(atlas, level, p + STEP * d, d, sign)
        least = WEAK * reference
        strong = strength > least
        p = p + STEP * d
        p[strong] = at[strong]
        reference = np.where(strong, 0.9 * reference + 0.1 * strength, reference)
        weak = np.where(strong, 0, weak + 1)
        if step > MEMORY:
            moved = p - past[step % MEMORY]
            moved /= np.linalg.norm(moved, axis=1, keepdims=True) + 1e-9
            d = np.where(strong[:, None], (1 - TURNING) * d + TURNING * moved, d)
            d /= np.linalg.norm(d, axis=1, keepdims=True)
        past[step % MEMORY] = p
        inside, here = _looked_up(atlas, level, p)
        caught = inside & (here >= 0) & (here != own)
        end[arm[caught]] = here[caught]
        heading[arm[caught]] = np.arctan2(d[caught, 1], d[caught, 0])
        flipped = ~strong & (back > 2 * least)
        stop = caught | ~inside | flipped | (weak >= WEAK_STEPS)
        if step % STEPS_PER_LEVEL == 0:
            stop |= level == len(atlas.scale) - 1
            ratio = atlas.scale[np.minimum(level + 1, len(atlas.scale) - 1)]
            ratio = (ratio / atlas.scale[level])[:, None]
            level, p, past = level + 1, p / ratio, past / ratio
        go = ~stop
        if not go.any():
            break
        if stop.any():
            arm, own, sign, level, weak = (a[go] for a in (arm, own, sign, level, weak))
            d, p, past, reference = d[go], p[go], past[:, go], reference[go]
    return end, heading


def _stepped(atlas, level, p, d, sign):
    """Across from p to the strongest slope: (there, its height, largest opposite)."""
    import cv2

    offsets = (ACROSS * np.arange(-REACH - 1, REACH + 2)).astype(np.float32)
    normal = np.stack([-d[:, 1], d[:, 0]], axis=1)
    # A remap clips at the atlas's border, not at the level's: stay inside it.
    u = np.clip(p[:, 0], 0, atlas.width[level] - 1) + atlas.left[level]
    v = np.clip(p[:, 1], 0, atlas.height[level] - 1) + atlas.top[level]
    u = u[:, None] + normal[:, :1] * offsets
    v = v[:, None] + normal[:, 1:] * offsets
    profile = remapped(atlas.grey, u, v, cv2.BORDER_REPLICATE)
    rise = (profile[:, 2:] - profile[:, :-2]) * sign
    where, strength = _peak(rise)
    back = -rise[:, 1:-1].min(axis=1)
    return p + normal * (ACROSS * where)[:, None], strength, back


def _peak(rise):
    """(offset in samples from the middle, height) of the largest value of each row."""
    count = np.arange(len(rise))
    k = rise.argmax(axis=1)
    inner = np.clip(k, 1, rise.shape[1] - 2)
    a, b, c = rise[count, inner - 1], rise[count, inner], rise[count, inner + 1]
    bend = np.minimum(a - 2 * b + c, -1e-6)
    shift = np.clip((a - c) / (2 * bend), -1, 1)
    where = np.where(k == inner, inner + shift, k)
    return where - rise.shape[1] // 2, rise[count, k]


def _looked_up(atlas, level, p):
    """(inside (N,), node or -1 (N,)) at positions p (N, 2) of levels."""
    u, v = np.rint(p).astype(np.int32).T
    width, height = atlas.width[level], atlas.height[level]
    inside = (u > 0) & (v > 0) & (u < width - 1) & (v < height - 1)
    u = np.where(inside, u, 0) + atlas.left[level].astype(np.int32)
    v = np.where(inside, v, 0) + atlas.top[level].astype(np.int32)
    return inside, atlas.known[v, u] - 1


def _mutual(nodes, ends, heading):
    """Keep links that both ends confirm, and say by which arm they arrive."""
    links = np.full((*ends.shape, 2), -1)
    i, k = np.nonzero(ends >= 0)
    if not len(i):
        return links
    j = ends[i, k]
    back = heading[i, k] + np.pi
    off = (nodes.angles[j] - back[:, None] + np.pi) % (2 * np.pi) - np.pi
    wrong = nodes.signs[j] != -nodes.signs[i, k][:, None]
    off = np.abs(off) + 10.0 * wrong
    m = off.argmin(axis=1)
    sure = (off.min(axis=1) < ARRIVAL) & (ends[j, m] == i)
    links[i[sure], k[sure]] = np.stack([j[sure], m[sure]], axis=1)
    agreed = links[links[..., 0], links[..., 1]]
    number = np.arange(len(ends))[:, None]
    same = (agreed[..., 0] == number) & (agreed[..., 1] == np.arange(4))
    links[~same | (links[..., 0] < 0)] = -1
    return links
