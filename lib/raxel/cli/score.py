"""`raxel score SET --corners F --points FOLDER --camera F --json F`"""

from pathlib import Path

from raxel.cameras.io import load_camera
from raxel.cli.outputs import check_written
from raxel.cli.scores import percent
from raxel.errors import InputError
from raxel.evaluation.benchmark import score_camera, score_corners, score_points
from raxel.features.boards import read_boards
from raxel.io.files import check_can_be_written, write_json
from raxel.sets import load_set


def score(options, say):
    """Score what is given against the truth of a rendered set."""
    if not (options.corners or options.points or options.camera):
        raise InputError(
            f"{options.set}: nothing to score; give --corners, --points or --camera"
        )
    if options.json:
        check_can_be_written(options.json)
    image_set = load_set(options.set)
    read = options.camera, options.corners, options.points
    check_written([options.json], [image_set], read)
    result = {"set": image_set.name}
    if options.corners:
        say(f"corners of {options.corners}")
        boards = read_boards(options.corners, image_set)
        result["corners"] = score_corners(image_set, boards)
    if options.points:
        say(f"points in {options.points}")
        result["points"] = score_points(image_set, Path(options.points))
    if options.camera:
        say(f"camera {options.camera}")
        result["camera"] = score_camera(image_set, load_camera(options.camera))
    if options.json:
        write_json(options.json, result)
    for name, line in LINES.items():
        if name in result:
            print(f"{image_set.name}: {line(result[name])}")


def _corners_line(scored):
    return (
        f"corners: {scored['views']} views, {scored['found']} found, "
        f"{scored['right']} right, {_told(scored, 'px')}"
    )


def _points_line(scored):
    shares = [percent(scored[name]) for name in ("share_decoded", "gross")]
    return (
        f"points: {shares[0]} decoded, {shares[1]} of these gross, "
        f"{scored['beside']} px beside the monitor, {_told(scored, 'mm')}"
    )


def _camera_line(scored):
    return (
        f"camera: {percent(scored['share_with_ray'])} of pixels with a ray, "
        f"{_told(scored, 'deg')}, {_told(scored, 'px')}"
    )


def _told(scored, unit):
    names = "rms", "median", "max"
    values = [(name, scored[f"{name}_{unit}"]) for name in names]
    return ", ".join(
        f"{name} {'none' if value is None else f'{value:.4g} {unit}'}"
        for name, value in values
    )


LINES = {"corners": _corners_line, "points": _points_line, "camera": _camera_line}
