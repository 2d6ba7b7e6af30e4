"""Where a board's corners lie beside where they are said to, in words and as JSON."""

from raxel.evaluation.distortion import MIN_N_BOARDS


def corner_fields(found):
    """A BoardCorners as JSON, lengths in the unit of the result; None where there is
    none. Corners are numbered row by row."""
    if found is None:
        return None
    return {
        "as_stated": found.as_stated,
        "p_value": found.p_value,
        "rays_px": found.rays_px,
        "worst": found.worst,
        "offsets": found.offsets.tolist(),
        "sd": found.sd.tolist(),
    }


def corner_line(found, unit, words):
    """Whether corners lie where they are said to, for people; words: of the target."""
    if found is None:
        return (
            f"{words.point}s of the {words.target}: taken where they are said to be; "
            f"to ask takes {MIN_N_BOARDS} chessboards"
        )
    if not found.offsets.any():
        return (
            f"{words.point}s of the {words.target}: nothing that all {words.target}s "
            f"share says that they are not where they are taken to be (p = "
            f"{found.p_value:.2g})"
        )
    return f"{words.point}s of the {words.target}: {_numbers(found, unit, words)}"


def corner_warnings(found, test, unit, words):
    """What to say of a board whose corners lie elsewhere; test: BoardTest of the bends
    and the stretch that the fit took, or None."""
    if found is None or found.as_stated:
        return []
    beyond = ", beside the shape that the fit takes" if test and test.used else ""
    return [
        f"{words.point}s of the {words.target} do not lie where they are said to"
        f"{beyond}: {_numbers(found, unit, words)}; stated standard deviations do not "
        f"hold that; measure the {words.target}, or take one that is printed on a "
        f"stiff plate; a finder that errs alike on all {words.target}s does so, too; "
        "board_corners of --json has all offsets"
    ]


def _numbers(found, unit, words):
    row, column = divmod(found.worst, found.columns)
    length, sd = found.distance
    return (
        f"that of column {column} and row {row}, counted from 0, is {length:.2g} +- "
        f"{sd:.1g} {unit} off, all {words.point}s {found.rms:.2g} {unit} (RMS), which "
        f"moves the rays of a lens that is free to follow by {found.rays_px:.2g} px "
        f"(RMS); p = {found.p_value:.2g}"
    )
