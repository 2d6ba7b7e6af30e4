"""Two camera models on the same photographs, scored on the same points.

Points are the corners of boards, or what pixels have read of grids. A general camera
has rays only where these were; a parametric one has them everywhere, also where it is
wrong. So every model is scored twice: on all points, with the share that it has a ray
for, and on those that all models can answer for.
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError
from raxel.evaluation.cross_validation import cross_validate

# Fewer common points, or of fewer views, do not tell models apart.
FEWEST_COMMON = 50
FEWEST_VIEWS = 3
# A model whose mean angle is larger than this many times another's does not fit.
FITS = 3.0


class ModelComparison(NamedTuple):
    """Cross-validated scores of several models.

    own: {model: Evaluation} on all corners; common: the same on the corners that every
    model in `own` answers for, from boards kept out of all of them ({} if there are
    none); refused: {model: reason} for models that gave no camera at all.
    """

    own: dict
    common: dict
    refused: dict

    def best(self):
        """The model that predicts best; see `choice`."""
        return self.choice()[0]

    def choice(self):
        """(the best model, why it is the best, in words).

        Those models are candidates that fit: whose mean angle on their own corners is
        at most FITS times the smallest. Of these the one with the smallest mean angle
        on the common corners is the best; where these are too few to tell, the one that
        answers for the most corners. Raises CalibrationError if no model is left.
        """
        if not self.own:
            raise CalibrationError("; ".join(self.refused.values()))
        angles = {m: e.mean_deg for m, e in self.own.items() if np.isfinite(e.mean_deg)}
        if not angles:
            raise CalibrationError(
                "cross-validation: no model answers for six points of a view that was"
                " kept out; take more views that share areas of the image"
            )
        if len(angles) == 1:
            alone = len(self.own) == 1
            what = "gave a camera" if alone else "answers for a view kept out"
            return next(iter(angles)), f"no other model {what}"
        fitting = [m for m in angles if angles[m] <= FITS * min(angles.values())]
        if len(fitting) == 1:
            return fitting[0], (
                f"its mean angle on kept-out views is less than 1 / {FITS:g} of any"
                " other's"
            )
        if self.common_is_enough():
            return min(fitting, key=lambda model: self.common[model].mean_deg), (
                "the smallest mean angle on kept-out points that all can answer for"
            )
        return max(fitting, key=lambda model: self.own[model].share_with_ray), (
            "rays for the most kept-out points; too few are common to all models"
        )

    def common_counts(self):
        """(corners, boards) that all models answer for."""
        scored = [
            image.n_corners - image.n_without_ray
            for evaluation in list(self.common.values())[:1]
            for image in evaluation.images
        ]
        return sum(scored), sum(count > 0 for count in scored)

    def common_is_enough(self):
        """Whether there are enough common corners, of enough boards, to compare on."""
        corners, boards = self.common_counts()
        return corners >= FEWEST_COMMON and boards >= FEWEST_VIEWS

    def doubts(self):
        """What makes the comparison unsure: a list of texts, each for one line."""
        doubts = []
        for model, evaluation in self.own.items():
            if evaluation.left_out:
                reason = next(iter(evaluation.left_out.values()))
                doubts.append(
                    f"{model}: {len(evaluation.left_out)} of the cross-validation's"
                    f" parts left out, where the other views gave no camera: {reason}"
                )
        if len(self.own) > 1 and not self.common_is_enough():
            points, views = self.common_counts()
            counted = f"for {points} common points of {views} views kept out"
            doubts.append(
                f"all models answer {counted if points else 'for no common point'}:"
                " too few to tell which is better"
            )
        return doubts


def compare_models(builders, views, folds):
    """Cross-validate models on the same parts of `views`.

    builders: {model: callable, list of views -> Camera}; views: BoardViews or
    DenseViews with different names; folds: number of parts. Returns ModelComparison.
    """
    cameras = {model: _Remembering(build) for model, build in builders.items()}
    own, refused = {}, {}
    for model, build in cameras.items():
        try:
            own[model] = cross_validate(build, views, folds)
        except CalibrationError as fault:
            refused[model] = str(fault)
    if len(own) < 2:
        return ModelComparison(own, {}, refused)
    return ModelComparison(own, _on_shared(cameras, own, views, folds), refused)


def _on_shared(cameras, own, views, folds):
    """Evaluations on the corners that all answer for; {} where there are none.

    Without the others a board has another pose, at which a model may miss a corner that
    it had: this goes round until all answer for all.
    """
    parts = _parts_of_all(own, views, folds)
    common = own
    while parts:
        views = _shared_corners(common, views)
        common = {model: cross_validate(cameras[model], views, parts) for model in own}
        shares = [evaluation.share_with_ray for evaluation in common.values()]
        if np.isnan(shares).all():
            break
        if min(shares) == 1:
            return common
    return {}


class _Remembering:
    """Builds a camera once for the same views, told by their names."""

    def __init__(self, build):
        self._build = build
        self._known = {}

    def __call__(self, views):
        key = tuple(view.name for view in views)
        if key not in self._known:
            self._known[key] = self._build(views)
        return self._known[key]


def _shared_corners(evaluations, views):
    """The views with only those corners that all can answer for."""
    scored = [{s.name: s for s in e.images} for e in evaluations.values()]
    shared = []
    for view in views:
        pixels = view.pixels.copy()
        for scores in scored:
            if view.name in scores:
                pixels[np.isnan(scores[view.name].residuals_px[:, 0])] = np.nan
        shared.append(view._replace(pixels=pixels))
    return shared


def _parts_of_all(evaluations, views, folds):
    """The parts that every model gave a camera for."""
    folds_of = [{score.fold for score in e.images} for e in evaluations.values()]
    whole = set.intersection(*folds_of)
    return [list(range(fold, len(views), folds)) for fold in sorted(whole)]
