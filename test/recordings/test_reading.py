"""Files of a recording, whole and damaged: what can be read of them is, and until when is said."""

import sqlite3
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip('mcap')

from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer
from recordings import recorder
from recordings.recorder import BEGIN

from drake_geom_ros.recordings import RecordingError, message_types
from drake_geom_ros.recordings.recording import Recording

COUNT = 400


def messages(count=COUNT, begin=0.0, size=10_000):
    """Return messages of 10 kB, so that chunks of a megabyte hold a hundred."""
    return [
        (begin + 0.1 * k, '/text', recorder.text(f'{k:06}' + 'x' * (size - 6)))
        for k in range(count)
    ]


def numbers(recording):
    return [int(each.message.data[:6]) for each in recording.messages(['/text'])]


@pytest.fixture(params=[False, True], ids=['mcap', 'sqlite'])
def run(tmp_path, request):
    return recorder.record(tmp_path / 'run', messages(), sqlite=request.param)


def test_files_and_folders_are_read_with_and_without_their_metadata(run):
    expected = list(range(COUNT))
    assert numbers(Recording(run)) == expected
    assert numbers(Recording(recorder.file_of(run))) == expected
    (run / 'metadata.yaml').unlink()
    recording = Recording(run)
    assert numbers(recording) == expected
    assert recording.damage == []


@pytest.mark.parametrize('how', ['file', 'message', 'storage'])
def test_what_is_compressed_is_read(tmp_path, how):
    run = recorder.record(tmp_path / 'run', messages(), compressed=how)
    assert numbers(Recording(run)) == list(range(COUNT))


def test_several_files_are_one_recording_in_the_order_of_time(tmp_path):
    late = recorder.record(tmp_path / 'a', messages(5, begin=10.0))
    early = recorder.record(tmp_path / 'b', messages(5, begin=0.05), sqlite=True)
    between = recorder.record(tmp_path / 'c', messages(5))
    recording = Recording([late, early, between])
    times = [(each.time - BEGIN) / 1e9 for each in recording.messages(['/text'])]
    expected = np.sort([x + 0.1 * k for k in range(5) for x in (0.0, 0.05, 10.0)])
    np.testing.assert_allclose(times, expected)
    with pytest.raises(RecordingError, match=r'3 runs.*a, b, c'):
        Recording(tmp_path)


def test_a_truncated_recording_gives_what_is_left(run):
    file = recorder.file_of(run)
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) * 6 // 10])
    recording = Recording(file)
    found = numbers(recording)
    assert found == list(range(len(found)))
    assert COUNT * 0.3 < len(found) < COUNT * 0.65
    damage = recording.damage[-1]
    assert damage.file == str(file)
    assert damage.until == BEGIN + round(0.1 * found[-1] * 1e9)


@pytest.mark.parametrize('compression', CompressionType)
def test_the_beginning_of_a_chunk_that_is_cut_is_read(tmp_path, compression):
    file = written(tmp_path / 'run.mcap', messages(size=1000), compression, chunk_size=2**30)
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) * 6 // 10])
    recording = Recording(file)
    found = numbers(recording)
    assert found == list(range(len(found)))
    assert len(found) > 0.3 * COUNT
    (damage,) = recording.damage
    assert 'breaks off' in damage.lost.reason
    assert damage.until == BEGIN + found[-1] * 10**8


def written(file, messages, compression, chunk_size=2**14):
    """Write a file with checksums, by the writer of mcap; return it."""
    with file.open('wb') as stream:
        writer = Writer(stream, compression=compression, chunk_size=chunk_size)
        writer.start('ros2')
        kind = 'std_msgs/msg/String'
        definition, _ = recorder.store().generate_msgdef(kind)
        schema = writer.register_schema(kind, 'ros2msg', definition.encode())
        channel = writer.register_channel('/text', 'cdr', schema)
        for seconds, _, message in messages:
            time = BEGIN + round(seconds * 1e9)
            data = bytes(recorder.store().serialize_cdr(message, kind))
            writer.add_message(channel, time, data, time)
        writer.finish()
    return file


@pytest.fixture(scope='module', params=[*CompressionType, 'sqlite'])
def small(tmp_path_factory, request):
    """Return a small file of messages of random letters."""
    folder, rng = tmp_path_factory.mktemp('small'), np.random.default_rng(0)
    told = [
        (0.1 * k, '/text', recorder.text(f'{k:06}' + rng.bytes(150).hex())) for k in range(200)
    ]
    if request.param == 'sqlite':
        file = recorder.file_of(recorder.record(folder / 'run', told, sqlite=True))
    else:
        file = written(folder / 'run.mcap', told, request.param)
    return file


@settings(max_examples=150, deadline=None)
@given(
    keep=st.one_of(st.just(1.0), st.floats(0.0, 1.0)),
    places=st.lists(st.floats(0.0, 1.0, exclude_max=True), max_size=3),
    length=st.integers(1, 300),
)
def test_whatever_is_harmed_nothing_false_is_told_and_nothing_lost_in_silence(
    tmp_path_factory, small, keep, places, length
):
    data = bytearray(small.read_bytes())
    for place in places:
        k = int(place * len(data))
        data[k : k + length] = bytes(each ^ 0x5A for each in data[k : k + length])
    file = tmp_path_factory.getbasetemp() / f'harmed{small.suffix}'
    file.write_bytes(data[: int(keep * len(data))])
    try:
        recording = Recording(file)
        found = list(recording.messages(['/text']))
    except RecordingError:
        return
    told = [each.message for each in found]
    # A whole chunk bears a checksum; that in which a file breaks off cannot be checked.
    if small.suffix == '.mcap' and not (places and keep < 1.0):
        assert all(each is not None for each in told)
        assert {int(each.data[:6]) for each in told} <= set(range(200))
    assert len(found) == 200 or recording.damage


def test_messages_that_the_index_tells_of_are_missed(tmp_path):
    file = recorder.file_of(recorder.record(tmp_path / 'run', messages(30, size=100)))
    data = bytearray(file.read_bytes())
    place = data.index(b'000013xxx')
    # Its record is no message any more: kind, length, channel, sequence, two times, CDR, length.
    data[place - 4 - 4 - 22 - 9] = 0x80
    file.write_bytes(data)
    recording = Recording(file)
    assert numbers(recording) == [k for k in range(30) if k != 13]
    (damage,) = recording.damage
    assert damage.lost.reason.startswith('1 message that its index tells of')


def chunks_of(data):
    with BytesIO(data) as stream:
        records = list(StreamReader(stream, emit_chunks=True).records)
    return [record.data for record in records if isinstance(record, Chunk)]


def test_a_damaged_chunk_is_left_out_and_told(tmp_path):
    file = recorder.file_of(recorder.record(tmp_path / 'run', messages(), compressed='storage'))
    data = bytearray(file.read_bytes())
    chunk = chunks_of(data)[1]
    place = data.index(chunk)
    data[place + 10 : place + len(chunk)] = b'\xff' * (len(chunk) - 10)
    file.write_bytes(data)
    recording = Recording(file)
    found = numbers(recording)
    lost = sorted(set(range(COUNT)) - set(found))
    assert lost == list(range(lost[0], lost[-1] + 1))
    assert 80 < lost[0] < 120
    assert 80 < len(lost) < 120
    assert found == sorted(found)
    (damage,) = recording.damage
    assert 'a chunk is damaged' in damage.lost.reason
    assert [time - BEGIN for time in damage.lost.span] == [lost[0] * 10**8, lost[-1] * 10**8]
    told = (
        f', from {0.1 * lost[0]:.3f} to {0.1 * lost[-1]:.3f} s; it told something until 39.900 s'
    )
    assert damage.in_words(BEGIN).endswith(told)


def test_a_damaged_page_ends_a_database(tmp_path):
    file = recorder.file_of(recorder.record(tmp_path / 'run', messages(), sqlite=True))
    data = bytearray(file.read_bytes())
    middle = len(data) // 2 // 4096 * 4096
    data[middle : middle + 200_000] = b'\xff' * 200_000
    file.write_bytes(data)
    recording = Recording(file)
    found = numbers(recording)
    assert found == list(range(len(found)))
    assert COUNT * 0.3 < len(found) < COUNT * 0.7
    assert recording.damage


def test_messages_that_wait_in_a_log_are_told_of(tmp_path):
    file = recorder.file_of(recorder.record(tmp_path / 'run', messages(3), sqlite=True))
    database = sqlite3.connect(file)
    database.execute('PRAGMA journal_mode=WAL')
    database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (1, 1, x'00')")
    database.commit()
    recording = Recording(file)
    assert numbers(recording) == [0, 1, 2]
    assert 'wal_checkpoint' in recording.damage[0].lost.reason
    database.close()


@pytest.mark.parametrize('content', [b'', b'nothing of the kind' * 100])
def test_what_is_no_recording_is_refused(tmp_path, content):
    for suffix in ('.mcap', '.db3'):
        file = tmp_path / f'run{suffix}'
        file.write_bytes(content)
        with pytest.raises(RecordingError, match='nothing can be read'):
            Recording(file)
    with pytest.raises(RecordingError, match='no such file'):
        Recording(tmp_path / 'there.mcap')
    (tmp_path / 'run.bag').touch()
    with pytest.raises(RecordingError, match='a recording is one of'):
        Recording(tmp_path / 'run.bag')


def test_a_message_that_is_none_does_not_end_the_others(tmp_path):
    run = recorder.record(tmp_path / 'run', messages(3), sqlite=True)
    with sqlite3.connect(recorder.file_of(run)) as database:
        database.execute("UPDATE messages SET data = x'00010000ffffffff' WHERE id = 2")
    found = list(Recording(run).messages(['/text']))
    assert [each.message is None for each in found] == [False, True, False]
    assert 'std_msgs/msg/String cannot be read' in found[1].reason


def test_recordings_without_definitions_are_read_by_those_of_ours(tmp_path):
    poses = recorder.frame_poses(0.0, ('a',), (1, 2, 3, 0, 0, 0, 1))
    run = recorder.record(tmp_path / 'run', [(0.0, '/p', poses)], sqlite=True)
    with sqlite3.connect(recorder.file_of(run)) as database:  # as ROS 2 Humble has it
        database.execute('DROP TABLE message_definitions')
        database.execute('UPDATE schema SET schema_version = 3')
    (found,) = Recording(run).messages(['/p'])
    assert found.topic.encoding == ''
    assert found.message.poses.tolist() == [1, 2, 3, 0, 0, 0, 1]
    lines = (recorder.MSGS / 'FramePoses.msg').read_text().splitlines()
    bare = [line.partition('#')[0].split() for line in lines]
    assert [line for line in bare if line] == [
        line.split() for line in message_types.FRAME_POSES.split('\n') if line
    ]


def test_a_file_that_the_metadata_name_and_that_is_gone_is_told_of(run):
    text = (run / 'metadata.yaml').read_text()
    name = recorder.file_of(run).name
    assert f'- {name}' in text
    (run / 'metadata.yaml').write_text(text.replace(f'- {name}', f'- {name}\n  - other{name}'))
    for place in (run, run / 'metadata.yaml'):
        recording = Recording(place)
        assert numbers(recording) == list(range(COUNT))
        (damage,) = recording.damage
        assert damage.file == str(run / f'other{name}')
        assert 'metadata.yaml names it' in damage.lost.reason
    assert not Recording(recorder.file_of(run)).damage  # which is all that was asked for


def test_it_goes_from_the_first_message_of_any_topic_to_the_last(run):
    for recording in (Recording(run), Recording(recorder.file_of(run))):
        assert (recording.begin, recording.end) == (BEGIN, BEGIN + (COUNT - 1) * 10**8)
    file = recorder.file_of(run)
    file.write_bytes(file.read_bytes()[: file.stat().st_size * 6 // 10])
    recording = Recording(file)
    count = len(numbers(recording))
    assert (recording.begin, recording.end) == (BEGIN, BEGIN + (count - 1) * 10**8)
