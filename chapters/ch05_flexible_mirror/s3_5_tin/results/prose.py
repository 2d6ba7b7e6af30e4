"""Numbers quoted on the page: medians, as words, over the runs that have a tin."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.results.predicates import distances_normal
from chapters.ch05_flexible_mirror.s3_5_tin.results.runs import RUNS, TinRuns
from chapters.ch05_flexible_mirror.s3_5_tin.trials.run import MATCHES
from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import tin_points, two_places
from chapters.shared.mirror_bench import LABORATORY, LEVEL
from chapters.shared.mirror_rigs import mirror_rig
from raxel.geometry import transform
from repro.page.reader import value

BENT_MM = 15.0


def in_words(number):
    """A number below 10 with two digits, a larger one as a whole number."""
    return f"{number:.2g}" if abs(number) < 10 else f"{number:.0f}"


def middle(found):
    """Median of the runs that have a value, as words; "no" without any."""
    known = found[np.isfinite(found)]
    return in_words(np.median(known)) if len(known) else "no"


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {RUNS: open_results(RUNS)}
    runs = TinRuns(results, bench=LEVEL)
    value("true.off", middle(runs.of("off_deg", "true")))
    _, least, _, _ = distances_normal(runs)
    value("normal.least", middle(least))
    low_noise = TinRuns(results, bench=LABORATORY)
    for name, measure in (("off", "off_deg"), ("rms", "rms_mm")):
        value(f"lab.published.{name}", middle(low_noise.of(measure)))
    way_mm, degrees = meeting_rays()
    value("way", way_mm)
    value("meet", degrees)


def meeting_rays():
    """Return the mean distance of the tin's points from the mirror, mm, and the mean
    angle at which the two rays of each meet, degrees; one tin, geometry A."""
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
