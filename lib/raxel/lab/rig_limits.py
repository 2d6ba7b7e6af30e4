"""What no picture of a rig could show: limits that join several of its numbers.

The schema bounds each number alone. Here each is held against the size of the picture
or of the target, before anything is computed with it.
"""

import math

from raxel.errors import InputError
from raxel.io.machine import physical_memory

# Peak memory of one pixel on its way through lens and sensor, per channel.
BYTES_PER_PIXEL = 150
# Blur of such an SD, as a share of the shorter side, spreads a point over a sixth of
# the picture: nothing of a target is left to find.
MOST_BLUR = 1 / 40
# An optical centre so many pictures away from the picture is none of this picture.
FARTHEST_CENTRE = 1.0
# Of a square or of a monitor's period: less has no middle.
LEAST_PX = 2
# Of the shorter side: a lens that moves farther has come off.
MOST_SHIFT = 0.1
# How often spots may cover the picture over and over.
MOST_COVERS = 10


def check_memory(camera, sensor):
    """Raise InputError where a picture takes more than half of the memory."""
    channels = 3 if "bayer" in sensor else 1
    need = camera.width * camera.height * BYTES_PER_PIXEL * channels
    if need > physical_memory() / 2:
        raise InputError(
            f"field 'camera.width': an image of {camera.width} x {camera.height} px "
            f"needs {need / 1e9:.3g} GB, more than half of this machine's "
            f"{physical_memory() / 1e9:.3g} GB; give fewer pixels"
        )


def check_limits(camera, optics, blemishes, target, poses):
    """Raise InputError, with the section's field, for what no picture can show.

    camera: the rig's; optics: its Optics; blemishes: its Blemishes; target, poses: the
    sections' values by name.
    """
    _check_centre(camera, optics)
    _check_blur(camera, optics)
    _check_blemishes(camera, blemishes)
    if target["kind"] == "chessboard":
        _check_board(camera, target)
    else:
        _check_patterns(target)
    _check_poses(camera, poses)


def _check_centre(camera, optics):
    if optics.centre_px is None:
        return
    for value, size in zip(
        optics.centre_px, (camera.width, camera.height), strict=True
    ):
        if not -FARTHEST_CENTRE <= value / size <= 1 + FARTHEST_CENTRE:
            raise InputError(
                f"field 'optics.centre.value': found {list(optics.centre_px)}; give a "
                f"pixel in the image of {_size(camera)} px, or at most its own size "
                "away from it"
            )


def _check_blur(camera, optics):
    most = MOST_BLUR * min(camera.width, camera.height)
    strongest = optics.strongest_blur_px(camera.width, camera.height)
    if strongest > max(most, 1):
        raise InputError(
            f"field 'optics.blur_sd.value': found {list(optics.blur_sd_px)}, up to "
            f"{strongest:.4g} px in the image of {_size(camera)} px; give at most "
            f"{max(most, 1):.4g}, a fortieth of its shorter side"
        )


def _check_blemishes(camera, blemishes):
    diagonal = math.hypot(camera.width, camera.height)
    for name in ("spot_radius", "glare_radius", "glare_within"):
        largest = getattr(blemishes, name)[1]
        if largest > diagonal:
            raise InputError(
                f"field 'blemishes.{name}.value': found {largest:g} px in an image of "
                f"{_size(camera)} px; give at most its diagonal"
            )
    area = blemishes.spots * math.pi * blemishes.spot_radius[1] ** 2
    if area > MOST_COVERS * camera.width * camera.height:
        raise InputError(
            f"field 'blemishes.spots.value': found {blemishes.spots} of up to "
            f"{blemishes.spot_radius[1]:g} px, which cover an image of {_size(camera)} "
            f"px more than {MOST_COVERS} times; give fewer or smaller ones"
        )


def _check_board(camera, target):
    columns, rows = target["columns"], target["rows"]
    if columns * rows * LEAST_PX**2 > camera.width * camera.height:
        raise InputError(
            f"field 'target.columns.value': {columns} x {rows} corners have squares of "
            f"less than {LEAST_PX} px in an image of {_size(camera)} px; give fewer"
        )


def _check_patterns(target):
    size = target["monitor_px"]
    for axis, bits, pixels in zip(
        "xy", target.get("gray_bits", (0, 0)), size, strict=True
    ):
        if 2**bits > pixels:
            raise InputError(
                f"field 'target.gray_bits.value': {bits} bits along {axis} make "
                f"{2**bits} cells on {pixels} px of the monitor; give at most "
                f"{int(math.log2(pixels))}"
            )
    _check_monitor_chessboard(target)
    periods = target.get("phase_periods", (0, 0))
    for axis, count, pixels in zip("xy", periods, size, strict=True):
        if count * LEAST_PX > pixels:
            raise InputError(
                f"field 'target.phase_periods.value': {count:g} periods along {axis} "
                f"are narrower than {LEAST_PX} of the monitor's {pixels} px; give at "
                f"most {pixels // LEAST_PX}"
            )


def _check_monitor_chessboard(target):
    board = target.get("chessboard")
    if not board:
        return
    for axis, count, first, pixels in zip(
        "xy",
        (board["columns"], board["rows"]),
        board["origin"],
        target["monitor_px"],
        strict=True,
    ):
        low, high = first - board["pitch"], first + count * board["pitch"]
        if low < 0 or high > pixels:
            raise InputError(
                f"field 'target.chessboard.origin.value': squares from {low:g} to "
                f"{high:g} along {axis} on {pixels} px of the monitor; give a smaller "
                "pitch, or another origin"
            )


def _check_poses(camera, poses):
    side = min(camera.width, camera.height)
    if 2 * poses["margin"] >= side:
        raise InputError(
            f"field 'poses.margin.value': found {poses['margin']:g} px, which leaves "
            f"nothing of an image of {_size(camera)} px; give less than half a side"
        )
    if poses["least_spacing"] > side:
        raise InputError(
            f"field 'poses.least_spacing.value': found {poses['least_spacing']:g} px "
            f"in an image of {_size(camera)} px; give less than its shorter side"
        )
    for index, entry in enumerate(poses.get("list", ())):
        if math.hypot(*entry.get("lens_shift", (0, 0))) > MOST_SHIFT * side:
            raise InputError(
                f"field 'poses.list[{index}].lens_shift.value': found "
                f"{list(entry['lens_shift'])} px in an image of {_size(camera)} px; "
                f"give at most {MOST_SHIFT * side:g}, a tenth of its shorter side"
            )
    axis = poses.get("axis", (0, 0, 1))
    if math.hypot(*axis) < 1e-6:
        raise InputError(
            f"field 'poses.axis.value': found {list(axis)}, which is no direction; "
            "give one such as [0, 0, 1]"
        )


def _size(camera):
    return f"{camera.width} x {camera.height}"
