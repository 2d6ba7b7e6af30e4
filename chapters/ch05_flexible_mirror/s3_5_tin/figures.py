"""Textured model of the tin, and distances of its points from their planes."""

import numpy as np
from scipy.stats import norm

from chapters.ch05_flexible_mirror.s3_5_tin.results.runs import (
    PICTURES,
    PUBLISHED,
    RUNS,
    WAYS,
)
from chapters.ch05_flexible_mirror.s3_5_tin.trials.faces import usual
from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import FACES
from chapters.shared.mirror_bench import LEVEL, SAID
from raxel.show import Points, Surface, framed
from repro.page.space import draw_scene
from repro.page.style import INK, legend_below, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

UP, ASPECT, POINT_PX = (0.0, -1.0, 0.0), 1.0, 4.0
DRAWN_WAYS = ("true", PUBLISHED)
BINS = 25


def tin_model(result, bench=LEVEL, way=PUBLISHED):
    """(textured Surfaces and points, viewing direction (3,)) of the first run's tin.

    None where it has none.
    """
    parts = []
    for name in FACES:
        sheets = result.arrays(f"{bench}.{way}.sheet.{name}")
        if not sheets:
            return None
        texture = result.arrays(f"{bench}.{way}.texture.{name}")[0]
        parts.append(Surface(sheets[0], texture=texture))
    # Viewed along the faces' normals, from outside.
    inside = np.mean([np.mean(part.points, axis=(0, 1)) for part in parts], axis=0)
    sight = -sum(_outward(part.points, inside) for part in parts)
    points = result.arrays(f"{bench}.{way}.at")[0]
    parts.append(Points(points, series(1)["color"], "matched points", POINT_PX))
    return parts, sight / np.linalg.norm(sight)


def _outward(sheet, inside):
    """Unit normal (3,) of a sheet (2, 2, 3), away from a point."""
    normal = np.cross(sheet[0, 1] - sheet[0, 0], sheet[1, 0] - sheet[0, 0])
    away = np.mean(sheet, axis=(0, 1)) - inside
    return normal * np.sign(normal @ away) / np.linalg.norm(normal)


@figure("fig_5_22", needs=("fig_5_22_pictures",), evidence="rendered", scene=True)
def model_figure(results):
    """Image of the tin in the mirror, and its model."""
    result = results[PICTURES]
    bench, way = next(
        (b, w)
        for b, w in ((LEVEL, PUBLISHED), (LEVEL, "true"), ("laboratory", "true"))
        if tin_model(result, b, w) is not None
    )
    parts, sight = tin_model(result, bench, way)
    note = "Faces are planes through triangulated matches, coloured by calibrated rays."
    scene = framed(parts, tuple(sight), UP, note, aspect=ASPECT)
    drawn, axes = new_figure(1, 2, height_in=3.4)
    picture = result.arrays(f"{bench}.picture")[0]
    axes[0].imshow(picture, cmap="gray", vmin=0, vmax=255)
    axes[0].set(xticks=[], yticks=[])
    for panel, letter in zip(axes, "ab", strict=True):
        panel.set_title(f"({letter})")
    draw_scene(axes[1], scene)
    return Drawing(
        drawn,
        columns(
            ("face", "points"),
            [
                (name, int(np.sum(result.arrays(f"{bench}.{way}.face")[0] == k)))
                for k, name in enumerate(FACES)
            ],
        ),
        "The tin in the bent mirror, rendered (a), and its model (b): planes through "
        "matched features of each face, with the grey values of the image. Geometry A, "
        f"{SAID[bench]}, mirror: {WAYS[way]}. The mirror image is reversed, the model "
        "is not.",
        scene=scene,
    )


@figure("fig_5_23", needs=("table_5_8_runs",), evidence="rendered")
def distances_figure(results):
    """Histograms of the signed distances of each face, and normal curves."""
    result, rows = results[RUNS], []
    drawn, axes = new_figure(1, 3, height_in=3.0, sharey=True)
    came = [np.isfinite(result.column(f"{LEVEL}.{w}.rms_mm")) for w in DRAWN_WAYS]
    both = np.flatnonzero(np.logical_and.reduce(came))
    seed = both[0] if len(both) else 0
    for number, way in enumerate(DRAWN_WAYS):
        if not came[number][seed]:
            continue
        place = np.count_nonzero(came[number][:seed])
        distances, face = (
            result.arrays(f"{LEVEL}.{way}.{name}")[place]
            for name in ("distances", "face")
        )
        for k, panel in enumerate(axes):
            d = distances[face == k]
            look = series(number)["color"]
            counts, edges = np.histogram(d, BINS)
            width = edges[1] - edges[0]
            panel.stairs(counts, edges, color=look, fill=way == PUBLISHED,
                         alpha=0.6, label=WAYS[way])  # fmt: skip
            kept = d[usual(d)]
            x = np.linspace(edges[0], edges[-1], 100)
            curve = len(kept) * width * norm.pdf(x, kept.mean(), kept.std(ddof=1))
            panel.plot(x, curve, color=look, marker="", lw=1.4)
            rows += [
                (way, FACES[k], float(at), int(n))
                for at, n in zip(edges[:-1] + width / 2, counts, strict=True)
            ]
    for panel, name in zip(axes, FACES, strict=True):
        panel.set_title(f"{name.capitalize()} face")
        panel.set_xlabel("Signed distance (mm)")
        panel.axvline(0, color=INK, lw=0.6)
    axes[0].set_ylabel("Number of points")
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(("mirror", "face", "distance_mm", "count"), rows),
        "Signed distances of the tin's points from the plane of their face, positive "
        "outside, and normal curves of the same spread (outliers excluded), with the "
        "true mirror and with the published calibration. First run of the second level "
        "that has both.",
    )
