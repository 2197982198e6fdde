"""The program ``record`` beside a node: what it writes is what a report reads."""

import signal

import pytest
from drake_geom_msgs import msg
from ros.harness import ROOT, Process, start_node, wait_until_ready
from ros.scene_calls import poses
from std_msgs.msg import String

pytest.importorskip('rosbags')
pytest.importorskip('mcap')

from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from drake_geom_ros.command_line.program import main as drake_geom_ros
from drake_geom_ros.ros.recorder.program import INCOMPLETE, MISUSED, main
from drake_geom_ros.ros.recorder.recorder import Recorder

pytestmark = pytest.mark.topics

NAME = 'recorded_by_program'


@pytest.fixture
def node(tmp_path):
    process = start_node(
        tmp_path / 'node.log', name=NAME, scene_file='scenes/minimal.yaml', max_distance=1.0
    )
    yield process
    assert process.end() == 0, process.output()


def counts_of(folder):
    """Return the number of recorded messages by topic."""
    with Reader(folder) as reader:
        return {each.topic: each.msgcount for each in reader.connections}


def test_a_run_is_recorded_and_a_report_reads_it(node, tmp_path, lone_client, capsys):
    folder = tmp_path / 'run'
    lone_client.server = f'/{NAME}'
    wait_until_ready(lone_client)
    publisher = lone_client.publisher(msg.FramePoses, 'frame_poses')
    extra = lone_client.node.create_publisher(String, '/note_of_the_test', 1)
    record = ['--node', NAME, '--out', str(folder), '--topic', '/note_of_the_test']
    recorder = Process(tmp_path / 'record.log', ROOT / 'scripts/record', *record)
    try:
        wanted = (f'/{NAME}/scene', f'/{NAME}/frame_poses', f'/{NAME}/signed_distances')
        lone_client.wait_for(
            lambda: all(f'record: {t}\n' in recorder.output() for t in (*wanted, extra.topic)),
            'subscriptions of the recorder',
        )
        heard = lone_client.listen(msg.SignedDistancePairs, 'signed_distances')

        def both_hear():
            extra.publish(String(data='here'))
            publisher.publish(poses(['ball'], [(0.5, 0.0, 0.3)]))
            return len(heard) > 20

        lone_client.wait_for(both_hear, 'results')
        recorder.popen.send_signal(signal.SIGINT)
        lone_client.wait_for(lambda: recorder.popen.poll() is not None, 'the end of the recorder')
    finally:
        assert recorder.end() == 0, recorder.output()
    counts = counts_of(folder)
    assert counts[f'/{NAME}/scene'] >= 1  # latched, from before the recorder came
    assert min(counts[topic] for topic in (*wanted[1:], extra.topic)) >= 1
    assert f'{counts[wanted[1]]:9}  {wanted[1]}' in recorder.output()
    assert 'no message of /clock, ' in recorder.output()

    report = ['report', str(folder), '--scene', 'scenes/minimal.yaml', '--max-distance', '1']
    report += ['--audit', '--pictures', '0', '--out', str(tmp_path / 'report')]
    # On a busy machine seconds pass before the first pose, which is a gap by default.
    report += ['--stale-after', '1000']
    assert drake_geom_ros(report) == 0
    out = capsys.readouterr().out
    assert 'all: distance 0.2 m within' in out
    assert 'refuted' not in out.lower() or '0 refuted' in out.lower()


def test_a_recording_is_played_again(tmp_path, lone_client):
    """By examples/play_recording.py, where there is no `ros2 bag play`."""
    said, topic = ['one', 'two', 'three'], '/played_again'
    with Writer(tmp_path / 'run', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        types = get_typestore(Stores.LATEST)
        connection = writer.add_connection(topic, 'std_msgs/msg/String', typestore=types)
        for number, text in enumerate(said):
            data = serialize_message(String(data=text))
            writer.write(connection, 1_000_000_000 + number * 1000, data)
    heard = lone_client.listen(String, topic)
    script = ROOT / 'examples/play_recording.py'
    players = []

    def have_come():
        """Play until a whole run is heard: a subscriber may not know the publisher yet."""
        if not players or players[-1].popen.poll() is not None:
            log = tmp_path / f'log_{len(players)}'
            players.append(Process(log, script, str(tmp_path / 'run'), anew=True))
        return [message.data for message in heard[-3:]] == said

    lone_client.wait_for(have_come, 'the messages')
    lone_client.wait_for(lambda: players[-1].popen.poll() is not None, 'the end of the player')
    assert players[-1].end() == 0, players[-1].output()
    assert '3 messages' in players[-1].output()
    wrong = [str(tmp_path / 'run'), '--topic', '/absent'], [str(tmp_path / 'run'), '--rate', '0']
    for number, (words, reason) in enumerate(
        zip(wrong, ('/absent is not in ', '--rate is 0; it must be'), strict=True)
    ):
        refused = Process(tmp_path / f'refused_{number}', script, *words, anew=True)
        lone_client.wait_for(lambda each=refused: each.popen.poll() is not None, 'the refusal')
        assert refused.popen.returncode != 0
        assert reason in refused.output()
        assert 'Traceback' not in refused.output()


def test_without_a_message_it_says_so(tmp_path, capsys):
    command = ['--node', 'nobody_at_all', '--out', str(tmp_path / 'run'), '--seconds', '0.1']
    assert main(command) == INCOMPLETE
    out = capsys.readouterr()
    assert '0 messages' in out.out
    assert '/nobody_at_all/scene' in out.err


def test_a_disk_that_is_full_ends_it_and_what_was_written_stays(
    tmp_path, lone_client, monkeypatch, capsys
):
    publisher = lone_client.node.create_publisher(String, '/to_a_full_disk', 10)
    writes = []

    def write(writer, connection, stamp, data):
        writes.append(data)
        publisher.publish(String(data='next'))
        if len(writes) > 3:
            raise OSError(28, 'No space left on device')
        return whole_write(writer, connection, stamp, data)

    whole_write = Writer.write
    monkeypatch.setattr(Writer, 'write', write)
    monkeypatch.setattr(Recorder, 'look', looking(publisher))
    command = ['--node', 'nobody_at_all', '--out', str(tmp_path / 'run')]
    assert main([*command, '--topic', publisher.topic_name]) == INCOMPLETE
    assert 'No space left on device' in capsys.readouterr().err
    assert counts_of(tmp_path / 'run')[publisher.topic_name] == 3


def looking(publisher):
    """Return ``Recorder.look`` that also publishes: a message before the first is lost."""
    look = Recorder.look

    def look_and_publish(recorder):
        look(recorder)
        publisher.publish(String(data='first'))

    return look_and_publish


@pytest.mark.parametrize(
    ('words', 'reason'),
    [
        (['--out', '{tmp}'], 'is there already'),
        (['--out', '{tmp}/none/run'], 'there is no folder'),
        (['--seconds', '0'], 'must be positive'),
        (['--topic', 'a b'], "--topic 'a b': Invalid topic name"),
        (['--node', 'a b'], "--node '/a b': Invalid topic name"),
    ],
)
def test_what_cannot_be_is_refused(words, reason, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main([word.format(tmp=tmp_path) for word in words])
    assert ended.value.code == MISUSED
    assert reason in capsys.readouterr().err


def test_a_type_that_is_not_installed_is_not_recorded_and_others_are(tmp_path):
    from drake_geom_ros.ros.recorder.recorder import Definitions, UnknownTypeError

    definitions = Definitions()
    with pytest.raises(UnknownTypeError, match='nowhere_msgs/msg/Thing'):
        definitions.add('nowhere_msgs/msg/Thing')
    types = definitions.add('drake_geom_msgs/msg/Scene')
    assert {'drake_geom_msgs/msg/SceneFrame', 'geometry_msgs/msg/Pose'} < set(types.fielddefs)
