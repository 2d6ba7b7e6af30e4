"""The film of the bending mirror, and its still."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results.film import FILM, Frames
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.film import KEPT
from chapters.shared.mirror_rigs import mirror_rig
from raxel.geometry import intersect_rays_plane
from raxel.show import Polyline, Scene, Segments, Surface, framed
from raxel.show.boards import board
from raxel.show.cameras import frustum
from repro.page.film import pictured
from repro.page.space import draw_scene, scene_frames
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing, Film, Panel

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
            *board(self._rig.board, T),
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
