"""Columns of trials at the laboratory's noise and at the bench's, for tests."""

from chapters.shared.central.noise import NOISES, SWEPT_NOISES

EVERY_NOISE = tuple(NOISES | SWEPT_NOISES)


def at_every_noise(values, **other):
    """{noise.name: value}, the same at every noise but for those of `other`.

    other: {noise: {name: value}} of noises that differ.
    """
    return {
        f"{noise}.{name}": value
        for noise in EVERY_NOISE
        for name, value in (values | other.get(noise, {})).items()
    }
