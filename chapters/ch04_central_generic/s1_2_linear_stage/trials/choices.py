"""What the choices that the linear stage leaves are worth, in mm of the centre."""

from chapters.ch04_central_generic.s1_2_linear_stage.trials.outliers import centre_off
from chapters.shared.wide_angle import SETTINGS, draw_scene, wide_lens
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

NOISE_PX = 0.5
TRIALS = {"quick": 6, "full": 60}
CHOICES = {
    "as in the thesis": {},
    "weighted": {"weights": "image noise"},
    "RANSAC": {"robust": "ransac"},
}


def choices_trial(condition, rng):
    """The centre's error (mm) with each of CHOICES on the same points."""
    camera = wide_lens(condition["fov_deg"])
    seen = draw_scene(camera, NOISE_PX, rng, grids=condition["grids"])
    found = {}
    for name, options in CHOICES.items():
        more = {"rng": rng} if "robust" in options else {}
        found[name] = centre_off(seen.noisy, **options, **more)[0]
    return found


@experiment(
    "ext_linear_choices_trials", artefact="ext_linear_choices", shards={"full": 2}
)
def choices(effort):
    """Weights and RANSAC, for two lenses and three or ten grids."""
    conditions = crossed(fov_deg=(100, 150), grids=(3, 10))
    settings = SETTINGS | {"noise_px": NOISE_PX}
    return Plan(choices_trial, conditions, TRIALS[effort], settings)
