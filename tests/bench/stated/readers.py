"""Files of every kind, damaged at random: read, refused in one line, or a fault."""

from tests.fuzz.outcome import READ, REFUSED
from tests.fuzz.run import counted

WHAT = (
    "Files of every kind that can be read, damaged at random. Refused: in one line "
    "that names the file. A fault is a traceback, a hang, more than 2 GB of memory, or "
    "words that name no file."
)
TITLES = {"mutants": "Damaged", "read": "Read", "refused": "Refused", "faults": "Fault"}
MUTANTS, SEED = 2300, 2511


def measured():
    """A row for each reader."""
    arguments = ["--mutants", str(MUTANTS), "--seed", str(SEED)]
    for reader, count in counted(arguments).items():
        read, refused = count[READ], count[REFUSED]
        yield {
            "case": reader,
            "mutants": count.total(),
            "read": read,
            "refused": refused,
            "faults": count.total() - read - refused,
        }
