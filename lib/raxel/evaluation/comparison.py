"""Camera models on the same views, scored on the same points, each kept out once.

Points are the corners of boards, or what pixels have read of grids. A table has rays
only where these were; a formula has them everywhere, also where it is wrong. So every
point counts, and one that a model has no ray for counts as if it were far off.
Beside that, all models are scored on the points that all of them can answer for.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.views.near_copies import near_copies
from raxel.errors import CalibrationError
from raxel.evaluation.cross_validation import cross_validate

# What a point counts as that a model has no ray for, and the most that any counts as.
MISSED_PX = 5.0
# Models whose errors are this near to the smallest are as good: the simplest is taken.
AS_GOOD = 1.02


class ModelComparison(NamedTuple):
    """Cross-validated scores of several models, the simplest first.

    own: {model: Evaluation} on all corners; common: the same on the corners that every
    model in `own` answers for, from boards kept out of all of them ({} if there are
    none); refused: {model: reason} for models that gave no camera at all; errors_px:
    {model: px}, by which they are ranked: RMS distance of all kept-out corners, where a
    corner without a ray counts as MISSED_PX and none counts as more.
    """

    own: dict
    common: dict
    refused: dict
    errors_px: dict

    def best(self):
        """The model that predicts best; see `choice`."""
        return self.choice()[0]

    def choice(self):
        """(the best model, why it is the best, in words).

        The best is the first of those whose error is at most AS_GOOD times the
        smallest. Raises CalibrationError if no model is left.
        """
        if not self.own:
            raise CalibrationError("; ".join(self.refused.values()), code="no-camera")
        errors = {m: self.errors_px[m] for m, e in self.own.items() if e.n_scored}
        if not errors:
            raise CalibrationError(
                "cross-validation: no model answers for six points of a view that was"
                " kept out; take more views that share areas of the image",
                code="no-overlap",
            )
        if len(errors) == 1:
            alone = len(self.own) == 1
            what = "gave a camera" if alone else "answers for a view kept out"
            return next(iter(errors)), f"no other model {what}"
        least = min(errors, key=errors.get)
        best = next(m for m in errors if errors[m] <= AS_GOOD * errors[least])
        counted = f"where one without a ray counts as {MISSED_PX:g} px"
        if best == least:
            return best, (
                f"the smallest error on kept-out points, {errors[best]:.3g} px RMS, "
                + counted
            )
        return best, (
            f"on kept-out points, {counted}, as good as {least}"
            f" ({errors[best]:.3g} and {errors[least]:.3g} px RMS), and simpler"
        )

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
        return doubts


def compare_models(builders, views, folds):
    """Cross-validate models on the same parts of `views`.

    builders: {model: callable, as `cross_validate` takes}; views: BoardViews or
    DenseViews with different names; folds: number of parts, fewer where fewer views are
    no near copies of others, which stay in one part. Give the simplest model
    first. Returns ModelComparison.
    """
    cameras = {model: _Remembering(build) for model, build in builders.items()}
    own, refused, parts = {}, {}, _parts(views, folds)
    for model, build in cameras.items():
        try:
            own[model] = cross_validate(build, views, parts)
        except CalibrationError as fault:
            refused[model] = str(fault)
    common = _on_shared(cameras, own, views, parts) if len(own) > 1 else {}
    errors = {model: counted_error_px(found, views) for model, found in own.items()}
    return ModelComparison(own, common, refused, errors)


def counted_error_px(evaluation, views):
    """RMS distance in px of all corners of the views, none of which is left out: one
    without a ray, or in a view without a camera, counts as MISSED_PX, and none as more.
    """
    count = sum(np.count_nonzero(np.isfinite(view.pixels[:, 0])) for view in views)
    off = np.concatenate([image.residuals_px for image in evaluation.images])
    off = np.linalg.norm(off[np.isfinite(off[:, 0])], axis=1)
    squares = np.sum(np.minimum(off, MISSED_PX) ** 2)
    squares += (count - len(off)) * MISSED_PX**2
    return float(np.sqrt(squares / count)) if count else np.nan


def _parts(views, folds):
    """Indices of the views of each part, near copies in one, but where all views are
    copies of one."""
    groups = np.unique(near_copies(views), return_inverse=True)[1]
    if not groups.any():
        groups = np.arange(len(views))
    folds = min(folds, groups.max() + 1)
    return [np.flatnonzero(groups % folds == part) for part in range(folds)]


def _on_shared(cameras, own, views, parts):
    """Evaluations on the corners that all answer for; {} where there are none.

    Without the others a board has another pose, at which a model may miss a corner that
    it had: this goes round until all answer for all.
    """
    parts = _parts_of_all(own, parts)
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


def _parts_of_all(evaluations, parts):
    """The parts that every model gave a camera for."""
    folds_of = [{score.fold for score in e.images} for e in evaluations.values()]
    whole = set.intersection(*folds_of)
    return [parts[fold] for fold in sorted(whole)]
