# %% [markdown]
# # 3.3.3 How many cells, how many steps?
#
# **Question.** The thesis codes its monitor with 8 × 8 cells and four phase
# steps, and says that other grids "may merit further investigation". Here
# they are compared: 4 to 32 cells and 3 to 8 steps. Which is best depends on
# blur, noise and the monitor's response. On what else, and how much is
# there to gain?

# %%
from chapters.ch03_planar_grids.ext_cells_and_phases.exercises import (
    best_task,
    pictures_task,
    swing_task,
)
from chapters.ch03_planar_grids.ext_cells_and_phases.results import (
    bias_px,
    name_values,
    sigma_px,
)
from chapters.ch03_planar_grids.ext_cells_and_phases.trials import (
    BLURS_PX,
    BUDGETS,
    CELLS,
    CORRECTED_GAMMAS,
    CORRECTED_STEPS,
    CORRECTED_TRIALS,
    CORRECTED_WIDTH_PX,
    GAMMAS,
    LIGHTS,
    LINEAR,
    NOISES,
    ORDINARY,
    OTHER_TRIALS,
    OUR_BLUR_PX,
    OUR_CELLS,
    OUR_STEPS,
    SETTINGS,
    SHARED_BLURS_PX,
    STEPS,
    TRIALS,
    condition_of,
    corrected_trial,
    drawn_view,
    light_of,
    name_of,
    photographs,
    pictures_in_light,
    plan_for,
    scores,
    through_lens,
)
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("ext_cells")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - Finer cells are better until blur takes their contrast: the best cell is
#   $2\pi$ blur SDs wide in the picture, whatever the noise, and a curve with
#   nothing fitted predicts the error to {glue:text}`theory:.1f` % (median).
# - The decoder's 7 × 7 smoothing needs cells of at least
#   {glue:text}`narrowest:.1f` px; the narrowest that it takes are best with
#   little blur, with {glue:text}`sharp:g` px of it {glue:text}`gain:.1f`
#   times better than eight cells here, for {glue:text}`more` pictures more.
# - Four steps leave the third order of the response: up to
#   {glue:text}`bias.4:.2f` px with a gamma of {glue:text}`gamma.least:.1f`
#   to {glue:text}`gamma.most:.1f` and eight cells. Three steps are off by
#   up to {glue:text}`bias.3:.1f` px, six by {glue:text}`bias.6:.2f` px,
#   which is the rounding of grey values.
# - What four steps are off by can be told from the pictures and undone: with
#   a gamma of {glue:text}`strong:.1f` the smoothed error falls from
#   {glue:text}`seen.off.4:.3f` to {glue:text}`corrected.off.4:.3f` px, and
#   {glue:text}`corrected.within.4:.0f` instead of
#   {glue:text}`seen.within.4:.0f` % of the errors are within one stated SD.
# - Against noise alone, only the light counts: with the same number of
#   pictures, or the same exposure in all, three to eight steps differ by
#   {glue:text}`sines.spread:.1f` % and {glue:text}`light.spread:.1f` %.
# - With the same number of pictures, finer cells beat more steps, as long as
#   their contrast lasts and the smoothing takes them.

# %% [markdown]
# ## What the thesis claims
#
# Nothing, for this is what it leaves open. Section 3.2.2 chooses 8 × 8
# cells: 12 pictures of Gray code, 6 for each axis, tell them apart. Then 8
# pictures of sines, 4 for each axis, give the place inside a cell. At the
# end of 3.3.3 it says that other sizes of the grid were not examined.

# %% [markdown]
# ## Model
#
# A cell is $P$ px wide in the picture, and holds one period of the sine. $N$
# steps of it, each with noise of SD $\sigma_I$ grey levels, give the place
# in the cell with an SD of
#
# $$\sigma = \frac{P}{2\pi B}\,\sigma_I\sqrt{\frac{2}{N}}, \qquad
# B = B_0 \exp\left(-\frac{2\pi^2 s^2}{P^2}\right).$$
#
# $B$ is the swing of the sine, in grey levels to either side. Without blur
# it is $B_0$, half of what lies between black and white. A Gaussian blur of
# SD $s$ px takes the share of it that the exponential says.
#
# So a finer period is better in proportion, until the swing falls faster:
# $P\exp(2\pi^2 s^2/P^2)$ is least at
#
# $$P = 2\pi s.$$
#
# The noise is not in it. It only decides where a grid cannot be read any
# more, for a swing below a few $\sigma_I$ is taken for dark.
#
# **Smoothing.** The decoder takes each pixel's phase $\varphi$ as a unit
# vector $(\sin\varphi, \cos\varphi)$, and averages these over 7 × 7 px.
# With $c_k$ the mean of $\cos k(\varphi - \varphi_0)$ over the window,
# $\varphi_0$ the phase in its middle, that divides $\sigma$ by
#
# $$7\,c_1 \Big/ \sqrt{\tfrac12 (1 + c_2)},$$
#
# little less than 7. Where the mean vector is shorter than 0.7 the decoder
# does not average, for such a window may hold the edge of an object: that
# is so for periods below {glue:text}`narrowest:.1f` px.

# %% tags=["active-ipynb"]
# show_code(sigma_px)

# %% [markdown]
# **The response.** A monitor's light is not linear in its value. The sine
# becomes a sum of harmonics, and $N$ steps take those of order $mN \pm 1$
# for the first ($m$ a whole number): with 3 steps the second, with 4 the
# third, with 6 the fifth. [Appendix
# A](../appendix_a/phase_and_harmonics.ipynb) derives it. The shift of the
# phase does not depend on the cells, so the error in px goes with $P$; and
# blur takes high orders first.

# %% tags=["active-ipynb"]
# show_code(bias_px)

# %% [markdown]
# ## Experiment
#
# Rendered pictures of the thesis's monitor, decoded as `raxel decode
# --linear` does, which smooths and corrects no response, and by pixel:
# without smoothing. In each trial the monitor stands a little differently;
# it fills the picture. The errors are those of single coordinates. What was
# chosen, before the first run:
#
# | | | reason |
# |---|---|---|
# | cells | 4 to 32 | the question; 12 and 24 between powers of two |
# | steps | 3, 4, 5, 6, 8 | three are the fewest that give a phase |
# | monitor | 301.5 mm, tilted by 0 to 12° | size from the thesis |
# | picture | {glue:text}`width` × {glue:text}`height` px | small, for speed |
# | blur | SD 0.5 to 4 px | a sharp lens, to out of focus |
# | noise | SD 1, 3, 8 grey levels, added as in 3.3.3 | the decoder's tests have these |
# | black, white | 20, 220 grey levels | nothing clips |
# | gamma | 1 to 2.6 | linear, to beyond any monitor |
# | views | {glue:text}`trials`, {glue:text}`fewer` | of the cells, of the rest |


# %%
def grid_trial(condition, rng):
    """One view of one grid, under every response, blur and noise."""
    view = drawn_view(condition["width_px"], rng)
    plan = plan_for(condition["cells"], condition["steps"])
    sent = view.values(plan)
    found = {}
    for gamma in condition["gammas"]:
        light = light_of(sent, plan, gamma)
        for blur in condition["blurs_px"]:
            seen = through_lens(light, blur)
            for noise in condition["noises"]:
                pictures = photographs(seen, noise, rng)
                name = name_of(gamma, blur, noise)
                found[name] = scores(view, plan, pictures, linear=True)
    return found


@experiment("ext_cells_runs", artefact="ext_cells", shards={"full": 2})
def cells_runs(effort):
    """Numbers of cells against blur and noise, with four steps."""
    changed = {"blurs_px": BLURS_PX[effort], "noises": NOISES[effort]}
    conditions = [
        condition_of(effort, cells, OUR_STEPS, **changed) for cells in CELLS[effort]
    ]
    return Plan(grid_trial, conditions, TRIALS[effort], SETTINGS)


@experiment("ext_steps_runs", artefact="ext_steps")
def steps_runs(effort):
    """Numbers of steps against the monitor's response, without noise."""
    changed = {"gammas": GAMMAS[effort], "noises": (0.0,)}
    conditions = [
        condition_of(effort, OUR_CELLS, steps, **changed) for steps in STEPS[effort]
    ]
    return Plan(grid_trial, conditions, OTHER_TRIALS[effort], SETTINGS)


# %% [markdown]
# The same number of pictures can go into cells or into steps: twice the
# cells cost 4 pictures more, two more steps as many. 20 are those of the
# thesis, 28 are the least for 32 cells with 4 steps.


# %%
@experiment("ext_pictures_runs", artefact="ext_equal_pictures")
def pictures_runs(effort):
    """Grids of equally many pictures, on an ordinary monitor."""
    changed = {"gammas": [ORDINARY], "blurs_px": SHARED_BLURS_PX[effort]}
    conditions = [
        condition_of(effort, *grid, **changed)
        for total in BUDGETS
        for grid in BUDGETS[total]
    ]
    return Plan(grid_trial, conditions, OTHER_TRIALS[effort], SETTINGS)


# %%
def light_trial(condition, rng):
    """One view with a sensor's own noise, its light shared out in three ways."""
    view = drawn_view(condition["width_px"], rng)
    plan = plan_for(condition["cells"], condition["steps"])
    light = light_of(view.values(plan), plan, LINEAR)
    seen = through_lens(light, OUR_BLUR_PX)
    return {
        which: scores(
            view, plan, pictures_in_light(seen, plan, which, rng), linear=True
        )
        for which in LIGHTS
    }


@experiment("ext_light_runs", artefact="ext_steps_light")
def light_runs(effort):
    """Numbers of steps with the same pictures, and with the same light."""
    conditions = [condition_of(effort, OUR_CELLS, steps) for steps in STEPS[effort]]
    return Plan(light_trial, conditions, OTHER_TRIALS[effort], SETTINGS)


# %% [markdown]
# So far the response is left as it is, as in the thesis. Without `--linear`
# the decoder measures it on the same pictures: along a line of a smooth
# surface the phase is smooth, and the ripple, which comes again $N$ times a
# period, is not. Then it turns every pixel's phase back, before windows are
# averaged. Pictures of each view are decoded both ways, four steps and six.


# %%
@experiment("ext_corrected_runs", artefact="ext_steps_corrected")
def corrected_runs(effort):
    """The response left as it is and undone, on pictures of the same views."""
    condition = {
        "cells": OUR_CELLS,
        "steps": list(CORRECTED_STEPS),
        "gammas": list(CORRECTED_GAMMAS[effort]),
        "width_px": CORRECTED_WIDTH_PX[effort],
    }
    return Plan(corrected_trial, [condition], CORRECTED_TRIALS[effort], SETTINGS)


# %% [markdown]
# ## Which to take
#
# Find your blur and noise; what carries over to your camera is the width of
# a cell in its picture. The blur is that of the monitor's picture, which may
# be out of focus. Each time the error of the best grid stands beside that
# of the thesis's eight cells.

# %% tags=["active-ipynb"]
# show_table("ext_cells_advice", digits=3)

# %% [markdown]
# The steps follow from the monitor and the camera together. A camera that
# saves JPEG undoes most of a monitor's gamma; raw pictures do not.

# %% tags=["active-ipynb"]
# show_table("ext_steps_advice", digits=2)

# %% [markdown]
# ## Reading and limits
#
# **Cells.** With sharp pictures and by pixel, the error falls with the cell
# down to the finest grid tested. With a blur of {glue:text}`soft:g` px it is
# least at {glue:text}`soft.pixel.cells` cells of
# {glue:text}`soft.pixel.period:.0f` px; the theory says
# {glue:text}`soft.period:.0f` px. Finer ones lose their swing, then their
# pixels: the decoder masks what it cannot read. Cells that are very wide
# lose a few pixels, too: at their edges, where noise could turn the phase
# around, and a sharp edge says nothing to its neighbours. Pixels in a wrong
# cell, in all grids with four steps, blurs and noises together:
# {glue:text}`gross`.

# %% tags=["active-ipynb"]
# show_table("ext_cells_scores", digits=3)

# %% [markdown]
# **The stated standard deviation** follows the error: in all grids that can
# be read, {glue:text}`within.least:.0f` to {glue:text}`within.most:.0f` % of
# the errors are within one of it (medians over the views; a normal error is
# in 68 %). It knows noise. With `--linear` it does not know the response: what
# the next figure shows is not in it.

# %% tags=["active-ipynb"]
# show("ext_steps")

# %% [markdown]
# **Steps.** Three steps have the second order against them, which is large
# with any monitor. Four have the third, which is gone at a gamma of 1 and
# again at 2, where $(\tfrac12 + \tfrac12\sin\varphi)^2$ has no third
# harmonic; so the thesis's choice is a lucky one where the gamma is near 2.
# From five steps on, rounding to grey levels is all that is left here. Steps
# that divide evenly see the same grey levels again at some phases, and their
# rounding errors do not average out; that is why the markers at a gamma of
# 1 do not fall with $N$.

# %% tags=["active-ipynb"]
# show("ext_steps_corrected")

# %% [markdown]
# **Correction.** Can four steps be mended, with no further picture? The same
# pictures, read twice, say so. As the thesis reads them, one stated SD covers
# {glue:text}`seen.least.4:.0f` to {glue:text}`seen.most.4:.0f` % of the
# errors, by gamma: it is right where there is no third order, at 1 and at 2,
# and far too small elsewhere. Corrected it covers
# {glue:text}`corrected.least.4:.0f` to {glue:text}`corrected.most.4:.0f` %,
# and the error is that of noise alone. With a gamma of
# {glue:text}`strong:.1f` the decoder says that places were off by
# {glue:text}`corrected.told.4:.3f` px; the theory says
# {glue:text}`strong.shift:.3f` px.
#
# Six steps have next to nothing to correct: {glue:text}`seen.off.6:.4f` px as
# seen and {glue:text}`corrected.off.6:.4f` px corrected at that gamma. That is
# less than noise alone makes with four. So six are the default of `raxel
# patterns`. By pixel, noise hides much of the shift: with four steps as seen,
# {glue:text}`seen.pixels.4:.0f` % are within one SD even then.

# %% tags=["active-ipynb"]
# show_table("ext_steps_coverage", digits=3)

# %% tags=["active-ipynb"]
# show_table("ext_equal_pictures", digits=2)

# %% [markdown]
# **Equal pictures.** Twice the cells halve the error, and cost four
# pictures. Twice the steps take it down by $\sqrt2$, and cost more. So cells
# come first: of 28 pictures with a sharp lens the best grid has
# {glue:text}`of28.cells` cells and {glue:text}`of28.steps` steps, smoothed,
# and errs by {glue:text}`of28.rms:.3f` px, the worst by
# {glue:text}`of28.worst:.3f` px. Of 20 it has {glue:text}`of20.cells` cells
# and {glue:text}`of20.steps` steps.
#
# **Equal light.** Only the sum of the exposures counts against noise, unless
# they are so short that reading out adds more than the light does.

# %% tags=["active-ipynb"]
# show_table("ext_steps_light", digits=3)

# %% [markdown]
# **Limits.** One thing was changed after a first run: the outermost 4 px of
# the picture are not scored. No window of the smoothing fits there, and in
# so small a picture these pixels decided the RMS error of all. Cells just
# below {glue:text}`narrowest:.1f` px lose the smoothing, and with it all
# that it gains; a rule that knows an edge from a fine grid would do better.
#
# The blur is the same everywhere, the monitor has no raster, and
# its pixels are much finer than the camera's. The scene is smooth: on an
# object with edges, 7 × 7 smoothing loses the pixels near these, and finer
# cells are the better way. A fine grid also takes longer to show, and
# something may move. Cameras that squeeze the monitor into one corner of the
# picture have periods of all widths at once: there the finest place decides.
#
# The correction was shown an easy case: a plane, a power law, one gamma for
# all of the picture, nothing clipped. It needs surfaces that are smooth over
# some ripples, and ripples of 5 px or more; where it cannot tell, places stay
# as they are and their SDs grow, but for three steps, where it warns. Its
# pictures are {glue:text}`strong.width` px wide: in those of
# {glue:text}`width` px eight cells are narrow, and noise hides more of the
# shift. This was seen on other views, before its {glue:text}`strong.views`
# were drawn.

# %% [markdown]
# ## Compared with the published numbers
#
# The thesis has none on this.

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** A monitor is 800 px wide in the picture, and the lens blurs by 3 px.
# How many cells across it are best, by pixel?

# %% tags=["active-ipynb"]
# check(None, **best_task())

# %% [markdown]
# **2.** Which share of its swing does the best sine keep behind the blur?

# %% tags=["active-ipynb"]
# check(None, **swing_task())

# %% [markdown]
# **3.** Sharp pictures, by pixel. One grid has twice the cells of the
# thesis's, another one twice its steps. What is the error of the second,
# divided by that of the first?

# %% tags=["active-ipynb"]
# check(None, **pictures_task())
