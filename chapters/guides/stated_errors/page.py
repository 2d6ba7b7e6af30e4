# %% [markdown]
# # Stated errors beside errors that happen
#
# **Question.** A corner comes with a standard deviation, a decoded place with
# another, a focal length with a third. Are these the errors that happen? And where
# something is wrong that no standard deviation can hold, such as a bent board or
# photographs of two cameras, does the library say so?

# %%
from chapters.guides.stated_errors.results import RECORD_RUN, facts
from chapters.guides.stated_errors.trials import about, conditions, recorded_row
from repro.page.reader import open_results, show, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan


# %%
@experiment(
    "ext_stated_record",
    artefact="ext_stated_coverage",
    inputs=("data/records/stated.json",),
)
def ext_stated_record(effort):
    """What the record holds; nothing is measured again."""
    return Plan(
        lambda condition, rng: recorded_row(condition), conditions(), 1, about()
    )


# %% tags=["active-ipynb", "remove-input"]
# for name, x in facts(open_results(RECORD_RUN)).items(): value(name, x)

# %% tags=["active-ipynb"]
# show("ext_stated_coverage")

# %% [markdown]
# ## Findings
#
# - **Corners.** In {glue:text}`drawn.rows` drawn sets the spread of errors is
#   {glue:text}`drawn.ratio.least` to {glue:text}`drawn.ratio.most` times the stated
#   one, and up to {glue:text}`drawn.beyond3.most` % of a set's corners are more than
#   three standard deviations off; were errors Gaussian, it would be 1.1 %. In
#   {glue:text}`photographed.rows` photographed sets the spread about a consensus of
#   detectors is {glue:text}`photographed.ratio.least` to
#   {glue:text}`photographed.ratio.most` times the stated one, with
#   {glue:text}`photographed.beyond3.least` to {glue:text}`photographed.beyond3.most` %
#   beyond three. There the truth itself is uncertain: those detectors are
#   {glue:text}`photographed.truth_px.least` to
#   {glue:text}`photographed.truth_px.most` px apart, while
#   {glue:text}`photographed.sd_px.least` to {glue:text}`photographed.sd_px.most` px are
#   stated.
# - **Boards.** Of {glue:text}`boards.given.pictures` photographs of boards,
#   {glue:text}`boards.given.right` are read right where their size is told,
#   {glue:text}`boards.given.wrong` wrong, and {glue:text}`boards.given.refused` are
#   refused; {glue:text}`boards.alone.right`, {glue:text}`boards.alone.wrong` and
#   {glue:text}`boards.alone.refused` where it is not. Of {glue:text}`boards.none`
#   drawn patterns that are no chessboard, {glue:text}`boards.false` are taken for one.
# - **Decoded places**, behind monitors with a gamma of 1 to 2.4:
#   {glue:text}`decoding.within1.least` to {glue:text}`decoding.within1.most` % are
#   within one standard deviation of the truth (a Gaussian has 68.3 %), and
#   {glue:text}`decoding.within3.least` to {glue:text}`decoding.within3.most` % within
#   three (99.7 %). At most {glue:text}`decoding.left_out.most` % of good pixels are
#   left out.
# - **Decoded places in hard cases**, such as JPEG files, light that drifts and mirrors
#   that bend strongly: {glue:text}`decoding_hard.within1.least` to
#   {glue:text}`decoding_hard.within1.most` %, and
#   {glue:text}`decoding_hard.within3.least` to
#   {glue:text}`decoding_hard.within3.most` %.
# - **Focal lengths** of sound sets are off by {glue:text}`focal.least` to
#   {glue:text}`focal.most` times what is stated (RMS). A board bent by a millimetre is
#   noticed in {glue:text}`bent.shape` of {glue:text}`bent.sets` sets, and its shape is
#   fitted with the camera; rays are then {glue:text}`bent.rays` px off or less in the
#   median of the sets of either lens.
# - **What no standard deviation can hold.** Photographs of two cameras whose focal
#   lengths are 2 % apart are told in {glue:text}`cameras.told` of
#   {glue:text}`cameras.sets` sets, and 1 % apart, mixed at random, in
#   {glue:text}`near.told` of {glue:text}`near.sets`; a dent in the board or a row that
#   is printed half a millimetre off, which no bend explains, in
#   {glue:text}`dented.corners` of {glue:text}`dented.sets`; motion during the exposure
#   in {glue:text}`shutter.erratic` of {glue:text}`shutter.sets` by photographs that
#   differ; one photograph among fourteen that lacks 20 px at its left, by its name, in
#   {glue:text}`cropped.odd` of {glue:text}`cropped.sets`. False alarms:
#   {glue:text}`sets.false` in {glue:text}`sets.sound` sound sets. Tables of rays hang
#   less on a formula, and tell less: of sets of two cameras or a stretched board
#   {glue:text}`tables.found` of {glue:text}`tables.faulty` are noticed, and
#   {glue:text}`tables.false` of {glue:text}`tables.sound` sound ones are said to be
#   unstable.
# - **A pupil that moves.** It is said to move in {glue:text}`pupil.false` of
#   {glue:text}`pupil.central` central lenses, and in {glue:text}`pupil.found` of
#   {glue:text}`pupil.moved` where it does.
# - **Damaged files.** {glue:text}`readers.mutants` were read or refused in a line;
#   {glue:text}`readers.faults` ended otherwise.

# %% [markdown]
# ## Corners

# %% tags=["active-ipynb"]
# show_table("ext_stated_corners", digits=3)

# %% [markdown]
# A corner's standard deviation has four parts. Noise of pixels goes through the fit of
# two edges exactly. What else moves a corner (compression, a blur that is not the same
# to all sides, bends within the window) shows where the near part of the window says
# something else than the far part; by that factor the first part is multiplied, and
# corners around one have a say in it, but a row of them in the edge of a shadow speaks
# for itself only. A small constant is for what pixels do to edges that are as sharp as
# they are. The last part is by how much half a turn of its window moves the corner, as
# far as that is beyond chance.
#
# *Error over stated* is a robust standard deviation of the errors over the stated
# ones, so 1 is what it should be; below, too much is stated. A decile holds a tenth of
# a set's corners, from the least to the most certain.
#
# On photographs nobody knows the truth. A consensus of several detectors stands for
# it, and its own error counts here as ours: *detectors apart* is how far the farthest
# of them lies from it, in the median. So these rows say that both together are larger
# than stated, not whose the error is. What near and far cannot see is an error that a
# whole edge shares: behind a sharp colour mosaic, edges along the pixels are off by
# several stated deviations.
#
# ## Boards

# %% tags=["active-ipynb"]
# show_table("ext_stated_boards")

# %% [markdown]
# *Size* is the number of corners each way. Where nobody tells it, each picture is
# looked at by itself here. `raxel corners` and `raxel calibrate` let the photographs
# of one set vote, which the table leaves aside.
#
# ## Decoded places

# %% tags=["active-ipynb"]
# show_table("ext_stated_decoding", digits=3)

# %% [markdown]
# An ordinary monitor does not answer in proportion: a gamma of 2.2 makes of a sine a
# wave with harmonics, and with $N$ phase steps the harmonics $N - 1$ and $N + 1$ move
# each place by a ripple of $N$ periods in one of the sine. The decoder fits this
# ripple to what it sees on smooth pieces of lines, and undoes it. What it cannot know
# of it is added to the standard deviation. *Shift* is how far places were moved by the
# response, *left* what may be left of that.

# %% tags=["active-ipynb"]
# show_table("ext_stated_decoding_hard", digits=3)

# %% [markdown]
# In a JPEG file neighbours share their noise, and an average over a window takes less
# of it away than of white noise. Phases of neighbouring windows are compared, and
# standard deviations multiplied by what these differ by beyond noise. A fold is where
# the place turns round or its slope breaks; there the standard deviation
# holds what a bend of that size can do within the window. *Told* is how a message
# begins; its numbers and what to do follow there.
#
# ## Calibrations

# %% tags=["active-ipynb"]
# show_table("ext_stated_calibration", digits=3)

# %% [markdown]
# Each row is 20 to 120 drawn sets of photographs. *Shape used*: the board's bends,
# twist or stretch were fitted with the camera, since the photographs asked for it.
# *Board's corners lie elsewhere*: all photographs together say that some corners are
# not where the board has them, in a form that is no bend and no stretch.
# *Halves disagree*: fitted to two halves of the photographs, the camera differs by
# more than photographs of one half do. *Focal lengths alone differ*: no halves do, but
# photographs differ more in the focal length that each asks for than in all else.
# *Photographs differ*: one from another, by more than their corners' scatter.
# *One odd photograph*: one lies farther from what all others say of the camera than
# these lie from each other. Each photograph three times, with a third of the noise
# anew, stands for the frames of a film: they count together.

# %% tags=["active-ipynb"]
# show_table("ext_stated_tables")

# %% [markdown]
# A table of rays has errors of its own in each pixel, which two halves do not share.
# So photographs within one half say how far apart two halves may be.

# %% tags=["active-ipynb"]
# show_table("ext_stated_pupil", digits=3)

# %% [markdown]
# The entrance pupil of a wide lens may move along its axis with the angle. This is
# said only if kept-out boards are predicted better by more than chance, beside a law
# with as many terms more, and if the law that predicts best agrees.
#
# ## Damaged files

# %% tags=["active-ipynb"]
# show_table("ext_stated_readers")

# %% [markdown]
# ## Limits
#
# - All tables but those rows that name a photographed set are drawn. A drawing knows
#   the truth and nothing of dust.
# - Seeds were fixed before anything was measured with them; what was settled on the
#   way was settled on others.
# - Rows are records: {glue:text}`command` makes them again, which takes up to an
#   hour. No build does it.
