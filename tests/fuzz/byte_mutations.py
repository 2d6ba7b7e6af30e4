"""Damage to bytes that knows nothing of their meaning."""

NUMBERS = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF)


def mutated_bytes(rng, content, others):
    """`content` damaged in one to three places; others: list of bytes to splice in."""
    for _ in range(rng.integers(1, 4)):
        content = HOW[rng.integers(len(HOW))](rng, content, others)
    return content


def flipped(rng, content, others):
    """A few bits turned."""
    out = bytearray(content)
    for at in rng.integers(0, max(len(out), 1), rng.integers(1, 9)):
        if out:
            out[at] ^= 1 << rng.integers(8)
    return bytes(out)


def overwritten(rng, content, others):
    """A number of one, two or four bytes made an extreme one, in either order."""
    width = int(rng.choice([1, 2, 4]))
    order = ("little", "big")[rng.integers(2)]
    number = int(rng.choice(NUMBERS)) & (256**width - 1)
    at, _ = _span(rng, content)
    return content[:at] + number.to_bytes(width, order) + content[at + width :]


def cut(rng, content, others):
    """The end cut off."""
    return content[: _span(rng, content)[0]]


def taken_out(rng, content, others):
    """Some bytes taken out."""
    start, stop = _span(rng, content)
    return content[:start] + content[stop:]


def inserted(rng, content, others):
    """Random bytes put in."""
    at, _ = _span(rng, content)
    return content[:at] + rng.bytes(int(rng.integers(1, 17))) + content[at:]


def doubled(rng, content, others):
    """Some bytes given twice."""
    start, stop = _span(rng, content)
    return content[:stop] + content[start:]


def spliced(rng, content, others):
    """The beginning of one file and the end of another."""
    other = others[rng.integers(len(others))]
    return content[: _span(rng, content)[0]] + other[_span(rng, other)[0] :]


HOW = (flipped, flipped, overwritten, cut, taken_out, inserted, doubled, spliced)


def _span(rng, content):
    """Two places in order; near to each other half of the time."""
    start = int(rng.integers(0, len(content) + 1))
    reach = len(content) if rng.random() < 0.5 else 16
    return start, min(len(content), start + int(rng.integers(0, reach + 1)))
