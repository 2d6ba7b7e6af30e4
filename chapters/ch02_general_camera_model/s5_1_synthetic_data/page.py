# %% [markdown]
# # 2.5.1 Synthetic data: parametric and generic calibration compared
#
# **Question.** A lens can be described by a pinhole with two radial terms,
# or by a table that gives every pixel a ray of its own. Which one is
# better, and from how much distortion on? The thesis answers with simulated
# data in its Fig. 2.3. This page runs the simulation again.

# %%
from chapters.ch02_general_camera_model.s5_1_synthetic_data.exercises import (
    focal_task,
    residual_task,
    stretch_task,
    unseen_task,
)
from chapters.ch02_general_camera_model.s5_1_synthetic_data.results import name_values
from chapters.ch02_general_camera_model.s5_1_synthetic_data.trials import (
    FOV_NOISE,
    LEVELS,
    NOISE_FOV_DEG,
    SETTINGS,
    TRIALS,
    calibrate_generic,
    calibrate_parametric,
    conditions,
    point_noise_ratio,
    scores,
    widest_angle_deg,
)
from chapters.shared.methods import METHODS
from chapters.shared.three_planes import FOVS_DEG, measure, observe, score
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("fig_2_3")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings**
#
# - The residuals of both methods grow in proportion to the noise.
# - In the primary reading there is one crossing: the standard perspective
#   method is better up to {glue:text}`crossing.below`°, the generic method
#   from {glue:text}`crossing.above`° on. Whether and where methods cross
#   hangs on the reading.
# - A generic ray is fitted to three points only, and that costs nearly the
#   same at every field of view up to 120°. In the primary reading it leaves
#   {glue:text}`generic_as_printed.over.30:.2f` times what exact rays leave
#   at 30°, and {glue:text}`generic_as_printed.over.120:.2f` times at 120°.
# - Most of the rise at 150° is the stretch of the corrected view, which
#   exact rays show too; what is beyond it goes away on finite grids.
# - OpenCV's fisheye model, which the thesis did not have, contains the law
#   of this lens. It leaves {glue:text}`opencv_fisheye.over.150:.2f` times
#   what exact rays leave, at 150° as at 30°.

# %% [markdown]
# ## What the thesis claims
#
# Section 2.5.1 compares the *standard perspective method* (Zhang's, with
# two radial terms {cite}`zhang2000`) with the *central generic method*
# {cite}`sturm2004`, on a camera of 640 × 640 pixels:
#
# - Fig. 2.3(a): Gaussian noise is put on 999 random image points, 50 times
#   per level. The residuals of both methods grow in proportion to the
#   noise.
# - Fig. 2.3(b): the lens follows the equidistance law (2.6) and its field
#   of view grows from 30° to 150° (here: along the diagonal). The residual
#   of the parametric method grows. The generic method stays low, except at
#   150°, where mean and spread rise. The thesis puts that down to its
#   planes of unlimited extent, which some rays meet at a very small angle.

# %% [markdown]
# ## Model
#
# One trial needs a camera, three grids whose poses the methods do not know,
# and 999 pixels that see all three. Noise is drawn anew for every grid.
# This matters: one noisy pixel thrown on all planes would leave its three
# points on one line through the centre, and every method would be exact.
# The first grid is measured once more, with noise that no method sees.
#
# The code of one trial's data, from `chapters/shared/three_planes.py`:

# %% tags=["active-ipynb"]
# show_code(measure, observe)

# %% [markdown]
# Both methods then work on the same data. The parametric method gets pixels
# and grid points. The generic method gets the three points of every pixel,
# and runs steps 3 and 4 of Algorithm 1: the linear stage, then a bundle
# adjustment that moves grids and rays while the centre stays.

# %% tags=["active-ipynb"]
# show_code(calibrate_parametric, calibrate_generic)

# %% [markdown]
# **The residual.** A corrected image is formed by cutting the calibrated
# rays with a plane perpendicular to the principal ray. A homography then
# carries it onto the known positions (it keeps straight lines straight, so
# it cannot remove a bend), and what is left over is the residual. Its unit
# is a pixel of that corrected view, scaled so that at the centre it is as
# large as a pixel of the source image. Further out a corrected view
# stretches an equidistance image, by $1/\cos^2\theta$ along the radius at
# the angle $\theta$ from the principal ray, and the noise with it. So
# *exact rays*, those of the simulated camera, are scored as well: they
# leave the noise of the scored points and nothing else.

# %% tags=["active-ipynb"]
# show_code(score)

# %% [markdown]
# **What the text leaves open.** The thesis does not state the noise levels,
# the poses, the unit of the residual or the lens of Fig. 2.3(a). The
# choices are written down in the ledger, with a reason for each. Five open
# questions can change a verdict, so every claim is tested in all
# combinations of those that its wording leaves open. The first option of
# each is the *primary reading*, which decides the verdict:
#
# | question | options |
# |---|---|
# | noise | drawn in the image (**px**), or on the grids (mm) |
# | scoring | on **fresh noise**, on the same noise, or without noise |
# | extent | planes **unbounded**, or grids of ±600 mm |
# | standard method | linear stage **as printed**, or well conditioned |
# | pixels | of the **corrected view**, or of the source image |
#
# *Why fresh noise.* The thesis wants to say what precision is to be
# expected of each method, and scores points that have noise. It names no
# second set of points, so the noise calibrated with may be meant. But a
# generic ray is fitted to its own three points and absorbs a third of the
# variance of their noise; a pinhole with its few numbers cannot. Scored on
# the same noise the generic method is ahead wherever the pinhole fits,
# however well either is calibrated, and a comparison that can come out one
# way only is none.
#
# *As printed* is equations 2.15 to 2.25 with their typing errors mended but
# their numerics kept: one ratio sets the common scale, and divisions by
# numbers that may be close to zero stay, such as that by $C_y$, a
# coordinate of the centre, for the shift $t_z$ of a grid. *Well
# conditioned* solves the same equations with normalised coordinates and
# least squares. The same bundle adjustment follows both.

# %% [markdown]
# ## Experiment
#
# Two sweeps, each for noise in px and in mm and for unbounded and finite
# grids, 50 trials per condition. Seeds come from the artefact, the
# condition and the trial, so the numbers are the same for any number of
# cores, and OpenCV's fisheye model gets the data of the first trials.


# %%
def trial(condition, rng):
    """One trial: measure, calibrate with each method, score each way."""
    data, drawn = measure(condition, rng)
    out = drawn | {
        "points": len(data.pixels),
        "widest_angle_deg": widest_angle_deg(data),
    }
    if condition["noise"] > 0:
        out["point_noise_ratio"] = point_noise_ratio(data)
    return out | scores(data, METHODS)


@experiment("fig_2_3_noise", artefact="fig_2_3", shards={"quick": 2, "full": 6})
def noise_sweep(effort):
    """Fig. 2.3(a): rising noise, a lens the pinhole model can follow."""
    cases = conditions("lens", [NOISE_FOV_DEG], LEVELS)
    return Plan(trial, cases, TRIALS[effort], SETTINGS)


@experiment("fig_2_3_fov", artefact="fig_2_3", shards={"quick": 2, "full": 8})
def fov_sweep(effort):
    """Fig. 2.3(b): rising field of view of an equidistance lens."""
    cases = conditions("equidistance", FOVS_DEG, [FOV_NOISE])
    return Plan(trial, cases, TRIALS[effort], SETTINGS)


# %% [markdown]
# ## Figures
#
# Every point is the median over the trials of the mean (or SD) over the 999
# points of a trial; the band is its 95 % interval. A trial in which a
# method failed counts as its worst. The code that draws is in `figures.py`
# beside this page.

# %% tags=["active-ipynb"]
# show("ext_fig_2_3_fisheye")

# %% [markdown]
# ## Reading and limits
#
# **Noise.** On logarithmic axes both curves of Fig. 2.3(a) are straight
# lines of slope 1, in every reading. Their heights have simple causes. For
# noise of SD $\sigma$ on both axes of a pixel, a scored point lies
# $\sigma\sqrt{\pi/2}$ from its true place on average. The parametric model
# describes this lens exactly and leaves just that. A generic ray is fitted
# to three points, so its own error is $\sqrt{1/3}$ of it, and with the
# scored point's noise $\sqrt{4/3}$. On fresh noise the claim is therefore
# close to a matter of course. It is none without noise, where the residual
# is the calibration's own error, and it holds there, too.
#
# **Field of view.** Two radial terms cannot bend a pinhole into an
# equidistance lens: from 60° to 150° the residual of the parametric method
# grows from {glue:text}`parametric.mean.60:.2f` to
# {glue:text}`parametric.mean.150:.1f` px.
#
# **One crossing.** In the primary reading, up to 75° the pinhole fits as well
# as exact rays, and the table of rays pays for its many numbers. Then the
# pinhole's bend grows past that price, between {glue:text}`crossing.below`°
# and {glue:text}`crossing.above`°. This is the thesis's claim: the standard
# method is better at low distortion, the generic one at high.
#
# On grids of ±600 mm a share of {glue:text}`accepted_share.finite.150:.2f` of
# the pixels sees all three at 150°, and the widest ray is
# {glue:text}`widest_angle_deg.finite.150:.0f`° from the axis. Without noise
# the pinhole leaves {glue:text}`parametric.clean.finite.most:.2f` px there at
# most, at any field of view; the noise has an SD of 0.5 px on either axis. On
# fresh noise the generic method is ahead {glue:text}`ahead.finite.px` on
# these grids. With noise in mm it is ahead {glue:text}`ahead.finite.mm`: in a
# wider lens that noise is fewer pixels, and less of it hides the pinhole's
# bend. On the same noise the generic method is ahead everywhere, because it
# is scored on what it was fitted to. In the thesis's
# Table 2.2, of real images, each method has its range, as in the readings on
# unbounded planes that are scored on fresh noise or without.
#
# **What the measure itself does.** In a corrected view a residual in px
# grows with the field of view whatever is measured. Exact rays show how
# much (Fig. 2.3).
#
# **Flat or not?** The generic mean grows from 30° to 120° as that of exact
# rays does. In px of the source image it hardly moves.
#
# **The rise at 150°.** Most of it is the stretch: the generic mean is
# {glue:text}`generic_as_printed.over.120:.2f` times that of exact rays at
# 120° and {glue:text}`generic_as_printed.over.150:.2f` times at 150°. The
# rest is the method's, and grids of ±600 mm take it away, as the thesis
# says. Its explanation is another matter. On unbounded planes the noise of
# the points, in mm, is {glue:text}`noise_ratio:.0f` times larger at the
# edge of the field of view than at its centre; but a ray that grazes a
# plane meets it far away and nearly along the ray, and what counts for a
# ray is the angle, in which the noise is the same for all. Ray by ray the
# residual does not follow the angle to the plane, once the view's stretch
# is out of it. So the claim about the cause differs. A likelier cause, not
# tested here: rays are fitted to distances in mm, so that a point far away
# counts more than the two others, and a ray has less to average over.
#
# **OpenCV's fisheye model** has four radial terms beyond
# $r = f\theta$, and so describes the equidistance law exactly, as the
# pinhole does the lens of Fig. 2.3(a). It shows what a model of few numbers
# reaches where it fits. It failed in
# {glue:text}`opencv_fisheye.failed` of
# {glue:text}`opencv_fisheye.trials` trials. A lens that follows no such law
# is the case for the table of rays; this sweep has none.
#
# **What a distortion residual does not see.** As printed and well
# conditioned, the generic method leaves nearly the same residual. Its rays
# do not agree: at 90° their median error is
# {glue:text}`generic_as_printed.ray_deg.90:.2f` against
# {glue:text}`generic_well_conditioned.ray_deg.90:.2f` degrees. The
# likely reason: a wrong centre bends the bundle of rays almost as a
# homography does, and the alignment takes that out. Even at 150°, where the
# pinhole leaves {glue:text}`parametric.mean.150:.0f` px, its rays are off by
# {glue:text}`parametric.ray_deg.150:.2f` degrees and those of the table as
# printed by {glue:text}`generic_as_printed.ray_deg.150:.2f`. In angles the
# generic method is ahead {glue:text}`generic_as_printed.rays_ahead` as
# printed, and {glue:text}`generic_well_conditioned.rays_ahead` well
# conditioned. So an angle always stands beside a residual in this report.
#
# **The projection law** plays no part, as claimed: the same rays with the
# same noise in px leave the same residual under four laws, in the pixels of
# each camera's own image. In the corrected view they differ as exact rays
# do.
#
# **Noise in mm.** With it most claims about the field of view differ, for
# one reason: a wider lens has a shorter focal length, so the same noise on
# the grid is fewer pixels in the image.
#
# **Left out.** In {glue:text}`generic_as_printed.failed` of
# {glue:text}`trials` trials the method as printed found a negative $C_z^2$,
# the square of the centre's height over the base grid, and gave nothing
# (well conditioned, in {glue:text}`generic_well_conditioned.failed`); these
# trials count as the worst. Pixels that miss a plane are drawn again: at
# 150°, a share of {glue:text}`accepted_share.unbounded.150:.3f` of the
# pixels sees all three unbounded planes.
#
# **What was known when the choices were made.** The choices and the primary
# readings were put into the ledger after single trials and a build with few
# trials had been seen, before the first run of record. After that run, two
# kinds of things were changed. Fresh noise became an option, and primary;
# by then an independent run had shown that it brings the crossing back. And
# exact rays were set beside all tests; where these pass a test as well, it
# was mended, or says so. *Changed after a run*, in the table below, says
# what that did to each verdict. A reader who wants to be sure looks at all
# readings, not at the primary one.
#
# **Limits.** One size of noise in the sweep over the field of view, one
# kind of grid poses, and the ideal laws of three fisheye lenses and a
# pinhole. Noise is Gaussian and has no outliers.

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
# **1.** Noise of 0.5 px, three grids: what is the mean length of the error
# of a generic ray, in px of the source image?

# %% tags=["active-ipynb"]
# check(None, **residual_task())

# %% [markdown]
# **2.** A ray is fitted to three points with independent noise of one size.
# How large is its RMS distance from one of them, as a multiple of that from
# a fourth point that it has not seen?

# %% tags=["active-ipynb"]
# check(None, **unseen_task())

# %% [markdown]
# **3.** How long, in px, is the focal length of an equidistance lens whose
# field of view on the diagonal of this image is 120°?

# %% tags=["active-ipynb"]
# check(None, **focal_task())

# %% [markdown]
# **4.** By what factor does a corrected view stretch a short step along the
# radius, 60° from the principal ray, compared with the equidistance image?

# %% tags=["active-ipynb"]
# check(None, **stretch_task())

# %% [markdown]
# **5.** What if the thesis had run 500 trials? `make fig_2_3 TRIALS=500`
# draws the figure again, beside the record. Which intervals become
# narrower, and by how much?
