"""Where numbers stand in the bytes of messages is learnt from rosbags, and holds for all alike."""

from functools import reduce

import numpy as np
import pytest
from recordings import recorder

from drake_geom_ros.recordings.layouts import Layouts, MessageLayout, rows_of
from drake_geom_ros.recordings.message_types import CLOCK, JOINTS, POSES, TF, message_of
from drake_geom_ros.recordings.raw_messages import RecordedTopic


def written(message):
    return bytes(recorder.store().serialize_cdr(message, message.__msgtype__))


def random_messages(rng, kind, count):
    names = [f'j{"x" * k}' for k in range(rng.integers(1, 5))]
    for _ in range(count):
        t = rng.uniform(0.0, 1e4)
        if kind == JOINTS:
            message = recorder.joint_state(t, names, rng.normal(size=len(names)))
            message.header.frame_id = 'base'
            message.velocity = rng.normal(size=len(names))
        elif kind == POSES:
            message = recorder.frame_poses(t, names, rng.normal(size=(len(names), 7)), 's')
        else:
            message = recorder.clock(t)
        yield message


@pytest.mark.parametrize('kind', [JOINTS, POSES, CLOCK])
@pytest.mark.parametrize('seed', range(5))
def test_numbers_are_those_of_each_message(kind, seed):
    messages = list(random_messages(np.random.default_rng(seed), kind, 20))
    topic = RecordedTopic('/t', kind)
    rows = rows_of([written(message) for message in messages])
    ((layout, chosen),) = Layouts().of(topic, rows)
    assert chosen.tolist() == list(range(20))
    for path in layout.fields:
        *above, name = path.split('.')
        for k, message in enumerate(messages):
            owner = message
            for each in above:
                owner = getattr(owner, each)
            told = layout.numbers(rows, path)[k]
            assert told.tolist() == np.atleast_1d(getattr(owner, name)).tolist()


@pytest.mark.parametrize('count', [1, 2, 7])
def test_numbers_of_transforms_are_those_of_each(count):
    rng = np.random.default_rng(count)
    edges = [(f'p{"x" * k}', f'c{"y" * (k % 3)}{k}') for k in range(count)]
    messages = []
    for _ in range(9):
        rows = rng.normal(size=(count, 7)).round(rng.integers(3))  # some are equal
        message = recorder.transforms(
            0.0, *((*edge, row) for edge, row in zip(edges, rows, strict=True))
        )
        for entry in message.transforms:
            entry.header.stamp = recorder.stamp(rng.uniform(0.0, 1e4))
        messages.append(message)
    ((layout, chosen),) = Layouts().of(
        RecordedTopic('/tf', TF), rows_of(list(map(written, messages)))
    )
    assert chosen.tolist() == list(range(9))
    data = rows_of([written(message) for message in messages])
    for path in layout.fields:
        star, *names = path.removeprefix('transforms.').split('.')
        assert star == '*'
        told = [[reduce(getattr, names, each) for each in m.transforms] for m in messages]
        assert layout.numbers(data, path).tolist() == told
    assert len(layout.fields) == 9


def test_transforms_of_other_names_and_none_at_all():
    rows = np.random.default_rng(0).normal(size=(2, 7))
    one = recorder.transforms(1.0, ('a', 'bc', rows[0]), ('a', 'de', rows[1]))
    other = recorder.transforms(2.0, ('a', 'de', rows[0]), ('a', 'bc', rows[1]))
    found = Layouts().of(
        RecordedTopic('/tf', TF), rows_of([written(m) for m in (one, other, one)])
    )
    assert [chosen.tolist() for _, chosen in found] == [[0, 2]]
    empty = written(recorder.transforms(1.0))
    ((layout, chosen),) = Layouts().of(RecordedTopic('/tf', TF), rows_of([empty, empty]))
    assert chosen.tolist() == [0, 1]
    assert all(not field.places.size for field in layout.fields.values())


def test_other_names_and_other_lengths_are_other_layouts():
    rng = np.random.default_rng(0)
    names = (['aa', 'bb'], ['ab', 'ba'], ['aa', 'bb'])
    rows = rows_of([written(recorder.joint_state(1.0, n, rng.normal(size=2))) for n in names])
    found = Layouts().of(RecordedTopic('/t', JOINTS), rows)
    assert [chosen.tolist() for _, chosen in found] == [[0, 2]]  # what comes once is no stream
    message = recorder.joint_state(1.0, names[0], [0.0, 1.0])
    other = recorder.joint_state(1.0, names[0], [0.0])
    message.velocity, other.velocity = np.zeros(1), np.zeros(2)  # as long as each other
    assert len(written(message)) == len(written(other))
    layout = MessageLayout(RecordedTopic('/t', JOINTS), written(message))
    assert layout.of(rows_of([written(message), written(other)])).tolist() == [True, False]


@pytest.mark.parametrize('kind', [JOINTS, TF])
def test_what_stands_between_numbers_may_be_anything(kind):
    topic = RecordedTopic('/t', kind)
    message = recorder.joint_state(1.0, ['joint'], [0.5])
    if kind == TF:
        row = (0.5, 0, 0, 0, 0, 0, 1)
        message = recorder.transforms(1.0, ('ab', 'cd', row), ('base', 'e', row))
    model, own = MessageLayout(topic, written(message)), written(message)
    dirty = bytearray(own)
    for place in np.flatnonzero(~model._counts[4:]).tolist():
        inside = any(place + 4 in f.places for f in model.fields.values())
        if not inside:
            dirty[place + 4] = 0xAB
    assert bytes(dirty) != own
    assert written(message_of(topic, bytes(dirty))) == own
    # To 4 bytes before each length, to 8 before the first number of a kind: counted by hand.
    assert sum(a != b for a, b in zip(own, dirty, strict=True)) == (9 if kind == JOINTS else 15)
    assert model.of(rows_of([bytes(dirty)])).all()
    assert MessageLayout(topic, bytes(dirty)).of(rows_of([own])).all()


def test_another_byte_order_is_no_model():
    message = recorder.joint_state(1.0, ['a'], [0.5])
    big = bytes(recorder.store().serialize_cdr(message, JOINTS, little_endian=False))
    with pytest.raises(ValueError, match='another way'):
        MessageLayout(RecordedTopic('/t', JOINTS), big)
    assert Layouts().of(RecordedTopic('/t', JOINTS), rows_of([big, big])) == []


def test_another_definition_of_a_type_is_another_layout():
    rng = np.random.default_rng(0)
    rows = rows_of([written(recorder.joint_state(1.0, ['a'], rng.normal(size=1))) for _ in 'ab'])
    layouts = Layouts()
    ((own, _),) = layouts.of(RecordedTopic('/t', JOINTS), rows)
    text = 'std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n'
    text += f'float64[] effort\n{"=" * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n'
    text += (
        f'string frame_id\n{"=" * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n'
    )
    ((other, _),) = layouts.of(RecordedTopic('/t', JOINTS, 'ros2msg', text), rows)
    assert other is not own
    assert not layouts.may_know(
        RecordedTopic('/t', JOINTS, 'ros2msg', f'{text}\n'), rows.shape[1], 1
    )
