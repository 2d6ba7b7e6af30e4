"""Results of this page read: values of the prose, figures, tables."""

from functools import lru_cache
from typing import ClassVar, NamedTuple

import numpy as np
from scipy.stats import wilcoxon

from chapters.ch05_flexible_mirror.s3_3_repeatability.experiment import (
    ARMS,
    FEW,
    KEPT,
    LOOP,
    MANY,
    OUT,
    update_seconds,
)
from chapters.shared.mirror import (
    BACK_PROJECTION_MM,
    BENCHES,
    SAID,
    STAGES_MM,
    SWEPT,
    BenchRuns,
    mirror_rig,
    shape_name,
)
from raxel.calibration.mirror.edges import SWINGING_DEG
from raxel.geometry import intersect_rays_plane, inverse_pose, transform
from raxel.show import Polyline, Scene, Segments, Surface, framed
from raxel.show.boards import board as board_mesh
from raxel.show.cameras import frustum
from repro.page import INK, new_figure, series
from repro.page import value as name_value
from repro.page.film import pictured
from repro.page.space import draw_scene, scene_frames
from repro.run import (
    HOLDS,
    OVER_TRIALS,
    UNDECIDED,
    Check,
    Drawing,
    Film,
    Measured,
    Panel,
    Table,
    Value,
    bootstrap,
    columns,
    figure,
    median_and_range,
    median_interval,
    numbers,
    table,
    with_worst,
)

# The runs out and back: result, error level and step.


RUNS, SWEPT_RUNS, OTHER = "table_5_5_runs", "table_5_5_swept", "table_5_5_other"
JUDGED = ("table_5_5_runs", "table_5_5_swept")
PLACED, STARTED = "exp_c5_dense_grid", "exp_c5_not_sensitive_init"
STEPS = tuple(range(1, len(LOOP)))
THERE, BACK = STEPS[:OUT], STEPS[OUT:]
# Steps out, each with the step back that reverses it.
EQUIVALENT = tuple(zip(THERE, reversed(BACK), strict=True))
STEP_MM = STAGES_MM[1] - STAGES_MM[0]
WHOLE_MM = STAGES_MM[-1] - STAGES_MM[0]
SCALE = 10  # of the vectors of Fig. 5.13
PANELS = {
    "start": "(a) stage 0, before",
    "step3": "(b) stage 3, three steps",
    "step6": "(c) stage 0, six steps",
    "single": "(d) stage 0, three and one",
}


class LoopRuns(BenchRuns):
    """The loop out and back, and the single step back."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)
    ELSEWHERE: ClassVar = {"B": OTHER}
    SWINGS = tuple(f"step{step}" for step in STEPS)

    def goes_on(self, place):
        """Extends that of all runs; the single step starts after the third step."""
        if place != "single":
            return super().goes_on(place)
        on = super().goes_on(f"step{THERE[-1]}")
        swings = self.raw("single.swing_deg") >= SWINGING_DEG
        return on & ~(swings & self["swinging_ends"])

    def of(self, place, name):
        """A value (seeds,): place is "start", "step1" to "step6", or "single"."""
        return self.at_place(place, name)

    @property
    def completed(self):
        """Which runs (seeds,) completed all six steps."""
        return np.isfinite(self.of(f"step{STEPS[-1]}", "back_mm"))

    def at(self, name, steps=STEPS):
        """A value (steps, seeds) of several steps."""
        return np.array([self.of(f"step{step}", name) for step in steps])

    def refused(self):
        """Numbers of runs without the sixth step, and without the single step."""
        ends = self.of(f"step{STEPS[-1]}", "back_mm"), self.of("single", "back_mm")
        return tuple(int(np.isnan(end).sum()) for end in ends)

    def drawn(self, place):
        """Board corners and their errors (N, 2), mm, in the first completed run."""
        whole = np.isfinite(self.of("single", "back_mm"))
        seed = int(np.flatnonzero(whole)[0])
        before = np.isfinite(self.raw(f"{place}.back_mm"))[:seed].sum()
        name = f"{self.bench}.{place}.own"
        board = self.result.arrays(f"{self.bench}.board_mm")[0]
        return board, self.result.arrays(name)[before], seed


# Causes of error growth: what the steps see, and the board's known metric.


CONDITIONED = ("exp_c5_concave_conditioning", "exp_c5_concave_conditioning_swept")
METRIC = "exp_c5_metric_fit_helps"
MEASURES = ("covered", "reciprocal")
MAX_P = 0.05


class LoopSights(BenchRuns):
    """Measures of what the steps of a loop see, at one error level."""

    EXPERIMENTS = CONDITIONED
    SWINGS = tuple(f"step{step}" for step in STEPS)

    def of_steps(self, name):
        """A measure (steps, seeds) of all steps, nan from the rejected one on."""
        return np.array([self.at_place(place, name) for place in self.SWINGS])

    def back_over_out(self, name):
        """Mean of a measure over the steps back, over that of the steps out,
        (seeds,)."""
        found = self.of_steps(name)
        out, back = (
            found[np.subtract(steps, 1)].mean(axis=0) for steps in (THERE, BACK)
        )
        return back / out


def better_conditioned(seen):
    """Whether steps back cover more and are better conditioned, run by run, as
    `counterpart` uses it."""
    least = np.min([seen.back_over_out(name) for name in MEASURES], axis=0)
    with np.errstate(invalid="ignore"):
        return least > 1, least, "x", "steps back over steps out, the lesser of both"


def errors_of(result, arm, name="back_mm"):
    """Errors (steps, seeds) of one arm, nan from the step on that was rejected."""
    return np.array([result.column(f"{arm}.step{k}.{name}") for k in STEPS])


def rates(errors):
    """Slopes (seeds,) of errors (steps, seeds) on the step's number, per step."""
    x = np.arange(len(errors)) - (len(errors) - 1) / 2
    return x @ errors / (x @ x)


def without_less_metric(result, name="back_mm"):
    """Growth without the metric less that with it, (seeds,), per step; infinite where
    only that without was rejected, minus infinite where only the other was, nan where
    both were."""
    metric, without = (with_worst(rates(errors_of(result, arm, name))) for arm in ARMS)
    with np.errstate(invalid="ignore"):
        return without - metric


def while_both_go_on(result, name="back_mm"):
    """The same over the steps that both arms reach, of runs with two or more."""
    metric, without = (errors_of(result, arm, name) for arm in ARMS)
    reached = np.isfinite(metric + without).sum(axis=0)
    return np.array(
        [
            rates(without[:n, seed]) - rates(metric[:n, seed])
            for seed, n in enumerate(reached)
            if n >= 2
        ]
    )


def p_larger(differences):
    """One-sided p (Wilcoxon's signed ranks) that differences (n,) are above 0; infinite
    ones outrank all others."""
    finite = np.abs(differences[np.isfinite(differences)])
    largest = 1 + finite.max(initial=0)
    ranked = np.clip(differences, -largest, largest)
    return float(wilcoxon(ranked, alternative="greater").pvalue) if ranked.any() else 1


def decision_of(differences):
    """(decision, Estimate of the median, p): larger, if p and the median's interval
    support it."""
    middle, p = median_interval(differences), p_larger(differences)
    decision = middle.above(0.0)
    return (UNDECIDED if decision == HOLDS and p >= MAX_P else decision), middle, p


def refused(result, arm):
    """Number of runs of an arm that ended before the sixth step."""
    return sum(text is not None for text in result.texts(f"{arm}.refused"))


# Frames of the film of the bending mirror, from its rendered run.


FILM = "ext_mirror_film_pictures"
UM = 1000.0


class Frames(NamedTuple):
    """A row for each of n frames.

    true_mm, found_mm, angle_deg (n,); used (n,) corners; picture (n, h, w) uint8;
    corners (n, N, 2) px of the whole image; mirror, directions (n, a, b, 3); profile
    (n, b, 2) mm; T_camera_board (4, 4).
    """

    true_mm: np.ndarray
    found_mm: np.ndarray
    angle_deg: np.ndarray
    used: np.ndarray
    picture: np.ndarray
    corners: np.ndarray
    mirror: np.ndarray
    directions: np.ndarray
    profile: np.ndarray
    T_camera_board: np.ndarray

    @classmethod
    def of(cls, result):
        """Return the frames of the film's only trial."""
        return cls(**{name: result.arrays(name)[0] for name in cls._fields})

    @property
    def error_um(self):
        """Found minus true deflection (n,), um."""
        return UM * (self.found_mm - self.true_mm)

    @property
    def peak(self):
        """Number of the frame with the largest deflection."""
        return int(np.argmax(self.true_mm))


# Quantities of each run out and back, and the bounds of the claims.


MAX_APART, MAX_OPEN_MM = 6.0, 0.3
MAX_DIFFERENT, MAX_GROWTH = 1.0, 5.0
MAX_WORSE = 1.2
MIN_SD_MM, MIN_REDUCTION = 0.05, 20.0
MAX_SD = 1.0
median = OVER_TRIALS["median"]


def disagreement(runs):
    """Largest difference of equivalent steps, %, (seeds,)."""
    found = []
    for pair in EQUIVALENT:
        both = runs.at("deflection_mm", pair)
        found.append(100 * (both.max(axis=0) / both.min(axis=0) - 1))
    return np.max(found, axis=0)


def loop_error(runs):
    """All steps out less all steps back, mm, (seeds,), without sign."""
    out, back = (runs.at("deflection_mm", steps).sum(axis=0) for steps in (THERE, BACK))
    return np.abs(out - back)


def single_difference(runs):
    """Difference of the single step from the three back, %, (seeds,), without sign."""
    staged = runs.at("deflection_mm", BACK).sum(axis=0)
    return 100 * np.abs(runs.of("single", "deflection_mm") / staged - 1)


def height_errors(runs):
    """Error of the load's height after each step, mm, (steps, seeds), signed.

    The height is the estimate of stage 0 with all steps added.
    """
    signs = np.where(np.isin(STEPS, THERE), 1.0, -1.0)[:, None]
    found = np.cumsum(signs * runs.at("deflection_mm"), axis=0)
    true = np.array([STAGES_MM[LOOP[step]] for step in STEPS])
    return found - true[:, None]


def steps_agree(runs):
    """Test that equivalent steps agree within 6 %."""
    apart = disagreement(runs)
    return (apart <= MAX_APART, apart, "%", "largest difference of equivalent steps")


def loop_closes(runs):
    """Test that the sums out and back agree within 0.3 mm."""
    off = loop_error(runs)
    return (off <= MAX_OPEN_MM, off, "mm", "sum of the steps out less that back")


def error_growth(runs, name="back_mm", seeds=slice(None)):
    """Slope of the back-projection error on the step's number, % of the fitted line's
    value at the first step, Estimate; a draw is one of whole sequences. seeds: (seeds,)
    those that count, a rejected one as the worst."""
    trials = [with_worst(row[seeds]) for row in runs.at(name)]
    x = np.arange(len(trials)) - np.mean(np.arange(len(trials)))

    def slope(*rows):
        y = np.stack([median(row) for row in rows])
        rise = np.tensordot(x, y, 1) / (x @ x)
        return 100 * rise / (y.mean(axis=0) + x[0] * rise)

    return bootstrap(slope, *trials, paired=True)


def loop_ratio(after, before):
    """Ratio of the medians of two measures of the same runs, Estimate."""
    return bootstrap(
        lambda a, b: median(a) / median(b),
        with_worst(after),
        with_worst(before),
        paired=True,
    )


def in_places(result, bench, pitch):
    """Deflections (seeds, places) mm of one pitch, nan where rejected."""
    return np.array(result.arrays(f"{bench}.{pitch}"))


def between_places(*found):
    """SD of deflections between places, mm, (seeds,) for each array (seeds, places).

    Of the places in which none was rejected; nan where fewer than two are left.
    """
    known = np.all(np.isfinite(found), axis=0)
    enough = known.sum(axis=1) > 1
    spread = np.full((len(found), len(known)), np.nan)
    for row, mm in zip(spread, found, strict=True):
        row[enough] = np.nanstd(np.where(known, mm, np.nan)[enough], axis=1, ddof=1)
    return spread


def pooled_sd(result, bench, pitch="coarse"):
    """SD between places over all runs, mm, Estimate; runs are resampled."""
    (spread,) = between_places(in_places(result, bench, pitch))
    return bootstrap(_rms, spread[np.isfinite(spread)])


def reduction(result, bench):
    """Reduction of the SD between places by half the pitch, %, Estimate."""
    coarse, dense = between_places(
        *(in_places(result, bench, pitch) for pitch in ("coarse", "dense"))
    )
    known = np.isfinite(coarse)
    return bootstrap(
        lambda a, b: 100 * (1 - _rms(b) / _rms(a)),
        coarse[known],
        dense[known],
        paired=True,
    )


def _rms(spread):
    return np.sqrt(np.mean(spread**2, axis=-1))


def scatter_of_starts(result, bench, step, step_mm):
    """SD (seeds,) of the results of perturbed starts, % of the deflection; nan where a
    start or the whole stage was rejected."""
    return 100 * result.column(f"{bench}.{step}.sd_mm") / step_mm


# The numbers that the page quotes: medians over completed runs.


MS = 1000.0


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = LoopRuns({RUNS: open_results(RUNS)})
    last = f"step{STEPS[-1]}"
    more = runs.of("single", "back_mm") / runs.of(last, "back_mm")
    quoted = {
        "single.worse": 100 * float(np.mean(more[np.isfinite(more)] > 1)),
        "angle.start": quoted_median(runs.of("start", "angle_deg")),
        "angle.end": quoted_median(runs.of(last, "angle_deg")),
        "film.update_ms": MS * update_seconds(),
    }
    quoted |= quoted_of_metric(open_results(METRIC))
    for name, number in quoted.items():
        name_value(name, number)


def quoted_median(found):
    """Median of the runs (seeds,) that have a value, nan without any."""
    return median_and_range(found).value


def quoted_of_metric(result):
    """Back-projection error at stage 3 with the board's known metric and without."""
    return {
        f"metric.{arm}.third": quoted_median(errors_of(result, arm)[THERE[-1] - 1])
        for arm in ARMS
    }


# Effect of relief at stage 0, and how much of it more functions remove.


RELIEF = "exp_c5_high_order"
median_of_relief = OVER_TRIALS["median"]


class ReliefRuns(NamedTuple):
    """Trials with a smooth mirror and with one with relief."""

    trials: object

    @classmethod
    def of(cls, results):
        """Return the trials from the Results, by name."""
        return cls(results[RELIEF].select(geometry="A"))

    def values(self, mirror, shape, name):
        """A measure (seeds,), infinite where rejected."""
        return with_worst(self.trials.column(f"{mirror}.{shape_name(shape)}.{name}"))

    def rise(self, name="back_mm"):
        """Relief over smooth with the fewest functions, ratio of medians, Estimate."""
        pair = (self.values(mirror, FEW, name) for mirror in ("relief", "smooth"))
        return bootstrap(
            lambda a, b: median_of_relief(a) / median_of_relief(b), *pair, paired=True
        )

    def removed(self, name="back_mm"):
        """Share of the rise that the most functions remove, percent, Estimate."""
        four = (
            self.values(mirror, shape, name)
            for shape in (FEW, MANY)
            for mirror in ("relief", "smooth")
        )
        with np.errstate(invalid="ignore"):
            return bootstrap(_removed, *four, paired=True)


def _removed(rough, smooth, rough_left, smooth_left):
    left = median_of_relief(rough_left) - median_of_relief(smooth_left)
    return 100 * (1 - left / (median_of_relief(rough) - median_of_relief(smooth)))


# Vectors of Fig. 5.13 at the edge of the board that is seen next to the clamp.


SAME_ROW_MM = 1e-6


def below_at_the_edge(runs):
    """Whether the error is below the mean next to the clamp in all panels, run by run,
    as `counterpart` uses it: a run without a panel does not count."""
    ratios = np.array([edge_ratios(runs, place) for place in PANELS])
    worst = ratios.max(axis=0)
    with np.errstate(invalid="ignore"):
        return worst < 1, worst, "x", "edge over all, the largest of four panels"


def edge_ratios(runs, place):
    """Mean error at the edge next to the clamp over the mean of all corners, (seeds,).

    The edge: in each row of the board the visible corner nearest to the clamp.
    """
    found = np.full(runs.seeds, np.nan)
    board, reached, errors = vectors_at(runs, place)
    for seed, own in zip(reached, errors, strict=True):
        size = np.linalg.norm(own, axis=1)
        edge = next_to_clamp(board, np.isfinite(size), way_to_clamp())
        found[seed] = size[edge].mean() / size[np.isfinite(size)].mean()
    return np.where(runs.goes_on(place), found, np.nan)


def vectors_at(runs, place):
    """The board's corners (N, 2) mm, the runs (n,) that reached this place, and their
    errors, n times (N, 2) mm, NaN where a corner was not visible."""
    reached = np.flatnonzero(np.isfinite(runs.raw(f"{place}.back_mm")))
    board = runs.result.arrays(f"{runs.bench}.board_mm")[0]
    errors = runs.result.arrays(f"{runs.bench}.{place}.own")
    return board, reached, errors


def next_to_clamp(board, seen, way):
    """Indices of the edge's corners: board (N, 2) mm, seen (N,), way: see
    `way_to_clamp`."""
    indices = np.flatnonzero(seen)
    rows = np.round(board[indices, 1] / SAME_ROW_MM)
    return np.array(
        [
            indices[rows == row][np.argmax(way * board[indices[rows == row], 0])]
            for row in np.unique(rows)
        ]
    )


@lru_cache(maxsize=1)
def way_to_clamp():
    """1 or -1: the sense of the board's x axis that the mirror shows towards its clamp,
    of boards as they are held before geometry A."""
    rig = mirror_rig("A")
    T = rig.board_pose(np.random.default_rng(0), BACK_PROJECTION_MM)
    camera, board = rig.camera(0.0), rig.board.points()
    pixels, seen = rig.corners(camera, T)
    mirror = transform(
        inverse_pose(camera.T_viewer_mirror), camera.rays(pixels).origins
    )
    along = np.corrcoef(board[seen, 0], mirror[seen, 0])[0, 1]
    return -int(np.sign(along))


# The film of the bending mirror, and its still.


TRUE, FOUND, CORNER = INK, series(1)["color"], "#00b3ff"
LATER = {"color": "#c8ccd2", "lw": 1.2, "marker": ""}
# Images of the film: inches and dots per inch; pixels of the scene in space.
FRAME_IN, FRAME_DPI, SPACE_PX = (4.2, 3.0), 92, (480, 344)
SILVER, SIGHT_COLOUR, RAY, EDGE = "#9fb4c7", "#aeb6c0", "#0072b2", "#d55e00"
# View from above, behind the mirror.
SIGHT, UP, BODY_MM, ASPECT = (-0.55, 0.75, -0.4), (0.0, -1.0, 0.0), 45.0, 1.4
# Points across and along the sheet whose rays are drawn.
ACROSS, ALONG = (0, 4, 8), (1, 11, 21, 31)


class FilmView:
    """Scenes of a film's frames, all from one viewpoint."""

    def __init__(self, rig, frames):
        self._rig, self._frames = rig, frames
        whole = [part for k in (0, frames.peak) for part in self.parts(k)]
        self._seen = framed([*self._standing(), *whole], SIGHT, UP, aspect=ASPECT)

    def scene(self, k):
        """The Scene of frame k."""
        parts, seen = [*self._standing(), *self.parts(k)], self._seen
        return Scene(parts, seen.view_from, seen.look_at, UP, "", ASPECT)

    def parts(self, k):
        """Mirror, rays and outline on the board of frame k."""
        frames = self._frames
        mirror, ways = frames.mirror[k], frames.directions[k]
        met = self._on_board(mirror, ways)
        some = np.ix_(ACROSS, ALONG)
        starts, ends = mirror[some].reshape(-1, 3), met[some].reshape(-1, 3)
        return [
            Surface(mirror, SILVER, 0.8, ""),
            Segments(np.zeros_like(starts), starts, SIGHT_COLOUR, "", 1.0),
            Segments(starts, ends, RAY, "", 1.4),
            Polyline(_rim(met), EDGE, "", 3.0),
        ]

    def _standing(self):
        T = self._frames.T_camera_board
        return [
            frustum(self._rig.viewer, BODY_MM, label=""),
            *board_mesh(self._rig.board, T),
        ]

    def _on_board(self, origins, directions):
        T = self._frames.T_camera_board
        met = intersect_rays_plane(
            origins.reshape(-1, 3), directions.reshape(-1, 3), T
        ).points
        places = np.column_stack([met, np.zeros(len(met)), np.ones(len(met))])
        return (places @ T.T)[:, :3].reshape(origins.shape)


def _rim(points):
    """The outer ring (n, 3) of points (a, b, 3), closed."""
    return np.concatenate(
        [points[0], points[1:, -1], points[-1, -2::-1], points[-2::-1, 0]]
    )


@figure("ext_mirror_film", needs=("ext_mirror_film_pictures",), evidence="rendered",
        scene=True)  # fmt: skip
def film_figure(results):
    """A still of the film at its largest deflection, and the film."""
    rig, frames = mirror_rig("A", small=True), Frames.of(results[FILM])
    view = FilmView(rig, frames)
    still = frames.peak
    drawn, axes = new_figure(2, 2, height_in=6.0)
    draw_picture(axes[0, 1], frames, still)
    draw_profile(axes[1, 0], frames, still)
    draw_error(axes[1, 1], frames, still)
    for panel, letter in zip(axes.flat, "abcd", strict=True):
        panel.set_title(f"({letter})")
    draw_scene(axes[0, 0], view.scene(still))
    return Drawing(
        drawn,
        columns(
            ("frame", "true_mm", "found_mm", "angle_deg", "corners"),
            list(
                zip(range(len(frames.used)), frames.true_mm, frames.found_mm,
                    frames.angle_deg, frames.used, strict=True)
            ),
        ),
        "A bending mirror and the calibration that follows it, image by image: the "
        f"frame at {frames.true_mm[still]:g} mm. (a) Camera, estimated mirror, rays "
        "(grey, then blue), and the part of the board's plane that the mirror shows "
        "(orange). (b) Camera image with the tracked corners. (c) Profile of the "
        "mirror's middle line, true and estimated. (d) Error of the deflection over "
        "the film.",
        scene=film_of(frames, view),
    )  # fmt: skip


def film_of(frames, view):
    """The Film of all frames."""
    count = range(len(frames.true_mm))
    ways = (
        (draw_picture, "Camera image", "A board in the mirror, its corners "
         "marked where they were tracked."),
        (draw_profile, "Profile of the mirror", "Height of the mirror's middle line "
         "over the flat sheet, true and estimated."),
        (draw_error, "Error of the deflection", "Estimated minus true deflection over "
         "the film, up to the frame that is shown."),
    )  # fmt: skip
    panels = [
        Panel("In space", "Camera, bending mirror, rays and board; an orange outline "
              "on the board, what the mirror shows of it, widens and narrows.",
              scene_frames([view.scene(k) for k in count], SPACE_PX))
    ]  # fmt: skip
    panels += [
        Panel(title, says, [_alone(draw, frames, k) for k in count])
        for draw, title, says in ways
    ]
    labels = [
        f"Frame {k + 1} of {len(count)}: deflection {frames.true_mm[k]:.2f} mm, "
        f"estimated {_plain(frames.found_mm[k])} mm; {int(frames.used[k])} corners, "
        f"ray error {frames.angle_deg[k]:.3f} degrees"
        for k in count
    ]
    return Film(panels, labels)


def _plain(mm):
    """A length to a hundredth of a mm, without a minus before zero."""
    return f"{round(float(mm), 2) + 0:.2f}"


def _alone(draw, frames, k):
    drawn, axes = new_figure(height_in=FRAME_IN[1])
    drawn.set_size_inches(*FRAME_IN)
    draw(axes, frames, k)
    return pictured(drawn, FRAME_DPI)


def draw_picture(axes, frames, k):
    """Draw the camera's image with the corners of frame k."""
    axes.imshow(frames.picture[k], cmap="gray", vmin=0, vmax=255)
    # Pixel centres at whole numbers, in the stored image as in the camera's.
    places = KEPT * (frames.corners[k] + 0.5) - 0.5
    axes.plot(*places.T, "o", mfc="none", mec=CORNER, ms=4, mew=1.0)
    axes.set_axis_off()


def draw_profile(axes, frames, k):
    """Draw the height of the middle line, true and estimated, in frame k."""
    sheet = mirror_rig("A", small=True).camera(float(frames.true_mm[k])).mirror
    flat = np.linspace(0, sheet.end, 81)
    axes.plot(
        flat, sheet.height(flat, 0 * flat)[0], color=TRUE, marker="", label="true"
    )
    axes.plot(*frames.profile[k].T, ".", color=FOUND, ms=5, label="estimated")
    top = 1.15 * np.nanmax(frames.profile[..., 1])
    axes.set(xlim=(0, 1.03 * sheet.end), ylim=(-0.05 * top, top))
    axes.set(xlabel="Position along the flat sheet (mm)", ylabel="Height (mm)")
    axes.legend(loc="upper left")


def draw_error(axes, frames, k):
    """Draw the error of the deflection up to frame k; later frames are pale."""
    time = np.arange(len(frames.true_mm)) + 1
    axes.axhline(0, color=TRUE, lw=0.8, marker="")
    axes.plot(time, frames.error_um, **LATER)
    axes.plot(time[: k + 1], frames.error_um[: k + 1], ".-", color=FOUND, lw=1.4)
    axes.plot(time[k], frames.error_um[k], "o", color=FOUND, ms=7)
    axes.set(xlabel="Frame", ylabel="Deflection error (µm)")


# Fig. 5.13: back-projection errors along the loop.


MARGIN_MM = 10.0
ROUNDING = 1e-9


@figure("fig_5_13", needs=("table_5_5_runs",), evidence="rendered")
def fig_5_13(results):
    """Vectors from the corners of a board to where their rays meet it, times ten."""
    runs = LoopRuns(results)
    drawn, axes = new_figure(2, 2, height_in=4.4, sharex=True, sharey=True)
    rows, gaps, ends = [], [], []
    for panel, (place, title) in zip(axes.flat, PANELS.items(), strict=True):
        board, errors, seed = runs.drawn(place)
        known = np.isfinite(errors).all(axis=1)
        corners, off = board[known], errors[known]
        panel.plot(*corners.T, ls="", marker=".", ms=2.5, color=INK)
        panel.quiver(
            *corners.T, *(SCALE * off).T, angles="xy", scale_units="xy", scale=1,
            color=series(0)["color"], width=0.004,
        )  # fmt: skip
        mean = np.linalg.norm(off, axis=1).mean()
        panel.set_title(f"{title}: {mean:.2f} mm", fontsize=9.5)
        panel.set_aspect("equal")
        ends += [*corners, *(corners + SCALE * off)]
        gaps.append(abs(mean - runs.of(place, "back_mm")[seed]))
        rows += [(place, *four) for four in np.column_stack([corners, off])]
    low, high = np.min(ends, axis=0) - MARGIN_MM, np.max(ends, axis=0) + MARGIN_MM
    axes[0, 0].set(xlim=(low[0], high[0]), ylim=(high[1], low[1]))
    for panel in axes[-1]:
        panel.set_xlabel("Board x (mm)")
    for panel in axes[:, 0]:
        panel.set_ylabel("Board y (mm)")
    return Drawing(
        drawn,
        columns(("panel", "x_mm", "y_mm", "off_x_mm", "off_y_mm"), rows),
        "Back-projection errors on a board at 400 mm in the pose fitted by the "
        f"calibrated camera, scaled by {SCALE}: the first completed run at the second "
        "solved level. Mean lengths above the panels.",
        Check(
            bool(max(gaps) < ROUNDING),
            f"the drawn vectors have the mean lengths of the trial, to {max(gaps):.0e} "
            "mm",
        ),
    )


# Table 5.5 with its numbers and those of Fig. 5.13, and the sensitivity table.


SET = "the steps of the rig are these: put in, not found"
# Names of states of the loop in the registry's ids -> names in the results.
PLACES = {"stage0_primary": "start", "stage3": "step3", "stage0_after6": "step6"}
COLUMNS = {
    "linear": "linear_mm",
    "final": "deflection_mm",
    "res_mean": "residual_mm",
    "res_sd": "residual_sd_mm",
}


def _median(found, unit):
    """Median of the runs that have a value, with the number of others, as a Value."""
    known = found[np.isfinite(found)]
    lost = len(found) - len(known)
    reason = f"{lost} of {len(found)} runs were rejected before" if lost else ""
    return Value.median(known if len(known) else found, unit, reason)


def middle_value(found):
    """Median of the runs that have a value, nan without any."""
    return median_and_range(found).value


def _percent_more(after, before):
    """Increase of the medians over completed runs, %, as a Value."""
    done = np.isfinite(after + before)
    if not done.any():
        return Value(np.nan, unit="%")
    found = loop_ratio(after[done], before[done])
    value, low, high = (100 * (number - 1) for number in found[:3])
    return Value(value, (low, high), "%")


@numbers("table_5_5", needs=("table_5_5_runs",), evidence="rendered")
def numbers_table_5_5(results):
    """Cells of the table, and the text's numbers: medians over runs."""
    runs = LoopRuns(results)
    cells = {
        f"t5_5_step{step}_{column}": _median(runs.of(f"step{step}", name), "mm")
        for step in STEPS
        for column, name in COLUMNS.items()
    }
    actual = {
        f"t5_5_step{step}_actual": Value(STEP_MM, unit="mm", put_in=SET)
        for step in STEPS
    }
    loop = loop_error(runs)
    staged = runs.at("deflection_mm", BACK).sum(axis=0)
    single = {
        f"s5_rep_single_{name}": _median(runs.of("single", column), "mm")
        for name, column in {
            "lin": "linear_mm",
            "fin": "deflection_mm",
            "res_mean": "residual_mm",
            "res_sd": "residual_sd_mm",
        }.items()
    }
    difference = single_difference(runs)
    return (
        actual
        | cells
        | single
        | {
            "s5_rep_agree": _median(disagreement(runs), "%"),
            "s5_rep_hyst_mm": _median(loop, "mm"),
            "s5_rep_hyst_pct": _median(100 * loop / WHOLE_MM, "%"),
            "s5_rep_staged": _median(staged, "mm"),
            "s5_rep_single_pct": _median(difference, "%"),
        }
    )


@numbers("fig_5_13", needs=("table_5_5_runs",), evidence="rendered")
def numbers_fig_5_13(results):
    """Back-projection errors in the fitted pose: medians over runs."""
    runs = LoopRuns(results)
    found = {
        f"s5_rep_bp_{name}_{statistic}": _median(runs.of(place, column), "mm")
        for name, place in PLACES.items()
        for statistic, column in (("mean", "back_mm"), ("sd", "back_sd_mm"))
    }
    ends = runs.at("back_mm", (STEPS[-1], STEPS[0]))
    return found | {
        "s5_rep_single_bp_mean": _median(runs.of("single", "back_mm"), "mm"),
        "s5_rep_single_bp_sd": _median(runs.of("single", "back_sd_mm"), "mm"),
        "s5_rep_bp_increase": _percent_more(*ends),
        "fig5_13_scale": Value(SCALE, unit="x"),
    }


@table("table_5_5", needs=("table_5_5_runs",), evidence="rendered")
def table_5_5(results):
    """Steps by stage: deflections, residuals, and errors against the truth."""
    runs = LoopRuns(results)
    off = height_errors(runs)
    rows = []
    for step in STEPS:
        place = f"step{step}"
        rows.append(
            (
                LOOP[step],
                STEP_MM,
                *(_cell(runs.of(place, name)) for name in COLUMNS.values()),
                _cell(np.abs(off[step - 1])),
                *(_cell(runs.of(place, n)) for n in ("angle_deg", "back_true_mm")),
            )
        )
    names = (
        "Stage",
        "Actual (mm)",
        "Linear estimate (mm)",
        "Final estimate (mm)",
        "Residual, mean (mm)",
        "Residual, SD (mm)",
        "Error of the height at the load (mm)",
        "Angle to true rays (°)",
        "Back-projection, true pose (mm)",
    )
    printed = dict(zip(names[1:6], ("actual", *COLUMNS), strict=True))
    return Table(
        columns(names, rows),
        "Deflections and errors of three steps of 5 mm out and three back, second "
        f"solved level: medians over the {runs.completed.sum()} of {runs.seeds} "
        "completed runs, with 95 % intervals. The three columns on the right require "
        "the truth, which the thesis did not have: absolute error of the height, as "
        "the sum of all steps; mean angle of the rays to the true ones; and "
        "back-projection error on a board at 400 mm in its true pose.",
        printed={
            name: [f"t5_5_step{step}_{column}" for step in STEPS]
            for name, column in printed.items()
        },
    )


def judged_by(runs):
    """Quantities that the claims test, of completed runs, and the number of these."""
    done = runs.completed
    start, third, end = (runs.of(p, "back_mm")[done] for p in PLACES.values())
    own = [
        middle_value(measure(runs))
        for measure in (disagreement, loop_error, single_difference)
    ]
    if not done.any():
        return (*own, None, None, None, None, 0)
    return (
        *own,
        loop_ratio(runs.of("single", "back_mm")[done], end).value,
        error_growth(runs, "back_mm", done).value,
        loop_ratio(end, start).value,
        loop_ratio(end, third).value,
        int(done.sum()),
    )


@table("ext_table_5_5_sweep", needs=JUDGED, evidence="rendered")
def sweep_table(results):
    """Quantities that the claims test, at all levels and over the sweep."""
    rows = []
    for bench in (*BENCHES, *SWEPT):
        runs = LoopRuns(results, bench=bench)
        rows.append((SAID.get(bench, bench), *judged_by(runs), runs.seeds))
    return Table(
        columns(
            (
                "Error level",
                "Difference of equivalent steps (%)",
                "Loop error (mm)",
                "Single step against three (%)",
                "Back-projection, single over staged",
                "Growth per step (%)",
                "After six steps over before",
                "After six steps over after three",
                "Completed",
                "Runs",
            ),
            rows,
        ),
        "Quantities that the claims test, on rig A, at the error levels and at the "
        "ends of the sweep: medians, and ratios of medians, of the completed runs. A "
        "claim whose estimate changes side between half and twice the second level's "
        "numbers is undecided.",
    )


def _cell(found):
    """Median of the runs that have a value, with its interval; None without any."""
    known = found[np.isfinite(found)]
    return Measured.median_or_none(known) if len(known) else None
