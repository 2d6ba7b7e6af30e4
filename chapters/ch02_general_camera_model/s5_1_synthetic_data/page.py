# %% [markdown]
# # 2.5.1 Synthetic data: parametric and generic calibration compared
#
# **Question.** A lens can be described by a pinhole with two radial terms,
# or by a table that gives every pixel a ray of its own. Which one is
# better, and from how much distortion on? The thesis answers with simulated
# data in its Fig. 2.3. This page runs the simulation again.

# %% tags=["hide-cell"]
from chapters.ch02_general_camera_model.s5_1_synthetic_data.exercises import (
    clean_residual,
    focal_of_equidistance,
    stretch_at,
)
from chapters.ch02_general_camera_model.s5_1_synthetic_data.results import (
    name_values,
)
from chapters.ch02_general_camera_model.s5_1_synthetic_data.trials import (
    DOMAINS,
    EXTENTS,
    FOV_NOISE,
    LAWS,
    LAWS_FOV_DEG,
    LEVELS,
    NOISE_FOV_DEG,
    calibrate_generic,
    calibrate_parametric,
    measure_laws,
    point_noise_ratio,
    scores,
    widest_angle_deg,
)
from chapters.shared.methods import METHODS
from chapters.shared.three_planes import (
    FINITE_MM,
    FOVS_DEG,
    POINTS,
    SIZE_PX,
    measure,
    observe,
    score,
)
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

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
# large as a pixel of the source image.

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
# | scoring | on the **noisy** data calibrated with, or on clean data |
# | extent | planes **unbounded**, or grids of ±600 mm |
# | standard method | linear stage **as printed**, or well conditioned |
# | pixels | of the **corrected view**, or of the source image |
#
# *As printed* is equations 2.15 to 2.25 with their typing errors mended but
# their numerics kept: one ratio sets the common scale, and divisions by
# numbers that may be close to zero stay, such as that by $C_y$ for $t_z$.
# *Well conditioned* solves the same equations with normalised coordinates
# and least squares. The same bundle adjustment follows both.

# %%
TRIALS = {"quick": 4, "full": 50}

SETTINGS = {
    "image_px": [SIZE_PX, SIZE_PX],
    "points_per_trial": POINTS,
    "noise_sweep": {
        "law": "pinhole with k1 = -0.2, k2 = 0.05",
        "fov_deg": NOISE_FOV_DEG,
        "levels": list(LEVELS),
    },
    "fov_sweep": {
        "law": "equidistance",
        "fov_deg": list(FOVS_DEG),
        "noise": FOV_NOISE,
    },
    "law_sweep": {
        "laws": list(LAWS),
        "fov_deg": LAWS_FOV_DEG,
        "noise": FOV_NOISE,
    },
    "fov": "on the image diagonal",
    "finite_grids_mm": [-FINITE_MM, FINITE_MM],
    "grids": "600 mm away, shifted by up to 150 mm on every axis, tilted "
    "by 10 to 30 deg about a random axis, at least 10 deg apart",
}


# %% [markdown]
# ## Experiment
#
# Two sweeps, each for noise in px and in mm and for unbounded and finite
# grids, 50 trials per condition. Seeds come from the artefact, the
# condition and the trial, so the numbers are the same for any number of
# cores.


# %%
def conditions(law, fovs_deg, levels):
    """All conditions of a sweep."""
    return [
        {
            "law": law,
            "fov_deg": fov_deg,
            "noise": level,
            "domain": domain,
            "extent": extent,
        }
        for domain in DOMAINS
        for extent in EXTENTS
        for fov_deg in fovs_deg
        for level in levels
    ]


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


@experiment(
    "fig_2_3_noise", artefact="fig_2_3", shards={"quick": 2, "full": 6}
)
def noise_sweep(effort):
    """Fig. 2.3(a): rising noise, a lens the pinhole model can follow."""
    cases = conditions("lens", [NOISE_FOV_DEG], LEVELS)
    return Plan(trial, cases, TRIALS[effort], SETTINGS)


@experiment(
    "fig_2_3_fov", artefact="fig_2_3", shards={"quick": 2, "full": 8}
)
def fov_sweep(effort):
    """Fig. 2.3(b): rising field of view of an equidistance lens."""
    cases = conditions("equidistance", FOVS_DEG, [FOV_NOISE])
    return Plan(trial, cases, TRIALS[effort], SETTINGS)


def laws_trial(condition, rng):
    """One trial: the generic method's scores under every law."""
    measured = measure_laws(condition, rng)
    return {law: scores(measured[law], METHODS[1:]) for law in LAWS}


@experiment(
    "fig_2_3_laws", artefact="fig_2_3", shards={"quick": 1, "full": 2}
)
def law_sweep(effort):
    """Four laws at 90 degrees: same image radius, rays and noise."""
    cases = conditions("all four", [LAWS_FOV_DEG], [FOV_NOISE])
    return Plan(laws_trial, cases, TRIALS[effort], SETTINGS)


# %% [markdown]
# ## Figures
#
# Every point is the median over the trials of the mean (or SD) over the 999
# points of a trial; the band is its 95 % interval. A trial in which a
# method failed counts as its worst. The code that draws is in `figures.py`
# beside this page.


# %% tags=["active-ipynb"]
# show("fig_2_3")

# %% tags=["active-ipynb"]
# show("ext_fig_2_3_readings")

# %% tags=["active-ipynb"]
# show("ext_fig_2_3_rays")

# %% tags=["active-ipynb"]
# name_values(open_results("fig_2_3_noise"), open_results("fig_2_3_fov"))

# %% [markdown]
# ## Reading and limits
#
# **Noise.** Both curves of Fig. 2.3(a) grow in proportion to the noise, as
# claimed, in every reading: on logarithmic axes, straight lines of slope 1.
# Their heights have simple causes.
# The parametric model describes this lens exactly, so what is left is the
# noise of the pixels, $\sigma\sqrt{\pi/2}$. A generic ray is fitted to
# three points, so its own error is about that divided by $\sqrt 3$. Scored
# on one of the three points, as here, what is left of the noise is about
# $\sqrt{2/3}$.
#
# **Field of view.** From 60° to 150° the residual of the parametric method
# grows from {glue:text}`parametric.noisy.corrected.mean_px.60:.2f` to
# {glue:text}`parametric.noisy.corrected.mean_px.150:.1f` px. Two radial
# terms cannot bend a pinhole into an equidistance lens. The generic method
# goes from {glue:text}`generic_as_printed.noisy.corrected.mean_px.60:.2f`
# to {glue:text}`generic_as_printed.noisy.corrected.mean_px.150:.2f` px.
#
# **Flat or not?** That slow rise is mostly a matter of units. A corrected
# view stretches an equidistance image by $1/\cos^2\theta$ along the radius,
# and the noise with it. Measured in pixels of the source image, on clean
# data, the generic residual hardly moves:
# {glue:text}`generic_as_printed.clean.source.mean_px.30:.2f` px at 30°,
# {glue:text}`generic_as_printed.clean.source.mean_px.120:.2f` px at 120°.
#
# **The rise at 150°.** It is there when the noise is drawn in the image,
# and grids of ±600 mm take it away, as the thesis says. On unbounded planes
# the noise of the points is {glue:text}`noise_ratio:.0f` times larger at
# the edge of the field of view than at its centre. When the noise is drawn
# on the grids in mm, nothing is magnified, and the mean at 150° is
# {glue:text}`rise.mm:.2f` times that at 120°. But small grids also hide the
# edge: the pixels that see all three lie within about
# {glue:text}`widest_angle_deg.finite.150:.0f`° of the axis, whatever the
# field of view. There the parametric method hardly suffers either.
#
# **Which method is better?** On noisy data the generic method wins at every
# field of view, so the crossing that Table 2.2 suggests is not seen. This
# is not a merit. Each ray has two unknowns of its own for six measured
# coordinates, and it follows the noise that it is scored on. On clean data
# the parametric method is far better where it fits
# ({glue:text}`parametric.clean.corrected.mean_px.30:.3f` against
# {glue:text}`generic_as_printed.clean.corrected.mean_px.30:.2f` px at 30°),
# and the generic method is better
# {glue:text}`ahead.generic_as_printed.px.unbounded.corrected`; in pixels of
# the source image,
# {glue:text}`ahead.generic_as_printed.px.unbounded.source`; with noise in
# mm, {glue:text}`ahead.generic_as_printed.mm.unbounded.corrected`. That
# needs the edge of the image. On grids of ±600 mm and with noise in px, the
# generic method is better
# {glue:text}`ahead.generic_as_printed.px.finite.corrected`. With noise in mm
# it is better {glue:text}`ahead.generic_as_printed.mm.finite.corrected` as
# printed, {glue:text}`ahead.generic_well_conditioned.mm.finite.corrected`
# well conditioned, and in pixels of the source image
# {glue:text}`ahead.generic_as_printed.mm.finite.source`. The real images of
# Table 2.2, where each method has its range, look like the clean data on
# unbounded planes.
#
# **What a distortion residual does not see.** As printed and well
# conditioned, the generic method leaves nearly the same residual. Its rays
# do not agree: at 90° their median error is
# {glue:text}`generic_as_printed.ray_deg.90:.2f` against
# {glue:text}`generic_well_conditioned.ray_deg.90:.2f` degrees. A wrong
# centre bends the bundle of rays almost as a homography does, and the
# alignment takes that out. So an angle always stands beside a residual in
# this report.
#
# **Where the verdict is not "reproduced".** The crossing differs for the
# reason above. That the generic error does not depend on distortion
# differs, but narrowly: the test allows a fifth of the parametric slope,
# and the stretch of the corrected view uses up nearly all of that; well
# conditioned, it is undecided. In pixels of the source image it holds. The
# spread of the mean from 30° to 120° is undecided with 50 trials: its
# interval crosses the limit that the test sets. With noise in mm most
# claims about the field of view differ, for one reason: a wider lens has a
# shorter focal length, so the same noise on the grid is fewer pixels in the
# image.
#
# **The projection law** plays no part, as claimed: the same rays with the
# same noise in px leave the same residual under four laws, in the pixels of
# each camera's own image.
#
# **Left out.** In {glue:text}`generic_as_printed.failed` of
# {glue:text}`trials` trials the method as printed found a negative $C_z^2$
# and gave nothing (well conditioned, in
# {glue:text}`generic_well_conditioned.failed`); these trials count as the
# worst. Pixels that miss a plane are drawn again: at 150°, a share of
# {glue:text}`accepted_share.unbounded.150:.3f` of the pixels sees all three
# unbounded planes, and of {glue:text}`accepted_share.finite.150:.2f` all
# three grids of ±600 mm.
#
# **What was known when the choices were made.** The tests of the claims
# were written before any run, with one exception: after a full run, the
# test of the projection laws (`c2_modality_independent`) was changed to the
# wording of its claim (the same rays and noise for all four laws, pixels of
# the source image), which turned *undecided* into *reproduced*. The choices
# above and the primary readings were put into the ledger after single
# trials and a build with few trials had been seen, and before the run of
# record. The scale of the residual became an open question only then. No
# choice was made for its verdict, but a reader who wants to be sure looks
# at all readings, not at the primary one.
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
# Open this page as a notebook (`make notebooks`), put an answer in place of
# `None`, and run the cell.
#
# **1.** Noise of 0.5 px, three grids: what is the mean length of the error
# of a generic ray, in px of the source image? Compare with the figure.

# %% tags=["active-ipynb"]
# check(None, expected=lambda: clean_residual(0.5, 3), hint="noise, then 3 points")

# %% [markdown]
# **2.** How long, in px, is the focal length of an equidistance lens whose
# field of view on the diagonal of this image is 120°?

# %% tags=["active-ipynb"]
# check(None, lambda: focal_of_equidistance(120), hint="degrees or radians?")

# %% [markdown]
# **3.** By what factor does a corrected view stretch a short step along the
# radius, 60° from the principal ray, compared with the equidistance image?

# %% tags=["active-ipynb"]
# check(None, expected=lambda: stretch_at(60), hint="differentiate the tangent")

# %% [markdown]
# **4.** What if the thesis had run 500 trials? `make fig_2_3 TRIALS=500`
# draws the figure again, beside the record. Which intervals become
# narrower, and by how much?
