"""What every answer to a hard case must hold, by the case's truth and by the surfaces alone."""

import functools
import math

import numpy as np
from oracles import pairs
from scipy.spatial import ConvexHull

from drake_geom_ros.evidence.truth import bodies as truth
from drake_geom_ros.evidence.truth.meshes import point_distance
from drake_geom_ros.geometry import METHODS
from drake_geom_ros.math import RigidTransform

EPS = truth.EPS
ROUNDING = 64.0 * EPS  # of the extent: what positions and normals may be off by
# Of the extent: what an iteration, which stops by the distance, may leave in the witness points
# and, times a lever as long as the pair, in the normal.
WITNESSES = 1e-10
NORMALS = 1e-8
ITERATIVE = METHODS['iterative']
TOUCHING = 1e-14  # of the size: what counts as touching, see the engine's TOUCHING_DEPTH
LEVELS = {'bound': math.inf, 'fast': 1e-3, 'balanced': 1e-6, 'exact': 1e-9}  # [m] at 1 m


def away(case):
    """Return how far [m] the pair is from the world's origin."""
    return float(max(np.abs(case.a.p).max(), np.abs(case.b.p).max()))


def rounding(case):
    """Return what positions may be off by [m]: digits, and rotations that are not quite some."""
    skew = max(np.abs(one.R.T @ one.R - np.eye(3)).max() for one in (case.a, case.b))
    return ROUNDING * (case.extent + away(case)) + skew * case.extent


def slack(case, row):
    """Return what the answer may be off by [m]: its certificate, and that of the truth."""
    return float(row.error_bound[0]) + case.tolerance


def iterated(row, part):
    """Return what an iteration may leave, and nothing where a closed form answered."""
    return part if row.method[0] == ITERATIVE else 0.0


def check_certificate(case, row):
    """The distance is right within the error bound."""
    assert np.isfinite(row.distance[0])
    assert abs(row.distance[0] - case.distance) <= slack(case, row)


def check_width(case, row, level):
    """The bound is as tight as the level promises, rounding of poses far away aside.

    In a solid no level promises a width.
    """
    if case.has_solid and case.distance < 0.0:
        return
    size = min([1.0] + [one.radius for one in (case.a, case.b) if one.radius])
    allowed = 2.0 * LEVELS[level] * size + rounding(case)
    assert row.error_bound[0] <= allowed


def check_geometry(case, row):
    """Finite, a unit normal, witness points on the surfaces that span the distance along it."""
    nhat, p_WCa, p_WCb = row.nhat_BA_W[0], row.p_WCa[0], row.p_WCb[0]
    assert np.isfinite([nhat, p_WCa, p_WCb]).all()
    assert abs(np.linalg.norm(nhat) - 1.0) <= 1e-12
    np.testing.assert_allclose(p_WCa - p_WCb, row.distance[0] * nhat, rtol=0, atol=rounding(case))
    off = rounding(case) + slack(case, row) + iterated(row, WITNESSES) * case.extent
    assert abs(height(case.a, p_WCa)) <= off
    assert abs(height(case.b, p_WCb)) <= off


def check_normal(case, row):
    """No direction has a wider gap: the normal attains the distance, and is what was expected.

    Solids are not what their supporting planes say: of them the second alone, and
    ``check_contact``.
    """
    nhat = row.nhat_BA_W[0]
    # How well a normal can be known depends on how far the cores, without the radii, are apart.
    core = abs(case.distance + sum(map(radius_of_core, (case.a, case.b))))
    spread = 1.0 + case.extent / max(core, row.error_bound[0], math.ulp(0.0))
    if not case.has_solid:
        lacking = case.distance - truth.width(case.a, case.b, nhat)
        allowed = rounding(case) + slack(case, row) * spread + iterated(row, NORMALS) * case.extent
        assert lacking <= allowed
    if case.normals is not None:
        turned = min(np.linalg.norm(nhat - expected) for expected in case.normals)
        known = max(core, case.tolerance, EPS * case.extent)
        assert turned <= NORMALS + math.sqrt(8.0 * (slack(case, row) + rounding(case)) / known)


def check_contact(case, row, scene):
    """Moved along the normal by its distance, A touches B and overlaps with nothing of it."""
    if not case.has_solid:
        return
    X_WA = case.a.pose
    step = RigidTransform(-row.distance[0] * row.nhat_BA_W[0])
    scene.pose(step @ X_WA, case.b.pose)
    touching = scene.distance()
    scene.pose(X_WA, case.b.pose)
    assert abs(touching.distance[0]) <= slack(case, row) + slack(case, touching) + rounding(case)


def check_witnesses(case, row):
    """Where the witness points are unique they are the expected ones."""
    if case.witnesses is None:
        return
    # A point on a surface curved as the whole pair is known to the root of the distance's error.
    allowed = rounding(case) + math.sqrt(8.0 * (slack(case, row) + rounding(case)) * case.extent)
    found = np.array([row.p_WCa[0], row.p_WCb[0]])
    assert max(math.hypot(*off) for off in found - case.witnesses) <= allowed


def radius_of_core(body):
    """Return the radius of the ball that a body is its core grown by, as far as it matters."""
    return body.size[0] if body.kind in ('Sphere', 'Capsule') else 0.0


def height(body, p_W):
    """Return the signed distance of a point near a body's surface, well enough to tell."""
    if body.kind == 'HalfSpace':
        return float((p_W - body.p) @ body.R[:, 2])
    s = body.radius
    if s <= EPS * np.abs(body.p).max():  # a point, as far as the digits of its position go
        return math.hypot(*(p_W - body.p))
    q = (body.R.T @ (p_W - body.p)) / s
    if body.kind == 'Solid':
        return s * float(point_distance(body.corners / s, q)[0])
    if body.kind == 'Convex':
        planes = _planes(body.size)
        return s * float((planes[:, :3] @ q + planes[:, 3]).max())
    kind, size = truth.kernel_form(body)
    return s * pairs.height(kind, size / s, q)


@functools.cache
def _planes(vertices):
    points = np.array(vertices)
    return ConvexHull(points / np.linalg.norm(points, axis=1).max()).equations
