"""Levels, their costs, time budgets and replay files on the real node."""

import math
import time

import pytest
from drake_geom_msgs import msg, srv
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros.scene_calls import accepted, poses

pytestmark = pytest.mark.topics

LEVELS = ['bound', '0.01', 'fast', 'balanced', 'exact']
BOUND_ONLY = msg.SignedDistancePairs.METHOD_BOUND_ONLY
COUNT = 20
AGAIN = 10.0  # [s] after which poses are sent again
FRAMES = [f's::f{k}' for k in range(COUNT)]
PAIRS = COUNT * (COUNT - 1) // 2
KINDS = {float: (3, 'double_value'), str: (4, 'string_value')}


@pytest.fixture(scope='module')
def node_settings():
    return {'max_distance': 10.0}


@pytest.fixture(scope='module')
def node(shared_node):
    """Return the node with twenty cylinders, all near one another."""
    lines = ['sources: [s]', 'frames:', *(f'- {{name: f{k}, source: s}}' for k in range(COUNT))]
    shape = '{type: cylinder, radius: 0.05, length: 0.1}'
    lines += ['geometries:']
    lines += [f'- {{name: g, source: s, frame: f{k}, shape: {shape}}}' for k in range(COUNT)]
    shared_node.load('\n'.join(lines))
    return shared_node.process


def tilted(step):
    """Return poses in which no two cylinders are parallel, a little different for each step."""
    rows = []
    for k in range(COUNT):
        angle = 0.1 + 0.07 * k + 0.001 * step
        half = (math.sin(angle), math.cos(angle))
        rows.append((0.09 * (k % 5), 0.15 * (k // 5), 0.02 * k, half[0], 0, 0, half[1]))
    return rows


def put(client, **values):
    """Set parameters."""
    parameters = []
    for name, value in values.items():
        kind, field = KINDS[type(value)]
        parameters.append(Parameter(name=name, value=ParameterValue(type=kind, **{field: value})))
    answer = client.call(SetParameters, 'set_parameters', parameters=parameters)
    assert all(result.successful for result in answer.results), answer.results


@pytest.fixture
def ask(client):
    """Return a function that poses the scene and returns the distances and report of that."""
    distances = client.listen(msg.SignedDistancePairs, 'signed_distances')
    reports = client.listen(msg.CycleReport, 'cycle_report')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    stamps = iter(range(1, 10_000))

    def newest(messages, stamp):
        return next((m for m in messages if m.header.stamp.sec == stamp), None)

    def asked(step=0):
        sent, again = [], 0.0

        def answered():
            # Poses may be lost on the way: then the same are sent again. The first answer counts,
            # for to the second one they rest.
            nonlocal again
            if time.monotonic() > again:
                again = time.monotonic() + AGAIN
                sent.append(next(stamps))
                publisher.publish(poses(FRAMES, tilted(step), stamp=sent[-1]))
            pairs = ((newest(distances, stamp), newest(reports, stamp)) for stamp in sent)
            return next((pair for pair in pairs if all(pair)), None)

        return client.wait_for(answered, 'an answer')

    yield asked
    put(client, accuracy='exact', time_budget=0.0)


def test_the_level_changes_while_the_node_runs(client, ask):
    widths = {}
    for step, level in enumerate(LEVELS):
        put(client, accuracy=level)
        answer, _ = ask(step)
        assert len(answer.id_a) == PAIRS
        widths[level] = max(answer.error_bound)
        assert (set(answer.method) == {BOUND_ONLY}) == (level == 'bound')
    assert widths['bound'] > 0.01
    assert widths['fast'] <= 0.06e-3
    assert widths['balanced'] <= 0.06e-6
    assert widths['exact'] <= 0.06e-9
    # What rests and was loose is sharp as soon as that is asked for.
    put(client, accuracy='bound')
    ask(9)
    put(client, accuracy='exact')
    assert BOUND_ONLY not in ask(9)[0].method


def test_a_request_has_a_level_of_its_own(client, ask):
    put(client, accuracy='bound')
    ask(20)
    services = {
        'compute_signed_distance_pairwise': (srv.ComputeSignedDistancePairwise, {}),
        'compute_point_pair_penetration': (srv.ComputePointPairPenetration, {}),
        'compute_signed_distance_pair': (
            srv.ComputeSignedDistancePair,
            {'geometry_a': 's::f0/g', 'geometry_b': 's::f1/g'},
        ),
    }
    for name, (kind, fields) in services.items():
        for level in ('', *LEVELS):
            result = accepted(client.call(kind, name, accuracy=level, **fields)).result
            loose = {BOUND_ONLY} if level in ('', 'bound') else set()
            assert loose == set(result.method) & {BOUND_ONLY}, (name, level)
            assert len(result.method) > 0
        assert not client.call(kind, name, accuracy='superb', **fields).success
    # The cycles go on at the node's level.
    assert set(ask(21)[0].method) == {BOUND_ONLY}


def test_a_budget_is_spent_and_what_is_left_is_told(client, ask):
    put(client, time_budget=1e-9)
    loose, report = ask(30)
    left = list(loose.method).count(BOUND_ONLY)
    assert 0 < left < PAIRS == len(loose.method)
    assert (report.time_budget, report.unrefined_pairs) == (1e-9, left)
    put(client, time_budget=0.0)
    sharp, report = ask(30)
    assert (report.time_budget, report.unrefined_pairs) == (0.0, 0)
    assert BOUND_ONLY not in sharp.method
    # Only what was left is computed: the others rest.
    assert sum(report.method_pairs) == left
    assert (sharp.id_a, sharp.id_b) == (loose.id_a, loose.id_b)
    for k, distance in enumerate(sharp.distance):
        assert abs(distance - loose.distance[k]) <= loose.error_bound[k] + sharp.error_bound[k]


def test_a_scene_that_rests_becomes_sharp_under_a_budget(client, ask):
    put(client, time_budget=1e-9)
    left = [ask(40)[1].unrefined_pairs for _ in range(60)]
    assert left == sorted(left, reverse=True)
    assert left[0] > left[-1] == 0


def test_the_report_tells_what_each_level_would_have_cost(client, ask):
    steps = iter(range(100, 100_000))

    def measured():
        report = ask(next(steps))[1]
        return report if report.levels else None

    report = client.wait_for(measured, 'a measurement')
    assert list(report.levels) == LEVELS
    assert len(report.level_seconds) == len(LEVELS)
    assert all(math.isfinite(seconds) and seconds > 0.0 for seconds in report.level_seconds)
    assert report.level_samples == 64

    # Who rests is not computed: then levels cost nothing, and nothing is said.
    def idle():
        return not ask(7)[1].levels

    client.wait_for(idle, 'no costs')
    assert ask(7)[1].level_samples == 0
