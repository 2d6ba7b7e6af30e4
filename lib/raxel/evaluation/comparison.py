"""Two camera models on the same photographs, scored on the same corners.

A general camera has rays only where boards were; a parametric one has them everywhere,
also where it is wrong. So every model is scored twice: on all corners, with the share
that it has a ray for, and on those corners that all models can answer for.
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError
from raxel.evaluation.cross_validation import cross_validate


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
        """The model with the smallest mean angle on the common corners.

        Where there are none, the model that answers for the most corners. Raises
        CalibrationError if no model is left.
        """
        return self.choice()[0]

    def choice(self):
        """(the best model, why it is the best, in words); raises as `best`."""
        if not self.own:
            raise CalibrationError("; ".join(self.refused.values()))
        if len(self.own) == 1:
            return next(iter(self.own)), "no other model gave a camera"
        angles = {model: score.mean_deg for model, score in self.common.items()}
        if angles and np.isfinite(list(angles.values())).all():
            return min(angles, key=angles.get), (
                "the smallest mean angle on kept-out corners that all can answer for"
            )
        return max(self.own, key=lambda model: self.own[model].share_with_ray), (
            "rays for the most kept-out corners; none are common to all models"
        )


def compare_models(builders, views, folds):
    """Cross-validate models on the same parts of `views`.

    builders: {model: callable, list of BoardViews -> Camera}; views: BoardViews with
    different names; folds: number of parts. Returns ModelComparison.
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
    shared, parts = _shared_corners(own, views, folds)
    common = {}
    if parts:
        common = {model: cross_validate(cameras[model], shared, parts) for model in own}
    return ModelComparison(own, common, refused)


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


def _shared_corners(evaluations, views, folds):
    """The views with only those corners that all can answer for, and their parts."""
    scored = [{s.name: s for s in e.images} for e in evaluations.values()]
    shared = []
    for view in views:
        pixels = view.pixels.copy()
        for scores in scored:
            if view.name in scores:
                pixels[np.isnan(scores[view.name].residuals_px[:, 0])] = np.nan
        shared.append(view._replace(pixels=pixels))
    folds_of = [{score.fold for score in e.images} for e in evaluations.values()]
    whole = set.intersection(*folds_of)
    return shared, [list(range(fold, len(views), folds)) for fold in sorted(whole)]
