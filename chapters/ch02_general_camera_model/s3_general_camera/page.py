# %% [markdown]
# # 2.3 The general camera model: ray look-up tables and known motion
#
# **Question.** The general camera model stores a ray for every pixel instead
# of a projection formula, so it can describe any camera. Given are two images
# of a planar grid whose motion is known. Which cameras does such a look-up
# table represent, and how accurately can this method fill it?

# %%
import numpy as np

from chapters.ch02_general_camera_model.s3_general_camera.exercises import (
    bytes_task,
    line_task,
    ray_task,
    shift_task,
)
from chapters.ch02_general_camera_model.s3_general_camera.experiment import (
    DRAWN_STEP,
    IMAGE_PX,
    KNOWN_SHIFT_MM,
    LEVELS,
    SHIFTS_MM,
    TABLE_PX,
    TILTS_DEG,
    error_pose,
    meetings_of,
    ray_errors,
    table_trial,
    three_unknown_poses,
)
from chapters.ch02_general_camera_model.s3_general_camera.report import name_values
from chapters.shared.general import KINDS, draw_two_grids, faceted, fisheye, pinhole
from raxel.calibration import rays_from_known_motion
from raxel.cameras import pixel_grid
from raxel.geometry import (
    intersect_rays_plane,
    inverse_pose,
    pluecker_matrix,
    pluecker_vector,
    pose,
    rotate,
    rotation_from_vector,
)
from repro.page import check, compared, open_results, show, show_code
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show("fig_2_1")

# %% tags=["active-ipynb"]
# show("fig_2_2")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **A ray table holds any camera.** It represents the pinhole and the
#    fisheye of this page, and a camera whose rays jump by
#    {glue:text}`jump_deg:.0f`° between neighbouring pixels.
# 2. **Two images with known motion fill the table**, for the pixels that see
#    both grids. Without noise the rays are exact to rounding.
# 3. **The rays are as accurate as the known motion.** With the grids of this
#    page, 1 mm of error rotates the rays by {glue:text}`per_mm:.2f`° and 1° by
#    {glue:text}`per_deg:.2f`° (medians).
# 4. **The statements about Plücker coordinates hold.** The moment in (2.12)
#    has the opposite of the usual sign.

# %% [markdown]
# | statement | thesis | here |
# |---|---|---|
# | a ray table describes discontinuous cameras | yes | yes, four-mirror camera |
# | two grids with known motion calibrate it | yes | yes, exact without noise |
# | ray error and error of the motion | depends on it | proportional to it |
# | Plücker matrix independent of the two points | yes | yes, to rounding |
# | moment vanishes for lines through the origin | yes | yes, to rounding |

# %% [markdown]
# ## Terms
#
# A reader needs homogeneous coordinates and rigid motions.
#
# - *General camera model*: per-pixel ray model, a *look-up table* of rays.
#   Also called generic camera or raxel model.
# - *Plücker matrix, Plücker vector*: a $4 \times 4$ matrix or six numbers that
#   represent a line in space.
# - *Direction* and *moment* of a line through $\mathbf{A}$ and $\mathbf{B}$:
#   $\mathbf{B}-\mathbf{A}$ and $\mathbf{A}\times\mathbf{B}$.
# - *Anchor point*: the stored point of a ray.
# - *Central camera*: all rays have one anchor point, the centre (single
#   viewpoint). Otherwise the camera is *non-central*.
# - *Faceted camera*: a camera that looks into four plane mirrors.
# - $T_1$: the pose of the second grid relative to the first.
# - *General method*, also *two-pose method*: calibration with known $T_1$.
#   *Generic method*: calibration with three unknown poses.

# %% [markdown]
# ## What the thesis claims
#
# - A *look-up table* with one ray per pixel describes *any* camera, even a
#   discontinuous one, because no ray depends on its neighbours
#   {cite}`grossberg2001` (Fig. 2.1).
# - The rays are stored as Plücker matrices (2.11), which do not depend on the two
#   points chosen. The last three entries of the Plücker vector (2.12) vanish for a
#   line through the origin.
# - Two images of a planar grid with *known* relative transformation $T_1$ fill the
#   table (Fig. 2.2(a)), as accurately as $T_1$ is known. Section 2.4 does not need
#   $T_1$ (Fig. 2.2(b)).

# %% [markdown]
# ## Model
#
# Two points $\mathbf{A}$ and $\mathbf{B}$ of a line, with fourth coordinate 1,
# give a $4 \times 4$ matrix. It is the same, up to a factor, for any two
# points of the line:
#
# $$M \simeq \mathbf{A}\mathbf{B}^T - \mathbf{B}\mathbf{A}^T . \tag{2.11}$$
#
# Six of its numbers form a vector, direction first:
#
# $$L = \begin{pmatrix} M_{41}-M_{14} \\ M_{42}-M_{24} \\ M_{43}-M_{34} \\
# M_{32}-M_{23} \\ M_{13}-M_{31} \\ M_{21}-M_{12} \end{pmatrix} . \tag{2.12}$$
#
# For finite points this is $2\,(\mathbf{B}-\mathbf{A};\;
# -\mathbf{A}\times\mathbf{B})$. The moment has the opposite of the usual sign
# (errata E-2.03).

# %% tags=["active-ipynb"]
# show_code(pluecker_matrix, pluecker_vector)

# %% [markdown]
# **Non-central cameras** need a direction *and* an anchor point for each
# pixel. The faceted camera of this page looks into four plane mirrors that
# form a blunt pyramid. Each mirror has its own virtual centre, and the rays
# jump between mirrors.

# %% tags=["active-ipynb"]
# show_code(faceted)

# %% [markdown]
# **The general method.** A pixel sees one point on each of two grids. With known
# poses both points are expressed in one frame, and the line through them is the ray.
# The order of the grids, near before far, fixes its direction.

# %% tags=["active-ipynb"]
# show_code(rays_from_known_motion)

# %%
ERROR_TRIALS = {"quick": 6, "full": 50}

# %% [markdown]
# ## Experiment
#
# Two small runs provide the data of the figures: the tables of two cameras
# with few pixels, and one camera calibrated by both methods of Fig. 2.2. A
# third experiment adds a growing error to $T_1$, a translation or a rotation
# of the second grid, while all else is exact.


# %%
@experiment("fig_2_1_tables", artefact="fig_2_1")
def tables(effort):
    """The look-up tables of a fisheye and of a faceted-mirror camera."""
    conditions = crossed(camera=("fisheye", "faceted"))
    return Plan(table_trial, conditions, 1, {"image_px": list(TABLE_PX)})


def grids_trial(condition, rng):
    """Calibrate one camera both ways and meet its rays with the grids.

    All in the base grid's frame: poses (n, 4, 4), origins and directions
    (N, 3), where the rays meet the grids (n, N, 3), the grids' outlines
    (n, 5, 3), and how far all of it is from the truth.
    """
    camera = pinhole(*IMAGE_PX)
    grids = pose(
        rotation_from_vector(np.radians(TILTS_DEG)), np.array(SHIFTS_MM, float)
    )
    if condition["method"] == "general":
        known = pose(np.eye(3), np.array(KNOWN_SHIFT_MM, float))
        grids = np.stack([grids[0], grids[0] @ known])
    pixels = pixel_grid(*IMAGE_PX)
    true = camera.rays(pixels)
    hits = intersect_rays_plane(true.origins, true.directions, grids)
    truth = inverse_pose(grids[0]) @ grids
    if condition["method"] == "general":
        poses = truth
        found = rays_from_known_motion(hits.points, poses)
        origins, directions = found.origins, found.directions
    else:
        poses, centre, directions = three_unknown_poses(hits.points)
        origins = np.broadcast_to(centre, directions.shape)
    drawn = np.all(pixels % DRAWN_STEP == 0, axis=1)
    origins, directions = origins[drawn], directions[drawn]
    true_directions = rotate(inverse_pose(grids[0]), true.directions)
    return {
        "poses": poses,
        "centre": inverse_pose(grids[0])[:3, 3],
        "origins": origins,
        "directions": directions,
        **meetings_of(origins, directions, poses),
        "pose_error_mm": np.abs(poses - truth)[:, :3, 3].max(),
        "ray_error": np.abs(directions - true_directions[drawn]).max(),
    }


@experiment("fig_2_2_grids", artefact="fig_2_2")
def grids(effort):
    """One camera, calibrated with two known and three unknown poses."""
    settings = {"image_px": list(IMAGE_PX), "T_1_mm": list(KNOWN_SHIFT_MM)}
    return Plan(grids_trial, crossed(method=("general", "generic")), 1, settings)


def wrong_motion_trial(condition, rng):
    """Ray error (deg) of the two-pose method with T_1 wrong by a level.

    The wrong T_1 goes the same way at every level of a trial: a shift
    along a random direction, or a turn about a random axis of grid 2.
    """
    camera = fisheye(160, 120)
    true = camera.rays(rng.uniform([0, 0], [159, 119], (400, 2)))
    grids = draw_two_grids(rng, 1.0)
    hits = intersect_rays_plane(true.origins, true.directions, grids)
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    out = {"step_mm": float(grids[1, 2, 3] - grids[0, 2, 3])}
    for level in (0.0, *LEVELS):
        wrong = grids.copy()
        wrong[1] = grids[1] @ error_pose(condition["kind"], level * way)
        found = rays_from_known_motion(hits.points, wrong)
        angle, gap = ray_errors(found, true, found.valid & true.valid)
        out[f"ray_deg.{level:g}"] = np.degrees(np.median(angle))
        out[f"gap_mm.{level:g}"] = np.median(gap)
    return out


@experiment("fig_2_2_error", artefact="fig_2_2")
def wrong_motion(effort):
    """The two-pose method with a growing error put on T_1."""
    settings = {
        "levels": list(LEVELS),
        "units": dict(KINDS),
        "pixels": 400,
        "camera": "equidistance fisheye, 120 deg on the diagonal",
        "grids": "the second one 200 to 400 mm behind the first",
    }
    return Plan(
        wrong_motion_trial,
        [{"kind": kind} for kind in KINDS],
        ERROR_TRIALS[effort],
        settings,
    )


# %% [markdown]
# Further experiments, in `experiment.py`, draw random lines for (2.11) and (2.12), and
# calibrate every pixel of three cameras by two known grids.

# %% [markdown]
# ## Discussion
#
# - **Any camera.** The faceted camera is calibrated as exactly as the fisheye,
#   because the method never uses neighbouring pixels.
# - **Noise.** A ray keeps all of the error of its two measurements. A pixel without a
#   measurement has no ray.
# - **Plücker matrices.** Both statements are theorems, so the numbers test the code.
# - **Known motion.** The data do not reveal an error of $T_1$, because two points
#   always define a line. A third grid reveals it and makes the known motion
#   unnecessary ([section 2.4](s4_generic_calibration.ipynb)), as in Fig. 2.2(b).

# %% tags=["active-ipynb"]
# show("ext_fig_2_2_error")

# %% [markdown]
# ## Summary
#
# A ray table represents any camera, including non-central and discontinuous
# ones. Two grids with a known motion fill it exactly without noise. An error of the
# motion causes a proportional error of the rays, which the two images do not reveal.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** Write the Plücker vector (2.12) of the line through (1, 2, 3) and
# (4, 6, 3). Six numbers; a factor common to all of them does not count.

# %% tags=["active-ipynb"]
# check(None, **line_task())

# %% [markdown]
# **2.** A pixel sees the point (30, −20) on a grid, and (45, −30) on the
# same grid after it was moved by 100 mm along its $z$ axis. What is the
# unit direction of its ray, in the frame of the first grid?

# %% tags=["active-ipynb"]
# check(None, **ray_task())

# %% [markdown]
# **3.** A ray is perpendicular to two grids 250 mm apart. The true position of
# the second grid differs from the assumed one by 1 mm laterally. By how many
# degrees is the calibrated ray wrong? Compare with the figure.

# %% tags=["active-ipynb"]
# check(None, **shift_task())

# %% [markdown]
# **4.** What is the size in bytes of a look-up table of Plücker matrices in
# double precision, for an image of 3008 × 2000 pixels?

# %% tags=["active-ipynb"]
# check(None, **bytes_task())
