"""How far photographs lie apart in what each, its pose free, asks of shared parameters.

Each photograph has normal equations of its own, N_i x = r_i. All together they say one
thing, and what a photograph asks for beyond that is chance: of scatter alone its
squares add up to a known number, and whatever else moves the corners of one photograph
makes them more.
"""

from typing import NamedTuple

import numpy as np

SINGULAR = 1e-9  # of the largest eigenvalue: what nothing determines


class Apart(NamedTuple):
    """Squares of what photographs ask for beyond what they say together, in directions
    in which all are told alike.

    expected: what they add up to of scatter whose variance is 1; ways (K, K): the
    squares and products themselves. Those of several parts of the photographs add up.
    """

    expected: float
    ways: np.ndarray

    def __add__(self, other):
        return Apart(self.expected + other.expected, self.ways + other.ways)

    @property
    def variance(self):
        """Of scatter that explains the squares."""
        return np.trace(self.ways) / self.expected

    @property
    def several(self):
        """How many independent squares each photograph has: as they are larger some
        ways than others, fewer than ways (F. E. Satterthwaite 1946,
        doi:10.2307/3002019)."""
        return np.trace(self.ways) ** 2 / np.sum(self.ways**2)


def apart(normal, right):
    """Apart of photographs, by their equations (n, K, K) and (n, K)."""
    root, axes = inverse_root(normal.sum(axis=0))
    together = root @ (root.T @ right.sum(axis=0))
    share = root.T @ normal @ root
    beyond = (right - normal @ together) @ root @ axes.T
    return Apart(np.einsum("nii->", share) - np.sum(share**2), beyond.T @ beyond)


def inverse_root(normal):
    """W of W W', the pseudo-inverse of a normal matrix, and its axes."""
    size, axes = np.linalg.eigh(normal)
    told = size > SINGULAR * size[-1]
    return axes[:, told] / np.sqrt(size[told]), axes[:, told]
