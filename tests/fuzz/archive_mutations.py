"""Damage to .npz files: fields, headers of arrays, and the zip around them."""

import io
import struct
import warnings
import zipfile

import numpy as np

from tests.fuzz.document_mutations import scalar

TYPES = ("f2", "f4", ">f8", "<i1", ">u8", "i8", "?", "c8", "c16", "U3", ">U9", "S4")
TYPES += ("O", "M8[s]", "f16", "V3", "f8, i4")
SHAPES = ((), (0,), (1,), (2,), (3, 3), (4, 4), (4097,), (1, 1, 3), (0, 5), (300,))
NUMBERS = (0, 1, -1, 3, 1e-300, 1e9, 1e99, 1e150, 1e300, np.nan, np.inf, -np.inf)
# How often 50 MB of zeros are packed.
RARELY = 0.005
# A claim of 16 GB in the header, and one that multiplies beyond 64 bit.
LARGE = ((1 << 31,), (1 << 40, 1 << 40), (10**5, 10**4, 3), (-1,), (-3, -3))


def mutated_archive(rng, content, others):
    """An .npz file with one to three things in it changed."""
    with np.load(io.BytesIO(content)) as archive:
        members = {f"{name}.npy": _npy(archive[name]) for name in archive.files}
    for _ in range(rng.integers(1, 4)):
        if members:
            name = list(members)[rng.integers(len(members))]
            how = _bomb if rng.random() < RARELY else HOW[rng.integers(len(HOW))]
            how(rng, members, name)
    packing = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)[rng.integers(2)]
    out = _zipped(members, packing, twice=rng.random() < 0.02)
    return _misled(rng, out) if rng.random() < 0.3 else out


def _value(rng, members, name):
    """Other numbers in an array of the same shape and type."""
    array = np.array(_read(members[name]))
    if array.dtype.kind in "iuf" and array.size:
        at = rng.integers(array.size, size=1 + rng.integers(array.size))
        with np.errstate(all="ignore"):
            array.flat[at] = np.array(rng.choice(NUMBERS)).astype(array.dtype)
    members[name] = _npy(array)


def _scaled(rng, members, name):
    """Numbers a little or very different."""
    array = np.array(_read(members[name]))
    if array.dtype.kind == "f":
        with np.errstate(all="ignore"):
            array = array * 10.0 ** rng.normal(0, rng.choice([0.01, 1, 100]))
    members[name] = _npy(array)


def _shape(rng, members, name):
    shape = SHAPES[rng.integers(len(SHAPES))]
    array = np.array(_read(members[name]))
    members[name] = _npy(np.resize(array, shape) if array.size else np.zeros(shape))


def _type(rng, members, name):
    wanted = np.dtype(TYPES[rng.integers(len(TYPES))])
    array = np.array(_read(members[name]))
    try:
        with np.errstate(all="ignore"):
            array = array.astype(wanted)
    except (TypeError, ValueError, OverflowError):
        array = np.zeros(array.shape, wanted)
    if rng.random() < 0.3:
        array = np.asfortranarray(array)
    members[name] = _npy(array)


def _text(rng, members, name):
    array = np.array(_read(members[name]))
    members[name] = _npy(np.array(str(scalar(rng))[:1000] if array.size else "x"))


def _moved(rng, members, name):
    """One field's content under another's name."""
    other = list(members)[rng.integers(len(members))]
    members[other] = members[name]


def _lost(rng, members, name):
    del members[name]


def _renamed(rng, members, name):
    names = ("x.npy", name.removesuffix(".npy"), f"{name}.npy", "a/b.npy", "../a.npy")
    members[(*names, "d/", f"viewer.{name}")[rng.integers(7)]] = members.pop(name)


def _nested(rng, members, name):
    """The camera in itself, a few times or too often."""
    prefix, own = "", dict(members)
    for _ in range(int(rng.choice([1, 3, 30]))):
        prefix += "viewer."
        members |= {prefix + each: content for each, content in own.items()}


def _claimed(rng, members, name):
    """A header that claims another size than there is."""
    members[name] = _with_header(members[name], LARGE[rng.integers(len(LARGE))])


def _bomb(rng, members, name):
    """Truly large, though small when packed."""
    header = _with_header(_npy(np.zeros(0)), (1 << 21, 3))
    members[name] = header + bytes(3 << 24)


def _header_text(rng, members, name):
    """A byte of the array's own header changed."""
    content = bytearray(members[name] or b"?")  # an earlier change may have emptied it
    at = int(rng.integers(0, min(len(content), 128)))
    content[at] = int(rng.integers(256))
    members[name] = bytes(content)


def _header_replaced(rng, members, name):
    texts = (b"[" * 9000, b"{'shape': (1,)}", b"9" * 9000, b"{'descr': '\\z', 1: 0x}")
    text = texts[rng.integers(len(texts))]
    version = bytes([int(rng.integers(4)), 0])
    size = struct.pack("<H" if version[0] < 2 else "<I", len(text))
    members[name] = b"\x93NUMPY" + version + size + text


def _no_npy(rng, members, name):
    members[name] = rng.bytes(int(rng.integers(0, 200)))


HOW = (
    *(_value, _value, _value, _value, _scaled, _scaled, _scaled, _shape, _shape, _type),
    *(_type, _text, _moved, _moved, _lost, _renamed, _nested, _claimed, _header_text),
    *(_header_text, _header_replaced, _no_npy),
)


def _npy(array):
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.asanyarray(array), allow_pickle=True)
    return stream.getvalue()


def _read(content):
    """The array of an .npy text, or an empty one where it is none any more."""
    try:
        return np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    except Exception:  # An earlier mutation may have left anything.
        return np.zeros(0)


def _with_header(content, shape):
    stream = io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(stream, header)
    return stream.getvalue() + content[128:]


def _zipped(members, packing, twice):
    stream = io.BytesIO()
    entries = list(members.items())
    with warnings.catch_warnings(), zipfile.ZipFile(stream, "w", packing) as archive:
        warnings.simplefilter("ignore")
        for name, content in entries + entries[: int(twice)]:
            archive.writestr(name, content)
    return stream.getvalue()


# Offsets in an entry of the zip's directory: version, flags, method, sums and sizes,
# lengths of name and extra, place.
PLACES = (4, 6, 8, 10, 16, 20, 24, 28, 30, 32, 34, 42)


def _misled(rng, content):
    """A field of one entry of the zip's directory changed."""
    entries = []
    at = content.find(b"PK\x01\x02")
    while at >= 0:
        entries.append(at)
        at = content.find(b"PK\x01\x02", at + 4)
    if not entries:
        return content
    at = entries[rng.integers(len(entries))] + PLACES[rng.integers(len(PLACES))]
    number = (0, 1, 8, 9, 12, 14, 99, 0xFFFF, 1 << 31, 0xFFFFFFFF)[rng.integers(10)]
    width = 2 if number <= 0xFFFF and rng.random() < 0.5 else 4
    return content[:at] + number.to_bytes(width, "little") + content[at + width :]
