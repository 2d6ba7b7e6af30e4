"""Records of measurements on photographs that this repository does not hold."""

from functools import cache

from chapters.shared.rigs import RIGS
from raxel.io import read_json


@cache
def record(name):
    """The record `data/records/<name>.json`: what, command, date, versions, sets."""
    return read_json(RIGS.parents[1] / f"data/records/{name}.json")


def set_of(name, condition):
    """What a record holds of one set."""
    sets = record(name)["sets"]
    return next(one for one in sets if one["name"] == condition["set"])
