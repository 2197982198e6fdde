"""The real node does what its scene and its subscribers call for, and says so in counts."""

import pytest
from drake_geom_msgs import msg, srv
from ros.harness import LATCHED
from ros.scene_calls import accepted, exclude, poses

pytestmark = pytest.mark.topics

SCENE = """
sources: [s]
frames: [{name: a, source: s}, {name: b, source: s}, {name: c, source: s}]
geometries:
  - {name: g, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: g, source: s, frame: b, shape: {type: sphere, radius: 0.1}}
  - {name: g, source: s, frame: c, shape: {type: box, size: [0.2, 0.2, 0.2]}}
"""
DRAWN = 'shape: {type: box, size: [1, 1, 1]}, roles: {illustration: {}}'
PICTURE = 'sources: [seen]\ngeometries:\n' + '\n'.join(
    f'- {{name: g{k}, source: seen, {DRAWN}}}' for k in range(1000)
)
COUNTS = (
    *('frames_moved', 'geometries_updated', 'broadphase_pairs', 'filtered_pairs'),
    *('cached_pairs', 'methods', 'method_pairs'),
)


@pytest.fixture(scope='module')
def node(shared_node):
    scenes = shared_node.client.listen(msg.Scene, 'scene', LATCHED)
    shared_node.load(SCENE)
    shared_node.client.wait_for(
        lambda: scenes and len(scenes[-1].geometries) == 3, 'the scene on its topic'
    )
    shared_node.client.forget_topics()
    return shared_node.process


@pytest.fixture
def cycle(client):
    """Return a function that poses the bodies and returns the report of that very cycle."""
    reports = client.listen(msg.CycleReport, 'cycle_report')
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 10)
    stamps = iter(range(1, 10_000))

    def run(*xs):
        stamp = next(stamps)
        publisher.publish(poses(['a', 'b', 'c'], [(x, 0, 0) for x in xs], 's', stamp=stamp))
        client.wait_for(lambda: reports[-1].header.stamp.sec == stamp, 'the report')
        return reports[-1]

    # Until the node has found this subscriber, cycles say nothing.
    def found():
        publisher.publish(poses(['a', 'b', 'c'], [(0, 0, 0)] * 3, 's', stamp=0))
        return reports

    client.wait_for(found, 'a first report')
    run(0.0, 0.0, 0.0)  # a report since the last one of before
    return run


def ran(report):
    return {n for n, yes in zip(report.effects, report.effect_ran, strict=True) if yes}


def counts(report):
    plain = {name: getattr(report, name) for name in COUNTS}
    return {name: v if isinstance(v, int) else list(v) for name, v in plain.items()}


def test_without_subscribers_no_narrow_phase_runs(cycle):
    for step in range(5):
        report = cycle(0.0, 0.3, 0.6 + 0.01 * step)
        assert ran(report) == {'poses'}
        assert counts(report) == dict.fromkeys(COUNTS[:5], 0) | {'methods': [], 'method_pairs': []}


def test_resting_pairs_are_not_computed_again(client, cycle):
    client.listen(msg.SignedDistancePairs, 'signed_distances')
    client.wait_for(lambda: 'narrowphase' in ran(cycle(0.0, 0.3, 0.6)), 'a computed cycle')
    resting = cycle(0.0, 0.3, 0.6)
    assert (resting.cached_pairs, list(resting.method_pairs)) == (3, [])
    assert resting.frames_moved == resting.geometries_updated == 0
    assert not ran(resting) & {'broadphase', 'compile', 'narrowphase'}
    one = cycle(0.0, 0.3, 0.601)
    assert (one.frames_moved, one.geometries_updated) == (1, 1)
    assert (one.cached_pairs, sum(one.method_pairs)) == (1, 2)


def test_a_filtered_pair_is_not_computed(client, cycle):
    client.listen(msg.SignedDistancePairs, 'signed_distances')
    client.wait_for(lambda: 'narrowphase' in ran(cycle(0.0, 0.3, 0.6)), 'a computed cycle')
    request = {'declaration': exclude('a/g', 'b/g'), 'lease': 60.0}
    answer = client.call(srv.ApplyTransientFilter, 'apply_transient_filter', **request)
    try:
        report = cycle(0.001, 0.301, 0.601)
        assert (report.broadphase_pairs, report.filtered_pairs) == (3, 1)
        assert report.cached_pairs + sum(report.method_pairs) == 2
    finally:
        filter_id = accepted(answer).filter_id
        accepted(client.call(srv.RemoveFilter, 'remove_filter', filter_id=filter_id))


def test_1000_illustrations_change_no_count(client, cycle):
    """The last test of this node: they stay."""
    client.listen(msg.SignedDistancePairs, 'signed_distances')
    client.wait_for(lambda: 'narrowphase' in ran(cycle(1.0, 1.3, 1.6)), 'a computed cycle')
    before = [counts(cycle(2.0 + x, 2.3 + x, 2.6)) for x in (0.0, 0.001, 0.001)]
    added = accepted(client.call(srv.LoadScene, 'load_scene', text=PICTURE))
    assert added.geometries == 1000
    cycle(1.0, 1.3, 1.6)
    after = [counts(cycle(2.0 + x, 2.3 + x, 2.6)) for x in (0.0, 0.001, 0.001)]
    assert after == before
    assert before[-1]['cached_pairs'] == 3
