# %% [markdown]
# # A lens formula where one fits, without a guess
#
# **Question.** A table of rays fits any camera, but has no ray where no board
# was. A formula with a dozen numbers has one everywhere, if the lens obeys
# it. How good are formulas of fisheyes and mirrors when nobody tells them
# where to start, and what is missing where they fail?

# %%
from chapters.ch04_central_generic.ext_lens_formula.exercises import pupil_task
from chapters.ch04_central_generic.ext_lens_formula.results import name_values
from chapters.ch04_central_generic.ext_lens_formula.trials import (
    LENSES,
    SETTINGS,
    TRIALS,
    fitted,
    kept_out,
    lens_trial,
)
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("ext_lens_formula_figure")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - With the right formula, boards kept out are predicted to
#   {glue:text}`fisheye.kannala-brandt:.3f` px (fisheye) and
#   {glue:text}`mirror.unified:.3f` px (mirror) from corners with 0.1 px of
#   noise; no start was given. These are medians of
#   {glue:text}`trials` trials a lens.
# - Which formula it is matters for the mirror: Kannala-Brandt leaves
#   {glue:text}`mirror.kannala-brandt:.3f` px there.
# - Where the entrance pupil moves, central formulas leave
#   {glue:text}`pupil.kannala-brandt:.2f` px; with a pupil that may move
#   {glue:text}`pupil.pupil:.3f` px.
# - The test finds the pupil that moves in {glue:text}`moved.pupil` of
#   {glue:text}`trials` trials. On the fisheye whose pupil rests it finds one
#   in {glue:text}`moved.fisheye`, on the mirror, whose law the formula does
#   not have, in {glue:text}`moved.mirror`.

# %% [markdown]
# ## What the thesis claims
#
# Section 2.2 lists parametric models, and chapters 2 and 4 compare general
# cameras with one of them, a pinhole with two radial terms. A wide lens is
# unfair to that formula. Fisheye and mirror formulas are fairer rivals, and
# the thesis leaves them aside because they need a start, or a lens of the
# right kind.

# %% [markdown]
# ## Model
#
# A point at the distance $\rho$ from the axis and the height $z$ on it is
# seen at the angle $\theta$ from the entrance pupil at the height
# $z_0(\theta)$:
#
# $$(z - z_0(\theta)) \sin\theta = \rho \cos\theta, \qquad
#   z_0 = a_1 \theta^2 + a_2 \theta^4 + \dots$$
#
# For a central lens all $a$ are 0. In the image it lies at
# $\mathbf{p} = s(\theta)\,\mathbf{e}$, with $\mathbf{e}$ the direction of its
# azimuth, and then
#
# $$\mathbf{q} = \mathbf{p}\,(1 + k_1 s^2 + k_2 s^4 + \dots)
#   + \mathbf{d}(\mathbf{p}), \qquad
#   u = f_x q_x + c_x, \quad v = f_y q_y + c_y.$$
#
# - Kannala and Brandt {cite}`kannala2006`: $s = \theta$.
# - Unified sphere, of Geyer and Daniilidis
#   ([2000](https://doi.org/10.1007/3-540-45053-X_29)):
#   $s = (1 + \xi) \sin\theta / (\cos\theta + \xi)$.
# - Decentring $\mathbf{d}$: Brown's two terms and two of a thin prism, all
#   that grows with $s^2$ and goes round once with the azimuth. A mirror that
#   stands beside the axis of its lens needs all four.
#
# **The start.** Whatever the lens does along the radius, it leaves the
# azimuth alone. So the direction from the image's centre to a corner is that
# from the axis to the corner, which is linear in the board's pose but for its
# depth. That holds for any $s$, beyond 90 degrees, and for a pupil that
# moves. The centre is searched for as the point where the directions of all
# boards agree best; depths and the focal length follow from
# $r = F \theta$ and a search over $F$.
#
# **The fit.** Formula and poses are adjusted together to the corners, with a
# loss that lets wrong corners pull at nothing and names them. First all
# terms are free; those that do not pay for themselves by Schwarz's criterion
# go again.
#
# **Does the pupil move?** A likelihood-ratio test has to say so, beside a
# law with as many radial terms more; the error on boards that were kept out
# of the fit, by more than it scatters from board to board; and that formula
# which predicts these best. Where they do not agree it is undecided, and the
# pupil is taken to stand still.

# %% tags=["active-ipynb"]
# show_code(fitted, kept_out)

# %% [markdown]
# ## Experiment
#
# Three lenses whose truth is known. Each trial holds 12 boards of 54 corners
# at random before the lens, over all of its field of view, adds noise, and
# gives all models the same corners. Eight more boards, exact, are kept out.


# %%
@experiment("ext_lens_known", artefact="ext_lens_formula_figure", shards={"full": 2})
def known_lenses(effort):
    """Three known lenses, every model."""
    return Plan(lens_trial, crossed(lens=LENSES), TRIALS[effort], SETTINGS)


# %% [markdown]
# ## In numbers

# %% tags=["active-ipynb"]
# show_table("ext_lens_formula_table")

# %% [markdown]
# ## Reading and limits
#
# **What the pupil does.** In most lenses the point through which a ray seems
# to enter moves towards the scene as the angle grows. For things far away
# that does not show. A board at 30 cm sees a shift of
# {glue:text}`shift:.0f` mm as an angle, and at another distance as another
# angle: no central camera can be right for both. The shift has to be found
# from near boards, and it matters for near things.
#
# **What the test cannot say.** It takes the errors of corners for
# independent. A misfit of another sort, such as a board that is not flat,
# makes neighbours err alike, and then p is too small. That is why boards
# kept out have to agree.
#
# **Where formulas end.** They know lenses with an axis. A mirror whose rays
# cross nowhere near it, a window in front of the lens or a bent sheet of
# mirror needs rays of its own for each part of the image.
#
# **No start at all** is found where boards do not tell a lens from another:
# one board, or parallel ones before a narrow lens. The fit then says that
# the focal length is not determined.

# %% [markdown]
# ## Compared with the published numbers
#
# The thesis prints no numbers for these formulas.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** The third lens has $a_1 = 4$ mm and $a_2 = 1$ mm. By how many mm has
# its pupil moved at 80 degrees?

# %% tags=["active-ipynb"]
# check(None, **pupil_task())
