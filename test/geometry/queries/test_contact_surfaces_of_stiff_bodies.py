"""Contact surfaces of bodies of very different stiffness: the harder one tends to a rigid one.

Where the pressures are equal is then within the harder body, but nearer to its face than any
position is rounded.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.contact_scenes import Body, query_of

from drake_geom_ros.geometry import GeometryError
from truth.bodies.random_bodies import random_rotation

UPRIGHT = np.eye(3)
SOFT = 1e5  # [Pa]
CUBE = tuple((x, y, z) for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (-0.2, 0.2))
BODIES = {
    'box': Body('Box', (0.4, 0.6, 0.5), SOFT),
    'cube': Body('Convex', CUBE, SOFT),
    'ball': Body('Sphere', (0.3,), SOFT, 0.15),
    'cylinder': Body('Cylinder', (0.2, 0.5), SOFT, 0.15),
    'half space': Body('HalfSpace', (), SOFT, 0.2),
}


def surfaces_of(bodies, poses, order=(0, 1)):
    return query_of(bodies, poses, order=order)[0].ComputeContactSurfacesWithFallback()


@pytest.mark.parametrize('order', [(0, 1), (1, 0)])
@pytest.mark.parametrize(
    ('floor', 'cube', 'soft', 'depth'),
    [(100.0, 0.01, 1e5, 1e-5), (20.0, 0.01, 1e4, 1e-5), (20.0, 0.05, 1e5, 1e-6)],
)
def test_a_part_of_steel_on_foam(order, floor, cube, soft, depth):
    """The pressure of a slab grows from its face to its middle: E d / (h / 2)."""
    bodies = [Body('Box', (floor, floor, 1.0), soft), Body('Box', (cube,) * 3, 2e11)]
    turn = random_rotation(np.random.default_rng(1))
    at = [np.array([0.0, 0.0, -0.5]), np.array([0.3, 0.2, 0.5 * cube - depth])]
    for R in (UPRIGHT, turn):
        found, others = surfaces_of(bodies, [(R, R @ p) for p in at], order)
        assert not len(others)
        # With what is under of its sides.
        assert found.areas == pytest.approx([cube**2 + 4.0 * cube * depth], rel=1e-6)
        force = abs(found.forces_on_M_W[0] @ R[:, 2])
        # Positions are rounded to 1e-15 of the floor.
        assert force == pytest.approx(cube**2 * soft * depth / 0.5, rel=1e-6 + 1e-14 / depth)


@settings(max_examples=60)
@given(
    st.sampled_from(sorted(BODIES)),
    st.sampled_from(sorted(BODIES)),
    st.sampled_from([1e9, 1e12, 1e16, 1e20, 1e45]),
    st.integers(0, 2**32 - 1),
    st.permutations([0, 1]),
)
def test_a_much_harder_body_is_as_a_rigid_one(soft, hard, ratio, seed, order):
    if soft == hard == 'half space':
        return
    random = np.random.default_rng(seed)
    poses = [(random_rotation(random), random.uniform(-0.25, 0.25, 3)) for _ in range(2)]
    # Of a rigid half space all counts, whatever its normal is, as in Drake: so it is a hard one.
    limit = 1e8 * SOFT if hard == 'half space' else 0.0
    bodies = [BODIES[soft], BODIES[hard]._replace(modulus=limit)]
    rigid, beside = surfaces_of(bodies, poses, order)
    bodies[1] = BODIES[hard]._replace(modulus=SOFT * ratio)
    found, others = surfaces_of(bodies, poses, order)
    assert len(found) == len(rigid)
    assert len(others) == len(beside)
    if len(found):
        near = 10.0 / ratio + (1e-7 if limit else 1e-11)
        assert found.areas == pytest.approx(rigid.areas, rel=near, abs=near)
        sizes = SOFT * rigid.areas.max()
        np.testing.assert_allclose(
            found.forces_on_M_W, rigid.forces_on_M_W, rtol=0, atol=near * max(sizes, 1.0)
        )


@pytest.mark.parametrize('hint', [1e-6, 1e-12, 1e-50])
def test_a_thin_slab_is_as_rigid(hint):
    bodies = [BODIES['ball'], Body('HalfSpace', (), SOFT, hint)]
    poses = [(random_rotation(np.random.default_rng(1)), [0.0, 0.0, 0.25]), (UPRIGHT, [0, 0, 0])]
    (found,), _ = surfaces_of(bodies, poses)
    (rigid,), _ = surfaces_of([bodies[0], bodies[1]._replace(modulus=0.0)], poses)
    assert found.total_area() == pytest.approx(rigid.total_area(), rel=10.0 * hint + 1e-12)
    np.testing.assert_allclose(
        found.force_on_M_W(), rigid.force_on_M_W(), rtol=1e2 * hint + 1e-12, atol=1e-9
    )


@pytest.mark.parametrize('factor', [1e-60, 1e60])
def test_pressures_whose_squares_are_no_numbers_are_refused(factor):
    for body in (BODIES['ball'], BODIES['half space']):
        with pytest.raises(GeometryError, match=r'hydroelastic_modulus.*1e-50 to 1e\+50'):
            surfaces_of([body._replace(modulus=SOFT * factor)], [(UPRIGHT, [0, 0, 0])])
    with pytest.raises(GeometryError, match=r'slab_thickness.*1e-50 to 1e\+50'):
        surfaces_of([BODIES['half space']._replace(hint=factor)], [(UPRIGHT, [0, 0, 0])])
