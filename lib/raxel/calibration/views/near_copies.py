"""Photographs that show the board where another one does: frames of a film, say.

They share more than the board: what light, blur and the grid of pixels do to corners
there. So they say hardly more than one of them, and what they share looks like the
board's, or like another camera's. Where a fit takes all of them, its covariance and its
tests count them together, as they do the corners of one photograph.
"""

import numpy as np

NEAR = 0.01  # of the board's radius in the image: no two are held so still by chance


def near_copies(views):
    """(n,) indices: of each of n BoardViews the first that shows the board where it
    does, its own where none does, or where every pixel was read by itself."""
    first, kept = np.arange(len(views)), []
    for k, view in enumerate(views):
        if view.every_pixel:
            continue
        radius = np.sqrt(np.nanmean(np.nanvar(view.pixels, axis=0)))
        near = [j for j in kept if _apart(views[j], view) <= NEAR * radius]
        if near:
            first[k] = near[0]
        else:
            kept.append(k)
    return first


def _apart(one, other):
    """RMS distance in px along an axis of corners that both found; infinite where they
    are of other boards or fewer than half are shared."""
    if one.pixels.shape != other.pixels.shape:
        return np.inf
    squares = (one.pixels - other.pixels) ** 2
    both = np.isfinite(squares[:, 0])
    most = max(np.isfinite(each.pixels[:, 0]).sum() for each in (one, other))
    return np.sqrt(squares[both].mean()) if both.sum() > most / 2 else np.inf


def once_each(pairs):
    """Those of [(ImageScore, BoardView), ...] that are no near copies of others."""
    first = near_copies([view for _, view in pairs])
    return [pair for k, pair in enumerate(pairs) if first[k] == k]
