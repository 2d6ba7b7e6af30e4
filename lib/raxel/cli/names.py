"""Names of files and folders as they are typed: an empty one is none."""

import argparse


def read_name(text):
    """What a command reads."""
    return _named(text)


def written_name(text):
    """What a command writes: it is lost where nothing takes an empty name for one."""
    return _named(text)


def _named(text):
    if not text or "\0" in text:
        raise argparse.ArgumentTypeError(
            f"found {text!r}; give a name, or leave it out"
        )
    return text
