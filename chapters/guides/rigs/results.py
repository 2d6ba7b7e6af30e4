"""What the poses of the rigs say, and the words of the page about each."""

from chapters.guides.rigs.trials import NAMES


def uses_of(ran, name):
    """Use of each pose of a rig: those to evaluate with come last."""
    count = len(ran.arrays("T_camera_target", rig=name)[0])
    evaluate = int(ran.column("evaluate", rig=name)[0])
    return ["calibrate"] * (count - evaluate) + ["evaluate"] * evaluate


def facts(ran):
    """Names and texts for the prose: what each rig is, and its sizes."""
    seen = [float(ran.column("seen_deg", rig=name)[0]) for name in NAMES]
    count = [len(ran.arrays("distance_mm", rig=name)[0]) for name in NAMES]
    whole = [int(ran.column("whole", rig=name)[0]) for name in NAMES]
    found = {
        "rigs": len(NAMES),
        "least_deg": f"{min(seen):.0f}",
        "most_deg": f"{max(seen):.0f}",
        "poses": sum(count),
        "whole": sum(whole),
    }
    for name in NAMES:
        short = name.replace("-", "_")
        (summary,) = ran.texts("summary", rig=name)
        found[f"{short}.summary"] = summary[0].upper() + summary[1:]
        found[f"{short}.sizes"] = _sizes(ran, name)
    return found


def pose_numbers(ran, name):
    """Distances (mm) and tilts (deg) of the targets of a rig, each (poses,)."""
    return [ran.arrays(column, rig=name)[0] for column in ("distance_mm", "tilt_deg")]


def _sizes(ran, name):
    width, height, seen = (
        ran.column(value, rig=name)[0]
        for value in ("width_px", "height_px", "seen_deg")
    )
    (target,) = ran.texts("target", rig=name)
    distances, tilts = pose_numbers(ran, name)
    uses = uses_of(ran, name)
    extra = uses.count("evaluate")
    poses = _counted(len(uses) - extra) + (
        f" and {extra} more to evaluate with" if extra else ""
    )
    return (
        f"The picture has {width:.0f} x {height:.0f} px, and its field of "
        f"view is {seen:.0f}° wide. Target: {target}; "
        f"{poses}, {_range(distances, ' mm')} away and tilted by "
        f"{_range(tilts, '°')}"
    )


def _counted(poses):
    return "one pose" if poses == 1 else f"{poses} poses"


def _range(numbers, unit):
    low, high = (f"{x:.0f}" for x in (numbers.min(), numbers.max()))
    return f"{low}{unit}" if low == high else f"{low} to {high}{unit}"
