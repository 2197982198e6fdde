"""Files that no recorder makes are refused or read, and end no program with a traceback."""

import os
import sqlite3
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip('mcap')

from mcap.writer import Writer
from recordings import recorder
from recordings.recorder import BEGIN
from recordings.test_clearance import HERE, balls, poses  # noqa: F401
from recordings.test_what_is_lost import still

from drake_geom_ros.command_line import report
from drake_geom_ros.command_line.exit_codes import UNFORESEEN
from drake_geom_ros.command_line.program import main
from drake_geom_ros.recordings import RecordingError, clearance, layouts
from drake_geom_ros.recordings.layouts import Layouts, rows_of
from drake_geom_ros.recordings.message_types import JOINTS, POSES
from drake_geom_ros.recordings.raw_messages import RecordedTopic
from drake_geom_ros.recordings.recording import Recording

TEXT = 'std_msgs/msg/String'


def definition(kind):
    return recorder.store().generate_msgdef(kind)[0].encode()


def written(file, other, messages, times=None):
    """Write frame poses beside another topic, whose schema is (name, encoding, text)."""
    with file.open('wb') as stream:
        writer = Writer(stream)
        writer.start('ros2')
        schema = writer.register_schema(POSES, 'ros2msg', definition(POSES))
        channel = writer.register_channel('/node/frame_poses', 'cdr', schema)
        number = writer.register_schema(*other) if other else 0
        beside = writer.register_channel('/other', 'cdr', number)
        for k, (seconds, _, message) in enumerate(messages):
            time = BEGIN + round(seconds * 1e9) if times is None else times[k]
            data = bytes(recorder.store().serialize_cdr(message, POSES))
            writer.add_message(channel, time, data, time)
            writer.add_message(beside, time, b'any bytes', time)
        writer.finish()
    return file


STRANGE = {
    'empty': ('x/msg/Y', 'ros2msg', b''),
    'unknown': ('x/msg/Y', 'unknown', b''),
    'protobuf': ('x.Y', 'protobuf', b'\xff\xfe'),
    'no encoding': ('x', '', b'uint8 a'),
    'none': None,
}


@pytest.mark.parametrize('cut', [False, True], ids=['whole', 'cut'])
@pytest.mark.parametrize('kind', STRANGE)
def test_a_schema_of_another_topic_harms_nothing(tmp_path, balls, kind, cut):  # noqa: F811
    file = written(tmp_path / 'run.mcap', STRANGE[kind], still(0.1 * np.arange(20)))
    if cut:
        file.write_bytes(file.read_bytes()[:-8])
    found = clearance(file, balls, between=['a:b'])
    assert len(found.times) == 20
    assert bool(found.damage) is cut


def test_bytes_that_are_no_text_are_damage_where_a_text_is_needed(tmp_path):
    file = written(tmp_path / 'run.mcap', STRANGE['unknown'], still([0.0, 0.1]))
    data = file.read_bytes()
    file.write_bytes(data.replace(b'/node/frame_poses', b'/node/fram\xff_poses'))
    recording = Recording(file)
    assert len(list(recording.messages(['/node/frame_poses']))) == 2
    assert ["'utf-8' codec can't decode" in each.lost.reason for each in recording.damage] == [
        True
    ]


def test_a_definition_without_a_text_is_that_of_ros(tmp_path):
    with (tmp_path / 'run.mcap').open('wb') as stream:
        writer = Writer(stream)
        writer.start('ros2')
        for encoding in ('unknown', 'ros2msg', 'protobuf'):
            schema = writer.register_schema(TEXT, encoding, b'')
            channel = writer.register_channel(f'/{encoding}', 'cdr', schema)
            data = bytes(recorder.store().serialize_cdr(recorder.text('here'), TEXT))
            writer.add_message(channel, BEGIN, data, BEGIN)
        writer.finish()
    recording = Recording(tmp_path / 'run.mcap')
    found = {each.topic.name: each for each in recording.messages(['/unknown', '/ros2msg'])}
    assert {each.message.data for each in found.values()} == {'here'}
    assert len(found) == 2
    (refused,) = recording.messages(['/protobuf'])
    assert refused.message is None
    assert "encoding 'protobuf'" in refused.reason
    assert not recording.damage


def test_a_definition_of_no_encoding_of_ros_harms_no_database(tmp_path, balls):  # noqa: F811
    messages = [*still([0.0, 0.1, 0.2]), (0.25, '/text', recorder.text('here'))]
    file = recorder.file_of(recorder.record(tmp_path / 'run', messages, sqlite=True))
    database = sqlite3.connect(file)
    database.execute(
        "UPDATE message_definitions SET encoding = 'unknown', encoded_message_definition = '' "
        f"WHERE topic_type = '{TEXT}'"
    )
    # As written late: the order of times counts, not that of rows.
    database.execute('UPDATE messages SET id = 99 WHERE id = 1')
    database.commit()
    database.close()
    found = clearance(file, balls, between=['a:b'])
    assert found.times.tolist() == pytest.approx([0.0, 0.1, 0.2])
    assert found.damage == ()
    (said,) = Recording(file).messages(['/text'])
    assert said.message.data == 'here'


def test_times_that_are_all_0_are_times(tmp_path, balls):  # noqa: F811
    messages = still(0.1 * np.arange(3))
    file = written(tmp_path / 'run.mcap', STRANGE['unknown'], messages, times=[0, 0, 0])
    found = clearance(file, balls, between=['a:b'])
    assert found.times.tolist() == [0.0] * 3
    assert found.damage == ()
    # Their stamps are those of another clock, which is said.
    assert all('clock' in words or 'stale' in words for words in found.reservations())


def test_a_time_that_no_clock_tells_is_left_out_as_damage(tmp_path, balls):  # noqa: F811
    messages = still(0.1 * np.arange(5))
    times = [BEGIN + k * 10**8 for k in range(4)]
    file = written(tmp_path / 'run.mcap', None, messages, times=[*times, 2**63])
    found = clearance(file, balls, between=['a:b'])
    assert len(found.times) == 4
    (damage,) = found.damage
    assert damage.lost.reason == '2 messages of times behind the year 2262'
    assert found.duration == pytest.approx(0.3)
    written(file, None, messages, times=[2**63 + k for k in range(5)])
    with pytest.raises(RecordingError, match='9223372036854775812 ns, behind the year 2262'):
        Recording(file)


def test_a_rate_over_a_time_that_is_wrong_ends(tmp_path, balls):  # noqa: F811
    times = [0, *(BEGIN + k * 10**8 for k in range(4))]
    file = written(tmp_path / 'run.mcap', None, still(0.1 * np.arange(5)), times=times)
    with pytest.raises(RecordingError, match=r'rate=100 .* makes 1\.7e\+11 states'):
        clearance(file, balls, rate=100.0)
    assert len(clearance(file, balls).times) == 5


def test_an_unforeseen_error_has_a_code_of_its_own_and_ends_no_other_run(
    tmp_path,
    balls,  # noqa: F811
    monkeypatch,
    capsys,
):
    runs = [tmp_path / 'runs' / f'run_{k}' for k in range(3)]
    for run in runs:
        recorder.record(run, still(0.1 * np.arange(3)))
    make = report.make_report

    def faulty(options, scene):
        if options.recording == [str(runs[1])]:
            raise ZeroDivisionError('a fault')
        return make(options, scene)

    monkeypatch.setattr(report, 'make_report', faulty)
    asked = ['report', '--scene', str(balls), '--pictures', '0', '--out', str(tmp_path / 'out')]
    assert main([*asked, str(runs[0].parent)]) == UNFORESEEN
    told = capsys.readouterr().err
    assert 'run_1: an error that nobody foresaw, ZeroDivisionError' in told
    assert 'a fault' in told
    reports = sorted(path.parent.name for path in tmp_path.glob('out/*/report.html'))
    assert reports == ['run_0', 'run_2']
    assert main([*asked, str(runs[1])]) == UNFORESEEN
    assert 'drake_geom_ros: an error that nobody foresaw' in capsys.readouterr().err


def refused(*arguments):
    """Return what ``report`` says of a recording that it refuses, in a process that may hang."""
    asked = [sys.executable, '-m', 'drake_geom_ros', 'report', *map(str, arguments)]
    done = subprocess.run(asked, capture_output=True, text=True, timeout=800, check=False)
    assert done.returncode == 2, done.stderr
    return done.stderr


@pytest.mark.processes
def test_what_has_no_end_is_refused(tmp_path, balls):  # noqa: F811
    os.mkfifo(tmp_path / 'pipe.mcap')
    (tmp_path / 'zero.db3').symlink_to('/dev/zero')
    for name in ('pipe.mcap', 'zero.db3'):
        told = refused(tmp_path / name, '--scene', balls, '--out', tmp_path / 'out')
        assert f'{name} is no regular file' in told
    for inside in ('run.mcap', 'metadata.yaml', 'run.mcap.zstd'):
        folder = tmp_path / f'with_{inside}'
        folder.mkdir()
        os.mkfifo(folder / inside)
        told = refused(folder, '--scene', balls, '--out', tmp_path / 'out')
        assert f'{inside} is no regular file' in told


ENDLESS = 'WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)'
VIEW = (
    f'CREATE VIEW messages AS {ENDLESS} '
    "SELECT i AS id, 1 AS topic_id, i AS timestamp, x'00' AS data FROM n"
)


@pytest.mark.processes
@pytest.mark.parametrize('columns', ['(id, name, type)', '(id, name, type, a AS (name))'])
def test_a_database_with_views_is_refused(tmp_path, balls, columns):  # noqa: F811
    file = tmp_path / 'run.db3'
    database = sqlite3.connect(file)
    database.execute(f'CREATE TABLE topics{columns}')
    database.execute(f"INSERT INTO topics(id, name, type) VALUES (1, '/text', '{TEXT}')")
    if 'AS' in columns:
        database.execute('CREATE TABLE messages(id, topic_id, timestamp, data)')
    else:
        database.execute(VIEW)
    database.commit()
    database.close()
    told = refused(file, '--scene', balls, '--out', tmp_path / 'out')
    assert 'no recorder writes' in told or 'as no recorder has it' in told


def test_padding_is_looked_for_in_a_bounded_number_of_bytes(monkeypatch):
    tried = []

    def is_padding(own, place, read, written):
        tried.append(len(own))
        return False

    def message(letter):
        names = [f'{letter}{k}' for k in range(2500)]
        state = recorder.joint_state(0.0, names, np.zeros(2500))
        return bytes(recorder.store().serialize_cdr(state, JOINTS))

    monkeypatch.setattr(layouts, '_is_padding', is_padding)
    topic = RecordedTopic('/joint_states', JOINTS, 'ros2msg', definition(JOINTS).decode())
    rows = rows_of([message(letter) for letter in 'aabbccddee'])
    found = Layouts().of(topic, rows)
    assert [same.tolist() for _, same in found] == [[2 * k, 2 * k + 1] for k in range(5)]
    assert 0 < sum(tried) <= layouts._MOST_TRIED
