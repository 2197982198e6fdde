"""The second opinion beside the cycles: what is handed over, counted, told and kept."""

import time

import numpy as np
import pytest
from live.live_scenes import TWO_BALLS, live_scene

from drake_geom_ros.cross_check.question import AGREED, DISAGREED, LOST, REFUTED, SILENT, Verdict
from drake_geom_ros.live.outputs import cross_check as module
from drake_geom_ros.live.outputs.cross_check import PAIRS, CrossCheck, CrossCheckCounts
from drake_geom_ros.replay import Opinion, read

pytestmark = pytest.mark.clock

PATIENCE = 60.0  # [s]


@pytest.fixture
def live():
    return live_scene(TWO_BALLS, lambda: 0.0)


class FakeAsker:
    """Gives each question the next of the verdicts, when it is let."""

    verdicts = (Verdict(AGREED),)
    free = True

    def __init__(self, stopping):
        self._stopping, self.asked, self.lost, self.closed = stopping, [], 0, False

    def ask(self, query, version, questions):
        while not (self.free or self._stopping()):
            time.sleep(0.01)
        self.asked.append(questions)
        return [self.verdicts[k % len(self.verdicts)] for k in range(len(questions))]

    def close(self):
        self.closed = True


@pytest.fixture
def checks(monkeypatch, tmp_path):
    """Return a function that makes a CrossCheck with a FakeAsker."""
    monkeypatch.setattr(module, 'Asker', FakeAsker)
    made = []

    def make(rate=1e9, folder=tmp_path, limit=20):
        made.append(CrossCheck(rate, lambda: (str(folder), limit)))
        return made[-1]

    yield make
    for each in made:
        each.close()


def cycle(scene, check):
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints(10.0)
    check.look_at(scene, results, 10.0)
    return results


def waited(fact):
    end = time.monotonic() + PATIENCE
    while not fact() and time.monotonic() < end:
        time.sleep(0.01)
    assert fact()


def test_a_sample_of_a_cycle_is_asked_about_with_what_it_answered(scene, checks):
    check = checks()
    results = cycle(scene, check)
    waited(lambda: check.counts().pairs)
    (questions,) = check._asker.asked
    assert sorted(question.ids for question in questions) == [
        (a, b) for a, b in zip(results.id_A, results.id_B, strict=True)
    ]
    for question in questions:
        row = np.flatnonzero((results.id_A == question.ids[0]) & (results.id_B == question.ids[1]))
        assert question.distance == results.distance[row[0]]
        assert question.error_bound == results.error_bound[row[0]]
    assert check.counts() == CrossCheckCounts(len(results), 0, 0, 0, 0, 0)


def test_a_sample_is_small(checks):
    balls = '\n'.join(
        f'- {{name: b{k}, source: s, frame: a, shape: {{type: sphere, radius: 0.1}}}}'
        for k in range(PAIRS)
    )
    with live_scene(f'{TWO_BALLS}{balls}\n', lambda: 0.0).editing() as scene:
        check = checks()
        assert len(cycle(scene, check)) > PAIRS
        waited(lambda: check.counts().pairs)
        assert check.counts().pairs == PAIRS


def test_no_more_often_than_the_rate(scene, checks):
    check = checks(rate=0.001)
    for _ in range(5):
        cycle(scene, check)
    waited(lambda: check.counts().pairs)
    assert len(check._asker.asked) == 1
    assert check.counts().dropped == 0


def test_a_cycle_never_waits_for_an_opinion(scene, checks, monkeypatch):
    """What cannot be asked about is dropped, and counted."""
    monkeypatch.setattr(FakeAsker, 'free', False)
    check = checks(rate=1e9)
    for _ in range(50):
        cycle(scene, check)
    assert check.counts().pairs == 0
    assert check.counts().dropped >= 50 - module._WAITING - 1


def test_all_verdicts_are_counted(scene, checks, monkeypatch):
    kinds = (AGREED, DISAGREED, REFUTED, SILENT, LOST)
    monkeypatch.setattr(FakeAsker, 'verdicts', tuple(map(Verdict, kinds)))
    check = checks()
    cycle(scene, check)
    waited(lambda: check.counts().pairs)
    assert check.counts() == CrossCheckCounts(
        pairs=5, disagreements=1, refuted=1, silent=1, lost=1, dropped=0
    )


def test_a_disagreement_is_told_once_a_pair_of_types_and_kept(
    scene, checks, monkeypatch, tmp_path
):
    opinion = Opinion('python-fcl 9', 0.25, 1e-4, None, (0.0, 0.0, 0.1), (0.0, 0.0, 0.2))
    verdict = Verdict(DISAGREED, opinion, '1 m here, 0.25 m there')
    monkeypatch.setattr(FakeAsker, 'verdicts', (verdict,))
    folder = tmp_path / 'new'
    check = checks(folder=folder)
    told = []
    for number in (1, 2, 3):
        results = cycle(scene, check)
        wanted = number * len(results)
        waited(lambda n=wanted: check.counts().disagreements == n)
        waited(lambda: check._queue.empty())
    waited(lambda: told.extend(check.tell()) or len(told) == 3)
    files = {path.name.rpartition('_')[0]: path for path in folder.iterdir()}
    assert sorted(files) == [
        'replay_box_sphere',
        'replay_halfspace_sphere',
        'replay_sphere_sphere',
    ]
    for path in files.values():
        replay = read(path)
        assert replay.opinion == opinion
        row = (results.id_A == replay.ids[0]) & (results.id_B == replay.ids[1])
        assert replay.answer.distance == results.distance[row][0]
        assert any(
            text.startswith('python-fcl disagrees about a result of')
            and text.endswith(f'(1 m here, 0.25 m there): python -m drake_geom_ros replay {path}')
            for text in told
        )


def test_without_a_folder_a_disagreement_is_told_alone(scene, checks, monkeypatch):
    monkeypatch.setattr(FakeAsker, 'verdicts', (Verdict(DISAGREED, text='so and so'),))
    check, told = checks(folder=''), []
    cycle(scene, check)
    waited(lambda: told.extend(check.tell()) or len(told) == 3)
    assert all(text.endswith('(so and so)') for text in told)


def test_what_nobody_foresaw_is_told_and_the_check_goes_on(scene, checks, monkeypatch):
    check, told = checks(), []
    monkeypatch.setattr(check._asker, 'ask', lambda *question: 1 / 0)
    for _ in range(2):
        cycle(scene, check)
        waited(lambda: check._queue.empty())
        told += check.tell()
    monkeypatch.undo()
    cycle(scene, check)
    waited(lambda: check.counts().pairs)
    told += check.tell()
    assert told == ["internal error in the cross-check: ZeroDivisionError('division by zero')"]


def test_closed_it_leaves_nothing_behind(scene, checks, monkeypatch):
    monkeypatch.setattr(FakeAsker, 'free', False)
    check = checks()
    cycle(scene, check)
    check.close()
    assert check._asker.closed
    assert not check._thread.is_alive()
