"""Numbers as they are typed, for argparse, which names the option beside its words."""

import argparse
import math


def seed(text):
    """A whole number from 0."""
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"found {text!r}; give a whole number from 0")
    return int(text)


def length(text):
    """A length in mm."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0 < number <= 1e6:
        raise argparse.ArgumentTypeError(f"found {text!r}; give a length in mm")
    return number


def part(text):
    """A number from -1 to 1."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not abs(number) <= 1:
        raise argparse.ArgumentTypeError(f"found {text!r}; give a number, -1 to 1")
    return number


def count(text):
    """A whole number from 1 that a side of a picture may have."""
    number = seed(text)
    if not 1 <= number <= 32000:
        raise argparse.ArgumentTypeError(f"found {text}; give 1 to 32000")
    return number
