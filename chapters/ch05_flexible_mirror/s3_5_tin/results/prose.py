"""The numbers that the page quotes: medians, as words, over seeds that have a tin."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.results.predicates import (
    LEAST_NORMAL,
    angles_found,
    distances_normal,
)
from chapters.ch05_flexible_mirror.s3_5_tin.results.runs import (
    PICTURES,
    RUNS,
    WAYS,
    TinRuns,
)
from chapters.ch05_flexible_mirror.s3_5_tin.trials.run import MATCHES
from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import tin_points, two_places
from chapters.shared.mirror_bench import LABORATORY, LEVEL
from chapters.shared.mirror_rigs import mirror_rig
from raxel.geometry import transform
from repro.page.reader import value

SHORT = {LEVEL: "", LABORATORY: "lab."}
MEASURES = {"off": "off_deg", "rms": "rms_mm", "ray": "ray_deg"}
BENT_MM = 15.0


def said(number):
    """A number in two digits or in whole ones, as words; "no" where there is none."""
    if not np.isfinite(number):
        return "no"
    return f"{number:.2g}" if abs(number) < 10 else f"{number:.0f}"


def middle(found):
    """Median of the seeds that have a value, as words; a build may have none."""
    known = found[np.isfinite(found)]
    return said(np.median(known)) if len(known) else "no"


def name_values(open_results):
    """Name the numbers of the prose."""
    for name, found in of_runs({RUNS: open_results(RUNS)}).items():
        value(name, found)
    for name, found in of_pictures(open_results(PICTURES)).items():
        value(name, found)
    way_mm, degrees = meeting_rays()
    value("way", way_mm)
    value("meet", degrees)


def of_runs(results):
    """Name -> what prose quotes of the runs on both benches."""
    out = {}
    for bench, short in SHORT.items():
        runs = TinRuns(results, bench=bench)
        out[f"{short}seeds"] = runs.seeds
        for way in WAYS:
            for name, measure in MEASURES.items():
                out[f"{short}{way}.{name}"] = middle(runs.of(measure, way))
            out[f"{short}{way}.refused"] = sum(map(bool, runs.refused(way)))
            upright = runs.angles(way)[2]
            out[f"{short}{way}.upright"] = middle(upright)
        out |= {f"{short}{k}": v for k, v in _of_claims(runs).items()}
    return out


def _of_claims(runs):
    """What the claims ask of each seed, and how far the best one is off."""
    holds, most, _, _ = angles_found(runs)
    normal, least, _, _ = distances_normal(runs)
    of_true = runs.normality("true").min(axis=0)
    known = most[np.isfinite(most)]
    return {
        "count.angles": np.count_nonzero(holds),
        "count.normal": np.count_nonzero(normal),
        "count.true_normal": np.count_nonzero(of_true >= LEAST_NORMAL),
        "count.below": np.count_nonzero(np.all(runs.off() < 0, axis=0)),
        "normal.least": middle(least),
        "best": said(known.min()) if len(known) else "no",
    }


def of_pictures(result):
    """Name -> what prose quotes of the rendered pictures."""
    names = ("on_tin", "wrong", "match_px")
    out = {f"pic.{name}": middle(result.column(f"{LEVEL}.{name}")) for name in names}
    for way in ("true", "published"):
        out[f"pic.{way}.off"] = middle(result.column(f"{LEVEL}.{way}.off_deg"))
    for name, measure in (("left_out", "left_out"), ("kept", "wrong_kept")):
        out[f"pic.{name}"] = middle(result.column(f"{LEVEL}.true.{measure}"))
    return out | {"pic.seeds": result.trials_per_condition}


def meeting_rays():
    """How far the tin's points are from the mirror, mm, and the degrees at which the
    two rays of each meet: means over points of one tin, geometry A."""
    camera = mirror_rig("A").camera(BENT_MM)
    rng = np.random.default_rng(0)
    poses = two_places(camera, rng)
    points, _ = tin_points(rng, MATCHES)
    seen = [transform(T, points) for T in poses]
    rays = [camera.rays(camera.project(at).pixels) for at in seen]
    ways = [
        np.linalg.norm(at - r.origins, axis=1) for at, r in zip(seen, rays, strict=True)
    ]
    turns = np.einsum("ni,ni->n", *(r.directions for r in rays))
    return float(np.mean(ways)), float(np.degrees(np.mean(np.arccos(turns))))
