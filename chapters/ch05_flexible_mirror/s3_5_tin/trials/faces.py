"""A tin from pairs of rays: points, a plane for each face, angles between planes."""

from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import ANGLES_DEG, FACES, PAIRS
from raxel.errors import InputError
from raxel.multiview.fits.planes import fit_plane
from raxel.multiview.noisy_rays import rays_of_pixels
from raxel.multiview.ray_points import RayView
from raxel.multiview.triangulation import triangulate

# A point farther from its plane than this, in robust deviations, is an outlier of
# Fig. 5.23; a normal law has one in two thousand there.
OUTLYING = 3.5
STEP_PX = 1.0  # rays around a pixel are needed, to propagate its noise
MIN_N_POINTS = 12  # of a face


class FoundTin(NamedTuple):
    """A reconstructed tin.

    points (n, 3) mm, frame of the first image's camera; face (n,): 0 to 2; planes:
    PlaneFit of each face; distances (n,) mm from their planes, positive outside;
    angles (3,) degrees, inside the tin, of PAIRS; used (N,) bool: which pairs of rays
    became points.
    """

    points: np.ndarray
    face: np.ndarray
    planes: list
    distances: np.ndarray
    angles: np.ndarray
    used: np.ndarray = None

    def scores(self):
        """Scores that a trial keeps."""
        off = self.angles - ANGLES_DEG
        each = [self.distances[self.face == k] for k in range(3)]
        return {
            **{f"angle.{pair}": float(self.angles[k]) for k, pair in enumerate(PAIRS)},
            "off_deg": float(np.abs(off).max()),
            "points": len(self.points),
            "rms_mm": float(np.sqrt(np.mean(self.distances**2))),
            **{f"qq.{face}": normality(each[k]) for k, face in enumerate(FACES)},
            **{
                f"qq_all.{face}": normality(each[k], np.inf)
                for k, face in enumerate(FACES)
            },
        }


def with_rays(camera, pixels):
    """Which pixels (N, 2) have rays, they and their neighbours, (N,) bool."""
    steps = STEP_PX * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    there = camera.rays((pixels + steps[:, None]).reshape(-1, 2)).valid
    return there.reshape(len(steps), -1).all(axis=0)


def ray_pairs(camera, pixels, sd_px):
    """(NoisyRays of both images (n,), which (N,) of the pairs have rays).

    pixels: (2, N, 2).
    """
    known = np.all([with_rays(camera, p) for p in pixels], axis=0)
    return [rays_of_pixels(camera, p[known], sd_px) for p in pixels], known


def tin_of(rays, face, T_second_first):
    """FoundTin of pairs of rays whose faces (n,) are known, by the camera's motion.

    Points are those nearest to both rays (5.3.5). Raises InputError for a face
    with too few.
    """
    poses = np.stack([np.eye(4), T_second_first])
    found = triangulate([RayView(r) for r in rays], poses, linear=True)
    tin = tin_through(found.points[found.valid], face[found.valid])
    return tin._replace(used=found.valid)


def tin_through(points, face):
    """FoundTin of points (n, 3) on known faces (n,)."""
    count = np.bincount(face, minlength=3)
    if count.min() < MIN_N_POINTS:
        few = FACES[int(count.argmin())]
        raise InputError(
            f"tin: {count.min()} points on the {few} face; {MIN_N_POINTS} are needed"
        )
    planes = [fit_plane(points[face == k]) for k in range(3)]
    middles = np.array([plane.T_frame_plane[:3, 3] for plane in planes])
    normals = np.array([plane.normal for plane in planes])
    # A face's normal points away from the middle of all three.
    away = np.einsum("ki,ki->k", middles - middles.mean(axis=0), normals)
    sign = np.where(away < 0, -1, 1)
    normals = sign[:, None] * normals
    distances = np.empty(len(points))
    for k, plane in enumerate(planes):
        distances[face == k] = sign[k] * plane.residuals
    angles = [angle_inside(normals[a], normals[b]) for a, b in PAIRS.values()]
    return FoundTin(points, face, planes, distances, np.array(angles))


def angle_inside(first, second):
    """Degrees between two faces inside a solid, of their outward unit normals."""
    return 180 - np.degrees(
        np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second)
    )


def usual(distances, within=OUTLYING):
    """Which distances (n,) are not outliers, (n,) bool."""
    off = np.abs(distances - np.median(distances))
    return off <= within * 1.4826 * np.median(off)


def normality(distances, within=OUTLYING):
    """Correlation of distances (n,) with normal quantiles of their ranks.

    Outliers are excluded, except for `within` infinity.
    """
    d = np.sort(distances[usual(distances, within)])
    ranks = norm.ppf((np.arange(len(d)) + 0.5) / len(d))
    return float(np.corrcoef(d, ranks)[0, 1])
