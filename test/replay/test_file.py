"""Replay files: what is written comes back, and nothing else is taken."""

import dataclasses
import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.replay import Answer, Opinion, Question, Replay, file, read, write
from drake_geom_ros.scene_files import SceneFileError

QUESTION = Question(('s', 'f', 'a'), ('s', 'f', 'b'), 'exact', math.inf, (0.0, 0.6, 0.8))
ANSWER = Answer(0.1, (1.0, 0, 0), (0.1, 0, 0), (0.2, 0, 0), 1e-7, 1e-9, 'iterative', True)
REPLAY = Replay('sources: []\n', QUESTION, (3, 2**63 - 1), ANSWER, {'numpy': '2.0'})
VECTOR = st.tuples(*[st.floats()] * 3)


@settings(max_examples=40)
@given(
    st.builds(
        Replay,
        scene=st.text(),
        question=st.builds(
            Question,
            *[st.tuples(st.text(), st.text(), st.text())] * 2,
            accuracy=st.text(),
            max_distance=st.floats(),
            hint=st.none() | VECTOR,
        ),
        ids=st.tuples(st.integers(0, 2**63), st.integers(0, 2**63)),
        answer=st.builds(
            Answer,
            distance=st.floats(),
            nhat_BA_W=VECTOR,
            p_ACa=VECTOR,
            p_BCb=VECTOR,
            error_bound=st.floats(),
            promised_error_bound=st.floats(),
            method=st.text(),
            breaks_promise=st.booleans(),
        ),
        versions=st.dictionaries(st.text(), st.text()),
        opinion=st.none()
        | st.builds(
            Opinion,
            library=st.text(),
            distance=st.none() | st.floats(),
            tolerance=st.floats(),
            nhat_BA_W=st.none() | VECTOR,
            p_WCa=st.none() | VECTOR,
            p_WCb=st.none() | VECTOR,
        ),
    )
)
def test_what_is_written_comes_back(tmp_path_factory, replay):
    path = tmp_path_factory.mktemp('replay') / 'case.json'
    try:
        write(replay, path)
    except UnicodeEncodeError:
        assert not list(path.parent.iterdir())  # half of a surrogate pair: no part of a file
        return
    assert repr(read(path)) == repr(replay)
    assert [p.name for p in path.parent.iterdir()] == ['case.json']


def test_a_file_is_whole_or_not_there(tmp_path, monkeypatch):
    path = tmp_path / 'case.json'

    def full(*arguments, **options):
        raise OSError('no space left')

    with monkeypatch.context() as patch:
        patch.setattr(file.os, 'replace', full)
        with pytest.raises(OSError, match='no space'):
            write(REPLAY, path)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(OSError, match='nowhere'):
        write(REPLAY, tmp_path / 'nowhere' / 'case.json')


def test_what_is_there_already_stays(tmp_path):
    """Even what nobody can see: two nodes may find the same in one second."""
    path, link = tmp_path / 'case.json', tmp_path / 'link.json'
    write(REPLAY, path)
    before = path.read_text()
    link.symlink_to(tmp_path / 'elsewhere.json')
    for there in (path, link):
        with pytest.raises(FileExistsError, match='is there already'):
            write(dataclasses.replace(REPLAY, scene='other'), there)
    assert path.read_text() == before
    assert link.is_symlink()
    assert sorted(each.name for each in tmp_path.iterdir()) == ['case.json', 'link.json']


def changes():
    """Yield a change of a file's data and the words of the refusal."""
    yield lambda data: data.update(format='other'), 'format must be'
    yield lambda data: data.pop('scene'), 'missing `scene`'
    yield lambda data: data.update(more=1), 'more: unknown key; allowed are scene, question'
    yield lambda data: data.update(question=7), 'question: 7 must be a mapping'
    yield lambda data: data.update(scene=7), 'scene: 7 must be text'
    yield (
        lambda data: data['question'].update(hint=[1.0, 2.0]),
        'question.hint: has 2 items; 3 are',
    )
    yield (
        lambda data: data['question'].update(geometry_a=['s', 'f', 1]),
        r'question.geometry_a\[2\]: 1 must',
    )
    yield lambda data: data['answer'].update(distance='near'), "answer.distance: 'near' must"
    yield lambda data: data['answer'].update(distance=True), 'answer.distance'
    yield lambda data: data['answer'].update(breaks_promise=1), 'breaks_promise'
    yield lambda data: data.update(ids=[1, 2.5]), r'ids\[1\]: 2.5 must be an integer'
    yield lambda data: data.update(versions={'numpy': 2}), 'versions.numpy: 2 must be text'


@pytest.mark.parametrize(('change', 'message'), list(changes()))
def test_what_is_no_replay_is_refused_by_file_and_key(tmp_path, change, message):
    path = tmp_path / 'case.json'
    write(REPLAY, path)
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))
    with pytest.raises(SceneFileError, match=f'case.json: .*{message}'):
        read(path)


@pytest.mark.parametrize('content', [b'', b'{', b'[]', b'\xff\xfe', b'[' * 100_000, b'"text"'])
def test_what_is_no_json_is_refused(tmp_path, content):
    path = tmp_path / 'case.json'
    path.write_bytes(content)
    with pytest.raises(SceneFileError, match=r'case\.json: no'):
        read(path)


def test_a_file_from_before_there_were_opinions_is_read(tmp_path):
    path = tmp_path / 'case.json'
    write(REPLAY, path)
    data = json.loads(path.read_text())
    del data['opinion']
    path.write_text(json.dumps(data))
    assert read(path) == REPLAY


@pytest.mark.parametrize(
    ('distance', 'tolerance', 'differs'),
    [
        (0.1, 1e-4, False),
        (0.1001, 1e-4, False),
        (0.1002, 1e-4, True),
        (0.0998, 1e-4, True),
        (math.nan, 1e-4, True),
        (None, 1e-4, False),
    ],
)
def test_an_opinion_differs_beyond_what_both_may_be_off(distance, tolerance, differs):
    assert Opinion('x', distance, tolerance).differs(ANSWER) == differs


def test_no_contact_differs_from_an_overlap():
    for distance, differs in ((-0.1, True), (-1e-5, False)):
        answer = dataclasses.replace(ANSWER, distance=distance)
        assert Opinion('x', None, 1e-4).differs(answer) == differs
