"""FCL in a process that it ends or hangs: one verdict is lost, and no other."""

import dataclasses
import os
import signal

import numpy as np
import pytest

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.cross_check.question import (
    AGREED,
    DISAGREED,
    LOST,
    REFUTED,
    SILENT,
    QuestionBatch,
    QuestionedShape,
    questions_of,
    shapes_of,
)
from drake_geom_ros.cross_check.second_opinion import MOST_LOST, SecondOpinion, body_of
from drake_geom_ros.geometry import Mesh
from truth.hard_cases import cases
from truth.judging.asking import BodyScene
from truth.peers import PairAnswer

pytestmark = [pytest.mark.processes, pytest.mark.everything]

CORNERS = np.array([[0.0, 0.0, 0.3], [0.2, 0.0, 0.3], [0.0, 0.2, 0.3], [0.0, 0.0, 0.5]])
BODIES = [
    Body('Sphere', [0.1]),
    Body('Box', [0.2, 0.3, 0.1], p=np.array([0.25, 0.0, 0.0])),
    Body('Capsule', [0.1, 0.2], p=np.array([0.0, 0.3, 0.0])),
    Body('Convex', CORNERS),
    Body('HalfSpace', p=np.array([0.0, 0.0, -0.15])),
]


@pytest.fixture
def asked():
    """Return the query object of a scene, what it answers, and the questions about that."""
    scene = BodyScene(BODIES)
    query = scene.asked()
    results = query.ComputeSignedDistancePairwiseClosestPoints()
    return query, questions_of(query, results, range(len(results)))


def batch_of(query, questions, version=1):
    ids = {value for question in questions for value in question.ids}
    return QuestionBatch(version, questions, shapes_of(query, ids))


@pytest.fixture
def opinion(request):
    """Return a SecondOpinion of a test's parameter: what makes the peer; without: FCL."""
    made = SecondOpinion(getattr(request, 'param', None), limit=1.0)
    yield made
    made.close()


def test_fcl_agrees_about_a_scene(asked, opinion):
    query, questions = asked
    verdicts = opinion.judge(batch_of(query, questions))
    assert [each.verdict for each in verdicts] == [AGREED] * 10
    assert {each.opinion.library for each in verdicts} == {opinion.library}
    assert opinion.library.startswith('python-fcl 0.7')


def test_shapes_come_later_and_change(asked, opinion):
    query, questions = asked
    for version in (1, 1, 2):
        for question in questions:
            (verdict,) = opinion.judge(batch_of(query, [question], version))
            assert verdict.verdict == AGREED


CATALOGUE = [case for case in cases.load() if case.family in ('lattice', 'half_spaces', 'reports')]


@pytest.mark.parametrize('case', CATALOGUE[::7], ids=lambda case: case.id)
def test_what_fcl_fails_on_is_no_disagreement(opinion, case):
    scene = BodyScene((case.a, case.b))
    query = scene.asked()
    results = query.signed_distance_of_pair(*scene.ids)
    (verdict,) = opinion.judge(batch_of(query, questions_of(query, results, [0])))
    assert verdict.verdict in (AGREED, REFUTED, SILENT, LOST), verdict.text


class Peer:
    """Agrees about all pairs but (0, 1), over which it does what ``fault`` says."""

    def __init__(self, bodies, fault):
        self._ids, self._fault = sorted(bodies)[:2], fault

    def __call__(self, query, a, b, X_WA, X_WB, new):
        if [a, b] == self._ids:
            self._fault()
        return PairAnswer(np.nan, None, None, None)


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def hang():
    while True:
        pass


def complain():
    raise TypeError('no such pair')


@pytest.mark.parametrize(
    ('opinion', 'verdict', 'text'),
    [
        (lambda bodies: Peer(bodies, die), LOST, 'crash (signal 9)'),
        (lambda bodies: Peer(bodies, hang), LOST, 'hang (1 s)'),
        (lambda bodies: Peer(bodies, complain), SILENT, 'no such pair'),
    ],
    indirect=['opinion'],
    ids=['dies', 'hangs', 'complains'],
)
def test_what_a_peer_does_over_one_pair_costs_that_pair(asked, opinion, verdict, text):
    query, questions = asked
    for version in (1, 1, 2):
        verdicts = opinion.judge(batch_of(query, questions, version))
        assert (verdicts[0].verdict, verdicts[0].text) == (verdict, text)
        assert {each.verdict for each in verdicts[1:]} == {SILENT}
        assert len(verdicts) == 10


@pytest.mark.parametrize('opinion', [lambda bodies: Peer(bodies, die)], indirect=True)
def test_a_pair_that_costs_one_process_after_the_other_is_asked_about_no_more(asked, opinion):
    query, questions = asked
    found = [opinion.judge(batch_of(query, questions[:1]))[0].verdict for _ in range(5)]
    assert found == [LOST] * MOST_LOST + [SILENT] * 2


@pytest.mark.parametrize(
    'opinion', [lambda bodies: lambda *question: PairAnswer(9.0, None, None, None)], indirect=True
)
def test_who_is_wrong_is_told_with_both_answers(asked, opinion):
    query, questions = asked
    verdict = opinion.judge(batch_of(query, questions))[0]
    assert verdict.verdict == REFUTED
    assert verdict.opinion.distance == 9.0
    assert '9 m within 0.0001 m by python-fcl' in verdict.text


@pytest.mark.parametrize('off', [0.01, -0.01, 2e-3, -2e-3])
def test_a_wrong_answer_is_told_whatever_the_shapes(asked, opinion, off):
    query, questions = asked
    wrong = [dataclasses.replace(each, distance=each.distance + off) for each in questions]
    verdicts = opinion.judge(batch_of(query, wrong))
    assert {each.verdict for each in verdicts} == {DISAGREED}, [each.text for each in verdicts]


def test_a_mesh_file_that_is_gone(asked, opinion, tmp_path):
    query, questions = asked
    given = batch_of(query, questions)
    lost = questions[0].ids[0]
    given.shapes[lost] = QuestionedShape(Mesh(tmp_path / 'gone.stl'), False)
    verdicts = opinion.judge(given)
    for question, verdict in zip(questions, verdicts, strict=True):
        assert verdict.verdict == (SILENT if lost in question.ids else AGREED)


def test_a_solid_has_its_triangles():
    cube = np.indices((2, 2, 2)).reshape(3, -1).T
    body = Body('Solid', cube, triangles=[[0, 1, 3]])
    assert body_of(QuestionedShape(body.shape, True)).kind == 'Solid'
    assert body_of(QuestionedShape(body.shape, False)).kind == 'Convex'
