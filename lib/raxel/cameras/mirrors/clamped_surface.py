"""A sheet of mirror clamped along a straight edge and bent: hit, reflect, parametrise.

In the mirror's frame the clamped edge lies on the y axis about the origin, x runs along
the flat sheet to its free edge and z away from the light. With p a profile (`profiles`)
the bent sheet is
    z(x, y) = h p(x / h),   h = 1 + c y,
a part of a cone with its apex on the line of the clamp, at y = -1 / c; for c = 0 a
cylinder. Every such sheet is developable, and lies on the clamp's line with slope zero
all along: rulings can only run obliquely if they spread from a point of that line, for
one that crosses it at an angle would leave the edge straight on one side alone. To the
cone, `Unevenness` is added. Lengths are mm.
"""

import numpy as np

from raxel.cameras.core.base import checked_array, checked_positive
from raxel.cameras.mirrors.conic_surface import Reflection
from raxel.cameras.mirrors.running_integral import RunningIntegral
from raxel.errors import InputError

# Newton's steps from the flat sheet to the bent one, and the share of the half
# diagonal at which they have arrived.
STEPS, ARRIVED = 60, 1e-13
# The surface is trusted this share of the sheet beyond its border.
BEYOND = 0.5
RIM = 1e-12
STEEPEST = 1.0
# Rulings so far from the clamp's direction bring the apex into the sheet's reach.
MOST_RULINGS = np.radians(45)
GRID = (33, 17)


class ClampedMirror:
    """profile: a BeamProfile or ElasticaProfile of the line y = 0.

    size: (length from the clamp along the sheet, width), mm; rulings: angle, radians,
    between the ruling through the middle of the free edge and the clamp's line,
    positive where they spread towards +y; unevenness: an `Unevenness`; holder: length
    of sheet behind the clamp's holder, mm, which no ray meets.
    Raises InputError naming the field that no such sheet can have, also for one that
    somewhere is steeper than 45 degrees.
    """

    # Reflections are looked for as on a mirror that may be hollow in places.
    inside = True

    def __init__(self, profile, size, rulings, unevenness, holder):
        self.profile, self.unevenness = profile, unevenness
        self.size = checked_positive("size", size, (2,))
        self.half_width = self.size[1] / 2
        self.rulings = float(checked_array("rulings", rulings, ()))
        self.holder = float(checked_array("holder", holder, ()))
        self._check()
        self._fan = np.tan(self.rulings) / self.size[0]
        self.radius = float(np.hypot(self.size[0] / 2, self.half_width))
        self._middle = np.array([self.size[0] / 2, 0.0])
        ends = np.append(profile.breaks, self.size[0] * (1 + BEYOND))
        # Along the edge where the cone is narrowest a load may lie beyond the sheet.
        ends[-1] = max(ends[-1], 1.5 * profile.breaks[-1])
        self._length = RunningIntegral(ends, self._length_rate)
        self._check_slope()

    def _check(self):
        length, load = self.size[0], self.profile.loads[-1]
        if load > length:
            raise InputError(
                f"field 'loads': found one at {load:g} mm on a sheet {length:g} mm "
                "long; put it on the sheet"
            )
        if not 0 <= self.holder < length:
            raise InputError(
                f"field 'holder': found {self.holder:g} mm of a sheet {length:g} mm "
                "long; leave some of it to see"
            )
        near = abs(np.tan(self.rulings)) * self.half_width / length
        if not (abs(self.rulings) <= MOST_RULINGS and near < 1 / 2):
            raise InputError(
                f"field 'rulings': found {np.degrees(self.rulings):.3g} degrees, which "
                "bring the cone's apex up to the sheet; give fewer"
            )

    def _check_slope(self):
        x, y = (self._middle + self.radius * self.nodes().reshape(-1, 2)).T
        _, by_x, by_y, *_ = self.height(x, y)
        slope = np.hypot(by_x, by_y).max()
        if not slope <= STEEPEST:
            steep = np.degrees(np.arctan(slope))
            raise InputError(
                f"field 'deflections': the sheet is up to {steep:.0f} degrees steep; "
                "45 is the most"
            )

    def nodes(self):
        """Chart coordinates (17, 33, 2) spread over the sheet, its border included."""
        x = np.linspace(0, self.end, GRID[0])
        y = np.linspace(-self.half_width, self.half_width, GRID[1])
        return (np.stack(np.meshgrid(x, y), axis=-1) - self._middle) / self.radius

    @property
    def end(self):
        """x of the middle of the free edge, mm."""
        x = self.size[0]
        for _ in range(STEPS):
            gap = self.flat(np.array([x]), np.zeros(1))[0][0] - self.size[0]
            x -= gap / np.hypot(1, self.profile.at(np.array([x]))[1][0])
            if abs(gap) <= ARRIVED * self.radius:
                break
        return float(x)

    def height(self, x, y):
        """Height (N,) at x, y (N,), then its derivatives by x, y, xx, xy and yy."""
        h = 1 + self._fan * y
        at = x / h
        z, slope, bend = self.profile.at(at)
        turn = -self._fan * at
        bend = bend / h
        heights = np.stack(
            [
                h * z,
                *(slope, self._fan * z + turn * slope),
                *(bend, turn * bend, turn**2 * bend),
            ]
        )
        return heights if self.unevenness.flat else heights + self.unevenness.at(x, y)

    def flat(self, x, y):
        """Where x, y (N,) of the bent sheet lie on the flat one: x, y (N,), mm.

        The cone unrolls about its apex: distances from it stay, and angles about it
        become lengths of the profile seen from there. Terms are ordered so that a
        cylinder is the limit without loss of digits.
        """
        c = self._fan
        h = 1 + c * y
        at = x / h
        z, _, _ = self.profile.at(at)
        rise = at**2 + z**2
        stretch = np.sqrt(1 + c**2 * rise)
        way = self._length(at)
        turned = way * np.sinc(c * way / np.pi)
        inward = -c * (way * np.sinc(c * way / (2 * np.pi))) ** 2 / 2
        outward = c * rise / (stretch + 1) * np.cos(c * way) + inward
        return h * stretch * turned, y * stretch * np.cos(c * way) + outward

    def _length_rate(self, at):
        """Length on the flat sheet by x / h, at unit distance of the apex from it."""
        z, slope, _ = self.profile.at(at)
        c = self._fan
        across = c * (z - at * slope)
        return np.sqrt(1 + slope**2 + across**2) / (1 + c**2 * (at**2 + z**2))

    def normals(self, points):
        """Normals (N, 3), not unit, towards the light."""
        _, by_x, by_y, *_ = self.height(points[:, 0], points[:, 1])
        return np.column_stack([by_x, by_y, -np.ones(len(points))])

    def carries(self, points):
        """Whether points (N, 3) of the surface are on the sheet, ahead of its holder.

        The sheet does not stretch: its border is where it was on the flat one.
        """
        with np.errstate(invalid="ignore", over="ignore"):
            x, y = self.flat(points[:, 0], points[:, 1])
            along = (x >= self.holder) & (x <= self.size[0] * (1 + RIM))
            return along & (np.abs(y) <= self.half_width * (1 + RIM))

    def reflect(self, origins, directions):
        """Meet rays with the sheet and turn them: exact to rounding.

        origins, directions: (N, 3), the latter unit. Not valid where a ray comes from
        behind. The sheet is too flat for a second reflection by more than a grazing
        ray; such a ray is not looked for.
        """
        points, met = self._meetings(origins, directions)
        with np.errstate(over="ignore", invalid="ignore"):
            n = self.normals(points)
            towards = np.sum(directions * n, axis=1)
            leaving = directions - (2 * towards / np.sum(n * n, axis=1))[:, None] * n
            leaving /= np.linalg.norm(leaving, axis=1, keepdims=True)
            valid = met & (towards < 0) & self.carries(points)
        keep = valid[:, None]
        return Reflection(
            np.where(keep, points, np.nan), np.where(keep, leaving, np.nan), valid
        )

    def _meetings(self, o, d):
        """(points (N, 3), met (N,)): Newton on the height of the ray over the sheet."""
        reach = BEYOND * self.size
        with np.errstate(all="ignore"):
            t = -o[:, 2] / d[:, 2]
            met = np.zeros(len(o), bool)
            for _ in range(STEPS):
                x, y, z = (o + t[:, None] * d).T
                x = np.clip(x, -reach[0], self.size[0] + reach[0])
                y = np.clip(y, -self.half_width - reach[1], self.half_width + reach[1])
                height, by_x, by_y, *_ = self.height(x, y)
                rate = d[:, 2] - by_x * d[:, 0] - by_y * d[:, 1]
                step = (height - z) / rate
                t = t + step
                met = np.abs(step) <= ARRIVED * np.maximum(self.radius, np.abs(t))
                if met[np.isfinite(t)].all():
                    break
            points = o + t[:, None] * d
            return points, met & (t > 0)

    def chart(self, points):
        """Chart coordinates p (N, 2) of places next to points (N, 3), see `point`."""
        return (points[:, :2] - self._middle) / self.radius

    @property
    def chart_extent(self):
        """|p| at the sheet's corners, as long as it is flat."""
        return 1.0

    def point(self, p):
        """Surface points (N, 3) of chart coordinates p (N, 2): x, y from the sheet's
        middle over half its diagonal.

        Returns the points, their first derivatives (N, 3, 2) and second (N, 3, 2, 2).
        """
        x, y = (self._middle + self.radius * p).T
        z, by_x, by_y, xx, xy, yy = self.height(x, y)
        first = np.zeros((len(p), 3, 2))
        first[:, :2] = self.radius * np.eye(2)
        first[:, 2] = self.radius * np.column_stack([by_x, by_y])
        second = np.zeros((len(p), 3, 2, 2))
        bends = np.column_stack([xx, xy, xy, yy]).reshape(-1, 2, 2)
        second[:, 2] = self.radius**2 * bends
        return np.column_stack([x, y, z]), first, second
