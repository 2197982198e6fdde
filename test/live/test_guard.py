"""Nothing that fails reaches the executor; without a node."""

import time
from types import SimpleNamespace as Plain

import pytest

from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.scene.waiting import Waiting
from drake_geom_ros.ros.outputs.diagnostics import Diagnostics, SceneStatus


class Log:
    def __init__(self):
        self.lines = []

    def warning(self, text):
        self.lines.append(('warning', text))

    def error(self, text):
        self.lines.append(('error', text))


@pytest.fixture
def log():
    return Log()


@pytest.fixture
def diagnostics():
    return Diagnostics('/node')


@pytest.fixture
def guard(log, diagnostics):
    return Guard(log, diagnostics.refuse)


def told(diagnostics):
    cycle = Plain(count=0, worst_error_bound=0.0, contacts=Plain(told='not asked for'))
    state = SceneStatus(0, {}, Waiting([], 0, 0), {})
    message = diagnostics.message(state, 1.0, cycle, 1.0)
    return {v.key: v.value for v in message.status[0].values}


def refuse(message):
    raise RuntimeError(f'{message} is none')


def break_down(*_):
    return [][0]


def test_what_is_taken_leaves_no_trace(guard, log, diagnostics):
    taken = []
    guard.take('poses', taken.append, 'message')
    guard.attempt(lambda: taken.append('due'))
    assert (taken, log.lines) == (['message', 'due'], [])
    assert told(diagnostics)['latest refusal'] == 'none'


def test_a_refusal_is_counted_each_time_and_told_now_and_then(guard, log, diagnostics):
    for number in range(10):
        guard.take('poses', refuse, number)
    guard.take('/tf', break_down, 'message')
    assert log.lines == [
        ('warning', 'a message of poses was refused: 0 is none'),
        (
            'warning',
            "a message of /tf was refused: internal error: IndexError('list index out of range')",
        ),
    ]
    values = told(diagnostics)
    assert (values['refused from poses'], values['refused from /tf']) == ('10', '1')
    assert values['latest refusal'].startswith('/tf: internal error')


def test_it_is_told_again_after_a_while(guard, log, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, 'monotonic', lambda: now[0])
    for step in (0.0, 4.9, 0.2):
        now[0] += step
        guard.take('poses', refuse, now[0])
    assert [text.split()[6] for _, text in log.lines] == ['100.0', '105.10000000000001']


def test_a_task_that_fails_is_done_again_the_next_time(guard, log, diagnostics):
    guard.attempt(break_down)
    guard.attempt(break_down)
    assert log.lines == [
        ('error', "internal error in break_down: IndexError('list index out of range')")
    ]
    assert told(diagnostics)['refused from break_down'] == '2'


def test_a_request_is_answered_whatever_happens(guard, log):
    response = guard.answer(break_down, None, Plain(), Plain(success=True, message=''))
    assert not response.success
    assert 'internal error: IndexError' in response.message
    assert log.lines == [('error', f'SimpleNamespace: {response.message}')]


def test_too_little_memory_is_a_refusal_and_no_fault_of_ours(guard, log):
    def take_much(*_):
        raise MemoryError('Unable to allocate 3 GiB')

    response = guard.answer(take_much, None, Plain(), Plain(success=True, message=''))
    assert not response.success
    assert response.message == (
        'the process has too little memory left: ask for less (Unable to allocate 3 GiB)'
    )
    assert log.lines == []


def test_an_answer_says_whether_it_did_what_was_asked(guard, log):
    def handler(scene, request, response):
        response.found = scene[request]

    response = guard.answer(handler, {'a': 1}, 'a', Plain(success=False, message=''))
    assert (response.success, response.message, response.found) == (True, '', 1)
    response = guard.answer(lambda *_: refuse('b'), {}, 'b', Plain(success=True, message=''))
    assert (response.success, response.message) == (False, 'b is none')
    assert log.lines == []


def test_what_may_fail_is_told_and_nothing_is_counted(guard, log, diagnostics):
    def configured():
        refuse('scene')

    assert guard.succeeds(lambda: None)
    assert not guard.succeeds(configured)
    assert log.lines == [('error', 'not configured: scene is none')]
    assert told(diagnostics)['latest refusal'] == 'none'


def test_long_reasons_are_shortened(guard, log):
    guard.take('poses', refuse, 'n' * 10**6)
    assert len(log.lines[0][1]) < 2000


def test_parts_of_a_message_are_counted_each_and_told_now_and_then(guard, log, diagnostics):
    guard.refuse('/tf', '2 of 3 transforms were left out', 2)
    guard.refuse('/tf', '1 of 3 transforms were left out', 1)
    assert told(diagnostics)['refused from /tf'] == '3'
    assert log.lines == [('warning', 'of a message of /tf: 2 of 3 transforms were left out')]


def test_one_reason_does_not_hide_another_and_ever_new_ones_are_few(guard, log):
    def refuse(reason):
        def take(message):
            raise RuntimeError(reason)

        guard.take('~/frame_poses', take, None)

    for k in range(50):
        refuse(f"There is no frame 'f{k}' in the scene")
        refuse(f'poses holds {k} numbers')
    assert len(log.lines) == 2
    assert 'poses holds 0 numbers' in log.lines[1][1]
    for word in 'abcdefghij':
        refuse(f'reason {word}')
    assert len(log.lines) == 5
