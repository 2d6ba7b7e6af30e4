# %% [markdown]
# # 2.4 Generic calibration: the coefficients of Table 2.1
#
# **Question.** The linear stage of generic calibration uses four coefficient
# vectors that the thesis prints in Table 2.1, and one wrong cell would spoil
# every calibration. Given are the table, the collinearity equations and
# random scenes in exact arithmetic. Are all cells right?

# %%
from chapters.ch02_general_camera_model.s4_generic_calibration.exercises import (
    entries_task,
    exercise_scene,
    meeting_task,
)
from chapters.ch02_general_camera_model.s4_generic_calibration.experiment import (
    draw_scene,
    library_difference,
    meet,
    substitute,
)
from chapters.ch02_general_camera_model.s4_generic_calibration.report import summary_of
from repro.page import check, compared, open_results, show_code, show_table, value
from repro.run import Plan, experiment

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
# 1. **One row of the printed table is wrong**, in two cells (bold above). All
#    other cells are right.
# 2. **The corrected table is exact.** All four sums are exactly zero, in
#    rational arithmetic, in all {glue:text}`scenes` random scenes.
# 3. **As printed, two sums do not vanish.** They leave
#    {glue:text}`printed_w:.3f` ($W$) and {glue:text}`printed_n:.3f` ($N$) of
#    the size of their terms (medians).

# %% [markdown]
# | vector | thesis | here |
# |---|---|---|
# | $V$, $M$ | sum zero for every ray | zero, as printed |
# | $W$ | sum zero for every ray | {glue:text}`printed_w:.3f` printed, zero corrected |
# | $N$ | sum zero for every ray | {glue:text}`printed_n:.3f` printed, zero corrected |

# %% [markdown]
# ## Terms
#
# A reader needs rigid motions, determinants and minors.
#
# - *Base grid*: grid 1, whose plane $z = 0$ and frame define the world.
# - $R^n, \mathbf{t}^n$: rotation and translation that take points of grid $n$
#   into that frame.
# - $\mathbf{C}$: the camera centre. $\mathbf{Q}^n$: the point that a pixel sees
#   on grid $n$; $Q^n_j$ is its coordinate $x$, $y$ or $w = 1$ in the grid's own
#   frame.
# - $V, W, M, N$: coefficient vectors of nine entries, $V$ and $W$ for grid 2,
#   $M$ and $N$ for grid 3.
# - $j(i)$, $k(i)$: the coordinates that belong to entry $i$.
# - *Scene*: one random centre with two random grid poses.

# %% [markdown]
# ## What the thesis claims
#
# The centre and the points $\mathbf{Q}^1, \mathbf{Q}^2, \mathbf{Q}^3$ of one
# pixel are collinear {cite}`sturm2004`. As columns they form a matrix (2.13)
# of rank two, so all its $3 \times 3$ minors vanish. The minors with the first
# two columns and the last two rows give four sums (2.14), for example
#
# $$\sum_{i=1}^{9} Q^1_{j(i)}\, Q^2_{k(i)}\, V_i = 0 .$$
#
# The vectors depend on the centre and the grid poses and are the same for all
# pixels. Table 2.1 lists them, with the $j$ and $k$ of each $i$ (which the
# equations omit, E-2.06). The claim: they make the sums zero for *every* ray.

# %% [markdown]
# ## Model
#
# A pose takes points of grid $n$ to the base grid, $\mathbf{P} = R^n (x, y,
# 0)^T + \mathbf{t}^n$. The test must not depend on rounding, so the cells are
# kept as formulas and evaluated with rational numbers. A rotation from an
# integer quaternion has rational entries, and a ray through rational points
# meets a plane in a rational point. Each sum is then exactly zero or not.

# %% tags=["active-ipynb"]
# show_code(meet, substitute)

# %% [markdown]
# ## Experiment
#
# Each random scene has eight rays. The table is inserted as printed, and with
# row 3 corrected according to errata E-2.08. The library's coefficient vectors
# are compared with the formulas in the same run.

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
# ## Discussion
#
# - A sum that vanishes as a polynomial vanishes everywhere. A sum that does
#   not would vanish in random scenes only by an unlikely coincidence.
# - The printed superscripts of $t_z$ in row 3 of $W$ and $N$ are one too low.
#   $W_3$ names the base grid, whose $t_z$ is zero by definition. The stated
#   remainders are the largest of eight rays, as a median over scenes.
# - The library computes the same vectors, to {glue:text}`library:.1e` of their
#   largest entry.
# - Some entries of each vector are zero in every scene. The library solves for
#   the others only, because nine columns have no unique solution.
# - This page has no noise. Section 2.5.1 tests how noise affects the linear
#   stage.

# %% [markdown]
# ## Summary
#
# Table 2.1 is right except for two superscripts in row 3, which are misprints.
# With the correction all four sums vanish exactly, and the library uses the
# corrected vectors. A literal use of the printed table gives wrong equations
# for $W$ and $N$.

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
# **2.** In the scene below, a ray from the centre meets the base grid in
# (37, −16). Where does it meet grid 2? Give $(x, y)$ on that grid.

# %% tags=["active-ipynb"]
# scene = exercise_scene()

# %% tags=["active-ipynb"]
# {name: str(scene[name]) for name in scene if not name.endswith("_3")}

# %% tags=["active-ipynb"]
# check(None, **meeting_task(scene))
