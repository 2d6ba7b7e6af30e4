"""Conditions of section 3.3.4: rigs, seeds, settings, and the sets they read."""

SMALL = {"quick": "-small", "full": ""}
SEEDS = {"quick": (1,), "full": (1, 2, 3)}
# Full widths and SDs (px): of the sweep, and of a coarser one.
WINDOWS = {"quick": (5, 13, 21), "full": tuple(range(5, 58, 4))}
COARSE = {"quick": (5, 21), "full": tuple(range(5, 58, 8))}
BLURS = {"quick": (0.5, 2.0), "full": (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)}
COARSE_BLURS = {"quick": (0.5,), "full": (0.5, 2.0, 4.0, 8.0)}
COARSER = ("sharp", "16 bits")
VIEWS = ("long wall", "corner")
PITCHES = ("pitched", "half pitched")

# Literals, which the workflow reads without running them.
CORNER_SETS = {
    "quick": ("d200-boards-small/1", "d200-lens-small/1", "d200-lens-sharp-small/1"),
    "full": (
        "d200-boards/1", "d200-boards/2", "d200-boards/3",
        "d200-lens/1", "d200-lens/2", "d200-lens/3",
        "d200-lens-sharp/1", "d200-lens-sharp/2", "d200-lens-sharp/3",
    ),
}  # fmt: skip
FISHEYE_SETS = {
    "quick": ("d200-fisheye-small/1",),
    "full": ("d200-fisheye/1", "d200-fisheye/2", "d200-fisheye/3"),
}
BALL_SETS = {
    "quick": ("mirror-ball-small/1",),
    "full": ("mirror-ball/1", "mirror-ball/2", "mirror-ball/3"),
}


def corner_conditions(effort, cases):
    """Return a condition for each seed of the cases of Table 3.8, by name."""
    return [
        {
            "case": case,
            "seed": seed,
            "rig": f"d200-lens{'-sharp' * (case == 'sharp')}{SMALL[effort]}",
            "boards": f"d200-boards{SMALL[effort]}",
            "pose": int(case == "far"),
            "bits": 16 if case == "16 bits" else 8,
            "windows": list((COARSE if case in COARSER else WINDOWS)[effort]),
            "blurs": list((COARSE_BLURS if case in COARSER else BLURS)[effort]),
        }
        for case in cases
        for seed in SEEDS[effort]
    ]


def line_conditions(effort, pitches, views):
    """Return a condition for each seed, pitch of the grid and view of the room."""
    return [
        {
            "rig": f"d200-fisheye{SMALL[effort]}",
            "seed": seed,
            "pose": PITCHES.index(pitch),
            "pitch": pitch,
            "view": view,
            "drawn": (seed, pitch, view) == (1, PITCHES[0], VIEWS[0]),
        }
        for view in views
        for pitch in pitches
        for seed in SEEDS[effort]
    ]


def ball_conditions(effort):
    """Return a condition for each seed of the mirror ball."""
    rig = f"mirror-ball{SMALL[effort]}"
    return [{"rig": rig, "seed": seed, "drawn": seed == 1} for seed in SEEDS[effort]]
