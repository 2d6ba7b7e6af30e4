"""Does a camera fit its boards as well as their corners allow?

Noise moves every corner on its own. What a camera cannot follow moves neighbours alike:
a lens of another law, rays that miss the centre, a shutter that rolls, boards of two
cameras. So the second differences of the residuals along rows and columns of the
lattice tell how much single corners scatter, whatever detector found them, and what
the residuals hold beyond that is not the corners' noise. The standard deviation that a
detector states says less: it knows the image's noise, but not the printer's.
"""

from typing import NamedTuple

import numpy as np

# Residuals this many times the scatter, and this much beyond it, are a misfit. Boards
# that are not quite flat, and cells that bend, reach 1.8 times; noise alone, 1.
TIMES_SCATTER = 2.2
BEYOND_PX = 0.25
# Residuals this large are one too where they vary too fast to tell from scatter.
PLAIN_PX = 3.0
PLAIN_TIMES_SD = 10.0
ODD_TIMES = 2.5  # the residuals of the next board, where one is alone at fault
# And where all together are not too large: the median of all boards' residuals, of so
# many corners. Where some scatter twice as much as others it is 2.2 at most.
ODD_TIMES_MEDIAN, ODD_CORNERS = 3.0, 12
# The share of a second difference's variance: 1 + 4 + 1.
SECOND = np.array([1.0, -2.0, 1.0]) / np.sqrt(6)


class Misfit(NamedTuple):
    """How residuals compare with what single corners do.

    rms_px: of the residuals; scatter_px: RMS distance by which corners move on their
    own, NaN where no three neighbours are scored; sd_px: as the detector states it, the
    same kind of number, NaN where it states none; large: whether the residuals are more
    than the corners explain; odd_board: name of the one board that makes them so, or
    whose own are far larger than those of the others, "" where it is not one alone.
    """

    rms_px: float
    scatter_px: float
    sd_px: float
    large: bool
    odd_board: str = ""

    @property
    def beyond_px(self):
        """RMS of what neighbouring corners share."""
        return float(np.sqrt(max(self.rms_px**2 - self.scatter_px**2, 0.0)))


def misfit(scores, views):
    """Misfit of a camera on boards; scores: their ImageScores; views: as scored."""
    pairs = [
        (score, view)
        for score, view in zip(scores, views, strict=True)
        if np.isfinite(score.rms_px)
    ]
    found = _misfit(pairs)
    if len(pairs) < 3:
        return found
    pairs.sort(key=lambda pair: pair[0].rms_px)
    *others, second, worst = (score.rms_px for score, _ in pairs)
    alone = worst > ODD_TIMES * second
    if found.large:
        # One bad board pulls the camera, and so the others, with it.
        odd = alone or not _misfit(pairs[:-1]).large
    else:
        usual = np.median([*others, second, worst])
        scored = np.isfinite(pairs[-1][0].residuals_px[:, 0]).sum()
        odd = alone and worst > max(ODD_TIMES_MEDIAN * usual, BEYOND_PX)
        odd = odd and scored >= ODD_CORNERS
    return found._replace(odd_board=pairs[-1][0].name) if odd else found


def _misfit(pairs):
    if not pairs:
        return Misfit(np.nan, np.nan, np.nan, False)
    rms = _rms(np.concatenate([score.residuals_px for score, _ in pairs]))
    scatter = _rms(np.concatenate([_differences(*pair) for pair in pairs]))
    sd = np.sqrt(2) * _rms(np.concatenate([_stated(view) for _, view in pairs]))
    found = Misfit(rms, scatter, sd, False)
    smooth = rms > TIMES_SCATTER * scatter and found.beyond_px > BEYOND_PX
    plain = rms > PLAIN_PX and not rms <= PLAIN_TIMES_SD * sd
    return found._replace(large=bool(smooth or plain))


def _differences(score, view):
    """Second differences (M, 2) of residuals, as long as single corners' errors are."""
    lattice = score.residuals_px.reshape(view.rows, view.columns, 2)
    along = [
        np.einsum("k,kijc->ijc", SECOND, np.stack([a[:-2], a[1:-1], a[2:]]))
        for a in (lattice, np.swapaxes(lattice, 0, 1))
    ]
    return np.concatenate([a.reshape(-1, 2) for a in along])


def _stated(view):
    sd = [] if view.sd is None else view.sd
    return np.reshape(sd, (-1, 1))


def _rms(vectors):
    """Root mean square length of those vectors (N, k) that are finite; NaN of none."""
    squares = np.sum(np.asarray(vectors, float) ** 2, axis=1)
    squares = squares[np.isfinite(squares)]
    return float(np.sqrt(squares.mean())) if len(squares) else np.nan
