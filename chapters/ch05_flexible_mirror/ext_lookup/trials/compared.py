"""New deflections looked up in a table, and found by updating from a board."""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.ext_lookup.trials.table import (
    ENTRIES_MM,
    ERRORS,
    FEW,
    METHOD,
    TRACED_PX,
    edges_of,
    prepared,
)
from chapters.shared.mirror_runs import lattice, outline, seen_board
from chapters.shared.mirror_scores import load_height, ray_angles
from raxel.calibration.mirror.update import update_mirror
from raxel.cameras import FlexibleMirrorCamera
from raxel.errors import CalibrationError

# px between the pixels whose rays are compared.
COMPARED_PX = 96


class BentCase(NamedTuple):
    """A shape to be found: deflection, mm; rulings: degrees by which they run
    obliquely, None as when the table was made; before: the case from which the update
    comes, None for the table's first entry."""

    deflection: float
    before: str | None = None
    rulings_deg: float | None = None


# Between the entries of the table; on one; twisted as none of them is; beyond them.
CASES = {
    "between1": BentCase(2.5),
    "between2": BentCase(7.5, "between1"),
    "between3": BentCase(12.5, "between2"),
    "entry": BentCase(5.0, "between1"),
    "twisted": BentCase(7.5, "between1", 3.0),
    "twisted_more": BentCase(7.5, "between1", 8.0),
    "beyond": BentCase(18.0, "between3"),
}


def compared_trial(condition, rng):
    """Errors of rays and deflection of every case, by table and by update."""
    made = prepared(condition["geometry"], rng)
    true = {name: true_camera(made.rig, case) for name, case in CASES.items()}
    tables = {
        name: made.table(noise_px, rng) for name, noise_px in TRACED_PX.items()
    } | {"few": made.table(TRACED_PX["traced"], rng, FEW)}
    noise = TRACED_PX | {"few": TRACED_PX["traced"]}
    found = {
        f"{name}.{case}": looked_up(made, table, true[case], noise[name], rng)
        for name, table in tables.items()
        for case in CASES
    }
    return found | updates(made, true, rng)


def true_camera(rig, case):
    """The FlexibleMirrorCamera of a case."""
    if case.rulings_deg is None:
        return rig.camera(case.deflection)
    fields = rig.rig.camera.arguments()
    turned = np.radians(case.rulings_deg)
    return FlexibleMirrorCamera(
        **fields | {"deflections": case.deflection, "rulings": turned}
    )


def looked_up(made, table, true, noise_px, rng):
    """What a table gives for a mirror whose boundary is traced with an error."""
    edges = edges_of(true)
    found = table.look_up(edges + rng.normal(0, 1, edges.shape) * noise_px)
    return scores(made, true, found.camera) | {
        "off_px": found.off_px,
        "flagged": bool(found.flags),
    }


def updates(made, true, rng):
    """The same by updates, 2.5 to 5.5 mm each, from a board before the mirror."""
    found, cameras = {}, {}
    points = made.rig.board.points()
    for name, case in CASES.items():
        if case.before is not None and case.before not in cameras:
            found[f"update.{name}"] = {"refused": f"{case.before} was refused"}
            continue
        start = 0.0 if case.before is None else CASES[case.before].deflection
        before = made.rig.camera(start)
        T = made.rig.board_pose(rng, deflections=(start, case.deflection))
        pictures = [
            seen_board(made.rig, camera, T, ERRORS, rng)
            for camera in (before, true[name])
        ]
        known = made.cameras[0] if case.before is None else cameras[case.before]
        try:
            stage = update_mirror(
                known,
                *pictures,
                points,
                made.clamp,
                METHOD,
                outline=outline(true[name]),
            )
        except CalibrationError as refusal:
            found[f"update.{name}"] = {"refused": str(refusal)}
            continue
        cameras[name] = stage.camera
        found[f"update.{name}"] = scores(made, true[name], stage.camera) | {
            "flagged": bool(stage.flags)
        }
    return found


def scores(made, true, found):
    """Mean ray angle (degrees) over the mirror, and by how much the load's way from the
    first entry was found wrong (um)."""
    rig, flat = made.rig, made.rig.camera(ENTRIES_MM[0])
    start = load_height(rig, made.cameras[0], flat)
    way = rig.deflection_direction() @ (rig.load_point(true) - rig.load_point(flat))
    return {
        "angle_deg": mean_angle(found, true),
        "deflection_um": 1000 * (load_height(rig, found, true) - start - way),
    }


def mean_angle(found, true):
    """Mean angle, degrees, between the rays of two cameras over the mirror."""
    return float(np.nanmean(ray_angles(found, true, lattice(true, COMPARED_PX))))
