"""OctoMaps on their topic, where there are messages of them, and what is said without."""

import array
import time

import numpy as np
import pytest
from drake_geom_msgs import msg
from ros.harness import run_python, start_node
from std_msgs.msg import Header

from drake_geom_ros.sensed_maps.cells import Cells
from drake_geom_ros.sensed_maps.octree import binary_of_cells

pytestmark = pytest.mark.topics

SCENE = """
sources: [s]
frames:
- {name: hand, source: s}
- {name: table, source: s, pose: {position: [1, 0, 0]}, static: true}
geometries:
- {name: ball, source: s, frame: hand, shape: {type: sphere, radius: 0.1}}
"""


def test_octomaps_without_their_messages_are_refused_at_the_start(tmp_path):
    code = (
        'import importlib.util as u, sys; find = u.find_spec; '
        "u.find_spec = lambda name, *a: None if name == 'octomap_msgs' else find(name, *a); "
        'from drake_geom_ros.ros.scene_graph_node import main; '
        "sys.exit(main(['--ros-args', '-p', 'obstacles:=[octomap]']))"
    )
    done = run_python('-c', code)
    assert done.returncode == 2
    assert 'octomap_msgs' in done.stderr


def test_an_octomap_is_a_map_in_its_frame(tmp_path, lone_client):
    Octomap = pytest.importorskip('octomap_msgs.msg').Octomap
    (tmp_path / 'scene.yaml').write_text(SCENE)
    node = start_node(
        tmp_path / 'log', scene_file=tmp_path / 'scene.yaml', obstacles='[octomap]',
        max_distance=10.0,
    )  # fmt: skip
    client = lone_client
    try:
        poses = client.publisher(msg.FramePoses, 'frame_poses')
        maps = client.publisher(Octomap, 'obstacles/octomap')
        results = client.listen(msg.SignedDistancePairs, 'signed_distances')
        cells = Cells.of_points([[0.05, 0.05, 0.55], [0.05, 0.05, 1.55]], 0.1)
        data = array.array('b', binary_of_cells(cells).data)

        def heard():
            stamp = client.node.get_clock().now().to_msg()
            row = [1.05, 0.05, 0.0, 0.0, 0.0, 0.0, 1.0]
            header = Header(stamp=stamp, frame_id='world')
            poses.publish(msg.FramePoses(header=header, frame_names=['s::hand'], poses=row))
            told = {'binary': True, 'id': 'OcTree', 'resolution': 0.1, 'data': data}
            maps.publish(Octomap(header=Header(stamp=stamp, frame_id='s::table'), **told))
            client.spin_until(time.monotonic() + 0.05)
            return results and len(results[-1].distance)

        client.wait_for(heard, 'a distance to the map')
        assert list(results[-1].distance) == pytest.approx([0.4], abs=1e-6)
        assert np.isfinite(results[-1].oldest_pose_age)
    finally:
        node.end()
