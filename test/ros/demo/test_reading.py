from types import SimpleNamespace as Some

import numpy as np
import pytest
from ros.demo.demo_scenes import SCENE

from drake_geom_ros.client.results import SignedDistances
from drake_geom_ros.client.scene_table import SceneTable
from drake_geom_ros.common.frame_names import AmbiguousNameError
from drake_geom_ros.ros.demo import reading

TABLE = SceneTable.from_message(SCENE)
HALF_TURN = (1.0, 0.0, 0.0, 0.0)  # about x: y and z change their signs
POSES = Some(
    source='arm',
    frame_names=['tip', 'hand'],
    poses=[0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, *HALF_TURN],
)


def _result(distance):
    return Some(
        header=Some(stamp=Some(sec=12, nanosec=500_000_000)),
        id_a=[5, 5, 6],
        id_b=[6, 8, 8],
        scene_version=7,
        names_version=7,
        oldest_pose_age=0.0,
        oldest_frame=0,
        waiting_frames=[],
        waiting_pairs=0,
        shell_points=0,
        least_shell_distance=float('inf'),
        max_distance=1.0,
        distance=distance,
        error_bound=[0.0] * 3,
        method=[1] * 3,
        p_aca=[0.1, 0.2, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        p_bcb=[0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        nhat_ba_w=[0.0, 0.0, 1.0] * 3,
    )


def test_world_poses_follow_the_parents():
    X_WFs = reading.world_poses(POSES, TABLE.parents)
    np.testing.assert_allclose(X_WFs['arm', 'hand'][:3, 3], [1, 2, 3])
    np.testing.assert_allclose(X_WFs['arm', 'tip'][:3, 3], [1, 2, 2.5])  # z of hand points down


def test_names_with_their_source_and_frames_that_are_missing():
    poses = Some(source='', frame_names=['arm::tip'], poses=POSES.poses[:7])
    X_WFs = reading.world_poses(poses, TABLE.parents)
    assert not X_WFs  # the tip's parent has no pose


def test_names_with_colons_are_those_of_their_sources():
    """Source `a`, frame `b::c` and source `a::b`, frame `c`, which hangs on `c` of `x`."""
    parents = {('x', 'c'): None, ('a', 'b::c'): None, ('a::b', 'c'): ('x', 'c')}
    rows = np.ravel([[x, 0, 0, 0, 0, 0, 1] for x in (1.0, 2.0)])
    for source in ('a', 'a::b'):
        poses = Some(source=source, frame_names=['b::c' if source == 'a' else 'c'], poses=rows[:7])
        assert list(reading.world_poses(poses, parents)) == (
            [('a', 'b::c')] if source == 'a' else []
        )
    poses = Some(source='', frame_names=['x::c', 'a::b::c'], poses=rows)
    with pytest.raises(AmbiguousNameError, match="'b::c' of source 'a' and 'c' of source 'a::b'"):
        reading.world_poses(poses, parents)


def test_approach_expresses_the_witnesses_in_the_world():
    X_WFs = reading.world_poses(POSES, TABLE.parents)
    found = SignedDistances(_result([0.3, 0.4, 0.5]), TABLE)
    moment = reading.approach(found[0], found.stamp, TABLE, X_WFs)
    assert (moment.time, moment.id_a, moment.id_b, moment.distance) == (12.5, 5, 6, 0.3)
    np.testing.assert_allclose(moment.p_WCa, [0.1, 0.2, 0.0])
    np.testing.assert_allclose(moment.p_WCb, [1.0, 1.9, 2.3])
    np.testing.assert_allclose(moment.nhat_BA_W, [0, 0, 1])


@pytest.mark.parametrize(
    ('distance', 'expected'),
    [([0.1, 0.2, 0.3], []), ([-0.1, 0.0, 0.3], [(5, 6), (5, 8)]), ([1.0, 1.0, 0.0004], [(6, 8)])],
)
def test_touching_are_those_that_overlap_or_nearly(distance, expected):
    pairs = reading.touching(SignedDistances(_result(distance), TABLE))
    assert [(a.id, b.id) for a, b in pairs] == expected
