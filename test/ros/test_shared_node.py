"""The shared node is put back, and what cannot be put back is an error."""

import os
import signal

import pytest
from drake_geom_msgs import msg, srv
from ros.scene_calls import accepted, add_pair, exclude
from ros.shared_node import SharedNode, domain_of_the_shared_node

pytestmark = pytest.mark.topics

PAIR = ('used::a/ball', 'used::b/ball')


@pytest.fixture(scope='module')
def shared(tmp_path_factory):
    """Return a node like that of the worker, for this file alone."""
    node = SharedNode(tmp_path_factory.mktemp('shared') / 'log')
    yield node
    node.client.close()
    node.process.end(signal.SIGKILL)


def use(shared):
    """Leave something of every kind."""
    call = shared.client.call
    add_pair(shared.client, 'used')
    shared.set(max_distance=3.0, mesh_roots=['/nowhere'], rate=50.0)
    rule = {'name': 'near', 'set_a': ['used::a'], 'set_b': ['used::b'], 'level': 1, 'enter': 0.1}
    accepted(
        call(srv.AddProximityRule, 'add_proximity_rule', rule=msg.ProximityRule(leave=0.2, **rule))
    )
    accepted(call(srv.ApplyFilter, 'apply_filter', declaration=exclude(*PAIR)))
    filters = {'declaration': exclude(*PAIR), 'owner': 'test'}
    accepted(call(srv.ApplyTransientFilter, 'apply_transient_filter', **filters))
    camera = msg.Camera(name='eye', frame='used::a', width=8, height=8, fov_y=0.8)
    accepted(call(srv.AddCamera, 'add_camera', camera=camera))


def test_what_tests_did_is_gone_after_a_reset(shared):
    fresh = shared.state()
    use(shared)
    used = shared.state()
    assert [key for key in fresh if used[key] == fresh[key]] == []
    shared.reset()
    assert shared.state() == fresh


def test_what_is_left_is_an_error_that_names_it(shared, monkeypatch):
    use(shared)
    monkeypatch.setattr(shared, '_put', lambda parameters: None)
    with pytest.raises(AssertionError, match=r"'rate'.*double_value=50\.0"):
        shared.reset()
    monkeypatch.undo()
    shared.reset()


def test_a_node_that_died_is_an_error_with_its_log(shared):
    assert shared.process.end(signal.SIGKILL) == -signal.SIGKILL
    with pytest.raises(AssertionError, match=r'the node died:\n.*configured in'):
        shared.reset()


def test_its_domain_is_that_of_no_worker(monkeypatch):
    workers = [1 + 37 * number for number in range(3)]
    shared = []
    for domain in workers:
        monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
        with domain_of_the_shared_node():
            shared.append(int(os.environ['ROS_DOMAIN_ID']))
        assert os.environ['ROS_DOMAIN_ID'] == str(domain)
    assert not set(shared) & set(workers)
    assert all(1 <= domain <= 101 for domain in shared)
