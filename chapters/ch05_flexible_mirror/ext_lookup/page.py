# %% [markdown]
# # The other method: shapes looked up by the mirror's boundary
#
# **Question.** There was one method for bending mirrors before the thesis's
# (1.2.3): bend the mirror beforehand, measure each shape, and later know the
# shape again by the mirror's outline in the picture. The thesis could not
# compare the two. In the rig it can be done. Which is better, and where does
# each of them fail?

# %%
from chapters.ch05_flexible_mirror.ext_lookup.exercises import noise_task, spacing_task
from chapters.ch05_flexible_mirror.ext_lookup.results import name_values
from chapters.ch05_flexible_mirror.ext_lookup.trials.compared import compared_trial
from chapters.ch05_flexible_mirror.ext_lookup.trials.table import SETTINGS
from raxel.calibration.mirror.lookup import BoundaryTable
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

RIGS = (
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
)
SEEDS = {"quick": 1, "full": 12}

# %% tags=["active-ipynb"]
# show("ext_mirror_lookup_figure")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.** Mean ray angles, degrees; the boundary traced with
# {glue:text}`traced_px` px of noise.
#
# - **Between its entries the table is a match for the update.** At 7.5 mm it
#   is {glue:text}`A.traced.between2.angle_deg` off on geometry A and
#   {glue:text}`B.traced.between2.angle_deg` on B, the update
#   {glue:text}`A.update.between2.angle_deg` and
#   {glue:text}`B.update.between2.angle_deg`. At 12.5 mm it is
#   {glue:text}`A.traced.between3.angle_deg` and
#   {glue:text}`B.traced.between3.angle_deg`, and the update, which by then has
#   handed on the errors of two others,
#   {glue:text}`A.update.between3.angle_deg` and
#   {glue:text}`B.update.between3.angle_deg`. And the table needs no board.
# - **Deflections** are the update's strength: at 7.5 mm the table is
#   {glue:text}`A.traced.between2.deflection_um` µm off on A, the update
#   {glue:text}`A.update.between2.deflection_um`. Most of the table's error is
#   there without any noise ({glue:text}`A.exact.between2.deflection_um`):
#   shapes do not lie on the straight way between two entries.
# - **A twist that the table lacks** is looked up all the same. With rulings
#   8° oblique it is {glue:text}`A.traced.twisted_more.angle_deg` (A) and
#   {glue:text}`B.traced.twisted_more.angle_deg` (B), the update
#   {glue:text}`A.update.twisted_more.angle_deg` and
#   {glue:text}`B.update.twisted_more.angle_deg`. The boundary tells of it in
#   {glue:text}`A.traced.twisted_more.flagged` (A) and
#   {glue:text}`B.traced.twisted_more.flagged` (B) of {glue:text}`seeds`
#   seeds.
# - **Beyond its last entry** it has nothing: at 18 mm
#   {glue:text}`A.traced.beyond.angle_deg` degrees, and it says so in
#   {glue:text}`A.traced.beyond.flagged` of {glue:text}`seeds` seeds. The update
#   goes on, {glue:text}`A.update.beyond.angle_deg`.
# - **It is as good as its entries are near.** With the two outer ones alone it
#   is {glue:text}`A.few.between2.angle_deg` off at 7.5 mm.

# %% [markdown]
# ## What the thesis claims
#
# That the other method *has demonstrated good accuracy* and is applicable to
# video, with more than 30 000 pairs of boundary and shape, and that it needs
# *a significant offline calibration stage* with equipment that measures
# surfaces (1.2.3). That benchmarking against it is not possible for want of
# data (5.5).

# %% [markdown]
# ## Model
#
# **An entry** is a shape $k$ of the mirror: its calibrated spline, and a
# descriptor $b_k$ of its boundary. This is the list of the pixels that divide
# each of the four edges evenly, from corner to corner.
#
# **Looking up.** A boundary $b$ is compared with the straight ways from each
# entry to the next. On the nearest one, at the share
#
# $$t = \frac{(b - b_k) \cdot (b_{k+1} - b_k)}{|b_{k+1} - b_k|^2},$$
#
# kept between 0 and 1, the spline's coefficients are
# $(1 - t)\,c_k + t\,c_{k+1}$. All entries have the same knots, laid over all
# that the mirror ever covers of the picture, so that coefficients of two
# entries can be mixed. What remains of the distance, more than three standard
# deviations of a traced point, says that the table lacks this shape.
#
# This is our own plain version: what descriptor the original has, and how it
# goes between entries, the thesis does not say.

# %% tags=["active-ipynb"]
# show_code(BoundaryTable.look_up)

# %% [markdown]
# ## Experiment
#
# Both rigs. The table has {glue:text}`entries` entries up to
# {glue:text}`last_mm` mm. Each is calibrated from two places of a monitor, as
# the first shape is in 5.3.3: the best that this laboratory has. Corners have
# 0.2 px and decoded points 0.01 mm of Gaussian noise; a boundary is traced at
# 33 points along each edge.
#
# The update starts from the table's first entry and goes on in steps of 2.5 to
# 5.5 mm, from a board 260 mm from the mirror, placed anew each time: inverse
# depth, the clamp's position and slope, and the prior of [How far can an
# updated calibration be trusted?](ext_trust.ipynb). A twisted sheet
# has rulings that run obliquely by 3 or 8 degrees, where the rig's have 1.


# %%
@experiment("ext_mirror_lookup_runs", artefact="ext_mirror_lookup_figure", inputs=RIGS)
def lookup_runs(effort):
    """Shapes between, on and beyond the entries, and twisted ones, by both methods."""
    return Plan(compared_trial, crossed(geometry=("A", "B")), SEEDS[effort], SETTINGS)


# %% [markdown]
# ## Case by case

# %% tags=["active-ipynb"]
# show_table("ext_mirror_lookup_table")

# %% [markdown]
# *Flagged* is to be read differently for the two. The table flags a boundary
# that none of its shapes has. The update flags outer knot intervals into which
# few corners reach, and that is so nearly always, whether harm comes of it or
# not: such a flag says where to look, and no more.

# %% [markdown]
# ## Reading and limits
#
# **Why the boundary tells so much.** A clamped sheet that one load bends has
# one degree of freedom. Its free edge moves over the picture by more than ten
# pixels for each mm, and many traced points agree on where it is. Where nature
# leaves one number open, a boundary that shows it is enough.
#
# **Why it tells so little.** A twist moves the boundary of A at 7.5 mm by
# {glue:text}`A.twisted.off_px` px with rulings at 3°, noise included; without
# twist it is {glue:text}`A.between2.off_px` px. Rays turn by twice the slope
# of the sheet, and the boundary shows heights. A table with twists in it needs
# an entry for each pair of deflection and twist: this is where 30 000 pairs
# come from.
#
# **What each asks for.** The table: a monitor in two places, and forty
# pictures, for every entry, beforehand; then a picture in which the whole
# boundary is seen, and no target. The update: one such calibration, then a
# board and two pictures for every deflection. A camera that must see while the
# mirror moves, and that cannot hold a board, is the table's case; the thesis
# says as much (5.5).
#
# **In the table's favour here.** The mirror comes back to its shapes exactly.
# A real sheet creeps, a load slips, and an entry of last week is not today's.
# **In the update's favour.** The board is always there to be seen, and its
# corners are never mistaken.
#
# **Limits.** The boundary's errors are independent from point to point and its
# corners are found; no picture is rendered. Beyond its ends the table could
# be extrapolated; this one does not, and says so.

# %% [markdown]
# ## Compared with the published numbers
#
# There are none: the thesis has no numbers of the other method.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** The free edge moves over 180 px of the picture while the load goes
# from 0 to 15 mm, and 33 points of it are traced, each with 0.5 px of noise
# across the edge. If that edge alone counts: what is the standard deviation of
# the deflection, in µm?

# %% tags=["active-ipynb"]
# check(None, **noise_task())

# %% [markdown]
# **2.** Without noise, a table of entries 5 mm apart is off by some 20 µm
# half-way between them. How far apart, in mm, may entries be if it is to be a
# tenth of that?

# %% tags=["active-ipynb"]
# check(None, **spacing_task())
