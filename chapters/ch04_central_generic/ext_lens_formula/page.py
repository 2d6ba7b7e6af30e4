# %% [markdown]
# # Parametric lens models without initial values
#
# **Question.** A parametric lens model has a ray for every pixel, whereas a ray table
# has none where no board was. It needs the right formula and, in many implementations,
# initial values. How accurate are models of fisheyes and mirrors without initial
# values, and when do they fail?

# %%
from chapters.ch04_central_generic.ext_lens_formula.exercises import pupil_task
from chapters.ch04_central_generic.ext_lens_formula.experiment import (
    LENSES,
    SETTINGS,
    TRIALS,
    fitted,
    held_out_errors,
    lens_trial,
)
from chapters.ch04_central_generic.ext_lens_formula.report import name_values
from repro.page import check, open_results, show, show_code, show_table
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show("ext_lens_formula_figure")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **The right model predicts held-out boards.** In {glue:text}`trials` trials per
#    lens with 0.1 px noise, the median error is {glue:text}`fisheye.kannala-brandt:.3f`
#    px (fisheye) and {glue:text}`mirror.unified:.3f` px (mirror).
# 2. **The choice matters for the mirror.** The Kannala-Brandt model has an error of
#    {glue:text}`mirror.kannala-brandt:.3f` px there.
# 3. **A shifted entrance pupil needs a model of its own.** Central models leave
#    {glue:text}`pupil.kannala-brandt:.2f` px. With an adjustable pupil the error is
#    {glue:text}`pupil.pupil:.3f` px.
# 4. **The pupil test makes no errors here.** It finds the shift in every trial with
#    one, and in no trial without one.

# %% [markdown]
# | question or quantity | thesis | here |
# |---|---|---|
# | parametric model compared | Zhang's pinhole model | fisheye and sphere models |
# | initial values | not discussed | none needed |
# | right model, fisheye (px) | – | {glue:text}`fisheye.kannala-brandt:.3f` |
# | right model, mirror (px) | – | {glue:text}`mirror.unified:.3f` |
# | entrance-pupil shift | not discussed | estimated and tested |

# %% [markdown]
# ## Terms
#
# - *Kannala-Brandt*: fisheye model, polynomial in the angle $\theta$. *Unified sphere*:
#   central mirror model with parameter $\xi$.
# - *Entrance-pupil shift*: the point where a ray crosses the axis moves with $\theta$
#   (axial, non-central model).
# - $\rho$, $z$: distance of a point from the axis, height along it. $z_0(\theta)$:
#   position of the pupil. $a_i$: its coefficients.
# - $s(\theta)$: radial function. $k_i$: radial terms. $\mathbf{d}$: decentring.
#   $f_x, f_y, c_x, c_y$: camera matrix. $\mathbf{e}$: direction of the azimuth.
# - *Held-out boards*: boards that are not used for the fit.

# %% [markdown]
# ## What the thesis claims
#
# Section 2.2 reviews parametric models, with up to 23 parameters for Kannala-Brandt. It
# finds them more complex and more specific as the distortion increases. The comparison
# of section 2.5 uses one of them, Zhang's pinhole model with radial distortion, which
# does not suit a wide lens.

# %% [markdown]
# ## Model
#
# A point is viewed at the angle $\theta$ from the entrance pupil:
#
# $$(z - z_0(\theta)) \sin\theta = \rho \cos\theta, \qquad
#   z_0 = a_1 \theta^2 + a_2 \theta^4 + \dots$$
#
# For a central lens all $a_i$ are 0. The image point follows from
# $\mathbf{p} = s(\theta)\,\mathbf{e}$:
#
# $$\mathbf{q} = \mathbf{p}\,(1 + k_1 s^2 + k_2 s^4 + \dots)
#   + \mathbf{d}(\mathbf{p}), \qquad
#   u = f_x q_x + c_x, \quad v = f_y q_y + c_y.$$
#
# - Kannala and Brandt {cite}`kannala2006`: $s = \theta$.
# - Unified sphere of Geyer and Daniilidis
#   ([2000](https://doi.org/10.1007/3-540-45053-X_29)):
#   $s = (1 + \xi) \sin\theta / (\cos\theta + \xi)$.
# - Decentring $\mathbf{d}$: Brown's two terms and two of a thin prism, that is, all
#   terms that grow with $s^2$ and have one period of the azimuth. A mirror off the axis
#   of its lens needs all four.
#
# **Initial values.** A radial lens does not change the azimuth. The direction from the
# image centre to a corner is therefore that from the axis to the corner. It is linear
# in the board's pose except for the depth, for any $s$, beyond 90° and with a pupil
# shift. The image centre is the point where the directions of all boards agree best.
# Depths and focal length follow from $r = F \theta$ and a search over $F$.
#
# **Fit.** Model and poses are adjusted together with a robust loss that also reports
# wrong corners. All terms start free, and Schwarz's criterion (BIC) removes unnecessary
# ones.
#
# **Test of the pupil shift.** Three criteria have to agree. A likelihood-ratio test
# prefers the shift to as many additional radial terms. The error on held-out boards
# falls by 5 % or more, and by more than its scatter between boards. No other law that
# predicts these boards better contradicts the shift. If the criteria disagree, the
# result is undecided, and the pupil stays fixed.

# %% tags=["active-ipynb"]
# show_code(fitted, held_out_errors)

# %% [markdown]
# ## Experiment
#
# There are three lenses with known parameters. Each trial has 12 boards of 54 corners,
# at random over the whole field of view, with noise. All models use the same corners.
# Eight more boards without noise are held out.


# %%
@experiment("ext_lens_known", artefact="ext_lens_formula_figure")
def known_lenses(effort):
    """Three known lenses, every model."""
    return Plan(lens_trial, crossed(lens=LENSES), TRIALS[effort], SETTINGS)


# %% [markdown]
# ## In numbers

# %% tags=["active-ipynb"]
# show_table("ext_lens_formula_table")

# %% [markdown]
# ## Discussion
#
# - **Pupil shift.** In most lenses the pupil moves towards the scene as the angle
#   grows. Distant points do not show it. A board at 30 cm views the shift as an angle
#   that depends on its distance, so no central model fits. Near boards are needed to
#   estimate it, and it matters for near objects.
# - **Limits of the test.** It assumes independent corner errors. Another misfit, such
#   as a bent board, correlates the errors of neighbours and makes p too small. Held-out
#   boards are therefore a second criterion.
# - **Where the models end.** They require an axis. A mirror far from the axis, a window
#   in front of the lens and a bent mirror sheet need individual rays.
# - **Undetermined cases.** One board, or parallel boards in front of a narrow lens, do
#   not determine the focal length. `raxel calibrate` rejects them.
#
# ## Summary
#
# Fisheye and mirror models, fitted without initial values, predict held-out boards to a
# small fraction of the corner noise if the model is right. A wrong model or a neglected
# pupil shift increases the error by several times. The pupil shift is found from near
# boards, and held-out boards guard its test against other misfits.
#
# ## Compared with the published numbers
#
# The thesis prints no numbers for these models.
#
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an answer in
# place of `None`, and run that cell again.
#
# **1.** The third lens has $a_1 = 4$ mm and $a_2 = 1$ mm. By how many mm has its pupil
# moved at 80°?

# %% tags=["active-ipynb"]
# check(None, **pupil_task())
