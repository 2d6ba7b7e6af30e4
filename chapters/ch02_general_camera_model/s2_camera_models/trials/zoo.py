"""What several trials of the zoo share, and the trials that only feed a picture."""

from functools import cache

import numpy as np

from chapters.shared.rigs import rig_named
from chapters.shared.zoo import HALF_ANGLE, MIDDLE, SIZE_PX, K_of, camera, made
from raxel.cameras import caustic_points
from raxel.cameras.lenses.fit import fit_camera, radii_of

RIG = "coolpix-fce8-zoom-3"
# Where a ray is met again for the round trip.
POINT_MM = 2000.0


def grid_of(step):
    """Every step-th pixel (N, 2), symmetric about the middle."""
    axis = np.arange((SIZE_PX - 1) % step / 2, SIZE_PX, step)
    return np.stack(np.meshgrid(axis, axis), axis=2).reshape(-1, 2)


def looking(model):
    """Unit vector (3,) along which a camera looks: its middle ray.

    The mean ray where the middle pixel has none.
    """
    middle = model.rays(np.array([[MIDDLE, MIDDLE]]))
    if middle.valid[0]:
        return middle.directions[0]
    mean = np.nanmean(model.rays(grid_of(5)).directions, axis=0)
    return mean / np.linalg.norm(mean)


def angles_from(axis, directions):
    """Angles (N,) of directions (N, 3) from a unit vector, accurate."""
    across = np.linalg.norm(np.cross(directions, axis), axis=1)
    return np.arctan2(across, directions @ axis)


def there_and_back(model, pixels, rays):
    """Distance (N,) in px from pixels to those of points on their rays."""
    points = rays.origins + POINT_MM * rays.directions
    if model.kind != "planar mirrors":
        back = model.project(points).pixels
    else:
        facet, back = model.facet_of(pixels), np.full(pixels.shape, np.nan)
        for k in range(model.facets):
            mine = facet == k
            back[mine] = model.project_facet(points[mine], k).pixels
    return np.linalg.norm(back - pixels, axis=1)


def model_end(model):
    """Angle (deg) at which the law of a round central model ends."""
    if model.kind == "perspective":
        return float(np.degrees(np.arctan(model.max_radius)))
    return float(np.degrees(getattr(model, "max_angle", np.nan)))


def curve_trial(condition, rng):
    """theta (N,) rad and r (N,) px along a row, and the slope at 0."""
    model = camera(condition["model"])
    r = np.concatenate([[0.01], np.arange(0.5, 150, 0.5)])
    row = np.column_stack([MIDDLE + r, np.full_like(r, MIDDLE)])
    theta = angles_from(looking(model), model.rays(row).directions)
    seen = np.isfinite(theta)
    return {"theta": theta[seen], "r": r[seen] * theta[0] / r[0]}


# Fits. Models of the image plane cannot see 91.5 degrees.
PLANE_ANGLE = np.radians(70.0)


@cache
def lens(name):
    """Radius law of a lens: angles (N,) rad -> radii (N,) px."""
    rig = rig_named(RIG).laboratory().camera
    if name == "FC-E8":
        return lambda angles: radii_of(rig, angles)
    rim = radii_of(rig, np.array([HALF_ANGLE]))[0]
    return lambda angles: rim / HALF_ANGLE * angles


def _ideal(law):
    def start(focal, extra):
        return made(
            "fisheye",
            projection=law,
            focal_px=focal,
            principal_point=[0, 0],
            max_angle=1.7,
        )

    return start


def _micusik(law):
    def start(focal, extra):
        a, b = (focal, 0.1) if law == "sine" else (1 / focal, 1e-8)
        return made("micusik-pajdla", law=law, a=a, b=b, principal_point=[0, 0])

    return start


# Family -> (widest angle, numbers of extra terms, start(focal, extra)).
FAMILIES = {
    "radial": (
        PLANE_ANGLE,
        range(4),
        lambda f, n: made("perspective", K=K_of(f), radial=[0.0] * n),
    ),
    "division": (
        PLANE_ANGLE,
        range(1, 4),
        lambda f, n: made("division", K=K_of(f), coefficients=[0.0] * n),
    ),
    "field of view": (
        PLANE_ANGLE,
        range(4),
        lambda f, n: made("field of view", omega=1.0, K=K_of(f), radial=[0.0] * n),
    ),
    "equidistance": (HALF_ANGLE, (0,), _ideal("equidistance")),
    "equisolid angle": (HALF_ANGLE, (0,), _ideal("equisolid")),
    "stereographic": (HALF_ANGLE, (0,), _ideal("stereographic")),
    "Micusik-Pajdla, rational": (HALF_ANGLE, (0,), _micusik("rational")),
    "Micusik-Pajdla, sine": (HALF_ANGLE, (0,), _micusik("sine")),
    "Kannala-Brandt": (
        HALF_ANGLE,
        range(1, 4),
        lambda f, n: made(
            "kannala-brandt",
            k=[1.0] + [0.0] * n,
            pixels_per_unit=[f, f],
            principal_point=[0, 0],
        ),
    ),
    "Tardif": (
        HALF_ANGLE,
        range(2, 4),
        lambda f, n: made(
            "tardif",
            coefficients=[f, 0.0, -0.4 / f] + [0.0] * (n - 2),
            principal_point=[0, 0],
        ),
    ),
    "Scaramuzza": (
        HALF_ANGLE,
        range(1, 4),
        lambda f, n: made(
            "scaramuzza", coefficients=[f, -0.4 / f] + [0.0] * (n - 1), centre=[0, 0]
        ),
    ),
    "unified sphere": (
        HALF_ANGLE,
        range(4),
        lambda f, n: made("unified sphere", xi=1.0, K=K_of(1.5 * f), radial=[0.0] * n),
    ),
}
LENSES = ("equidistance", "FC-E8")


def mirror_trial(condition, rng):
    """The unified sphere fitted to a mirror that looks along -z."""
    model = camera(condition["model"])
    r = np.linspace(1, 95, 60)
    rays = model.rays(np.column_stack([MIDDLE + r, np.full_like(r, MIDDLE)]))
    theta = angles_from(np.array([0, 0, -1.0]), rays.directions)
    seen = rays.valid
    first = made("unified sphere", xi=0.95, K=K_of(80))()
    found = fit_camera(first, theta[seen], r[seen])
    return {"rms_px": found.rms_px, "xi": float(found.camera.xi)}


# Pictures: where rays start, where they go, and where neighbours meet.
DRAWN_MM = {
    "spherical mirror": 45.0,
    "hyperboloid off the focus": 45.0,
    "two plane mirrors": 260.0,
    "X-slits": 110.0,
    "pushbroom": 900.0,
    "axial": 5.0,
}


def rays_trial(condition, rng):
    """Rays (N, 3) of a lattice of pixels, and caustic points (M, 2, 3)."""
    model = camera(condition["model"])
    drawn, dense = grid_of(19), grid_of(5)
    rays = model.rays(drawn)
    return {
        "pixels": drawn,
        "origins": rays.origins,
        "directions": rays.directions,
        "caustic": caustic_points(model, dense),
        "from_px": dense,
    }


# The room. Looking ahead; up into a mirror; away from plane mirrors.
AHEAD = np.eye(3)
UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
BACK = np.diag([-1.0, 1.0, -1.0])
ROOM = {
    "radial": AHEAD,
    "field of view": AHEAD,
    "equidistance": AHEAD,
    "stereographic": AHEAD,
    "hyperboloid mirror": UP,
    "two plane mirrors": BACK,
    "X-slits": AHEAD,
    "pushbroom": AHEAD,
}


def room_trial(condition, rng):
    """The room through one camera: picture (h, w, 3) uint8."""
    from raxel.geometry import pose
    from raxel.lab.render import render
    from raxel.lab.room import room

    model = camera(condition["model"])
    T_world_camera = pose(ROOM[condition["model"]], np.zeros(3))
    radiance = render(
        model, T_world_camera, room(), colour=True, samples=condition["samples"]
    )
    # Display response of an ordinary screen.
    shown = 255 * np.clip(radiance / 1.1, 0, 1) ** (1 / 2.2)
    return {
        "picture": np.round(shown).astype(np.uint8),
        "mean": float(radiance.mean()),
        "seen": float(np.mean(radiance.max(axis=2) > 0)),
    }


PANELS = {
    "In the image plane": ("radial", "division", "field of view"),
    "Fisheye laws": (
        "equidistance",
        "equisolid angle",
        "stereographic",
        "Micusik-Pajdla, rational",
        "Micusik-Pajdla, sine",
        "Kannala-Brandt, symmetric",
    ),
    "Mirrors and general": (
        "Tardif",
        "Scaramuzza",
        "unified sphere",
        "hyperboloid mirror",
        "paraboloid mirror",
        "ellipsoid mirror",
        "spherical mirror",
    ),
}
CURVES = tuple(name for names in PANELS.values() for name in names)
