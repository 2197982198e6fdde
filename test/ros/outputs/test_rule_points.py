"""The nearest points of rules as plain points in the world."""

import numpy as np
import pytest
from drake_geom_msgs.msg import FramePoses
from geometry_msgs.msg import PointStamped
from ros.harness import SENSOR, start_node

from drake_geom_ros.ros.outputs.rule_points import token

SCENE = """
frames: [{name: a, pose: {position: [2, 0, 0]}}]
geometries:
- {name: post, shape: {type: sphere, radius: 0.2}}
- {name: ball, frame: a, shape: {type: sphere, radius: 0.1}}
proximity_rules:
- {name: near the post!, set_a: a, set_b: post, level: slow, enter: 0.3, leave: 0.4}
"""


@pytest.mark.parametrize(
    ('name', 'part'),
    [
        *(('near', 'near'), ('near the post!', 'near_the_post'), ('a__b', 'a_b')),
        *(('left/right', 'left_right'), ('2 m', 'rule_2_m'), ('__', 'rule_'), ('ß', 'rule_')),
    ],
)
def test_a_name_of_a_rule_is_a_part_of_a_topic(name, part):
    assert token(name) == part


@pytest.mark.topics
def test_they_are_published_for_a_listener_and_follow(lone_client, tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text(SCENE)
    node = start_node(tmp_path / 'log', scene_file=path, max_distance=5.0)
    try:
        poses = lone_client.publisher(FramePoses, 'frame_poses', SENSOR)
        base = 'proximity_rules/near_the_post'
        a, b = (lone_client.listen(PointStamped, f'{base}/point_{end}') for end in 'ab')

        def points(y):
            poses.publish(FramePoses(frame_names=['a'], poses=[0, y, 0, 0, 0, 0, 1]))
            if not (a and b):
                return False
            seen = [[m.point.x, m.point.y, m.point.z] for m in (a[-1], b[-1])]
            return np.allclose(seen, [[0, 0.2, 0], [0, y - 0.1, 0]], rtol=0, atol=1e-9)

        for y in (0.5, 0.45):
            lone_client.wait_for(lambda y=y: points(y), f'the points of a ball at {y}')
        assert a[-1].header.frame_id == 'world'
        assert a[-1].header.stamp == b[-1].header.stamp
    finally:
        node.end()
