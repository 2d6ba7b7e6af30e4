# %% [markdown]
# # 4.2 Pose of a further grid
#
# **Question.** A camera is calibrated as far as three grids reach. A further
# grid brings rays for more pixels, once its pose is known. The standard
# generic method finds that pose from three points at a time. CGSP finds it
# from all points at once, by linear equations. Which pose is better, and
# what is left to gain?

# %%
import numpy as np

from chapters.ch04_central_generic.s2_pose.exercises import normal_task, sample_task
from chapters.ch04_central_generic.s2_pose.results import name_values
from chapters.ch04_central_generic.s2_pose.trials.estimators import (
    all_estimates,
    scored,
)
from chapters.ch04_central_generic.s2_pose.trials.kodak import with_outliers
from chapters.ch04_central_generic.s2_pose.trials.simulated import (
    DOMAINS,
    LEVELS,
    METRICS,
    RAYS,
    WIDE,
    moved,
    rays_and_points,
    threshold,
)
from chapters.shared.wide_angle import (
    CENTRE_MM,
    EULER_DEG,
    SETTINGS,
    SHIFT_MM,
    draw_scene,
    radial_lens,
)
from raxel.calibration.pose.grid_pose import synthetic_plane_normal
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("fig_4_4")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - Three points alone give a poor pose: {glue:text}`three_points_deg:.2g`°
#   at half a pixel of noise, where CGSP's linear pose has
#   {glue:text}`cgsp_ransac_deg:.2g`°.
# - Refined on all inliers, as the thesis says it was, the standard pose is
#   {glue:text}`refining:.0f` times better and no worse than CGSP's. The
#   lead of CGSP is that of all points over three.
# - Minimising the angles between rays and points, which the thesis does not
#   do, is better than both: {glue:text}`angular_deg:.2g`°, and
#   {glue:text}`angular_exact_deg:.2g`° where the rays are exact.
# - A linear pose without RANSAC does not survive outliers: with 0.3 % of
#   them the error of a decoded grid's pose grows from
#   {glue:text}`scenes_cgsp_ransac_mm:.2g` to {glue:text}`scenes_cgsp_mm:.2g` mm
#   at the bench's noise, and from {glue:text}`lab_scenes_cgsp_ransac_mm:.2g` to
#   {glue:text}`lab_scenes_cgsp_mm:.2g` mm with the laboratory's own decoding errors.
# - The synthetic plane can stand anywhere as long as there is no noise. With
#   noise a plane at 60° makes the rotation {glue:text}`tilt_60:.1f` times
#   worse; at 30° no difference can be told.

# %% [markdown]
# ## What the thesis claims
#
# - The linear pose beats the three-point pose at every level of noise
#   (Fig. 4.4), and RANSAC brings it nothing where no point is wrong.
# - On real images with few outliers (Table 4.1), CGSP with RANSAC is best,
#   CGSP without it worst, and the standard method does fairly well.
# - Errors on real images are larger, since grids are smaller and farther.
# - Three points are sensitive to noise unless they are far apart, and often
#   have no solution. The linear pose always has one, and is fast.
# - The synthetic plane may have any orientation, and should be nearly
#   perpendicular to the rays.

# %% [markdown]
# ## Model
#
# **A plane of our choice.** The camera's centre $\mathbf{C}$ and its rays
# are known. Ray $i$ has the unit direction $\mathbf{r}_i$ and sees a point
# $\mathbf{X}_i$ of the further grid, whose place on the grid is known from
# its pattern. A plane is put between camera and grid, in thought only.
# Where the rays pass it, they leave the points $\mathbf{x}'_i$.

# %% tags=["active-ipynb"]
# show("fig_4_3")

# %% [markdown]
# Whatever the lens is, these points are the image of a pinhole, because
# all rays start in one point. So a homography $H$, a 3 x 3 matrix, takes
# the grid to its image (4.20), and
#
# $$(K R_s)^{-1} H \simeq
#   (\mathbf{t}_1 \;\; \mathbf{t}_2 \;\; \mathbf{t}_4 - \mathbf{C}) .
# \tag{4.23}$$
#
# $K$ and $R_s$ are the synthetic camera's: we chose the plane, so both are
# known. $\mathbf{t}_1, \mathbf{t}_2, \mathbf{t}_4$ are columns of the pose
# $T$ that is sought. The first two are unit vectors at right angles, which
# fixes the scale; the nearest rotation to them is taken. If the plane is at
# distance 1 from the centre, $K$ is the identity and drops out.
#
# **Which plane.** The best normal $\mathbf{n}$ is as nearly parallel to all
# rays as can be,
#
# $$\operatorname{argmin}_{\mathbf{n}} \sum_i
#   \|[\mathbf{r}_i]_\times \mathbf{n}\|^2 ,
#   \quad \|\mathbf{n}\| = 1 . \tag{4.24}$$
#
# The print has no square, and then no closed form (E-4.07). With it,
# $\mathbf{n}$ is the eigenvector of $\sum \mathbf{r}_i \mathbf{r}_i^T$ with
# the largest eigenvalue. Its sign is that for which most rays have
# $\mathbf{r}_i \cdot \mathbf{n} > 0$; rays that lead away from the plane
# are left out and counted.

# %% tags=["active-ipynb"]
# show_code(synthetic_plane_normal)

# %% [markdown]
# **RANSAC.** Samples of four points give homographies. The one that most
# points agree with is found again from all of these points, until they stay
# the same. The standard method does the same with samples of three
# ([section 2.4](../ch02_general_camera_model/s4_1_linear_and_pose.ipynb)),
# and has no linear way to use more than three. Section 4.2.2 refines it by
# minimising the distances between rays and points (4.18).
#
# **Angles.** Noise in an image turns rays. The natural error of a pose is
# then the angle between a ray and the direction of its point, and not a
# length, which grows with the distance of the point. The last estimator
# minimises the sum of squared angles, from the linear pose on.

# %% [markdown]
# ## Experiment
#
# **Simulation.** The camera of 4.1.5: 100 degrees of field, 640 px, centre
# 600 mm above the base grid. A further grid is shifted by up to 150 mm and
# turned by up to 30 degrees. 999 pixels see both grids. Each gets its
# ray from a noisy point of the base grid, and a noisy point of the further
# one. All estimators see the same points, and both kinds of RANSAC have the
# same threshold.

# %%
TRIALS = {"quick": 5, "full": 50}


def noise_trial(condition, rng):
    """Errors of every estimator in one scene of condition's noise."""
    camera = radial_lens()
    noise, domain = condition["noise"], condition["domain"]
    scene = draw_scene(camera, noise, rng, grids=2, domain=domain)
    directions, points = rays_and_points(scene, condition["rays"])
    limit = threshold(camera, noise, domain, condition["unit"])
    true = scene.T_base_grid[1]
    size = np.linalg.norm(true[:3, 3])
    out = {}
    found = all_estimates(directions, points, rng, limit, METRICS[condition["unit"]])
    for name, T in found.items():
        out[name] = scored(T, moved(true, -CENTRE_MM))
        if "translation_mm" in out[name]:
            share = out[name]["translation_mm"] / size
            out[name]["translation_percent"] = 100 * share
    return out


@experiment("fig_4_4_noise", artefact="fig_4_4", shards={"full": 2})
def noise_sweep(effort):
    """Pose errors against the noise, in px and mm, on two kinds of rays."""
    levels = LEVELS if effort == "full" else LEVELS[::2]
    conditions = [
        {"noise": noise, "domain": domain, "rays": rays, "unit": unit}
        for domain in DOMAINS
        for rays in RAYS
        for unit in METRICS
        for noise in levels
    ]
    settings = SETTINGS | {
        "ransac_threshold_sd": WIDE,
        "shift_mm": [-SHIFT_MM, SHIFT_MM],
        "euler_deg": [-EULER_DEG, EULER_DEG],
    }
    return Plan(noise_trial, conditions, TRIALS[effort], settings)


# %% [markdown]
# **Pictures.** A Kodak MegaPlus 1.4i, a perspective camera, looks at a
# monitor with an active grid in two poses, drawn anew for each of
# {glue:text}`rendered_seeds` seeds. Both sequences are rendered and decoded.
# The camera was calibrated by Zhang's method from rendered pictures of a
# board, to {glue:text}`zhang_px:.2g` px. The truth is a laser scan with
# 0.1 mm of noise. What is scored is the pose of the second grid relative to
# the first, as in the thesis. The decoder of today leaves
# {glue:text}`wrong_percent:.1g` % of the pixels wrong, the one of the thesis
# less than 0.3 %. So 0.3 % of the points are put somewhere on the grid.

# %% tags=["active-ipynb"]
# show_code(with_outliers)

# %% [markdown]
# **Redrawn scenes.** The claims ask for fifty scenes. Further ones have the
# rig's poses and the errors of the decoded pictures: a bias of up to
# {glue:text}`bias_mm:.2g` mm that repeats with the sines of the pattern, and
# noise of {glue:text}`noise_mm:.2g` mm with the correlation that was
# measured. At the bench's noise these errors are larger by the factor that
# [section 4.3.2](s3_2_results.ipynb) solves; no number of this section was
# looked at for it. Both kinds stand beside each other:

# %% tags=["active-ipynb"]
# show_table("table_4_1")

# %% tags=["active-ipynb"]
# show_table("ext_table_4_1")

# %% [markdown]
# ## Reading and limits
#
# **Which standard method.** 4.2 says that re-estimation from all inliers is
# not possible with three points; 4.2.2 says that it was done, by minimising
# ray-point distances. The primary reading is the second, which is what was
# compared. Then the two methods are close: CGSP is ahead for certain at no
# level, and at most levels the refined standard pose is a little nearer.
# The ranking of Fig. 4.4 is found where the refinement is left out. The
# standard's three points were drawn far apart here, the remedy that 4.2
# names; it can only help.
#
# **No solution.** Of three noisy points drawn at random,
# {glue:text}`lost_any:.1f` % have no pose ahead of the camera. The library
# solves the quartic in closed form and keeps double roots that noise
# pushes off the real axis; a solver that drops them loses more, and the one
# of the thesis had to be replaced by a search. Close triples are
# {glue:text}`close_far:.0f` times worse than far ones.
#
# **Fast.** The linear pose solves one system of all points and never
# iterates. In this simulation the refinement solves
# {glue:text}`refining_systems:.0f` such systems (median), after
# {glue:text}`sampled_polynomials:.0f` polynomials of three points. Within
# RANSAC the linear pose draws samples, too.
#
# **Rendered against printed.** The errors here are far smaller than those that
# Table 4.1 prints. The laser scan's noise is most of what is left
# with RANSAC: all three good estimators share it. Today's rendered monitor
# is flat, nothing moves between two pictures, and the calibration is nearly
# perfect. A real set-up has none of that, and the text does not say how the
# scan was brought to the grid. The order of the two rows with CGSP does not
# depend on it.
#
# **Threshold.** Both kinds of RANSAC take the same length. Noise of pixels
# makes longer distances on far points, of which planes without bounds have
# many. A length leaves these out, an angle does not, and the linear pose
# within RANSAC is then the one without it. That is the second reading.
#
# **Angles.** Angular refinement is the best estimate for noise of the image
# in a camera that magnifies evenly. Where noise is in mm on the grid, a
# length is the right error, and its lead is gone.
#
# **Better rays.** With variance $v$ of a point and $v / n$ of a ray from $n$
# grids, a pose's error grows with $\sqrt{1 + 1/n}$: by 1.41 for one grid
# and 1.15 for three, compared with exact rays.
#
# **Tilted planes.** A plane at 60° loses {glue:text}`lost_rays:.0f` % of the
# rays. The comparison takes those that all planes see, so that the
# orientation alone differs; with all rays the best plane's lead is larger.

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
# **1.** Three rays lie in the x-z plane, at 10, 20 and 60 degrees to the z
# axis. At which angle (degrees) to it is the normal of (4.24)?

# %% tags=["active-ipynb"]
# check(None, **normal_task())

# %% [markdown]
# **2.** Let 10 % of the pairs be wrong. In how many percent of RANSAC's
# samples are all four pairs right?

# %% tags=["active-ipynb"]
# check(None, **sample_task())
