"""Every scene of the bench is what it says, and builds and answers in this project."""

import numpy as np
import pytest

from bench.peers import ours, scenes
from bench.peers.motion import PACES

FEW = [name for name in scenes.names() if name.partition('/')[0] != 'anchored-2000']
SMALL = ('spheres-50', 'arms', 'hulls-20')
CYCLES = 5


@pytest.mark.parametrize('pace', PACES)
@pytest.mark.parametrize('name', FEW)
def test_a_scene_is_posed_in_every_cycle(name, pace):
    scene = scenes.build(name)
    poses = scene.motion.poses(CYCLES, 1, pace)
    assert scene.name == name
    assert poses.shape == (CYCLES, len(scene.bodies), 7)
    np.testing.assert_allclose(np.linalg.norm(poses[..., 3:], axis=-1), 1.0, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(poses, scenes.build(name).motion.poses(CYCLES, 1, pace))


@pytest.mark.parametrize('name', [name for name in FEW if not name.endswith(scenes.SPREAD)])
def test_motions_are_small_and_of_as_many_bodies_as_the_variant_says(name):
    scene = scenes.build(name)
    poses = scene.motion.poses(CYCLES, seed=1)
    moved = (np.diff(poses, axis=0) != 0.0).any(axis=(0, 2))
    share = 0.1 if name.endswith(scenes.TENTH) else 1.0
    assert moved.sum() == max(1, round(share * len(scene.bodies)))
    assert np.abs(np.diff(poses[..., :3], axis=0)).max() < 0.05


@pytest.mark.parametrize('name', SMALL)
def test_a_scene_builds_and_answers_in_this_project(name):
    scene = scenes.build(name)
    side = ours.Side(scene)
    side.set_poses(side.layout(scene.motion.poses(CYCLES, seed=1)[-1]))
    found = {query: answer() for query, answer in side.answers.items()}
    bodies, still = len(scene.bodies), len(scene.anchored)
    pairs = bodies * (bodies - 1) // 2 + bodies * still - len(scene.filtered)
    assert set(found) == set(scenes.QUERIES)
    assert 0 < found['penetration'] <= found['candidates'] < pairs
    assert found['penetration'] <= found['near'] < pairs
    assert found['all'] == pairs
    assert found['points'] == 100 * (bodies + still)
    assert found['has_collisions'] == 1


@pytest.mark.parametrize('name', SMALL)
def test_what_is_spread_out_does_not_touch(name):
    scene = scenes.build(name + scenes.SPREAD)
    side = ours.Side(scene)
    for poses in scene.motion.poses(50, seed=1)[::10]:
        side.set_poses(poses)
        assert side.answers['has_collisions']() == 0


def test_more_anchored_boxes_leave_the_moving_bodies_as_they_are():
    one, two = scenes.build('anchored-1000'), scenes.build('anchored-2000')
    assert (len(one.anchored), len(two.anchored)) == (1000, 2000)
    assert [body.size for body in one.bodies] == [body.size for body in two.bodies]
    np.testing.assert_array_equal(one.motion.poses(2, 0), two.motion.poses(2, 0))
    for body, same in zip(one.anchored, two.anchored, strict=False):
        assert body.size == same.size
        np.testing.assert_array_equal(body.R, same.R)
        np.testing.assert_array_equal(body.p, same.p)


def test_a_hull_has_all_its_points_as_vertices():
    scene = scenes.build('hulls-20')
    assert {len(body.size) for body in scene.bodies} == {64}
    for body in scene.bodies[:3]:
        vertices, faces = body.shape.hull_surface()
        assert len(vertices) == len(np.unique(faces)) == 64
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        outward = np.einsum('ij,ij->i', np.cross(b - a, c - a), a)
        assert (outward > 0).all()  # the origin is inside, so every face looks away from it
