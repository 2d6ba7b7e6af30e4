"""Error of the printed Table 2.1, from the result of section 2.4."""

import numpy as np


def summary_of(result, vector):
    """Return the median over scenes of the largest relative sum, as printed."""
    return float(np.median(result.column(f"printed.{vector}.relative")))
