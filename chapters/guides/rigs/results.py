"""What the poses of the rigs say, and the words of the page about each."""

from chapters.guides.rigs.trials import NAMES


def uses_of(ran, name):
    """Use of each pose of a rig: those to evaluate with come last."""
    count = len(ran.arrays("T_camera_target", rig=name)[0])
    evaluate = int(ran.column("evaluate", rig=name)[0])
    return ["calibrate"] * (count - evaluate) + ["evaluate"] * evaluate


def facts(ran):
    """Names and texts for the prose: what each rig is, and its sizes."""
    every = ran.select()
    seen = every.column("seen_deg")
    found = {
        "rigs": len(NAMES),
        "least_deg": f"{seen.min():.0f}",
        "most_deg": f"{seen.max():.0f}",
        "poses": sum(map(len, every.arrays("distance_mm"))),
        "whole": int(every.column("whole").sum()),
    }
    for name, summary in zip(NAMES, every.texts("summary"), strict=True):
        short = name.replace("-", "_")
        found[f"{short}.summary"] = summary[0].upper() + summary[1:]
        found[f"{short}.sizes"] = _sizes(ran, name)
    return found


def _sizes(ran, name):
    one = ran.one(rig=name)
    width, height, seen, extra = (
        one.column(value)[0]
        for value in ("width_px", "height_px", "seen_deg", "evaluate")
    )
    distances, tilts = (one.arrays(value)[0] for value in ("distance_mm", "tilt_deg"))
    poses = _counted(len(tilts) - int(extra)) + (
        f" and {extra:.0f} more to evaluate with" if extra else ""
    )
    return (
        f"The picture has {width:.0f} x {height:.0f} px, and its field of "
        f"view is {seen:.0f}° wide. Target: {one.texts('target')[0]}; "
        f"{poses}, {_range(distances, ' mm')} away and tilted by "
        f"{_range(tilts, '°')}"
    )


def _counted(poses):
    return "one pose" if poses == 1 else f"{poses} poses"


def _range(numbers, unit):
    low, high = (f"{x:.0f}" for x in (numbers.min(), numbers.max()))
    return f"{low}{unit}" if low == high else f"{low} to {high}{unit}"
