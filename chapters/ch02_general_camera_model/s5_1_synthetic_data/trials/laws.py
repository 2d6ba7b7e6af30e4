"""The generic method under four projection laws: same rays, same noise."""

from __future__ import annotations

from chapters.shared.synthetic import (
    METHODS,
    POINTS,
    camera_of,
    draw_grids,
    draw_pixels,
    observe,
    scores,
)

LAWS = ("equidistance", "equisolid", "stereographic", "perspective")
# Its radius is the largest at every angle short of the corner, so rays
# drawn in its image lie inside the other images too.
OUTERMOST_LAW = "equisolid"


def measure_laws(condition, rng):
    """Data by law: the same grids, rays and noise, seen by each camera."""
    fov_deg, domain = condition["fov_deg"], condition["domain"]
    drawn = camera_of(OUTERMOST_LAW, fov_deg)
    grids, _ = draw_grids(rng)
    pixels, _ = draw_pixels(drawn, grids, condition["extent"], rng)
    rays = drawn.rays(pixels).directions
    noise = condition["noise"] * rng.standard_normal((3, POINTS, 2))
    data = {}
    for law in LAWS:
        camera = camera_of(law, fov_deg)
        seen = camera.project(rays).pixels
        data[law] = observe(camera, grids, seen, noise, domain)
    return data


def laws_trial(condition, rng):
    """One trial: the generic method's scores under every law."""
    measured = measure_laws(condition, rng)
    return {law: scores(measured[law], METHODS[1:]) for law in LAWS}
