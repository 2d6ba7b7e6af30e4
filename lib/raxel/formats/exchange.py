"""Export of a camera to the file of another program, and import from one."""

from __future__ import annotations

from os import PathLike
from pathlib import PurePath
from typing import NamedTuple

import numpy as np

from raxel.cameras.core.base import Camera, pixel_grid
from raxel.cameras.lenses.moving_pupil import AxialCamera, MovingPupilCamera
from raxel.errors import InputError, did_you_mean
from raxel.formats.conventions import FORMATS, TABLES
from raxel.formats.files import READERS, WRITERS, Record
from raxel.formats.models import LACKING, camera_of, equals_of, parameters
from raxel.formats.refit import angles_of, refit, refit_own, sample_of
from raxel.io.documents import one_line
from raxel.io.files import replacing, write_whole
from raxel.multiview.views import perspective_view, source_pixels

MAX_RESIDUAL_PX = 0.5


class Export(NamedTuple):
    """What a file of another program holds of a camera.

    Attributes
    ----------
    format, model : str
        Format, and name of the model in it.
    exact : bool
        Whether the model equals that of the camera; otherwise it is refitted.
    residuals : dict of str to (float, float)
        RMS and largest residual of the rays by area of the image, px: 'under the
        boards' and 'beyond', or 'in the whole image' if the camera file does not
        contain the area that boards covered.
    angle_deg : float
        Largest angle to the axis that the file holds, deg.
    held : float
        Share of the camera's rays that the file holds.
    pupil_mm : float
        Largest distance of a ray from the centre of the file's camera, if the entrance
        pupil moves, mm.
    R_format_camera : ndarray, shape (3, 3)
        Directions in the camera frame of the format from those in that of Raxel.
    """

    format: str
    model: str
    exact: bool
    residuals: dict[str, tuple[float, float]]
    angle_deg: float
    held: float
    pupil_mm: float
    R_format_camera: np.ndarray

    def lines(self) -> list[str]:
        """Return the model, its residuals, its field of view and the conventions."""
        form = FORMATS[self.format]
        areas = [
            f"{area} {rms:.2g} px RMS, {largest:.2g} px at most"
            for area, (rms, largest) in self.residuals.items()
        ]
        lines = [
            f"{self.model}, {'exact' if self.exact else 'refitted'}",
            f"residual {', '.join(areas)}",
            f"field of view up to {self.angle_deg:.1f} deg from the axis, "
            f"{100 * self.held:.0f} % of the rays",
            f"centre of the first pixel ({form.first_pixel:g}, {form.first_pixel:g}), "
            f"{form.axes}, unit {form.unit}",
        ]
        if self.pupil_mm:
            lines.append(
                f"for far points: rays pass {self.pupil_mm:.3g} mm (pitches where the "
                "pitch is unknown) from the centre"
            )
        if not np.allclose(self.R_format_camera, np.eye(3), rtol=0, atol=5e-7):
            rows = self.R_format_camera.round(6).tolist()
            lines.append(f"R_format_camera {rows}")
        return lines


def export_camera(
    camera: Camera, path: str | PathLike[str], format: str, allow_residual: bool = False
) -> Export | None:
    """Write a camera to a file of another program, whole or not at all.

    If no model of the format equals that of the camera, the richest ones are refitted
    to its rays, with a rotation. The one with the smallest RMS residual under the
    boards is written. The file states the residuals, the field of view and the
    conventions.

    Parameters
    ----------
    camera : Camera
        A central camera, or one whose entrance pupil moves. For ``table``, any.
    path : str or path-like
        File to write.
    format : str
        A key of `raxel.formats.conventions.FORMATS`; ``maps``, an .npz file with
        `mapx` and `mapy` of a perspective view (height, width) float32, its `K` and
        `R_camera_view`; or ``table``, one with the rays of all pixels: `origins` and
        `directions` (height, width, 3) in the camera frame, NaN without a ray.
    allow_residual : bool
        Write also a model with an RMS residual above 0.5 px under the boards.

    Returns
    -------
    Export or None
        Model, residuals, field of view and conventions; None for maps and tables.

    Raises
    ------
    InputError
        The format is unknown or cannot hold the camera, the residual is too large, or
        the file cannot be written. The message is one line.

    Examples
    --------
    >>> import tempfile
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.formats import export_camera
    >>> K = [[800, 0, 320], [0, 800, 240], [0, 0, 1]]
    >>> camera = PerspectiveCamera(K, [-0.1], 640, 480)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     export_camera(camera, f"{folder}/cameras.txt", "colmap").model
    'OPENCV'
    """
    _check_format(format, [*FORMATS, *TABLES])
    if format in TABLES:
        arrays = _maps(camera) if format == "maps" else _table(camera)
        with replacing(path) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **arrays)
        return None
    pupil, sample, form = _pupil_shift(camera), sample_of(camera), FORMATS[format]
    equal = _equal(camera, form.models, sample)
    name, p, R, errors = equal or refit(camera, form.models, sample)
    held = np.isfinite(errors)
    if not held.any():
        raise InputError(f"--format {format}: no model holds a ray; give another one")
    if camera.board_cells is None:
        areas = {"in the whole image": held}
    else:
        areas = {
            "under the boards": held & sample.covered,
            "beyond": held & ~sample.covered,
        }
    export = Export(
        format,
        name,
        equal is not None,
        {key: _sizes(errors[area]) for key, area in areas.items() if area.any()},
        float(angles_of(R, sample)[held].max(initial=0.0)),
        float(held.mean()),
        pupil,
        form.R_format_camera @ R,
    )
    lines = export.lines()
    rms = next(iter(export.residuals.values()))[0]
    if rms > MAX_RESIDUAL_PX and not allow_residual:
        raise InputError(
            f"--format {format}: {name}: {lines[1]}; give --allow-residual, or another "
            "format"
        )
    p |= {axis: p[axis] + form.first_pixel for axis in ("cx", "cy")}
    p = {key: float(p[key]) for key in form.models[name].names.split()}
    record = Record(name, p, camera.width, camera.height, lines)
    write_whole(path, WRITERS[format](record, PurePath(path).suffix))
    return export


def _check_format(format, known):
    if format not in known:
        advice = f"{did_you_mean(format, known)} known are {', '.join(known)}".lstrip()
        raise InputError(f"--format: found {format!r}; {advice}")


def _sizes(errors):
    return float(np.sqrt(np.mean(errors**2))), float(errors.max())


def _pupil_shift(camera):
    """Largest distance of a ray from the origin, mm, 0 for a central camera."""
    if camera.central:
        return 0.0
    if not isinstance(camera, (MovingPupilCamera, AxialCamera)):
        raise InputError(
            f"camera of kind {camera.kind}: its rays do not meet in one point, and no "
            "model of the formats holds that; give --format table"
        )
    rays = camera.rays(pixel_grid(camera.width, camera.height)[::97])
    arms = np.cross(rays.origins, rays.directions)[rays.valid]
    return float(np.linalg.norm(arms, axis=1).max())


def _equal(camera, models, sample):
    """As `refit`, of the first model that equals a camera, or None."""
    for formula, p in equals_of(getattr(camera, "lens", camera)):
        own = {name for name, value in p.items() if value != LACKING.get(name, 0)}
        for name, model in models.items():
            if model.formula == formula and own <= set(model.names.split()):
                held = angles_of(np.eye(3), sample) < model.max_angle_deg
                errors = np.where(held, 0.0, np.nan)
                return name, parameters(p, p.values()), np.eye(3), errors
    return None


def _maps(camera):
    view = perspective_view(camera)
    mapx, mapy = np.moveaxis(source_pixels(camera, view), -1, 0)
    return {
        "mapx": mapx,
        "mapy": mapy,
        "K": view.K,
        "R_camera_view": view.R_camera_view,
    }


def _table(camera):
    rays = camera.rays(pixel_grid(camera.width, camera.height))
    shape = camera.height, camera.width, 3
    return {
        "origins": rays.origins.reshape(shape),
        "directions": rays.directions.reshape(shape),
    }


def import_camera(path: str | PathLike[str], format: str) -> Camera:
    """Return the camera in a file of another program.

    Parameters
    ----------
    path : str or path-like
        File with one camera.
    format : str
        A key of `raxel.formats.files.READERS`.

    Returns
    -------
    Camera
        Camera whose rays are those of the file, with pixels and axes of Raxel.

    Raises
    ------
    InputError
        As `import_with_residual`.
    """
    return import_with_residual(path, format)[0]


def import_with_residual(
    path: str | PathLike[str], format: str
) -> tuple[Camera, tuple[float, float]]:
    """Return `import_camera`, and its RMS and largest residual to the file's model.

    If no camera of Raxel equals that model, the closest one is fitted to its rays.

    Parameters
    ----------
    path : str or path-like
        File with one camera.
    format : str
        A key of `raxel.formats.files.READERS`.

    Returns
    -------
    Camera, (float, float)
        The camera, and the residuals in px, 0 for an equal camera.

    Raises
    ------
    InputError
        The format or the model is unknown, a field is missing, a value is not finite,
        or the RMS residual is above 0.5 px. The message is one line that names file and
        field.
    """
    _check_format(format, READERS)
    form = FORMATS[format]
    try:
        model, values, *size = READERS[format](path)
        values, size = list(map(float, values)), list(map(float, size))
    except KeyError as fault:
        raise InputError(f"{path}: {fault.args[0]}: missing; add it") from fault
    except (ValueError, TypeError, IndexError, SyntaxError, AttributeError) as fault:
        # Only the messages of ValueErrors name what is in the file.
        known = type(fault) is ValueError and " object at " not in str(fault)
        reason = one_line(fault) if known else "fields of another form"
        raise InputError(
            f"{path}: not a camera of {format} ({reason}); correct the file"
        ) from fault
    if not np.isfinite([*values, *size]).all():
        raise InputError(f"{path}: parameters: not all finite; correct the file")
    model = model or list(form.models)[-1]
    if model not in form.models:
        raise InputError(
            f"{path}: model: found {model!r}; known are {', '.join(form.models)}"
        )
    names = form.models[model].names.split()
    if len(values) != len(names):
        raise InputError(
            f"{path}: parameters: found {len(values)}; {model} has {' '.join(names)}"
        )
    p = parameters(names, values)
    p["cx"] -= form.first_pixel
    p["cy"] -= form.first_pixel
    formula, errors = form.models[model].formula, np.zeros(1)
    try:
        camera = camera_of(formula, p, *size)
        if camera is None:
            formula, p, errors = refit_own(form.models[model], p, *size)
            camera = camera_of(formula, p, *size)
    except InputError as fault:
        raise InputError(f"{path}: {fault}") from fault
    rms, largest = _sizes(errors)
    if not rms <= MAX_RESIDUAL_PX:
        raise InputError(
            f"{path}: model: {model} differs by {rms:.2g} px RMS from every camera of "
            "raxel; calibrate with raxel"
        )
    return camera, (rms, largest)
