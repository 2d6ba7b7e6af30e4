"""Rows of the record of stated errors, and the numbers that the page quotes."""

import numpy as np

RECORD_RUN = "ext_stated_record"
DIGITS = 3


def rows_of(record, part):
    """[{head: cell}, ...] of a part, in the record's order; None where a row has none.

    record: the Result of `ext_stated_record`.
    """
    heads = record.settings[f"{part}.titles"]
    return [
        {head: _cell(row, name) for name, head in heads.items()}
        for row in record.select(part=part).by("row").values()
    ]


def _cell(row, name):
    return row.texts(name)[0]  # a number as it stands, too


def column(record, part, name):
    """(rows,) of a part; nan where a row has no number."""
    return record.select(part=part).column(name)


def cases(record, part):
    """Names of a part's rows."""
    return record.select(part=part).texts("case")


def where(record, part, words):
    """(rows,) bool: of which cases the name holds one of some words."""
    return np.array([any(w in one for w in words) for one in cases(record, part)])


DRAWN_BOARDS = "on paper", "on cloth", "partly hidden", "circles", "other patterns"
PHOTOGRAPHED = "fisheye-", "mirror-", "ordinary-", "wide-"
# Of calibrations: what is as it is said to be, what is told in columns of its own, and
# what no fit takes up, so that no standard deviation can hold it.
SOUND = "sound", "err together", "three times"
TOLD = "shape", "corners", "halves", "focal", "erratic", "odd"
UNTOLD = "two cameras", "shutter", "wrong", "dent", "one row", "cropped"
# Of calibrations: what is not as it is said to be.
FAULTS = {
    "bent": ("bent",),
    "longer": ("longer",),
    "cameras": ("2 % apart",),
    "near": ("1 % apart",),
    "dented": ("dent", "one row"),
    "shutter": ("shutter",),
    "cropped": ("cropped",),
}


def groups(record):
    """Label -> (record, part, (rows,) bool): sets that belong side by side."""
    photographed = where(record, "corners", PHOTOGRAPHED)
    faulty = where(record, "calibration", UNTOLD)
    return {
        "Corners, drawn": (record, "corners", ~photographed),
        "Corners, photographed": (record, "corners", photographed),
        "Places, gamma": (record, "decoding", where(record, "decoding", ("",))),
        "Places, hard cases": (
            record,
            "decoding_hard",
            where(record, "decoding_hard", ("",)),
        ),
        "Focal lengths": (record, "calibration", ~faulty),
        "Focal lengths, faulty": (record, "calibration", faulty),
    }


def facts(record):
    """Name -> what the prose says of the record."""
    found = {"command": record.settings["command"]}
    photographed = where(record, "corners", PHOTOGRAPHED)
    for kind, own in (("drawn", ~photographed), ("photographed", photographed)):
        names = "ratio", "beyond3", "truth_px", "sd_px"
        ranges = _ranges(record, "corners", names, own)
        found |= {name.replace("corners", kind): x for name, x in ranges.items()}
    found |= _ranges(record, "decoding", ("within1", "within3", "left_out"))
    found |= _ranges(record, "decoding_hard", ("within1", "within3"))
    found |= _of_boards(record) | _of_calibrations(record)
    said = column(record, "tables", "unstable")
    sound = where(record, "tables", ("sound",))
    asked = column(record, "tables", "count")
    found |= {
        "tables.false": int(said[sound].sum()),
        "tables.sound": int(asked[sound].sum()),
        "tables.found": int(said[~sound].sum()),
        "tables.faulty": int(asked[~sound].sum()),
    }
    central = where(record, "pupil", ("central",))
    moved = where(record, "pupil", ("mm theta",))
    moves, lenses = (column(record, "pupil", name) for name in ("moves", "count"))
    found |= {
        "pupil.false": int(moves[central].sum()),
        "pupil.central": int(lenses[central].sum()),
        "pupil.found": int(moves[moved].sum()),
        "pupil.moved": int(lenses[moved].sum()),
    }
    for name in ("mutants", "faults"):
        found[f"readers.{name}"] = int(column(record, "readers", name).sum())
    return found


def _ranges(record, part, names, own=slice(None)):
    """Least and most of some columns over some rows, and how many rows these are."""
    found = {f"{part}.rows": len(column(record, part, "count")[own])}
    for name in names:
        known = column(record, part, name)[own]
        known = known[np.isfinite(known)]
        for word, number in (("least", known.min()), ("most", known.max())):
            found[f"{part}.{name}.{word}"] = float(f"{number:.{DIGITS}g}")
    return found


def _of_boards(record):
    drawn = where(record, "boards", DRAWN_BOARDS)
    given, found = ~where(record, "boards", ("not given",)), {}
    for kind, own in (("given", given & ~drawn), ("alone", ~given & ~drawn)):
        for name in ("pictures", "right", "wrong", "refused"):
            numbers = column(record, "boards", name)
            found[f"boards.{kind}.{name}"] = int(numbers[own].sum())
    none = where(record, "boards", ("circles", "other patterns"))
    for name, key in (("false", "wrong"), ("none", "pictures")):
        found[f"boards.{name}"] = int(column(record, "boards", key)[none].sum())
    return found


def _of_calibrations(record):
    sets, rays = (column(record, "calibration", n) for n in ("sets", "rays_px"))
    told = {n: column(record, "calibration", n) for n in TOLD}
    told["told"] = told["halves"] + told["focal"]
    sound = where(record, "calibration", SOUND)
    ratio = column(record, "calibration", "rms")[sound]
    found = {
        "sets.sound": int(sets[sound].sum()),
        "sets.false": int(sum(told[name][sound].sum() for name in TOLD)),
        "focal.least": float(f"{ratio.min():.{DIGITS}g}"),
        "focal.most": float(f"{ratio.max():.{DIGITS}g}"),
    }
    for name, words in FAULTS.items():
        own = where(record, "calibration", words)
        found[f"{name}.sets"] = int(sets[own].sum())
        found[f"{name}.rays"] = float(f"{rays[own].max():.{DIGITS}g}")
        for key, counts in told.items():
            found[f"{name}.{key}"] = int(counts[own].sum())
    return found
