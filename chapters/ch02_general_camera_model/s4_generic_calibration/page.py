# %% [markdown]
# # 2.4 Generic calibration: the coefficients of Table 2.1
#
# **Question.** The linear stage of generic calibration rests on four
# vectors of nine coefficients, printed as Table 2.1. Are they right? A slip
# in one cell would spoil every calibration built on it.

# %%
from chapters.ch02_general_camera_model.s4_generic_calibration.exercises import (
    entries_task,
    exercise_scene,
    meeting_task,
)
from chapters.ch02_general_camera_model.s4_generic_calibration.results import summary_of
from chapters.ch02_general_camera_model.s4_generic_calibration.trials import (
    draw_scene,
    library_difference,
    meet,
    substitute,
)
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show_code, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show_table("table_2_1")

# %% tags=["active-ipynb"]
# sums = open_results("table_2_1_sums")

# %% tags=["active-ipynb"]
# value("scenes", sums.trials_per_condition)

# %% tags=["active-ipynb"]
# value("printed_w", summary_of(sums, "W"))

# %% tags=["active-ipynb"]
# value("printed_n", summary_of(sums, "N"))

# %% tags=["active-ipynb"]
# value("library", sums.column("library_difference").max())

# %% [markdown]
# **Findings.**
#
# - One row of the printed table has a slip, in two cells; they stand here
#   in bold. All others are right.
# - With that row mended, all four sums are exactly zero in all
#   {glue:text}`scenes` random scenes, in whole fractions.
# - As printed, two of the four sums are not zero: they leave
#   {glue:text}`printed_w:.3f` and {glue:text}`printed_n:.3f` of the size of
#   their terms (medians).
# - The library computes the same vectors, to {glue:text}`library:.1e` of
#   their largest entry.

# %% [markdown]
# ## What the thesis claims
#
# Three grids are seen. One is the base grid; $R^n, \mathbf{t}^n$ take points
# of grid $n$ into its frame. The camera centre $\mathbf{C}$ and the points
# $\mathbf{Q}^1, \mathbf{Q}^2, \mathbf{Q}^3$ that one pixel sees on them lie on
# a line {cite}`sturm2004`. Put side by side as columns, they make a matrix
# (2.13) of rank two, so every determinant of three of its rows and columns
# (a *minor*) vanishes. The minors with the first two columns and the last
# two rows give four sums (2.14), linear in products of what is seen, for example
#
# $$\sum_{i=1}^{9} Q^1_{j(i)}\, Q^2_{k(i)}\, V_i = 0 .$$
#
# $Q^n_j$ is a coordinate ($x$, $y$, or $w = 1$) of the point that the pixel
# sees on grid $n$, in that grid's own frame. $V_1$ to $V_9$ are made of the
# centre and the pose of grid 2; they are the same for all pixels. $W$ is
# its twin; $M$ and $N$ are the same for grid 3.
#
# Table 2.1 lists these vectors, and which $j$ and $k$ belong to each $i$
# (the equations leave that out, E-2.06). Its claim: put in, they make the sum
# zero for *every* ray.

# %% [markdown]
# ## Model
#
# A pose takes points of grid $n$ to the base grid, $\mathbf{P} = R^n (x, y,
# 0)^T + \mathbf{t}^n$; the base grid is the plane $z = 0$. Whether a
# formula is right is not a matter of rounding. So the cells are kept as
# formulas, and evaluated with whole fractions: a rotation made from a
# quaternion of whole numbers has rational entries, and a ray through
# rational points meets a plane in a rational point. The sum is then zero or
# it is not.

# %% tags=["active-ipynb"]
# show_code(meet, substitute)

# %% [markdown]
# ## Experiment
#
# Random scenes, each a centre and two poses, with eight rays each. The
# table is put in twice: with the correction of one row that the errata list
# names (E-2.08), and as printed. The library's own coefficient vectors are
# compared with the formulas in the same run.

# %%
TRIALS = {"quick": 20, "full": 200}


def substitution_trial(condition, rng):
    """Put one random scene into all four sums, corrected and as printed."""
    names = draw_scene(rng)
    out = {"library_difference": library_difference(names)}
    for kind in ("corrected", "printed"):
        for vector, (zero, largest) in substitute(
            names, printed=kind == "printed"
        ).items():
            out[f"{kind}.{vector}.zero"] = zero
            out[f"{kind}.{vector}.relative"] = largest
    return out


@experiment("table_2_1_sums", artefact="table_2_1")
def substitution(effort):
    """Exact substitution of Table 2.1 in random scenes."""
    return Plan(substitution_trial, [{}], TRIALS[effort], {"rays": 8})


# %% [markdown]
# ## Reading and limits
#
# - A sum that vanishes as a polynomial vanishes everywhere. One that does
#   not would vanish in random scenes by an unlikely chance only.
# - As printed, $V$ and $M$ are right, and $W$ and $N$ are not. The printed
#   superscripts of $t_z$ in row 3 are one too low: $W_3$ names the base
#   grid, whose $t_z$ is zero by definition. What is left of the two sums is
#   the worst of eight rays, and its median over the scenes.
# - Some of the nine entries of each vector are zero in every scene. The
#   library solves for the others only: with all nine columns there is no
#   unique solution.
# - This page says nothing about noise. How much noise the linear stage
#   bears is the subject of section 2.5.1.

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
# **1.** The vector $V$ has nine entries. How many of them can differ from
# zero?

# %% tags=["active-ipynb"]
# check(None, **entries_task())

# %% [markdown]
# **2.** In the scene below, a ray leaves the centre and meets the base grid
# in (37, −16). Where does it meet grid 2? Give $(x, y)$ on that grid.

# %% tags=["active-ipynb"]
# scene = exercise_scene()

# %% tags=["active-ipynb"]
# {name: str(scene[name]) for name in scene if not name.endswith("_3")}

# %% tags=["active-ipynb"]
# check(None, **meeting_task(scene))
