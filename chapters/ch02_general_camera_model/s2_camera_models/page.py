# %% [markdown]
# # 2.2 Camera distortions: a zoo of models
#
# **Question.** There are many formulas for how a camera bends the picture.
# Which cameras can each of them describe, which not, and with how many
# numbers?

# %%
import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.exercises import (
    cubics_task,
    edge_task,
    omega_task,
    sphere_task,
)
from chapters.ch02_general_camera_model.s2_camera_models.results import name_values
from chapters.ch02_general_camera_model.s2_camera_models.trials.zoo import (
    CURVES,
    DRAWN_MM,
    FAMILIES,
    LENSES,
    POINT_MM,
    ROOM,
    angles_from,
    curve_trial,
    grid_of,
    lens,
    looking,
    mirror_trial,
    model_end,
    rays_trial,
    room_trial,
    there_and_back,
)
from chapters.shared.zoo import ELSEWHERE, ZOO, camera
from raxel.cameras import (
    DivisionCamera,
    KannalaBrandtCamera,
    QuadricMirrorCamera,
    ScaramuzzaCamera,
    UnifiedSphereCamera,
    centrality,
)
from raxel.cameras.lenses.fit import fit_camera
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("ext_zoo_room")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# The room itself, from outside, is shown with the camera of [Fig.
# 1.1](../ch01_introduction/s1_1_panorama.ipynb) in the same place.
#
# **Findings.**
#
# - The zoo has {glue:text}`cameras` cameras, one for every model that the
#   section names and the library has. All of them turn pixels into rays and
#   points into pixels.
# - Models that displace points of the image plane end before 90° from the
#   axis, as the thesis says. That is geometry and has nothing to do with
#   fitting.
# - The form of a model can count for more than its number of coefficients.
#   Up to 70° from the axis of the FC-E8 fisheye, the one coefficient of the
#   field-of-view model leaves {glue:text}`fov_px:.2f` px, and two radial
#   terms leave {glue:text}`radial_px:.1f` px.
# - {glue:text}`not_central` of the cameras have no single centre. The rays
#   of the lens whose pupil moves miss one point by
#   {glue:text}`axial_mm:.1f` mm (RMS), those of the curved mirrors by
#   {glue:text}`curved_least_mm:.1f` to {glue:text}`curved_most_mm:.0f` mm.

# %% [markdown]
# ## What the thesis claims
#
# - Radial distortion is the largest distortion of an ordinary lens, and
#   (2.4) with one or two coefficients describes it. Other models of the
#   image plane are the division model, with one number, and the rational
#   cubics of Hartley and Saxena, with "80 parameters".
# - A fisheye needs a projection law from rays to points, (2.5) to (2.9).
#   "The image displacement approach will fail for fisheye cameras with FOVs
#   greater than or equal to 180°, since in these cases there is no single
#   plane with which all the camera rays can intersect." The complete model
#   of Kannala and Brandt {cite}`kannala2006` has 6 to 23 parameters.
# - Mirrors: central models by shape, one sphere for all of them, and a
#   polynomial (2.10). Mirrors off their focus, flat mirrors and exotic
#   cameras (X-slits, pushbroom, axial) are not central.
# - So there are many models, each for its own cameras; section 2.3 replaces
#   them by one that fits all.

# %% [markdown]
# ## Model
#
# **Displacement in the image plane.** With $\mathbf{p}$ the undistorted
# point and $r = |\mathbf{p}|$,
#
# $$\check{\mathbf{p}} = \mathbf{p} + \mathbf{p}(k_1 r^2 + k_2 r^4 + \dots).
# \tag{2.4}$$
#
# **A law of the angle.** With $\theta$ from the axis and $\varphi$ around
# it,
#
# $$\mathbf{p} = r(\theta)\,(\cos\varphi, \sin\varphi)^T, \tag{2.5}$$
#
# $$r = f\theta, \tag{2.6}$$
#
# $$r = 2f \sin(\theta/2), \tag{2.7}$$
#
# $$r = 2f \tan(\theta/2), \tag{2.8}$$
#
# $$\check{\mathbf{p}} = \mathbf{p} + \Delta_r(\theta, \varphi) +
# \Delta_t(\theta, \varphi). \tag{2.9}$$
#
# **A ray for a point.** A polynomial in the radius gives the third
# coordinate of the ray:
#
# $$\begin{aligned}
# \mathbf{r} \simeq (&\check{\mathbf{p}}';\; a_0 + a_2
# |\check{\mathbf{p}}'|^2 \\
# &+ \dots + a_n |\check{\mathbf{p}}'|^n).
# \end{aligned} \tag{2.10}$$
#
# **A mirror.** The library does not fit a formula to a mirror. It reflects
# the viewer's ray in the quadric.
#
# Each model is one class with `rays` (pixels to rays) and `project` (points
# to pixels). Its text says what ends where.

# %% tags=["active-ipynb"]
# show_code(DivisionCamera, ScaramuzzaCamera, UnifiedSphereCamera)

# %% [markdown]
# ## Experiment
#
# One camera of every model, {glue:text}`cameras` in all, has an image of
# 200 × 200 pixels. Five small runs use them: a census, the projection
# curves, fits of every round model to two lenses, the rays of those that
# are not central, and a picture of one room through eight cameras. The
# second lens is the FC-E8 fisheye converter at one zoom setting, as the
# rig of section 2.5.2 has it from a published calibration.

# %%
STEPS = {"quick": 5, "full": 2}
ANGLES = {"quick": 30, "full": 60}
# Terms beyond the simplest form, at most, for the two lenses.
MOST_TERMS = {"quick": (1, 2), "full": (3, 3)}
SAMPLES = {"quick": 16, "full": 64}
MIRRORS = ("hyperboloid mirror", "paraboloid mirror", "ellipsoid mirror")


# %%
def census_trial(condition, rng):
    """Counts and measures of one camera."""
    model = camera(condition["model"])
    pixels = grid_of(condition["step"])
    rays = model.rays(pixels)
    pixels = pixels[rays.valid]
    seen = type(rays)(*(part[rays.valid] for part in rays))
    misses = there_and_back(model, pixels, seen)
    widest = angles_from(looking(model), seen.directions).max()
    return {
        "kind": model.kind,
        "parameters": int(model.parameters),
        "central": bool(model.central),
        "projects": bool(model.projects),
        "widest_deg": float(np.degrees(widest)),
        "model_end_deg": model_end(model),
        "centrality_mm": centrality(seen),
        "round_trip_px": float(np.nanmax(misses)),
        "returned": float(np.isfinite(misses).mean()),
        "share": float(rays.valid.mean()),
    }


@experiment("exp_zoo", artefact="sec_2_2")
def census(effort):
    """Counts, field of view, centrality and round trip of every camera."""
    conditions = crossed(model=ZOO, step=[STEPS[effort]])
    settings = {
        "image_px": [200, 200],
        "round trip": f"by the point {POINT_MM:g} mm along the ray",
        "left out": dict(ELSEWHERE),
    }
    return Plan(census_trial, conditions, 1, settings)


@experiment("exp_zoo_curves", artefact="sec_2_2")
def curves(effort):
    """Angle and radius along a row of every round camera."""
    return Plan(curve_trial, [{"model": name} for name in CURVES], 1)


def fit_trial(condition, rng):
    """One family, one number of terms, one lens: rms and largest error."""
    widest, _, start = FAMILIES[condition["family"]]
    angles = np.linspace(0, widest, condition["angles"])
    radii = lens(condition["lens"])(angles)
    # A pinhole's radius grows without end: its focal length starts small.
    focal = radii[-1] / angles[-1]
    found = fit_camera(start(focal, condition["extra"])(), angles, radii)
    return {
        "free": found.free,
        "rms_px": found.rms_px,
        "largest_px": float(np.abs(found.residuals_px).max()),
        "rim_px": float(radii[-1]),
    }


@experiment(
    "exp_zoo_fits",
    artefact="sec_2_2",
    shards={"full": 2},
    inputs=("data/rigs/coolpix-fce8-zoom-3.yaml",),
)
def fits(effort):
    """Every round model, with more and more terms, fitted to two lenses."""
    conditions = [
        {"lens": lens, "family": family, "extra": extra, "angles": ANGLES[effort]}
        for lens, most in zip(LENSES, MOST_TERMS[effort], strict=True)
        for family, (_, terms, _) in FAMILIES.items()
        for extra in terms
        if extra <= most
    ]
    settings = {
        "angles": "even, to 91.5 deg; models of the image plane to 70 deg",
        "weights": "none: least squares of the radius in px",
    }
    return Plan(fit_trial, conditions, 1, settings)


@experiment("exp_zoo_mirrors", artefact="sec_2_2")
def mirrors(effort):
    """The unified sphere fitted to the three central mirrors."""
    return Plan(mirror_trial, [{"model": name} for name in MIRRORS], 1)


@experiment("exp_zoo_rays", artefact="sec_2_2")
def rays(effort):
    """Rays and caustic points of cameras that are not central."""
    return Plan(rays_trial, [{"model": name} for name in DRAWN_MM], 1)


@experiment("exp_zoo_room", artefact="sec_2_2")
def pictures(effort):
    """One room through eight cameras, without lens blur or noise."""
    return Plan(room_trial, crossed(model=ROOM, samples=[SAMPLES[effort]]), 1)


# %% [markdown]
# The claim that no plane is met by all rays from 180° on has an experiment
# of its own, in `trials/planes.py` beside this page: a linear programme
# looks for a normal that all rays of a bundle have in front.

# %% [markdown]
# ## Reading and limits
#
# - **Both ways.** All {glue:text}`cameras` cameras have `project` as well
#   as `rays`, so none has to say why not. {glue:text}`returned:.0f` % of
#   the pixels with a ray come back from a point of it, to
#   {glue:text}`trip_px:.0e` px. For some cameras a point may have several
#   pixels: a point seen in two plane mirrors, or short of the caustic of a
#   concave mirror. Then `project` gives one of them.
# - **Where plane models end.** The linear programme finds a plane for
#   every bundle up to {glue:text}`plane_fov:.0f`° and for none from 180°
#   on: the claim holds, and it is geometry, not fitting. The division
#   model and the FOV model see less than 90° from the axis. The *formula*
#   of the FOV model goes on beyond, but as published it displaces points
#   of the image plane, and the library keeps to that. With decentring the
#   library stops at {glue:text}`brown_end:.1f`°, where it inverts the map
#   by search.
# - **Few numbers can do.** The table below compares models with as few
#   numbers as they have. The field-of-view model contains equidistance
#   (exercise 1), and this lens is near to that. "Image displacement" is not
#   worse as such: it only has to end.
# - **Fisheye laws.** Over the whole 183° of the FC-E8 the ideal law (2.6)
#   leaves {glue:text}`ideal_px:.1f` px. One number more leaves
#   {glue:text}`rational_px:.1f` px with the rational law of Micusik and
#   Pajdla, and {glue:text}`sphere_fit_px:.1f` px with the unified sphere. The
#   polynomial (2.10) leaves {glue:text}`poly_2_px:.1f` px with one number
#   more, and {glue:text}`poly_3_px:.1f` px with two. That Kannala and
#   Brandt's polynomial fits exactly says nothing: the rig's lens is such a
#   polynomial.
# - **Counting.** Parameters are counted in different ways. Hartley and
#   Saxena's "80" are four cubics of the three coordinates of a point, 20
#   coefficients each; two of them are scales that cancel. Most of the
#   cameras that these describe are not central: points behind one pixel lie
#   on a curve, not on a ray. The library has the central ones, with
#   {glue:text}`cubic:.0f` parameters. Of the {glue:text}`kb:.0f` of Kannala
#   and Brandt three are scales that cancel, too. The look-up table of
#   section 2.3 has two numbers for every pixel with a ray,
#   {glue:text}`table_size:.0f` here.
# - **Signs.** A negative $a_0$ in (2.10), the sign of the published
#   toolbox, means that the middle of the image looks along $-z$. A mirror
#   looks back at its viewer too: with $z$ reversed the unified sphere
#   equals each of the three central mirrors, to {glue:text}`sphere_px:.0e`
#   px.
# - **Not central.** How far the rays of each camera are from one common
#   point stands in the table of the zoo. Far away that does not matter,
#   near by it does. For X-slits the caustic (the surface that all rays
#   touch) is the two slits, for the pushbroom the one path: its other sheet
#   is at infinity.
# - **Examples only.** The curves and fields of view are those of the
#   example parameters; the fits are of two lenses, without noise, with the
#   centre known. They show what a form can follow, not what a calibration
#   would reach.
# - **Read, not copied.** Of the 10-parameter model of Shah and Aggarwal the
#   section gives the order of its two polynomials, not the formula. The
#   zoo has a form with both: one polynomial for the radius, one for the
#   turn about the axis, five terms each.
# - **Not built.** Barreto's sphere with division, circular panoramas, and
#   networks of cameras. The {glue:text}`elsewhere` camera is in the library
#   and not in the zoo: it is the viewer of the paraboloid mirror.

# %% tags=["active-ipynb"]
# show_table("ext_zoo_few")

# %% tags=["active-ipynb"]
# show("ext_zoo_fits")

# %% tags=["active-ipynb"]
# show("ext_zoo_curves")

# %% tags=["active-ipynb"]
# show("ext_zoo_rays")

# %% tags=["active-ipynb"]
# show_table("ext_zoo")

# %% tags=["active-ipynb"]
# show_table("ext_zoo_scope")

# %% tags=["active-ipynb"]
# show_code(KannalaBrandtCamera, QuadricMirrorCamera.rays)

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
# **1.** The FOV model is $r = \arctan(2 \tan\theta \tan(\omega/2)) /
# \omega$. For which $\omega$, in degrees, is it the law of equidistance?

# %% tags=["active-ipynb"]
# check(None, **omega_task())

# %% [markdown]
# **2.** The zoo's hyperboloid has the semi-axes 30 mm (along its axis) and
# 20 mm. Which $\xi$ has the unified sphere that equals it?

# %% tags=["active-ipynb"]
# check(None, **sphere_task())

# %% [markdown]
# **3.** The zoo's division model has $f = 130$ px and $\lambda_1 = -0.25$. At
# which radius in the image, in pixels, would it reach 90°?

# %% tags=["active-ipynb"]
# check(None, **edge_task())

# %% [markdown]
# **4.** How many free numbers have two ratios of cubic polynomials of
# $(X/Z, Y/Z)$, if a common factor of numerator and denominator does not
# count?

# %% tags=["active-ipynb"]
# check(None, **cubics_task())
