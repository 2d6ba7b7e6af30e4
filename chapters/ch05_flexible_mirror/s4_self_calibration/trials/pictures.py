"""One push of 5 mm from pictures: rendered, their features found and matched by SIFT.

A printed wall stands 5 m before the mirror, with a printed plane before it, as in
Fig. 5.26. It is photographed before the push, half way and after it. Beside it stands
the same mirror with drawn features, so that what matching costs is told apart.
"""

import cv2
import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import STEPS_MM
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.scene import (
    DEPTHS_MM,
    Field,
    SceneFrame,
    features,
)
from chapters.shared.mirror_pictures import scene_picture
from chapters.shared.mirror_rigs import mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, lattice, outline, primary
from chapters.shared.mirror_scores import load_height, ray_angles
from raxel.calibration.mirror.self_calibration import linear_update
from raxel.errors import InputError
from raxel.features.sift import match_features
from raxel.geometry import intersect_rays_plane, transform
from raxel.geometry.planes import on_plane
from raxel.lab import ImageTexture, Rectangle, TexturedScene
from raxel.lab.windowed import mirror_window

STEPS = STEPS_MM[:3]
# Pixels of the small rig's pictures are so many times as wide.
SMALLER = 4
# Of what each surface covers: left, top, right, bottom as slopes from the mirror's
# middle. The plane hides some of the wall.
COVERS = {"wall": (-0.4, -0.4, 0.8, 0.4), "plane": (-0.05, -0.4, 0.06, 0.4)}
# Of the print: mm a pixel, sizes of its blots (mm), grey levels, and the room behind.
PRINT_MM, BLOTS_MM, INK, PAPER, ROOM = 5.0, (24, 48, 96, 192), 0.06, 0.85, 0.3
# A match is wrong where it is so many px beside its place; a person does not know that.
WRONG_PX = 3.0
# Beside a smooth warp by so many robust deviations, matches are left out, in so many
# rounds; what depths differ by is no more than that.
STRAY, ROUNDS, DEGREE = 5.0, 6, 4
COMPARED_PX = 42
# Drawn features: as many for a picture as in three pushes, and as many as SIFT matches.
AS_MANY = {"drawn": 1, "many": 10}


def pictures_trial(condition, rng, errors, benches):
    """{bench: what one push gives, from pictures and from drawn features}."""
    rig = mirror_rig(condition["geometry"], small=True)
    of_rig, seed = errors[condition["geometry"]], int(rng.integers(2**32))
    of_rig = of_rig._replace(
        corner=of_rig.corner / SMALLER, plate=of_rig.plate / SMALLER
    )
    return {
        name: of_bench(rig, bench, of_rig._replace(factor=bench.factor), seed)
        for name, bench in benches.items()
    }


def of_bench(rig, bench, errors, seed):
    """Scores of `sift`, of `drawn` features and of `many`, and how good matches are."""
    rng = np.random.default_rng(seed)
    cameras = [rig.camera(mm, bench.aberration_um, seed) for mm in STEPS]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    view = SceneFrame.of(cameras[0])
    walls = surfaces(view)
    scene = printed(walls)
    eye = np.eye(4)
    pictures = [scene_picture(rig, camera, scene, eye, rng) for camera in cameras]
    window = mirror_window(rig.camera(0.0))
    corner = np.array([window.u, window.v], float)
    fields = [Field(camera) for camera in cameras]
    drawn = {}
    for name, times in AS_MANY.items():
        points, _ = features(view, times * fields, rng)
        drawn[name] = [field.pictured(points, errors, rng) for field in fields]
    start = load_height(rig, first.camera, cameras[0])

    def by(pairs):
        """Linear self-calibration, step by step, from pixels (2, N, 2) of each."""
        camera = first.camera
        try:
            for (before, after), true in zip(pairs, cameras[1:], strict=True):
                camera = linear_update(
                    camera, before, after, first.clamp, PUBLISHED.settings,
                    outline=outline(true),
                ).camera  # fmt: skip
        except InputError as refusal:
            return {"refused": str(refusal)}
        pixels = lattice(cameras[-1], COMPARED_PX)
        return {
            "deflection_mm": load_height(rig, camera, cameras[-1]) - start,
            "angle_deg": float(np.nanmean(ray_angles(camera, cameras[-1], pixels))),
        }

    out = {name: by([seen[:2], seen[1:]]) for name, seen in drawn.items()}
    out["picture"] = pictures[-1]
    try:
        found = [match_features(*pictures[k : k + 2]).pixels + corner for k in (0, 1)]
    except InputError as refusal:
        return out | {"sift": {"refused": str(refusal)}}
    kept = [pixels[:, follows(*pixels)] for pixels in found]
    off = [beside(cameras[k : k + 2], walls, pixels) for k, pixels in enumerate(kept)]
    wrong = [np.linalg.norm(one, axis=1) >= WRONG_PX for one in off]
    right = np.concatenate([one[~bad] for one, bad in zip(off, wrong, strict=True)])
    out["sift"] = by(kept) | {
        "matches": int(sum(pixels.shape[1] for pixels in found)),
        "kept": int(sum(pixels.shape[1] for pixels in kept)),
        "wrong_kept": int(np.count_nonzero(np.concatenate(wrong))),
        "match_px": float(np.sqrt(np.nanmean(right**2) / 2)),
    }
    return out | {"matched": kept[1][1] - corner}


def surfaces(view):
    """{name: (T_viewer_surface (4, 4), low (2,), high (2,) mm)}, square to the view."""
    x = np.cross([0.0, 1.0, 0.0], view.axis)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(view.axis, x), view.axis])
    found = {}
    for name, slopes in COVERS.items():
        depth, edges = DEPTHS_MM[name], np.array(slopes) * DEPTHS_MM[name]
        T[:3, 3] = view.middle + depth * view.axis
        found[name] = T.copy(), edges[:2], edges[2:]
    return found


def printed(walls):
    """The TexturedScene of `surfaces`, the same print at every call."""
    rng, parts = np.random.default_rng(59), []
    for T, low, high in walls.values():
        width, height = np.rint((high - low) / PRINT_MM).astype(int)
        image = np.zeros((height, width))
        for size in BLOTS_MM:
            blots = rng.normal(size=image.shape)
            blots = cv2.GaussianBlur(blots, (0, 0), size / PRINT_MM / 2)
            image += blots / blots.std()
        image = INK + (PAPER - INK) / (1 + np.exp(-1.5 * image))
        T = T.copy()
        T[:3, 3] += T[:3, :2] @ low
        parts.append((Rectangle(T, *(high - low)), ImageTexture(image, PRINT_MM)))
    return TexturedScene(tuple(parts), ROOM)


def follows(before, after):
    """Which matches (N,) follow a warp that is a polynomial of the picture's place."""
    place = (before - before.mean(axis=0)) / np.ptp(before, axis=0)
    powers = [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]
    terms = np.column_stack([place[:, 0] ** i * place[:, 1] ** j for i, j in powers])
    kept = np.ones(len(before), bool)
    for _ in range(ROUNDS):
        warp = np.linalg.lstsq(terms[kept], (after - before)[kept], rcond=None)[0]
        rest = np.linalg.norm(after - before - terms @ warp, axis=1)
        kept = rest <= STRAY * 1.4826 * np.median(rest[kept])
    return kept


def beside(cameras, walls, pixels):
    """Px (N, 2) by which a match's second end (2, N, 2) is beside where the first one's
    place truly is, NaN where that is on no surface."""
    rays = cameras[0].rays(pixels[0])
    points = np.full(rays.origins.shape, np.nan)
    nearest = np.full(len(points), np.inf)
    for T, low, high in walls.values():
        met = intersect_rays_plane(rays.origins, rays.directions, T).points
        there = transform(T, on_plane(met))
        distance = np.linalg.norm(there - rays.origins, axis=1)
        with np.errstate(invalid="ignore"):
            on = np.all((met >= low) & (met <= high), axis=1) & (distance < nearest)
        points[on], nearest[on] = there[on], distance[on]
    return pixels[1] - cameras[1].project(points).pixels
