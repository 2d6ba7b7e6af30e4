"""How far from central a set of rays is (2.3.1)."""

import numpy as np


def closest_point(rays):
    """The point (3,) with the least sum of squared distances to the rays' lines.

    rays: `Rays`, camera frame; those that are not valid do not count. Where many
    points do equally well, as for parallel rays, the one nearest the mean origin.
    """
    origins, directions = _lines(rays)
    middle = origins.mean(axis=0)
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    target = np.einsum("nij,nj->i", across, origins - middle)
    step = np.linalg.lstsq(across.sum(axis=0), target, rcond=1e-12)[0]
    return middle + step


def centrality(rays):
    """Smallest RMS distance of the rays' lines from one point, in mm.

    rays: `Rays`. Zero for a central camera. Lines are taken as endless, as the centre
    behind a convex mirror is met by no half-line.
    """
    origins, directions = _lines(rays)
    reach = closest_point(rays) - origins
    return float(np.sqrt(np.mean(np.sum(np.cross(reach, directions) ** 2, axis=1))))


def _lines(rays):
    keep = rays.valid
    if not keep.any():
        raise ValueError("no valid ray")
    return rays.origins[keep], rays.directions[keep]
