"""Figures of the camera zoo: curves, fits, rays and caustics, and a room."""

import numpy as np

from chapters.ch02_general_camera_model.s2_camera_models.results import NONE_PX, fits_of
from chapters.ch02_general_camera_model.s2_camera_models.trials.zoo import (
    DRAWN_MM,
    FAMILIES,
    LENSES,
    PANELS,
    PLANE_ANGLE,
    ROOM,
)
from raxel.show import Labels, Points, Segments, framed, moved
from repro.page.method_looks import LOOKS, named_in
from repro.page.space import draw_scene
from repro.page.style import INK, SERIES, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing


@figure("ext_zoo_curves", needs=("exp_zoo_curves",), evidence="analytic")
def ext_zoo_curves(results):
    """r(theta) of the round cameras, at the same scale on the axis."""
    ran = results["exp_zoo_curves"]
    drawn, axes = new_figure(1, 3, height_in=4.6, sharey=True)
    rows = []
    for panel, (title, names) in zip(axes, PANELS.items(), strict=True):
        grid = np.linspace(0, np.radians(125), 50)
        for index, name in enumerate(names):
            theta, r = (ran.arrays(part, model=name)[0] for part in ("theta", "r"))
            look = LOOKS.get(named_in(name), series(index))
            look = look | {"marker": "", "lw": 1.4}
            panel.plot(np.degrees(theta), r, label=name, **look)
            rows += [(name, *cells) for cells in zip(np.degrees(theta), r, strict=True)]
        tangent = grid[grid < 1.24]
        panel.plot(
            np.degrees(tangent),
            np.tan(tangent),
            color="#9aa5b1",
            lw=0.9,
            ls="-",
            marker="",
            label="pinhole",
        )
        panel.axvline(90, color="#9aa5b1", lw=0.8, ls=":", marker="")
        panel.set(xlim=(0, 125), ylim=(0, 2.6), title=title)
        panel.set(xlabel="Angle θ (deg)", xticks=[0, 30, 60, 90, 120])
        panel.legend(
            loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=7.5, frameon=False
        )
    axes[0].set_ylabel("Radius r / r′(0) (1)")
    return Drawing(
        drawn,
        columns(("model", "theta_deg", "r"), rows),
        "Projection curves $r(\\theta)$ of the radially symmetric example "
        "cameras, drawn from the rays of a row of pixels, at equal slope on "
        "the axis. Grey: the pinhole. The mirrors' angles count from the "
        "direction back to the viewer.",
    )


@figure("ext_zoo_fits", needs=("exp_zoo_fits",), evidence="synthetic")
def ext_zoo_fits(results):
    """Every round model fitted to two lenses: error and parameters."""
    ran = results["exp_zoo_fits"]
    drawn, axes = new_figure(1, 2, height_in=5.0, sharey=True, sharex=True)
    rows, falls = [], True
    for panel, lens in zip(axes, LENSES, strict=True):
        for index, family in enumerate(FAMILIES):
            free, rms = fits_of(ran, lens, family)
            plane = FAMILIES[family][0] == PLANE_ANGLE
            falls &= bool((np.diff(rms) <= NONE_PX).all())
            # Points that would hide each other stand side by side.
            shift = 0.05 * (index - 5.5)
            look = series(index) | {"linestyle": ":" if plane else "-"}
            if index >= len(SERIES):
                look["marker"] = "<>*ph"[index - len(SERIES)]
            if family in LOOKS:
                look |= LOOKS[family] | {"linestyle": look["linestyle"]}
            look["mfc"] = "white" if plane else look["color"]
            panel.plot(
                free + shift,
                np.maximum(rms, NONE_PX),
                label=family + (" (70°)" if plane else ""),
                lw=1.0,
                **look,
            )
            to_deg = np.degrees(FAMILIES[family][0])
            rows += [
                (lens, family, int(n), error, to_deg)
                for n, error in zip(free, rms, strict=True)
            ]
        panel.set(yscale="log", title=f"Lens: {lens}", xticks=range(1, 6))
        panel.set_xlabel("Free radial parameters (1)")
    axes[0].set_ylabel("RMS radius error (px)")
    handles, labels = axes[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8)
    return Drawing(
        drawn,
        columns(("lens", "model", "free", "rms_px", "to_deg"), rows),
        "Every radially symmetric model fitted to two lenses of 183°: RMS "
        "error of the radius against the number of radial parameters (centre, "
        "aspect and skew are not counted). Open markers: models of the "
        "image plane, fitted up to 70° only. Errors below $10^{-6}$ px "
        "are drawn there: the model contains the lens. Models with equally "
        "many parameters are drawn side by side.",
        Check(falls, "more terms never fit worse"),
    )


@figure("ext_zoo_room", needs=("exp_zoo_room",), evidence="rendered")
def ext_zoo_room(results):
    """The same room through eight cameras."""
    ran = results["exp_zoo_room"]
    drawn, axes = new_figure(2, 4, height_in=4.3)
    rows = []
    for panel, name in zip(axes.flat, ROOM, strict=True):
        panel.imshow(ran.arrays("picture", model=name)[0])
        panel.set_title(name, fontsize=8.5)
        panel.set_axis_off()
        cells = (ran.column(what, model=name)[0] for what in ("mean", "seen"))
        rows.append((name, *cells))
    return Drawing(
        drawn,
        columns(("model", "mean_radiance", "share_lit"), rows),
        "The same room from its middle, through eight cameras. The viewer of "
        "the hyperboloid mirror looks up; that of the plane mirrors has the "
        "room's windows behind it.",
    )


BLUE, ORANGE, GREEN = (series(k)["color"] for k in range(3))
SHEETS = (ORANGE, GREEN)
# Cameras of revolution are drawn with half of the caustic: the other half
# would hide it.
ROUND = ("spherical mirror", "hyperboloid off the focus", "axial")
SIGHT = (0.62, 0.42, 0.66)
PANEL_ASPECT = 0.8
# Caustic points farther off than this many drawn lengths are left out.
REACH = 1.5
SCENE_MM = 200.0


class DrawnModel:
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


@figure("ext_zoo_rays", needs=("exp_zoo_rays",), evidence="analytic", scene=True)
def ext_zoo_rays(results):
    """Rays and caustics of six cameras that are not central."""
    ran = results["exp_zoo_rays"]
    cameras = {name: DrawnModel(ran, name) for name in DRAWN_MM}
    drawn, axes = new_figure(2, 3, height_in=6.2)
    drawn.set_layout_engine("none")
    rows = []
    for number, (panel, (name, one)) in enumerate(
        zip(axes.flat, cameras.items(), strict=True)
    ):
        down, across = divmod(number, 3)
        panel.set_position([0.33 * across + 0.005, 0.49 - 0.49 * down, 0.31, 0.46])
        panel.set_title(name, fontsize=9.5)
        # The caption says what a legend in each panel would.
        parts = moved(_parts(one, name in ROUND), np.eye(4), unlabelled=True)
        draw_scene(panel, framed(parts, SIGHT, aspect=PANEL_ASPECT))
        parts = {"ray start": one.origins, "ray end": one.ends}
        parts |= {f"caustic sheet {k + 1}": one.sheet(k) for k in (0, 1)}
        rows += [
            (name, part, *point) for part, points in parts.items() for point in points
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


def _parts(one, half):
    """Rays, their starts and the caustic of one camera, or half of it."""
    sheets = [one.sheet(k, half) for k in range(len(SHEETS))]
    return [
        Segments(one.origins, one.ends, BLUE, "ray", 1.0),
        Points(one.origins, INK, "ray start", 3.5),
        *(
            Points(sheet, colour, f"caustic, sheet {number}", 4.0)
            for number, (sheet, colour) in enumerate(
                zip(sheets, SHEETS, strict=True), 1
            )
            if len(sheet)
        ),
    ]


def _scene(cameras):
    """All six side by side, each scaled to the same length of rays."""
    parts = []
    for number, (name, one) in enumerate(cameras.items()):
        row, column = divmod(number, 3)
        scale = SCENE_MM / DRAWN_MM[name]
        T = np.eye(4)
        T[:3, 3] = [700.0 * column, 700.0 * row, 0.0] - scale * one.middle
        parts += moved(_parts(one, half=False), T, unlabelled=number > 0, scale=scale)
        parts.append(Labels([T[:3, 3] + scale * one.middle], [name], INK))
    return framed(
        parts,
        (0.0, 0.4, 0.9),
        note="Each camera is scaled to rays of the same length.",
        scale="",
    )
