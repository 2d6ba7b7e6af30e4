"""Pictures of the rays of cameras that are not central."""

from __future__ import annotations

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.trials import (
    DRAWN_MM,
)
from chapters.shared.axes_in_space import (
    dots,
    in_axes,
    name_axes,
)
from repro.page.scene import Points, Scene, Segments
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

BLUE, ORANGE, GREEN = (series(k)["color"] for k in range(3))
SHEETS = (ORANGE, GREEN)
# Cameras of revolution are seen from the side, with half of the caustic:
# the other half would hide it.
ROUND = ("spherical mirror", "hyperboloid off the focus", "axial")
SIDE, OBLIQUE = (12, -18), (22, -55)
# Caustic points farther off than this many drawn lengths are left out.
REACH = 1.5
SCENE_MM = 200.0


class Drawn:
    """Rays and caustic of one camera, as an experiment left them."""

    def __init__(self, result, name):
        for part in ("origins", "directions", "caustic", "from_px"):
            setattr(self, part, result.arrays(part, model=name)[0])
        self.far_half = self.from_px[:, 0] < self.from_px[:, 0].mean()
        keep = np.isfinite(self.directions[:, 0])
        self.origins = self.origins[keep]
        self.ends = self.origins + DRAWN_MM[name] * self.directions[keep]
        middle = (self.origins.min(axis=0) + self.origins.max(axis=0)) / 2
        self.middle, self.reach = middle, REACH * DRAWN_MM[name]

    def sheet(self, k, half=False):
        """Points (M, 3) of caustic sheet k, or half, in the picture."""
        points = self.caustic[self.far_half if half else slice(None), k]
        far = np.linalg.norm(points - self.middle, axis=1)
        with np.errstate(invalid="ignore"):
            return points[far < self.reach]


@figure(
    "ext_zoo_rays",
    needs=("exp_zoo_rays",),
    evidence="analytic",
    scene=True,
)
def ext_zoo_rays(results):
    """Rays and caustics of six cameras that are not central."""
    ran = results["exp_zoo_rays"]
    cameras = {name: Drawn(ran, name) for name in DRAWN_MM}
    drawn, axes = new_figure(
        2, 3, height_in=6.2, subplot_kw={"projection": "3d"}
    )
    drawn.set_layout_engine("none")
    rows = []
    for number, (panel, (name, one)) in enumerate(
        zip(axes.flat, cameras.items(), strict=True)
    ):
        down, across = divmod(number, 3)
        panel.set_position(
            [0.33 * across + 0.005, 0.49 - 0.49 * down, 0.31, 0.46]
        )
        panel.set_title(name, fontsize=9.5)
        _draw(panel, one, name in ROUND)
        parts = {"ray start": one.origins, "ray end": one.ends}
        parts |= {f"caustic sheet {k + 1}": one.sheet(k) for k in (0, 1)}
        rows += [
            (name, part, *point)
            for part, points in parts.items()
            for point in points
        ]
    return Drawing(
        drawn,
        columns(("model", "part", "x_mm", "y_mm", "z_mm"), rows),
        "Rays of six cameras that are not central (blue; black: where they "
        "start) and their caustics, the points where neighbouring rays "
        "meet (orange and green: the two sheets). A caustic behind a mirror "
        "is virtual; of a round one only the far half is drawn. Each camera "
        "has a scale of its own.",
        scene=_scene(cameras),
    )


def _draw(panel, one, round_one):
    ends = np.stack([one.origins, one.ends], axis=1)
    # One line with gaps: many rays, one artist.
    gaps = np.full((len(ends), 1, 3), np.nan)
    path = np.concatenate([ends, gaps], axis=1).reshape(-1, 3)
    panel.plot(*in_axes(path), color=BLUE, lw=0.45, ls="-", marker="")
    dots(panel, one.origins, INK, 1.0)
    for k, colour in enumerate(SHEETS):
        dots(
            panel, one.sheet(k, round_one), colour, 1.0 if round_one else 2
        )
    name_axes(panel, SIDE if round_one else OBLIQUE)
    panel.tick_params(labelsize=6, pad=-2)


def _scene(cameras):
    """All six side by side, each scaled to the same length of rays."""
    parts = []
    for number, (name, one) in enumerate(cameras.items()):
        row, column = divmod(number, 3)
        scale = SCENE_MM / DRAWN_MM[name]
        shift = np.array([700.0 * column, 700.0 * row, 0.0])

        def placed(points, one=one, scale=scale, shift=shift):
            return scale * (points - one.middle) + shift

        own = "" if number else "{}"
        parts.append(
            Segments(
                placed(one.origins),
                placed(one.ends),
                BLUE,
                own.format("ray"),
                1.0,
            )
        )
        parts.append(
            Points(placed(one.origins), INK, own.format("ray start"), 4.0)
        )
        for k, colour in enumerate(SHEETS):
            sheet = one.sheet(k)
            if len(sheet):
                label = own.format(f"caustic, sheet {k + 1}")
                parts.append(Points(placed(sheet), colour, label, 4.0))
    names = ", ".join(cameras)
    return Scene(
        parts,
        (700.0, -500.0, -1900.0),
        (700.0, 350.0, 0.0),
        note="Row by row: " + names + ". Each camera is scaled to rays of "
        "the same length.",
    )
