"""What a study of a mirror set says, whatever happened."""

import numpy as np

from repro.page.wording import literal

STUDY = "mirror_study"


class MirrorStudy:
    """The result of `mirror_study` for one mirror set.

    refusal: why there is no calibration, empty where there is; stages: their number;
    flags: texts.
    """

    def __init__(self, result):
        self.result, self.settings = result, result.settings
        self.refusal = result.texts("reason")[0] or ""
        self.stages = 0 if self.refusal else 1 + len(self.settings["steps"])
        told = "" if self.refusal else result.texts("flags")[0] or ""
        self.flags = told.splitlines()

    def number(self, name, stage=None):
        """A number of the calibration, or of one of its stages."""
        return float(self.result.column(_of(name, stage))[0])

    def array(self, name, stage=None):
        """An array of the calibration, or of one of its stages."""
        return self.result.arrays(_of(name, stage))[0]

    def moved_mm(self, stage):
        """How far the end of a stage's profile is off the first shape, mm."""
        along, height = self.array("along"), self.array("height")
        before = np.interp(along[stage, -1], along[0], height[0])
        return float(height[stage, -1] - before)

    def name(self, stage):
        """The photograph that a stage is drawn over."""
        return self.result.texts(_of("shown", stage))[0]


def _of(name, stage):
    return name if stage is None else f"stage{stage}.{name}"


def about(study):
    """What was photographed, with what."""
    s, camera = study.settings, literal(study.settings["camera"])
    text = f"The camera: {camera}. " if camera else ""
    steps = len(s["steps"])
    return (
        f"{text}Its pictures are {s['width_px']} × {s['height_px']} px. The mirror was "
        f"bent {steps} time{'s' * (steps > 1)}, with a board before it; before that a "
        f"monitor stood in {len(s['places'])} places."
    )


def found(study):
    """What came of it."""
    if study.refusal:
        return f"There is no calibration: {literal(study.refusal)}."
    last = study.stages - 1
    return (
        f"All {study.stages} shapes were found. Rays of the first meet within "
        f"{study.number('meet_mm'):.3f} mm, and the monitor's places are "
        f"{study.number('apart_mm'):.2f} mm apart (standard deviation "
        f"{study.number('apart_sd_mm'):.2f}). At stage {last} the mean residual is "
        f"{study.number('residual_mm', last):.3f} mm, and rays are predicted to "
        f"{study.number('predicted_deg', last):.3f} degrees among the corners."
    )


def flagged(study):
    """What the calibration says against itself."""
    if study.refusal:
        return "Nothing else is told of a calibration that is refused."
    if not study.flags:
        return "Nothing is flagged."
    return f"Flagged: {'; '.join(literal(text) for text in study.flags)}."
