"""Random motions of all shapes: never clear where a fine scan touches, and laws of any answer."""

import numpy as np
import pytest
from geometry.queries.moving_bodies import Moving
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import ACCURACY_LEVELS, Convex, Mesh
from drake_geom_ros.math.batched import compose, matrices_from_poses, poses_from_matrices

ROUNDING = 1e-11  # [m] of the oracle's matrices


def moved(pose, R, p):
    """Return poses (n, 7) after a common rigid motion."""
    return poses_from_matrices(*compose(R, p, *matrices_from_poses(pose)))


def hold(bodies, starts, ends, check, least, interpolation):
    """Hold what is told against a fine scan."""
    times, distances, bounds = bodies.scan(starts, ends, interpolation)
    upper = distances + bounds + ROUNDING
    near = times[upper <= least]
    if check.outcome == 'clear':
        assert not len(near)
        assert least < check.lower_bound <= upper.min()
        return
    assert not (near < check.last_free).any()
    if check.outcome == 'contact':
        first, last = check.times
        assert last - first <= 1e-6
        assert not len(near) or near[0] >= first
        assert check.distance + check.error_bound <= least + ROUNDING
        # Just before it nothing is so near, as nothing is between the scan's states.
        assert (distances - bounds - ROUNDING <= least)[times >= first].any() or last < 1.0


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    interpolation=st.sampled_from(['slerp', 'screw']),
    accuracy=st.sampled_from(ACCURACY_LEVELS),
    least=st.sampled_from([0.0, 0.05]),
    spread=st.sampled_from([0.5, 1.5, 4.0]),
)
def test_random_motions_against_a_fine_scan(seed, interpolation, accuracy, least, spread):
    rng = np.random.default_rng(seed)
    bodies = Moving.random(rng, int(rng.integers(2, 5)))
    starts, ends = bodies.states(rng, 2, spread)
    if seed % 2:  # some stay
        ends[0] = starts[0]
    asked = {'min_distance': least, 'interpolation': interpolation, 'accuracy': accuracy}
    check = bodies.check(starts, ends, **asked)
    hold(bodies, starts, ends, check, least, interpolation)
    back = bodies.check(ends, starts, **asked)
    if 'unknown' not in (check.outcome, back.outcome):
        assert check.outcome == back.outcome
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R *= np.linalg.det(R)
    p = rng.normal(size=3)
    other = bodies.check(moved(starts, R, p), moved(ends, R, p), **asked)
    if interpolation == 'slerp' and 'unknown' not in (check.outcome, other.outcome):
        assert check.outcome == other.outcome
        if check.outcome == 'contact':
            assert np.allclose(check.times, other.times, rtol=0, atol=2e-6)


@pytest.mark.parametrize('seed', range(6))
def test_hulls_and_solids(seed, tmp_path):
    rng = np.random.default_rng(seed)
    # An L-shaped prism: its hull fills the corner.
    outline = [(0, 0), (1, 0), (1, 0.3), (0.3, 0.3), (0.3, 1), (0, 1)]
    low = [(x, y, 0.0) for x, y in outline]
    high = [(x, y, 0.3) for x, y in outline]
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(c, b, a) for a, b, c in caps] + [(a + 6, b + 6, c + 6) for a, b, c in caps]
    for k in range(6):
        n = (k + 1) % 6
        faces += [(k, n, n + 6), (k, n + 6, k + 6)]
    path = tmp_path / 'l.obj'
    lines = [f'v {x} {y} {z}' for x, y, z in low + high]
    path.write_text('\n'.join(lines + [f'f {a + 1} {b + 1} {c + 1}' for a, b, c in faces]) + '\n')
    for shapes in ([Mesh(str(path)), Mesh(str(path))], [Convex(str(path)), Mesh(str(path))]):
        bodies = Moving(shapes)
        starts, ends = bodies.states(rng, 2, 0.9)
        check = bodies.check(starts, ends)
        hold(bodies, starts, ends, check, 0.0, 'slerp')
