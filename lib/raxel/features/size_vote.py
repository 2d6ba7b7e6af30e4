"""The size of a board that nobody gives, by a vote of the photographs of one set.

A photograph that shows complete boards votes for their sizes. What covers the end of a
board, or carries its pattern on, differs from photograph to photograph; the board does
not. With the size that wins, the other photographs are looked at again.
"""

from dataclasses import replace
from typing import NamedTuple

from raxel.errors import InputError
from raxel.features.boards import detect_boards

# Of all votes: with two thirds the board is seen twice as often as all else together.
LEAST_SHARE = 2 / 3
# Photographs that a line names.
MOST_NAMED = 3


class SizeVote(NamedTuple):
    """How photographs voted. votes: {(columns, rows): labels of those that show such a
    board}, the size that won first; photographs: how many there are; again: labels of
    those that were looked at again with it, and found: of these, with a board then."""

    votes: dict
    photographs: int
    again: list
    found: list

    @property
    def size(self):
        """The size (columns, rows) that won."""
        return next(iter(self.votes))

    def line(self):
        """The vote, for people."""
        first, *others = self.votes.items()
        count = len(first[1])
        text = (
            f"size not given: a board of {_size(first[0])} by {count} of "
            f"{self.photographs} photographs"
        )
        for size, labels in others:
            text += f", of {_size(size)} by {_named(labels)}"
        if self.again:
            text += (
                f"; {len(self.again)} looked at again with it, "
                f"{len(self.found)} of them found"
            )
        return text

    def fields(self):
        """The vote, for results."""
        votes = [
            {"columns": size[0], "rows": size[1], "files": labels}
            for size, labels in self.votes.items()
        ]
        again = {"looked_at_again": self.again, "found_then": self.found}
        return {"photographs": self.photographs, "votes": votes} | again


def votes_of(boards):
    """{(columns, rows): [labels]} of Boards, the size of most photographs first."""
    votes = {}
    for board in boards:
        seen = board.detection
        sizes = {(seen.columns, seen.rows)} if seen.found else set(seen.complete)
        for size in sorted(sizes):
            votes.setdefault(size, []).append(board.view.label)
    return dict(sorted(votes.items(), key=lambda vote: -len(vote[1])))


def agreed(image_set, boards, detector, say=None):
    """(Boards of one size, SizeVote) of the Boards of a set whose target has none.

    Those without a board of the size that wins are looked at again. (boards, None)
    where no photograph shows a complete board. Raises InputError where no size has two
    thirds of the votes.
    """
    votes = votes_of(boards)
    if not votes:
        return boards, None
    size, labels = next(iter(votes.items()))
    if len(labels) < LEAST_SHARE * sum(map(len, votes.values())):
        told = "; ".join(f"{_size(s)} in {_named(names)}" for s, names in votes.items())
        raise InputError(
            f"{image_set.description}: target.columns: found null, and the photographs "
            f"do not agree on the board's size: {told}; give columns and rows, or make "
            "a set for each board"
        )
    target = replace(image_set.target, columns=size[0], rows=size[1])
    others = [k for k, board in enumerate(boards) if not _shows(board, size)]
    views = [boards[k].view for k in others]
    if views and say:
        say(f"{len(views)} photographs are looked at again for {_size(size)} corners")
    sized = replace(image_set, target=target)
    again = detect_boards(sized, detector, views, say) if views else []
    boards = list(boards)
    for k, board in zip(others, again, strict=True):
        boards[k] = _explained(board, boards[k].detection, size, len(labels))
    found = [board.view.label for board in again if board.detection.found]
    names = [view.label for view in views]
    return boards, SizeVote(votes, len(boards), names, found)


def _shows(board, size):
    seen = board.detection
    return seen.found and (seen.columns, seen.rows) == size


def _explained(board, before, size, count):
    """The Board of a second look; of a refused one, why another size was not taken."""
    if board.detection.found or not before.found:
        return board
    reason = (
        f"it shows {_size((before.columns, before.rows))} corners, where {count} other "
        f"photographs show {_size(size)}: {board.detection.reason}"
    )
    return board._replace(detection=board.detection._replace(reason=reason))


def _size(size):
    return f"{size[0]} x {size[1]}"


def _named(labels):
    more = len(labels) - MOST_NAMED
    names = ", ".join(labels[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
    return f"{len(labels)} ({names})"
