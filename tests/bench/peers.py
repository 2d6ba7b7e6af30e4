"""What the decoder of active grids is measured against: plain code, a package, memory.

Plain code does what the decoder does in the easiest case, in one core and whole
pictures: cell, place after 7 x 7, sigma and a mask. It knows no wrap rule, no breaks
and no rim, and takes pictures of a Gray code with inverse and one cell a period.
"""

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np

from raxel.sets.patterns import cell_width

LEAST_CONTRAST, LEAST_MODULATION = 7, 5  # standard deviations, as in the decoder
WINDOW = 7


def read_plan(patterns, monitor_px):
    """Of each axis: [(picture, inverse), ...], [pictures of the steps], cell in px."""
    axes = []
    for axis in "xy":
        own = [(p, k) for k, p in enumerate(patterns) if p.axis == axis]
        bits = {(p.bit, p.inverse): k for p, k in own if p.kind == "gray"}
        pairs = [(bits[b, False], bits[b, True]) for b in range(len(bits) // 2)]
        steps = [k for _, k in sorted((p.step, k) for p, k in own if p.kind == "phase")]
        gray = next(p for p, _ in own if p.kind == "gray")
        axes.append((pairs, steps, cell_width(gray, monitor_px)))
    return axes


def with_numpy(images, axes, noise):
    """location, sigma (A, H, W) float32 and mask (H, W)."""
    mask = np.ones(images[0].shape, bool)
    location, sigma = (np.empty((2, *mask.shape), np.float32) for _ in range(2))
    for axis, (pairs, steps, cell) in enumerate(axes):
        value = np.zeros(mask.shape, bool)
        code = np.zeros(mask.shape, np.int16)
        for picture, inverse in pairs:
            value ^= images[picture] > images[inverse]
            code = 2 * code + value
        light, dark = images[pairs[0][0]].astype(np.int16), images[pairs[0][1]]
        mask &= np.abs(light - dark) > LEAST_CONTRAST * noise
        sine, cosine = (
            _mean_of_window(sum(w * images[k] for w, k in used))
            for used in _weighed_steps(steps)
        )
        modulation = np.hypot(sine, cosine)
        mask &= modulation > LEAST_MODULATION * np.sqrt(2 / len(steps)) * noise
        turn = np.arctan2(sine, cosine) * np.float32(0.5 / np.pi)
        turn += turn < 0
        location[axis] = cell * (code + turn)
        sigma[axis] = _sigma(len(steps), cell, noise) / modulation
    return location, sigma, mask


def _weighed_steps(steps):
    """[(weight, picture), ...] of sine and cosine, those that count."""
    angle = 2 * np.pi * np.arange(len(steps)) / len(steps)
    waves = np.array([np.cos(angle), np.sin(angle)])
    weights = np.round(2 / len(steps) * waves, 12).astype(np.float32)
    return [[(w, k) for w, k in zip(row, steps, strict=True) if w] for row in weights]


def _sigma(count, cell, noise):
    return np.float32(cell * np.sqrt(2 / count) * noise / (2 * np.pi * WINDOW))


def _mean_of_window(whole):
    framed = np.pad(whole, WINDOW // 2, mode="reflect")
    height, width = whole.shape
    rows = sum(framed[k : k + height] for k in range(WINDOW))
    return sum(rows[:, k : k + width] for k in range(WINDOW)) / np.float32(WINDOW**2)


def with_opencv(images, axes, noise):
    """As `with_numpy`, every step a call of OpenCV."""
    mask = np.full(images[0].shape, 255, np.uint8)
    location, sigma = (np.empty((2, *mask.shape), np.float32) for _ in range(2))
    for axis, (pairs, steps, cell) in enumerate(axes):
        value = np.zeros(mask.shape, np.uint8)
        code = np.zeros(mask.shape, np.uint8)
        for k, (picture, inverse) in enumerate(pairs):
            bit = cv2.compare(images[picture], images[inverse], cv2.CMP_GT)
            cv2.bitwise_xor(value, bit, value)
            cv2.bitwise_and(value, 1 << (len(pairs) - 1 - k), bit)
            cv2.bitwise_or(code, bit, code)
        contrast = cv2.absdiff(images[pairs[0][0]], images[pairs[0][1]])
        seen = cv2.compare(contrast, LEAST_CONTRAST * noise, cv2.CMP_GT)
        cv2.bitwise_and(mask, seen, mask)
        sine, cosine = (
            cv2.boxFilter(_weighed(images, used), -1, (WINDOW, WINDOW))
            for used in _weighed_steps(steps)
        )
        modulation, angle = cv2.cartToPolar(cosine, sine)
        least = LEAST_MODULATION * np.sqrt(2 / len(steps)) * noise
        cv2.bitwise_and(mask, cv2.compare(modulation, least, cv2.CMP_GT), mask)
        share = cell / (2 * np.pi)
        cv2.addWeighted(code, cell, angle, share, 0, location[axis], cv2.CV_32F)
        cv2.divide(float(_sigma(len(steps), cell, noise)), modulation, sigma[axis])
    return location, sigma, mask > 0


def _weighed(images, used):
    if len(used) == 2:
        (p, a), (q, b) = used
        return cv2.addWeighted(
            images[a], float(p), images[b], float(q), 0, dtype=cv2.CV_32F
        )
    total = np.zeros(images[0].shape, np.float32)
    for weight, k in used:
        cv2.addWeighted(total, 1, images[k], float(weight), 0, total, cv2.CV_32F)
    return total


def read_and_write(images, out, threads):
    """Look at every byte of the pictures, and write every one of out (A, H, W)."""

    def part(k):
        rows = slice(k * len(images[0]) // threads, (k + 1) * len(images[0]) // threads)
        for image in images:
            np.bitwise_or.reduce(_words(image[rows]))
        out[:, rows] = 1

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(part, range(threads)))


def _words(rows):
    flat = rows.reshape(-1).view(np.uint8)
    return flat[: len(flat) // 8 * 8].view(np.uint64)


def fringes_decoder(count, size):
    """decode(threads) of the package, on patterns of its own; None where it is not.

    count: of pictures, for both axes with two numbers of periods; size: (width,
    height). It reads no Gray code: it tells periods apart by a second sine.
    """
    try:
        from fringes import Fringes
    except ImportError:
        return None
    package = Fringes()
    package.X, package.Y = size
    package.K, package.N, package.v = 2, max(3, count // 4), [8, 1]
    pictures = package.encode()
    return lambda threads: package.decode(pictures, threads=threads).x
