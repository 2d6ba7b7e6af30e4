"""Section 5.1: a bent mirror in the plane of its bending."""

import numpy as np
from scipy.integrate import solve_ivp

from raxel.calibration.mirror.curves import HeightCurve, reflected, viewing_rays
from raxel.cameras.mirrors.profiles import BeamProfile, ElasticaProfile

LENGTH_MM, ANGLE_DEG = 420.0, 67.5
FOOT = np.array([-160.0, 400.0])
SPAN = (-0.38, 0.38)
TIP_MM, SCENE_MM = 16.7, 800.0
ANCHORS = (0.9, 1.0, 1.1)
SLOPES2 = (0.001, 0.0036, 0.01, 0.02, 0.036, 0.06, 0.1, 0.2, 0.4)
FAR = tuple(float(z) for z in np.geomspace(10, 100, 7))
"""Depths of distant scenes, in camera distances."""
DEFECT_RAD = 1e-3
DEFECT_DEPTHS_MM = (250.0, 500.0, 1000.0, 2500.0, 5000.0, 10000.0)
ALONG = np.array([np.sin(np.radians(ANGLE_DEG)), np.cos(np.radians(ANGLE_DEG))])
STEP = 1e-5


def curve(tip):
    """The mirror, bent by a force at its free edge (5.1)."""
    heights = tip / 2 * np.array([0.0, 0.0, 3.0, -1.0])
    return HeightCurve(heights, FOOT, ALONG, LENGTH_MM)


def beam_trial(condition, rng):
    """Largest difference of elastica and cubic, over the deflection of the cubic's tip.

    slope2: largest squared slope of the cubic, 3/2 of tip over length. By the same
    force, and bent to the same deflection where the force acts.
    """
    tip = np.sqrt(condition["slope2"]) * LENGTH_MM / 1.5
    beam = BeamProfile.deflected(LENGTH_MM, tip)
    bent = {
        "same_force": ElasticaProfile(LENGTH_MM, beam.forces),
        "same_deflection": ElasticaProfile.deflected(LENGTH_MM, tip),
    }
    out = {"tip_mm": float(tip)}
    for name, elastica in bent.items():
        x = np.linspace(0, float(elastica.places[0]), 401)
        apart = elastica.at(x)[0] - beam.at(x)[0]
        out[name] = float(np.abs(apart).max() / tip)
    return out


def anchored(u, points_at, start):
    """Distances (N,) along viewing rays u of the curve that reflects them to points.

    points_at: u -> scene point (2,); start: distance at u[0]. The normal halves the
    angle between viewing ray and the way to the point, and the curve is at right angles
    to it: a differential equation of first order, with one curve for every start.
    """

    def slope(at, D):
        V, V_u = viewing_rays([at])
        to = points_at(at) - D[0] * V[0]
        N = V[0] - to / np.linalg.norm(to)
        return [-D[0] * (V_u[0] @ N) / (V[0] @ N)]

    ends = (u[0], u[-1])
    return solve_ivp(slope, ends, [start], t_eval=u, rtol=1e-12, atol=1e-11).y[0]


def shapes_trial(condition, rng):
    """Mirrors anchored at several distances that show the same points on the same rays.

    offset_mm: farthest that a point lies from its scene ray, with tangents taken by
    differences of the curve. beyond_scale_mm: RMS distance from the true curve along
    the rays, after the best common factor.
    """
    true = curve(TIP_MM)

    def points_at(u):
        return true.points([u])[0] + SCENE_MM * true.scene_rays([u])[0]

    u = np.linspace(*SPAN, 41)
    inner = np.linspace(SPAN[0] + 0.01, SPAN[1] - 0.01, 41)
    around = np.concatenate([[SPAN[0]], *[[v - STEP, v, v + STEP] for v in inner]])
    points = np.array([points_at(v) for v in inner])
    D_true = true.distances(inner)
    out = {"points": points, "true": true.points(u)}
    for number, factor in enumerate(ANCHORS):
        start = factor * true.distances([SPAN[0]])[0]
        D = anchored(around, points_at, start)[1:].reshape(-1, 3)
        V = [viewing_rays(inner + step)[0] for step in (-STEP, 0.0, STEP)]
        before, S, after = (D[:, [k]] * V[k] for k in range(3))
        V_r = reflected(V[1], after - before)
        to = points - S
        scale = (D[:, 1] @ D_true) / (D_true @ D_true)
        out[f"anchor_{number}"] = {
            "factor": factor,
            "offset_mm": float(
                np.abs(V_r[:, 0] * to[:, 1] - V_r[:, 1] * to[:, 0]).max()
            ),
            "beyond_scale_mm": float(np.sqrt(np.mean((D[:, 1] - scale * D_true) ** 2))),
            "curve": S,
        }
    return out


def far_trial(condition, rng):
    """Mean angle between the scene rays of the same points before and after bending.

    depth: of the points, from the mirror, in distances of the camera from its middle.
    Before bending the mirror is flat, and each point has an image behind it.
    """
    bent, flat = curve(TIP_MM), curve(0.0)
    distance = float(np.linalg.norm(FOOT + LENGTH_MM / 2 * ALONG))
    u = np.linspace(SPAN[0] + 0.05, SPAN[1] - 0.05, 15)
    after = bent.scene_rays(u)
    points = bent.points(u) + condition["depth"] * distance * after
    away = np.array([-ALONG[1], ALONG[0]])
    image = points + 2 * ((FOOT - points) @ away)[:, None] * away
    before = flat.scene_rays(image[:, 0] / image[:, 1])
    sine = after[:, 0] * before[:, 1] - after[:, 1] * before[:, 0]
    return {"angle_deg": float(np.degrees(np.mean(np.abs(np.arcsin(sine)))))}


def defect_trial(condition, rng):
    """Displacement, mm, of the visible point by a defect of 1 mrad of the mirror.

    On a plane orthogonal to the scene ray, ``depth`` mm from the mirror.
    """
    bent = curve(TIP_MM)
    u = np.linspace(*SPAN, 15)
    V, tangents = viewing_rays(u)[0], bent.tangents(u)
    c, s = np.cos(DEFECT_RAD), np.sin(DEFECT_RAD)
    turned = tangents @ np.array([[c, s], [-s, c]])
    good, bad = reflected(V, tangents), reflected(V, turned)
    cosine = np.einsum("ij,ij->i", good, bad)
    moved = condition["depth"] * np.sqrt(1 / cosine**2 - 1)
    return {"moved_mm": float(np.mean(moved))}
