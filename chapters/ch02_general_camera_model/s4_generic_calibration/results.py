"""How far the printed Table 2.1 is off, read from the result of section 2.4."""

import numpy as np


def summary_of(result, vector):
    """Median over scenes of the largest relative sum, as printed."""
    return float(np.median(result.column(f"printed.{vector}.relative")))
