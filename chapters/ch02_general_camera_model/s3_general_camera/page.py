# %% [markdown]
# # 2.3 The general camera model, and its calibration by a known motion
#
# **Question.** A model of a camera can be a formula with a few parameters.
# It can also be a list: for every pixel, the ray that it sees. What does
# such a list look like, which cameras fit in it, and how does one fill it?

# %%
import numpy as np

from chapters.ch02_general_camera_model.s3_general_camera.exercises import (
    bytes_task,
    line_task,
    ray_task,
    shift_task,
)
from chapters.ch02_general_camera_model.s3_general_camera.results import name_values
from chapters.ch02_general_camera_model.s3_general_camera.trials.drawn_rays import (
    DRAWN_STEP,
    IMAGE_PX,
    KNOWN_SHIFT_MM,
    SHIFTS_MM,
    TABLE_PX,
    TILTS_DEG,
    meetings_of,
    table_trial,
    three_unknown_poses,
)
from chapters.ch02_general_camera_model.s3_general_camera.trials.known_motion import (
    LEVELS,
    error_pose,
    ray_errors,
)
from chapters.shared.general_cameras import (
    KINDS,
    draw_two_grids,
    faceted,
    fisheye,
    pinhole,
)
from raxel.calibration.generic.known_motion import rays_from_known_motion
from raxel.cameras.core.base import pixel_grid
from raxel.geometry import (
    intersect_rays_plane,
    inverse_pose,
    pluecker_matrix,
    pluecker_vector,
    pose,
    rotate,
    rotation_from_vector,
)
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("fig_2_1")

# %% tags=["active-ipynb"]
# show("fig_2_2")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - A table of rays asks nothing of neighbours. It holds the pinhole and the
#   fisheye of this page, and also a camera whose rays jump by
#   {glue:text}`jump_deg:.0f`° from a pixel to the next.
# - Two pictures of a grid fill the table for the pixels that see both, if
#   one knows how the grid was moved. Without noise the rays are exact to
#   rounding.
# - The result is as good as that knowledge. With the grids of this page, a
#   millimetre of error turns the rays by {glue:text}`per_mm:.2f`°, and a
#   degree by {glue:text}`per_deg:.2f`° (medians).
# - What the thesis says about Plücker matrices (2.11, 2.12) is true, up to
#   a sign in one place.

# %% [markdown]
# ## What the thesis claims
#
# - A list with one ray for every pixel, a *look-up table*, describes *any*
#   camera, central or not, even a discontinuous one, because no ray depends
#   on its neighbours {cite}`grossberg2001`. Fig. 2.1 shows it.
# - The rays are stored as Plücker matrices (2.11). A matrix is
#   skew-symmetric and does not depend on the two points that it was made
#   of. The last three entries of the Plücker vector (2.12) vanish for a
#   line through the origin.
# - The table can be filled from two images of a planar grid in two poses
#   whose relative transformation $T_1$ is *known*; Fig. 2.2(a). The result
#   is as good as the knowledge of $T_1$. Section 2.4 does without it;
#   Fig. 2.2(b).

# %% [markdown]
# ## Model
#
# A line in space is fixed by two of its points, $\mathbf{A}$ and
# $\mathbf{B}$. Written with a fourth coordinate 1, they make a $4 \times 4$
# matrix that is the same (up to a factor) for any two points of the line:
#
# $$M \simeq \mathbf{A}\mathbf{B}^T - \mathbf{B}\mathbf{A}^T . \tag{2.11}$$
#
# The six numbers that count are collected in a vector, direction first:
#
# $$L = \begin{pmatrix} M_{41}-M_{14} \\ M_{42}-M_{24} \\ M_{43}-M_{34} \\
# M_{32}-M_{23} \\ M_{13}-M_{31} \\ M_{21}-M_{12} \end{pmatrix} . \tag{2.12}$$
#
# For finite points at scale one this is $2\,(\mathbf{B}-\mathbf{A};\;
# -\mathbf{A}\times\mathbf{B})$: the moment has the opposite sign of the
# usual one (errata E-2.03).

# %% tags=["active-ipynb"]
# show_code(pluecker_matrix, pluecker_vector)

# %% [markdown]
# **A central camera** has one anchor point for all its rays, the centre. A
# camera that is not central needs a direction *and* an anchor point for
# each pixel. The second camera of this page looks into four plane mirrors
# that form a blunt pyramid. Each mirror shows the world as if from a centre
# of its own, and where two mirrors meet the rays jump.

# %% tags=["active-ipynb"]
# show_code(faceted)

# %% [markdown]
# **The general method.** A pixel sees a point on each of two grids. Their
# poses are known, so the two points can be written in one frame, and their
# join is the ray. Two points have no arrow: the order of the grids, near
# before far, gives the ray its sense. With more than two grids the line of
# least squares takes the place of the join.

# %% tags=["active-ipynb"]
# show_code(rays_from_known_motion)

# %%
ERROR_TRIALS = {"quick": 6, "full": 50}

# %% [markdown]
# ## Experiment
#
# Two small runs make what the figures draw: the tables of two cameras with
# so few pixels that they can be shown, and a camera calibrated by both
# methods of Fig. 2.2. Then an error is put on $T_1$, a shift or a turn of
# the second grid, and grows while everything else is exact.


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
# The other claims have experiments of their own, beside this page:
# `trials/lines.py`, random lines for (2.11) and (2.12); and for the claim
# that one model fits any camera `trials/known_motion.py`, every pixel of
# three cameras calibrated by two known grids.

# %% [markdown]
# ## Reading and limits
#
# - **Any camera.** The faceted camera is calibrated as exactly as the
#   fisheye. The method does not notice that rays of
#   neighbours jump, because it never looks at a neighbour.
# - **What that does not say.** Nothing is exact with noise. A ray is made
#   of two measurements, so it keeps all of their error, and a pixel that
#   was not measured has no ray. The library's table interpolates between
#   pixel centres, which means nothing across the edge of a mirror; such
#   places have to be left out of its mask.
# - **Plücker matrices.** Two pairs of points of a line give the same
#   matrix to {glue:text}`difference:.0e`, at unit norm. For lines through
#   the origin the last three entries are {glue:text}`through:.0e` of the
#   vector. Both statements are theorems; the numbers show that the code
#   follows them. They hold to rounding only while the two points are not
#   close together: the difference of the points loses the digits that they
#   share.
# - **The known motion.** A wrong $T_1$ turns the rays in proportion to its
#   error. Nothing in the data shows that error: two points always have a
#   join. A third grid would show it, as points that are not on a line. Then
#   there is no need to know the motion at all
#   ([section 2.4](s4_generic_calibration.ipynb)).
# - **Fig. 2.2(b)** shows poses that were found, not given: they agree with
#   the truth to {glue:text}`pose_mm:.0e` mm.
# - **Left out.** A pixel sees a solid angle, not a line. The raxel of the
#   original paper has radiometric properties too; the thesis and this
#   report use its geometry only.

# %% tags=["active-ipynb"]
# show("ext_fig_2_2_error")

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
# **3.** A ray stands at right angles on two grids 250 mm apart. The second
# is in truth 1 mm to the side of where it is said to be. By how many
# degrees is the calibrated ray wrong? Compare with the figure.

# %% tags=["active-ipynb"]
# check(None, **shift_task())

# %% [markdown]
# **4.** How many bytes has a look-up table of Plücker matrices in double
# precision, for an image of 3008 × 2000 pixels? The library stores
# directions, and anchor points where it must, and makes matrices on demand.

# %% tags=["active-ipynb"]
# check(None, **bytes_task())
