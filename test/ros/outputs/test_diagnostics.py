"""What /diagnostics says of frames without poses and of transient filters; without a node."""

import math
from types import SimpleNamespace as Plain

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from drake_geom_ros.geometry import kernel_state
from drake_geom_ros.live.scene.waiting import Waiting
from drake_geom_ros.ros.outputs import diagnostics
from drake_geom_ros.ros.outputs.diagnostics import Diagnostics, SceneStatus

CYCLE = Plain(
    count=3, worst_error_bound=0.0, contacts=Plain(told='1, and 0 pairs that overlap without')
)
NOBODY = Waiting([], 0, 0)


def status_of(ages, waiting=NOBODY, owners=None):
    """Return the status of a scene, and its values by key."""
    scene = SceneStatus(7, ages, waiting, owners or {})
    (status,) = Diagnostics('/node').message(scene, 1.0, CYCLE, 1.0).status
    return status, {v.key: v.value for v in status.values}


def test_a_frame_that_never_had_a_pose_is_warned_of_and_named():
    waiting = Waiting([f's::f{k}' for k in range(7)], 12, 3)
    ages = dict.fromkeys(waiting.frames, math.inf)
    status, values = status_of({**ages, 's::old': 2.0}, waiting)
    assert status.level == DiagnosticStatus.WARN
    assert status.message.startswith(
        '12 pairs are left out because 7 frames never had a pose: s::f0, s::f1, s::f2, s::f3, '
        's::f4 '
    )
    assert '8 of 8 frames are stale' in status.message
    assert values['frames that never had a pose'] == '7'
    assert values['names of frames that never had a pose'].split(', ') == waiting.frames
    assert values['pairs left out because of them'] == '12'


def test_without_such_frames_nothing_is_said_of_them():
    status, values = status_of({'s::a': 0.5})
    assert status.level == DiagnosticStatus.OK
    assert status.message == '3 cycles, 0 pose messages'
    assert values['names of frames that never had a pose'] == ''
    assert (
        values['frames that never had a pose'] == values['pairs left out because of them'] == '0'
    )


@pytest.mark.parametrize(
    ('owners', 'said'),
    [({}, 'none'), ({4: 'planner', 9: ''}, '4 (planner), 9 (no owner given)')],
)
def test_transient_filters_are_told_with_their_owners(owners, said):
    assert status_of({}, owners=owners)[1]['transient filters'] == said


def test_a_transient_filter_is_told_with_what_is_left_of_its_lease():
    scene = SceneStatus(7, {}, NOBODY, {4: 'planner', 9: ''}, filter_leases={4: 2.52})
    (status,) = Diagnostics('/node').message(scene, 1.0, CYCLE, 1.0).status
    (said,) = [v.value for v in status.values if v.key == 'transient filters']
    assert said == '4 (planner, lease ends in 2.5 s), 9 (no owner given)'


def test_without_a_descriptor_memory_is_told_as_the_most_it_was(monkeypatch, tmp_path):
    """Seen where no file may be opened any more: there were no diagnostics at all."""
    monkeypatch.setattr(diagnostics, '_STATM', tmp_path)  # a folder cannot be read
    assert float(status_of({})[1]['memory [MB]']) > 10.0


def test_the_kernels_that_answer_are_named():
    assert status_of({})[1]['kernels'] == kernel_state()


def test_lag_and_what_is_passed_over_are_figures_and_warnings():
    scene, counted = SceneStatus(7, {'s::a': 0.0}, NOBODY, {}), Diagnostics('/node')

    def told():
        (status,) = counted.message(scene, 1.0, CYCLE, 1.0).status
        return status, {v.key: v.value for v in status.values}

    for lag in (0.02, 0.03, 0.2, math.inf):
        counted.answer(lag)
    counted.take(0.01, 5)
    status, values = told()
    assert status.level == DiagnosticStatus.OK
    assert (values['lag p50 [ms]'], values['lag worst [ms]']) == ('30.000', '200.000')
    assert (values['pose messages taken'], values['largest batch of pose messages']) == ('5', '5')
    counted.answer(0.512)
    status, values = told()
    assert status.level == DiagnosticStatus.WARN
    assert status.message.startswith(
        'half of the results were published more than 512 ms after the stamp'
    )
    counted.take(0.01, 10, 3)
    status, values = told()
    assert status.level == DiagnosticStatus.WARN
    assert status.message.startswith('3 transform messages were skipped')
    assert (values['pose messages taken'], values['pose messages skipped']) == ('12', '3')
    assert values['lag p50 [ms]'] == 'none'
    status, values = told()
    assert status.level == DiagnosticStatus.OK
    assert values['pose messages skipped'] == '3'
