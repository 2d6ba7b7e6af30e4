"""The two benches of chapter 5: the laboratory as it is, and one like the thesis's.

The laboratory is far cleaner than the bench of 5.3.3. Its decoding errors are times
one factor, and its mirror is made uneven by four waves, both solved on geometry A
with the method as published, from one printed number each and before any claim was run
(`ext_mirror_bench`). Geometry B and section 5.3.2 take both as they are.
"""

from typing import NamedTuple


class Bench(NamedTuple):
    """factor: of decoding errors; aberration_um: of the mirror, RMS."""

    factor: float = 1.0
    aberration_um: float = 0.0


# Solved by `ext_mirror_bench`; their origin stands in settings.yaml, cam_olympus_flex.
FACTOR, ABERRATION_UM = 13.45, 21.0
BENCH = "bench"
BENCHES = {"laboratory": Bench(), BENCH: Bench(FACTOR, ABERRATION_UM)}
# The ends over which a verdict must not change: one number, the other as it is.
SWEPT = {
    "half the factor": Bench(FACTOR / 2, ABERRATION_UM),
    "twice the factor": Bench(2 * FACTOR, ABERRATION_UM),
    "half the aberration": Bench(FACTOR, ABERRATION_UM / 2),
    "twice the aberration": Bench(FACTOR, 2 * ABERRATION_UM),
}
