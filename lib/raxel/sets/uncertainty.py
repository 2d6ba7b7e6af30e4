"""How sure is a corner? Its standard deviation, from the detector to the calibration.

One rule for every `sd` beside corners (N, 2): an array (N,) in px, the standard
deviation of the position along each axis (root mean square of both); NaN for a corner
whose own nobody knows; 0 where the corner is true by construction; None in place of
the array where nobody states any. It says what noise does and is no weight yet.

In files it is a list of numbers and nulls, one number for all corners, or null.
"""

import numpy as np

from raxel.errors import InputError


def check_sd(where, sd, count):
    """`sd` as float64 (count,), all NaN for None. Raises InputError naming `where`."""
    if sd is None:
        return np.full(count, np.nan)
    sd = np.asarray(sd, float)
    if sd.shape != (count,) or (sd < 0).any():
        raise InputError(
            f"{where}: sd: found an array {sd.shape}; give one standard deviation for "
            f"each of {count} corners, px, not negative, NaN where it is unknown"
        )
    return sd


def sd_from_plain(where, value, count):
    """`sd` of `count` corners as a file gives it. Raises InputError naming `where`."""
    if value is None:
        return None
    values = value if isinstance(value, list) else [value] * count
    good = all(one is None or _is_spread(one) for one in values)
    if len(values) != count or not good:
        raise InputError(
            f"{where}: give one number for all corners, or a list of {count} numbers "
            "of 0 px or more, null where it is unknown"
        )
    return np.array(values, dtype=float)


def plain_sd(sd):
    """`sd` as a file takes it; not finite becomes null, as no file can hold it."""
    if sd is None:
        return None
    return [round(float(one), 6) if np.isfinite(one) else None for one in sd]


def _is_spread(value):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and 0 <= value < 1e9
