# %% [markdown]
# # 6.1 What held of the thesis
#
# **Question.** The thesis sets five goals (1.1.3), lists its contributions (1.4) and
# summarises what it showed (6.1). Given are these statements, and a verdict of this
# report on every claim of the thesis. Which of the statements hold?

# %%
from chapters.ch06_conclusions.s1_what_held.exercises import open_task, product_task
from chapters.ch06_conclusions.s1_what_held.report import (
    CONTRIBUTIONS,
    bars_of,
    name_values,
    of_kind,
)
from repro.page import check, scoreboard, show_part

# The scoreboard follows from the judgements of all pages.
READS_VERDICTS = True

# %% tags=["active-ipynb", "remove-input"]
# rows, statements = scoreboard()

# %% tags=["active-ipynb", "remove-input"]
# show_part("verdicts", *bars_of(rows))

# %% tags=["active-ipynb", "remove-input"]
# name_values(rows, statements)

# %% [markdown]
# **Findings.**
#
# 1. **Claims.** Of {glue:text}`claims` claims: {glue:text}`claims.verdicts`.
# 2. **Goals and contributions.** Of the five goals: {glue:text}`goals.verdicts`. Of the
#    eight contributions: {glue:text}`contributions.verdicts`.
# 3. **Summaries.** Of the {glue:text}`summaries` statements of 6.1 and 6.3:
#    {glue:text}`summaries.verdicts`.
# 4. **Calculation, simulation, images.** {glue:text}`analytic` claims that follow from
#    calculation are reproduced, {glue:text}`synthetic` on simulated points and
#    {glue:text}`rendered` on rendered images.

# %% [markdown]
# | goal | thesis | here |
# |---|---|---|
# | chessboards, severe distortion | reached | {glue:text}`goal_chessboards` |
# | active grids suit such cameras | reached | {glue:text}`goal_active_grids` |
# | better central generic calibration | reached | {glue:text}`goal_central` |
# | method for flexible mirrors | reached | {glue:text}`goal_mirror_method` |
# | use of flexible mirrors | reached | {glue:text}`goal_mirror_use` |

# %% [markdown]
# ## Terms
#
# - *Claim*: a sentence of the thesis with a test that can fail. The
#   [scoreboard](../scoreboard.md) lists all claims with their tests.
# - *Statement*: a goal, contribution or summary of the thesis. It rests on one or more
#   claims.
# - *Verdict*: reproduced, differs, undecided, or one of the other terms of
#   [Verdicts](../conventions.md#verdicts).
# - *Firm*: the same in every interpretation of the text. A hollow badge marks a verdict
#   that is not firm.
# - *CELECT*, *active grid*, *CGSP*, *SPFC²*: the methods of the thesis for corners
#   (3.1.2), targets (3.2.2), central cameras (4.1) and flexible mirrors (5.2).

# %% [markdown]
# ## What the thesis claims
#
# - Three goals concern wide-angle and omnidirectional cameras: easier use of
#   chessboards, suitable active grids, better central generic calibration.
# - Two goals concern flexible mirror cameras: a practical method, and its use for
#   practical tasks.
# - Three major and five minor contributions correspond to the chapters.
# - Experiments confirm each contribution (6.1). Only self-calibration of a flexible
#   mirror is not practical.
# - The contributions appeared in four publications (6.2)
#   {cite}`dunne2007mva,dunne2007iccv,dunne2008omnivis,dunne2008cviu`.

# %% [markdown]
# ## Model
#
# The verdict of a statement follows from those of its claims:
#
# 1. *Differs* if one of its claims differs.
# 2. Otherwise *reproduced* if all its claims are reproduced.
# 3. Otherwise *undecided*: a claim that is undecided or not comparable leaves a part of
#    the statement open.
#
# A statement lists the claims that state a part of it. Claims about causes, settings
# and limits of validity are excluded. The lists are in `conclusions.yaml`, next to the
# claims and their tests. They were written after full builds, when the verdicts of the
# claims were known.
#
# **Claims that matter most.** Each goal has one leading claim, marked by its measured
# value below. It is the result on images that 6.1 quotes for this goal. Of several
# such results it is the one that depends on all steps before: the angles of a box, for
# instance, depend on calibration, motion and structure.

# %% [markdown]
# ## Experiment
#
# This page has no experiment of its own. It reads the scoreboard of the same build, so
# a changed result changes the verdicts, counts and sentences of this page. A quick
# build has values but no verdicts.

# %% [markdown]
# ## Goals

# %% tags=["active-ipynb", "remove-input"]
# show_part("statements", of_kind(statements, "goal"))

# %% [markdown]
# ## Contributions

# %% tags=["active-ipynb", "remove-input"]
# show_part("statements", of_kind(statements, *CONTRIBUTIONS))

# %% [markdown]
# ## Summaries

# %% tags=["active-ipynb", "remove-input"]
# show_part("statements", of_kind(statements, "summary"))

# %% [markdown]
# ## Discussion
#
# - **Strictness.** One claim that differs decides a statement, even if others are
#   reproduced. The count next to a verdict shows how many are.
# - **Evidence.** Equations can be repeated exactly. A result on images depends on
#   cameras, light and software of 2009, which rendered images and current software
#   replace.
# - **Reasons.** The pages of the claims explain their verdicts. Begin with
#   [3.3.2](../ch03_planar_grids/s3_2_grid_sets.ipynb) for CELECT,
#   [3.3.3](../ch03_planar_grids/s3_3_active_grid_robustness.ipynb) for active grids,
#   [4.1.5](../ch04_central_generic/s1_5_simulated.ipynb) for CGSP and
#   [5.3.3c](../ch05_flexible_mirror/s3_3_repeatability.ipynb) for SPFC².
# - **Limits.** The assignment of claims to statements is our reading of the thesis.
#   Some words have no claim: no test compares SPFC² with the earlier method from the
#   mirror's boundary, or measures how easy a method is to use.

# %% [markdown]
# ## Summary
#
# Of {glue:text}`claims` claims: {glue:text}`claims.verdicts`. Of the five goals of the
# thesis: {glue:text}`goals.verdicts`. A verdict states whether the published results
# appear again, not whether a method is useful.

# %% [markdown]
# ## Compared with the published numbers
#
# The two claims of chapter 6 are judged on the pages of their results:
#
# - Corner errors of CELECT are below 8 px: *{glue:text}`c6_detect_8px`*
#   ([3.3.1](../ch03_planar_grids/s3_1_robustness.ipynb)).
# - Rays are more compact with CGSP for both cameras: *{glue:text}`c6_centrality_both`*
#   ([4.3.2a](../ch04_central_generic/s3_2_results.ipynb)).

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then replace `None` by an
# answer and run that cell again.
#
# **1.** Three independent claims are each reproduced with a probability of 80 %. With
# which probability, in %, is a statement that rests on all three reproduced?

# %% tags=["active-ipynb"]
# check(None, **product_task())

# %% [markdown]
# **2.** Each of three claims is reproduced, differs or is undecided. How many of the 27
# combinations make the statement undecided?

# %% tags=["active-ipynb"]
# check(None, **open_task())
