"""The cases of the page on CELECT's failures: boards, levels, and pairs to be drawn.

Every case changes one thing over some levels. Two or three of the levels are drawn:
where the prerequisite is broken, and where it is kept. The levels were found by trying.
"""

# What every level has unless it says otherwise. The ordinary board is bent mildly.
BOARD = {
    "columns": 8,
    "rows": 6,
    "arc_deg": 50.0,
    "radius_px": 700.0,
    "depth_px": 260.0,
    "size_px": 800,
}
ORDINARY = {
    "board": BOARD,
    "blur_px": 1.0,
    "noise_sd": 2.0,
    "start": 0,
    "clockwise": True,
    "settings": {},
}
# How trials of one level differ.
VARIATION = {
    "turn_deg": "even, 0 to 360",
    "shift_px": "even, +-0.5 both ways",
    "arc": "even, +-3 %",
    "click_sd_px": 1.0,
    "click_cap_px": 2.0,
}
ARC_VARIES = 0.03
CLICK_SD_PX, CLICK_CAP_PX = 1.0, 2.0

# A sheet with long thin squares at one end.
LONG = {
    "columns": 5,
    "rows": 9,
    "arc_deg": 10.0,
    "radius_px": 1030.0,
    "depth_px": 400.0,
}


def _half_ring(arc_deg):
    """Half a ring, as a mirror shows a board that reaches far around it."""
    return {
        "columns": 9,
        "rows": 5,
        "arc_deg": float(arc_deg),
        "radius_px": 470.0,
        "depth_px": 250.0,
        "size_px": 1150,
    }


def _bowed(bow_deg):
    """A third of a ring whose columns are bowed, so that both contours bend."""
    return {
        "columns": 9,
        "rows": 6,
        "arc_deg": 110.0,
        "radius_px": 560.0,
        "depth_px": 260.0,
        "size_px": 1100,
        "bow_deg": float(bow_deg),
    }


def _squares(columns, rows):
    """One bend, divided into fewer or more squares; its arcs are clicked as columns."""
    board = _half_ring(120) | {"depth_px": 260.0}
    return {"board": board | {"columns": columns, "rows": rows}, "start": 1}


def _choices(board):
    """The eight ways to click a board: four first corners, two directions."""
    return {
        f"c{start + 1} {way}": {
            "board": board,
            "start": start,
            "clockwise": way == "cw",
        }
        for way in ("cw", "ccw")
        for start in range(4)
    }


# Case -> levels (label -> what is not ordinary), and the labels that are drawn.
CASES = {
    "clearance": {
        "levels": {
            f"{ring:g}": {"board": BOARD | {"ring": ring}}
            for ring in (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0)
        },
        "drawn": {"too little": "0.15", "enough": "0.5"},
    },
    "first_corner": {
        "levels": {
            f"{arc}": {"board": _half_ring(arc), "start": 1}
            for arc in (110, 130, 145, 155, 160, 170)
        }
        | {"160, c1": {"board": _half_ring(160)}},
        "drawn": {"side 4 is the arc": "160", "side 4 is straight": "160, c1"},
    },
    "wrong_contour": {
        "levels": {f"{bow}": {"board": _bowed(bow)} for bow in range(5)}
        | {"3, c2": {"board": _bowed(3), "start": 1}},
        "drawn": {"first corner c1": "3", "first corner c2": "3, c2"},
    },
    "direction": {
        "levels": _choices(_half_ring(160)),
        "drawn": {"counterclockwise": "c1 ccw", "clockwise": "c1 cw"},
    },
    "window": {
        "levels": {
            f"{scale:g}": {
                "board": _half_ring(130),
                "settings": {"radius_scale": scale},
                "noise_sd": 10.0,
            }
            for scale in (0.3, 0.45, 0.7, 1.0, 1.5, 2.2, 3.0)
        },
        "drawn": {"too small": "0.3", "as published": "1", "too large": "3"},
    },
    "curvature": {
        "levels": {
            f"{columns - 1} x {rows - 1}": _squares(columns, rows)
            for columns, rows in ((3, 3), (4, 4), (5, 5), (7, 6), (9, 6))
        },
        "drawn": {"large squares": "3 x 3", "small squares": "8 x 5"},
    },
    "size_variation": {
        "levels": {
            f"{growth:g}": {"board": LONG | {"growth": growth}}
            for growth in (1.0, 3.0, 4.5, 6.0, 9.0, 14.0)
        },
        "drawn": {"1 : 6": "6", "1 : 3": "3"},
    },
    "blur_noise": {
        "levels": {
            f"blur {blur}": {"blur_px": float(blur)} for blur in (1, 3, 6, 10, 14)
        }
        | {f"noise {sd}": {"noise_sd": float(sd)} for sd in (5, 20, 40, 60, 80)},
        "drawn": {"blurred": "blur 14", "clear": "blur 1", "noisy": "noise 80"},
    },
}


def levels_of(case, effort):
    """Levels of a case, in order: only those that are drawn for a quick build."""
    levels = CASES[case]["levels"]
    drawn = CASES[case]["drawn"].values()
    taken = drawn if effort == "quick" else levels
    return {label: ORDINARY | levels[label] for label in levels if label in taken}
