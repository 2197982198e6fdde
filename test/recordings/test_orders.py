"""An audit refutes nothing that messages in another order, or a node that starts, explain."""

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import BALLS, balls  # noqa: F401

from drake_geom_ros.geometry import FramePoseVector, SceneGraph
from drake_geom_ros.recordings import Outcome, audit
from drake_geom_ros.scene_files import load_scene

A = np.array([[0.01 * k, 0, 0, 0, 0, 0, 1.0] for k in range(2)])  # at first, and later
B = np.array([[1.0, 0.02 * k, 0, 0, 0, 0, 1.0] for k in range(2)])
TOPICS = '/node/scene', '/node/signed_distances'
SECOND = 0.5  # [s] when the later poses were recorded, with one stamp


def said(file, a, b):
    """Return the ``~/scene`` of a node, and what it says of poses of both frames."""
    loaded = load_scene(file, graph := SceneGraph())
    context = graph.CreateSharedContext()
    ids = [loaded.frames['s', name] for name in 'ab']
    context.UpdateFramePoses(FramePoseVector.FromArrays(ids, np.array([a, b])))
    query = graph.get_query_output_port().Eval(context)
    found = query.ComputeSignedDistancePairwiseClosestPoints()
    message = recorder.empty('drake_geom_msgs/msg/SignedDistancePairs')
    message.header = recorder.header(SECOND)
    message.id_a, message.id_b = found.id_A.astype(np.uint64), found.id_B.astype(np.uint64)
    message.p_aca, message.p_bcb = found.p_ACa.ravel(), found.p_BCb.ravel()
    message.nhat_ba_w, message.distance = found.nhat_BA_W.ravel(), found.distance
    message.is_nhat_ba_w_unique = np.ones(len(found), dtype=bool)
    message.error_bound, message.method = found.error_bound, np.array(found.method, np.uint8)
    message.max_distance = np.inf
    for name, value in vars(message).items():
        if isinstance(value, np.ndarray):
            setattr(message, name, np.ascontiguousarray(value))
    return recorder.scene_of(graph), message


def poses_by(sender, seconds, name, row):
    """Return a message that poses one frame, on the topic of a sender."""
    if sender == 'tf':
        return '/tf', recorder.transforms(seconds, ('world', name, row))
    return '/node/frame_poses', recorder.frame_poses(seconds, [name], row)


def outcome_of(folder, file, given, sender, *, apart=0.001, names='ab', shows=(A[0], B[1])):
    """Return the outcome where the second poses of two senders were recorded so far apart."""
    scene, distances = said(file, *shows)
    places = {'a': A, 'b': B}
    messages = [(0.0, TOPICS[0], scene)]
    messages += [(0.1, *poses_by(sender, 0.1, name, places[name][0])) for name in 'ab']
    for k, name in enumerate(names):
        message = poses_by(sender, SECOND, name, places[name][1])
        messages.append((SECOND + apart * k, *message))
    messages.append((SECOND + 0.1, TOPICS[1], distances))
    run = recorder.record(folder / f'run_{len(list(folder.iterdir()))}', messages)
    (entry,) = audit(run, given).entries
    return entry


@pytest.mark.parametrize('sender', ['tf', 'poses'])
def test_two_senders_of_one_topic_may_have_come_in_another_order(tmp_path, balls, sender):  # noqa: F811
    for shows in ((A[1], B[0]), (A[1], B[1])):  # as recorded
        found = outcome_of(tmp_path, balls, balls, sender, shows=shows)
        assert found.outcome == Outcome.SAME
    found = outcome_of(tmp_path, balls, balls, sender)
    assert found.outcome == Outcome.NOT_REPRODUCIBLE
    assert 'in an order that nobody knows' in found.because


def test_what_came_later_than_clocks_differ_explains_nothing(tmp_path, balls):  # noqa: F811
    found = outcome_of(tmp_path, balls, balls, 'tf', apart=0.05)
    assert found.outcome == Outcome.REFUTED


def test_one_sender_keeps_its_order(tmp_path, balls):  # noqa: F811
    found = outcome_of(tmp_path, balls, balls, 'tf', names='aa', shows=(A[0], B[0]))
    assert found.outcome == Outcome.REFUTED


def test_what_the_node_had_not_yet_is_not_missed(tmp_path, balls):  # noqa: F811
    before = tmp_path / 'before.yaml'
    before.write_text('\n'.join(line for line in BALLS.splitlines() if 'floor' not in line))
    found = outcome_of(tmp_path, before, balls, 'tf', names='a', shows=(A[1], B[0]))
    assert found.outcome == Outcome.NOT_REPRODUCIBLE
    assert "the recorded ~/scene has no 's::world/floor'" in found.because
