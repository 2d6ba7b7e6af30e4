"""Rays as Plücker vectors, what a motion does to them, and when two of them meet.

The order is the thesis's (2.12), see `lines`: (d; -(o x d)), direction first, then the
moment with its sign reversed. With X_2 = R X_1 + t and E = [t]x R, lines that meet
satisfy L_2^T G L_1 = 0 (5.30), where

    G = [[E, -R], [-R, 0]]      in this order,
    G = [[E,  R], [ R, 0]]      in the usual one, (d; o x d)

(errata E-5.12). Whoever hands rays to another program, or takes a formula from a book,
calls `other_order` on the way.
Source: Pless 2003, doi:10.1109/CVPR.2003.1211520.
"""

import numpy as np

from raxel.geometry.poses import cross_matrix


def pluecker_of_rays(origins, directions):
    """Plücker vectors (..., 6) of rays, thesis order: (d; -(o x d)).

    origins: (..., 3) in the unit of length of the frame; directions: (..., 3). With
    unit directions the last three are as long as the line is far from the frame's
    origin. Any point of the line will do as its origin.
    """
    o, d = np.broadcast_arrays(np.asarray(origins, float), np.asarray(directions))
    return np.concatenate([d, np.cross(d, o)], axis=-1)


def other_order(L):
    """Plücker vectors (..., 6) from the thesis's order to the usual one, or back."""
    return np.asarray(L, float) * [1, 1, 1, -1, -1, -1]


def generalised_essential(T_2_1):
    """Generalised essential matrix (..., 6, 6) of a motion, thesis order (5.30).

    T_2_1: (..., 4, 4), X_2 = R X_1 + t.
    """
    T = np.asarray(T_2_1, float)
    R, G = T[..., :3, :3], np.zeros((*T.shape[:-2], 6, 6))
    G[..., :3, :3] = cross_matrix(T[..., :3, 3]) @ R
    G[..., :3, 3:] = G[..., 3:, :3] = -R
    return G


def side_products(L_1, L_2, T_2_1):
    """L_2^T G L_1 (N,) of matched lines (5.30), zero where they meet.

    L_1, L_2: (N, 6), thesis order, each in the frame of its view. For unit directions
    this is their distance times the sine of the angle between them, with a sign.
    """
    G = generalised_essential(T_2_1)
    return np.einsum("ni,ij,nj->n", np.asarray(L_2, float), G, np.asarray(L_1, float))
