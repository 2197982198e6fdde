"""A recording is answered as the live scene of a node is that takes the same messages."""

from pathlib import Path

import numpy as np
import pytest
from recordings import recorder

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.recordings import clearance
from drake_geom_ros.scene_files import load_scene, read_scene

CELL = Path(__file__).parents[1] / 'batch' / 'cell.yaml'
JOINTS = np.array(['turn', 'bend', 'roll', 'slide'])
# The tray waits for its first pose; the arm's base is welded to the world while it stays there.
TEXT = CELL.read_text().replace(', pose: {position: [0.6, 0.1, 0.4]}', '')
TEXT = TEXT.replace(', pose: {position: [0, 0, 0.1]}', '')
WELDED = """<link name="world"/><joint name="hold" type="fixed"><parent link="world"/>
<child link="base"/><origin xyz="0 0 0.1"/></joint></robot>"""
URDF = CELL.with_name('arm.urdf').read_text().replace('</robot>', WELDED)
BASE = (0, 0, 0.1, 0, 0, 0, 1)


def random_messages(rng, count):
    """Return messages of all kinds: some joints, the base where it was or not, the tray by TF."""
    messages = []
    for k in range(count):
        t = 0.05 * k
        kind = rng.choice(['joints', 'joints', 'base', 'moved', 'tf', 'static'])
        if kind == 'joints':
            some = rng.permutation(4)[: rng.integers(1, 5)]
            state = recorder.joint_state(t, JOINTS[some], rng.uniform(0, 0.1, len(some)))
            messages.append((t, '/joint_states', state))
        elif kind in ('base', 'moved'):
            q = rng.normal(size=4)
            row = BASE if kind == 'base' else (*rng.normal(size=3), *(q / np.linalg.norm(q)))
            messages.append((t, '/poses', recorder.frame_poses(t, ['arm::base'], row)))
        elif kind == 'tf':
            row = (*rng.normal(size=3), 0.6, 0, 0, 0.8)
            messages.append((t, '/tf', recorder.transforms(t, ('table', 'tray', row))))
        else:
            row = (*rng.normal(size=3), 0, 0.6, 0, 0.8)
            message = recorder.transforms(t, ('world', 'table', row))
            messages.append((t, '/tf_static', message))
    return messages


def by_a_live_scene(scene, messages):
    """Yield time, lower bound, distance, pairs that wait and age of each cycle of a node."""
    now = [0.0]
    clocks = Clocks(lambda: now[0], lambda: now[0])
    live = LiveScene('exact', clocks)
    inputs = PoseInputs(TfInput(clocks), JointInput(clocks, 1.0, by_default=True))
    with live.editing() as held:
        held.make(addition(read_scene(str(scene))))
        for t, topic, message in messages:
            now[0] = (recorder.BEGIN + round(t * 1e9)) / 1e9
            if topic == '/poses':
                frames = inputs.take_poses(held, message)
            elif topic == '/joint_states':
                frames = inputs.take_joint_states(held, message)
            else:
                inputs.tf.hear(message, static=topic == '/tf_static')
                frames = inputs.pose_by_transforms(held)
            if frames:
                view = held.view()
                found = view.query.ComputeSignedDistancePairwiseClosestPoints()
                lower = np.append(found.distance - found.error_bound, np.inf)
                k = int(np.argmin(lower))
                known = (lower[k], found.distance[k]) if len(found) else (np.nan, np.nan)
                yield t, *known, view.waiting().pairs


@pytest.mark.parametrize('seed', range(6))
def test_each_state_is_that_of_a_cycle(tmp_path, seed):
    scene = tmp_path / 'cell.yaml'
    scene.write_text(TEXT)
    (tmp_path / 'arm.urdf').write_text(URDF)
    welded = load_scene(scene, graph := SceneGraph()).frames['arm', 'base']
    assert graph.collision_filter_manager().welded_frames() == [welded]
    messages = random_messages(np.random.default_rng(seed), 60)
    expected = np.array(list(by_a_live_scene(scene, messages)))
    found = clearance(recorder.record(tmp_path / 'run', messages), scene)['all']
    begin = messages[0][0]
    np.testing.assert_allclose(found.times, expected[:, 0] - begin, rtol=0, atol=1e-9)
    assert found.left_out.tolist() == expected[:, 3].tolist()
    lower = found.known_distance - found.known_error_bound
    np.testing.assert_array_equal(lower, expected[:, 1])
    np.testing.assert_array_equal(found.known_distance, expected[:, 2])
