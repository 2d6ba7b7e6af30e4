"""Small pictures in every format that is read; damage that keeps sums right."""

import struct
import zlib

import cv2
import numpy as np

from tests.fuzz.byte_mutations import NUMBERS, mutated_bytes

WIDTH, HEIGHT = 48, 40
SIGNATURE = b"\x89PNG\r\n\x1a\n"
LZW, DEFLATE, PACKBITS, NONE = 5, 8, 32773, 1


def pictures():
    """Whole files of WIDTH x HEIGHT: PNG, JPEG, BMP, and TIFF in strips and tiles."""
    rng = np.random.default_rng(3)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    smooth = (
        127 + 100 * np.sin(u / 5) * np.cos(v / 7) + rng.normal(0, 3, v.shape)
    ) / 255
    grey, deep = (np.clip(smooth * top, 0, top) for top in (255, 65535))
    grey, deep = grey.astype(np.uint8), deep.astype(np.uint16)
    colour, deep_colour = (
        np.stack([one, one // 2, one // 3], -1) for one in (grey, deep)
    )
    alpha = np.dstack([colour, grey])
    files = [_written(".png", one) for one in (grey, deep, colour, deep_colour, alpha)]
    files += [_written(".png", grey // 128 * 255, cv2.IMWRITE_PNG_BILEVEL, 1)]
    files += [_written(".bmp", one) for one in (grey, colour, alpha)]
    files += [_written(".jpg", one) for one in (grey, colour)]
    files += [_written(".jpg", colour, cv2.IMWRITE_JPEG_PROGRESSIVE, 1)]
    files += [_written(".jpg", grey, cv2.IMWRITE_JPEG_RST_INTERVAL, 2)]
    for packing in (LZW, DEFLATE, PACKBITS, NONE):
        for one in (grey, deep, colour):
            files.append(_written(".tif", one, cv2.IMWRITE_TIFF_COMPRESSION, packing))
        files.append(tiled_tiff(grey, packing))
    return files


def _written(suffix, picture, *options):
    return cv2.imencode(suffix, picture, options)[1].tobytes()


def tiled_tiff(picture, packing, side=32):
    """A grey TIFF (uint8) in square tiles; `packing` may be NONE or DEFLATE."""
    height, width = picture.shape
    rows, columns = -(-height // side), -(-width // side)
    whole = np.pad(picture, ((0, rows * side - height), (0, columns * side - width)))
    tiles = whole.reshape(rows, side, columns, side).swapaxes(1, 2).reshape(-1, side**2)
    packing = DEFLATE if packing == DEFLATE else NONE
    parts = [tile.tobytes() for tile in tiles]
    parts = [zlib.compress(part) for part in parts] if packing == DEFLATE else parts
    places = np.cumsum([8, *map(len, parts)])
    lists = struct.pack(f"<{len(parts)}I", *places[:-1])
    lists += struct.pack(f"<{len(parts)}I", *map(len, parts))
    at = int(places[-1])
    tags = [
        (256, 4, 1, width),
        (257, 4, 1, height),
        (258, 3, 1, 8),
        (259, 3, 1, packing),
    ]
    tags += [(262, 3, 1, 1), (277, 3, 1, 1), (322, 3, 1, side), (323, 3, 1, side)]
    tags += [(324, 4, len(parts), at), (325, 4, len(parts), at + 4 * len(parts))]
    directory = struct.pack("<H", len(tags))
    directory += b"".join(struct.pack("<HHII", *tag) for tag in tags) + bytes(4)
    header = struct.pack("<2sHI", b"II", 42, at + len(lists))
    return header + b"".join(parts) + lists + directory


def mutated_picture(rng, content, others):
    """Damage by its format half of the time, else to bytes."""
    if rng.random() < 0.5:
        return mutated_bytes(rng, content, others)
    if content.startswith(SIGNATURE):
        return _png_with_right_sums(rng, content, others)
    if content[:4] in (b"II*\0", b"MM\0*"):
        return _tiff_with_another_tag(rng, content)
    return _numbers_in_the_header(rng, content)


def _png_with_right_sums(rng, content, others):
    chunks, at = [], len(SIGNATURE)
    while at < len(content):
        (length,) = struct.unpack_from(">I", content, at)
        kind, data = content[at + 4 : at + 8], content[at + 8 : at + 8 + length]
        if chunks and chunks[-1][0] == kind == b"IDAT":
            data = chunks.pop()[1] + data
        chunks.append((kind, data))
        at += 12 + length
    index = int(rng.integers(len(chunks)))
    kind, data = chunks[index]
    how = rng.integers(5)
    if how == 0:
        chunks.insert(int(rng.integers(len(chunks) + 1)), chunks[index])
    elif how == 1:
        del chunks[index]
    elif kind == b"IDAT" and how == 2:
        damaged = mutated_bytes(rng, zlib.decompress(data), others)
        chunks[index] = kind, zlib.compress(damaged)
    else:
        chunks[index] = kind, mutated_bytes(rng, data, others)
    out = SIGNATURE
    for kind, data in chunks:
        out += struct.pack(">I", len(data)) + kind + data
        out += struct.pack(">I", zlib.crc32(kind + data))
    return out


def _tiff_with_another_tag(rng, content):
    order = "<" if content.startswith(b"II") else ">"
    (at,) = struct.unpack_from(order + "I", content, 4)
    (count,) = struct.unpack_from(order + "H", content, at)
    place = at + 2 + 12 * int(rng.integers(count))
    field, width = ((0, 2), (2, 2), (4, 4), (8, 2), (8, 4))[rng.integers(5)]
    number = int(rng.choice([*NUMBERS, 2, 5, 8, 16, 32, 34712])) & (256**width - 1)
    place += field
    middle = number.to_bytes(width, "little" if order == "<" else "big")
    return content[:place] + middle + content[place + width :]


def _numbers_in_the_header(rng, content):
    """Of a BMP its first 54 bytes, of a JPEG any segment's length or size."""
    if content.startswith(b"BM"):
        at = int(rng.integers(2, 54))
    else:
        places = [i for i in range(len(content) - 1) if content[i] == 0xFF]
        at = places[rng.integers(len(places))] + int(rng.integers(1, 10))
    width = int(rng.choice([1, 2, 4]))
    number = int(rng.choice(NUMBERS)) & (256**width - 1)
    order = ("little", "big")[rng.integers(2)]
    return content[:at] + number.to_bytes(width, order) + content[at + width :]
