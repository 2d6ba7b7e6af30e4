"""The result of a study, as figures, tables and prose read it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from raxel.evaluation import MISSED_PX
from repro.run import MIN_RATIO, SIGNIFICANCE

# The kinds of target of the sets that the study is of.
BOARDS = ("chessboard", "charuco")
NAMES = {"zhang": "Zhang", "general": "General camera"}

MODELS = ("zhang", "general")
# A common model for wide lenses: scored on the corners with a ray of both compared
# models, without a part in the decision.
PEER = "opencv_fisheye"
ALL_NAMES = {**NAMES, PEER: "OpenCV fisheye"}
# Scored on every corner, and compared with the others on these.
OTHERS = {
    "kannala_brandt": "Kannala-Brandt",
    "unified": "Unified sphere",
    "spline": "Smooth rays",
    "cgsp": "CGSP",
}
EVERY = ALL_NAMES | OTHERS


@dataclass(frozen=True)
class Image:
    """One image: whether and where the board was found, and a small copy."""

    index: int
    name: str
    use: str
    found: bool
    reason: str
    corners: np.ndarray
    columns: int | None
    thumbnail: np.ndarray


@dataclass(frozen=True)
class Score:
    """Errors of one model in one image.

    residuals_px (N, 2): detected corner minus prediction, NaN if it is missing.
    """

    corners: int
    rms_px: float
    mean_deg: float
    reason: str
    residuals_px: np.ndarray


@dataclass(frozen=True)
class Row:
    """Scores of one image: {model: Score} on own corners and on shared ones."""

    image: Image
    corners: int
    own: dict[str, Score]
    same: dict[str, Score]


class Study:
    """The result of `photograph_study` for one image set."""

    def __init__(self, result) -> None:
        self.result = result
        self.settings = result.settings

    def number(self, *path, **condition) -> float:
        """Return one number of a condition; nan if it is missing."""
        return float(self.result.column(*path, **condition)[0])

    def text(self, *path, **condition) -> str:
        """Return one text of a condition; empty if it is missing."""
        return self.result.texts(*path, **condition)[0] or ""

    def array(self, *path, **condition) -> np.ndarray | None:
        """Return one array of a condition; None if it is missing."""
        if not self.result.path.with_suffix(".npz").is_file():
            return None
        found = self.result.arrays(*path, **condition)
        return found[0] if found else None

    def fit(self, *path) -> float:
        """Return a number of the calibration from all images."""
        return self.number(*path, part="fit")

    def failure(self, model: str) -> str:
        """Return why the model gave no camera from all images; empty where it did."""
        return self.text(model, "reason", part="fit")

    @cached_property
    def images(self) -> list[Image]:
        """Every image of the study, in the order of the set."""
        taken = self.result.levels("view", part="image")
        return [self._image(index, self.settings["images"][index]) for index in taken]

    def image(self, index: int) -> Image:
        """The image of this number in the set."""
        return next(image for image in self.images if image.index == index)

    @property
    def found(self) -> list[Image]:
        """The images in which the board was found."""
        return [image for image in self.images if image.found]

    def _image(self, index: int, name: str) -> Image:
        here = {"part": "image", "view": index}
        columns = self.number("columns", **here)
        corners = self.array("corners", **here)
        return Image(
            index,
            name,
            self.settings["uses"][index],
            corners is not None,
            self.text("reason", **here),
            np.empty((0, 2)) if corners is None else corners,
            int(columns) if columns == columns else None,
            self.array("thumbnail", **here),
        )

    @property
    def folds(self) -> list[int]:
        """The parts of the cross-validation that hold out an image or more."""
        every = self.result.by("fold").items()
        return [fold for fold, one in every if one.column("kept_out")[0] > 0]

    def fold_failures(self, model: str) -> list[str]:
        """Return why the model gave no camera, for the parts where it gave none."""
        of_parts = (self.text(model, "reason", fold=fold) for fold in self.folds)
        return [reason for reason in of_parts if reason]

    @property
    def left_out(self) -> dict[int, str]:
        """Boards that the generic method excluded, with the reason."""
        reasons = {
            image.index: self.text("general.left_out", image.index, part="fit")
            for image in self.found
        }
        return {index: reason for index, reason in reasons.items() if reason}

    def why_nothing_held_out(self, model: str) -> str:
        """Return why the model has no error in any held-out image."""
        reasons = [self.failure(model), *self.fold_failures(model)]
        reasons += [row.own[model].reason for row in self.held_out if model in row.own]
        given = [reason for reason in reasons if reason]
        return given[0] if given else "no image was held out"

    @cached_property
    def in_sample(self) -> list[Row]:
        """Images that the cameras were calibrated from."""
        return [
            self._row(image, part="fit")
            for image in self.found
            if image.use == "calibrate"
        ]

    @cached_property
    def held_out(self) -> list[Row]:
        """Every image, scored by cameras that were calibrated without it.

        One for evaluation is scored by the cameras from all images for calibration,
        the others by those of the part that held them out.
        """
        scored = ((image, self._scored_in(image)) for image in self.found)
        return [self._row(image, **where) for image, where in scored if where]

    def _scored_in(self, image: Image) -> dict | None:
        if image.use != "calibrate":
            return {"part": "fit"}
        for fold in self.folds:
            if np.isfinite(self.number("views", image.index, "corners", fold=fold)):
                return {"fold": fold}
        return None

    def _row(self, image: Image, **condition) -> Row:
        path = ("views", image.index)
        corners = int(self.number(*path, "corners", **condition))
        scores = (
            {m: self._score(*path, m, kind, **condition) for m in names}
            for kind, names in (("own", EVERY), ("same", ALL_NAMES))
        )
        return Row(image, corners, *({m: s for m, s in k.items() if s} for k in scores))

    def _score(self, *path, **condition) -> Score | None:
        corners = self.number(*path, "corners", **condition)
        if not np.isfinite(corners):
            return None
        return Score(
            int(corners),
            self.number(*path, "rms_px", **condition),
            self.number(*path, "mean_deg", **condition),
            self.text(*path, "reason", **condition),
            self.array(*path, "residuals_px", **condition),
        )


def column(rows: list[Row], kind: str, model: str, quantity: str) -> np.ndarray:
    """One quantity of one model over rows, nan where the model has no score."""
    scores = [getattr(row, kind).get(model) for row in rows]
    return np.array([np.nan if s is None else getattr(s, quantity) for s in scores])


def paired(rows: list[Row], quantity: str) -> tuple[np.ndarray, np.ndarray]:
    """The quantity of (Zhang, general) on shared corners, where both have it."""
    zhang, general = (column(rows, "same", model, quantity) for model in MODELS)
    both = np.isfinite(zhang) & np.isfinite(general)
    return zhang[both], general[both]


def share_with_ray(rows: list[Row], model: str) -> float:
    """Share of the found corners that the model could be scored on."""
    scored = np.nansum(column(rows, "own", model, "corners"))
    return float(scored / max(sum(row.corners for row in rows), 1))


def pooled_rms(rows: list[Row], kind: str, model: str) -> float:
    """Root mean square distance in px over all corners of the rows."""
    squares = column(rows, kind, model, "rms_px") ** 2
    weights = column(rows, kind, model, "corners")
    good = np.isfinite(squares) & (weights > 0)
    if not good.any():
        return float("nan")
    return float(np.sqrt(np.average(squares[good], weights=weights[good])))


def counted(study, model):
    """Return errors of a model over every held-out corner; None without any.

    A corner without a ray, or in an image without a camera, counts as MISSED_PX.
    rms_px, median_px; share: corners with a ray; parts: of the
    cross-validation, without a camera.
    """
    off, count = [], 0
    for row in study.held_out:
        count += row.corners
        if score := row.own.get(model):
            lengths = np.linalg.norm(score.residuals_px, axis=1)
            off.append(lengths[np.isfinite(lengths)])
    if not count:
        return None
    known = np.concatenate([np.zeros(0), *off])
    every = np.append(known, np.full(count - len(known), MISSED_PX))
    return {
        "rms_px": float(np.sqrt(np.mean(every**2))),
        "median_px": float(np.median(every)),
        "share": len(known) / count,
        "parts": len(study.fold_failures(model)),
    }


def decided(won):
    """Return whether a paired comparison of images is decided in favour.

    There is no minimum number of images, because with few of them p cannot be small.
    """
    return won.p < SIGNIFICANCE and won.ratio.low >= MIN_RATIO
