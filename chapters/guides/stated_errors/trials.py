"""What the record of stated errors holds: parts, and rows of each."""

from chapters.shared.records import record

RECORD = "stated"  # of data/records
ABOUT = "what", "date", "raxel", "seconds", "titles"


def parts():
    """{name of a part: what the record holds of it}"""
    return {one["part"]: one for one in record(RECORD)["sets"]}


def conditions():
    """[{"part", "row"}, ...]: every row of the record, numbered within its part."""
    return [
        {"part": name, "row": k}
        for name, part in parts().items()
        for k in range(len(part["rows"]))
    ]


def recorded_row(condition):
    """The numbers and words of one row; what it has none of is left out."""
    row = parts()[condition["part"]]["rows"][condition["row"]]
    return {name: x for name, x in row.items() if x not in (None, "")}


def about():
    """What the record says of itself and of each part: the settings of its Result."""
    kept = record(RECORD)
    told = {"record": RECORD, "command": kept["command"], **kept["versions"]}
    for name, part in parts().items():
        told |= {f"{name}.{key}": part[key] for key in ABOUT}
    return told
