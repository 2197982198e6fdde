"""The policy of SROS 2: its structure, and that it allows exactly what a running node has."""

import importlib.util
import subprocess
import sys
from collections import defaultdict
from xml.etree import ElementTree

import pytest
from ros.harness import ROOT, environment, start_node

from drake_geom_ros.ros.policy import policy

pytestmark = pytest.mark.topics

NAMESPACE, NAME = '/cell', 'geometry'
NODE = f'{NAMESPACE}/{NAME}'
SENSING = f'{NAME}_sensors'
MOVEIT = {
    *('/collision_object', '/attached_collision_object', '/planning_scene'),
    '/monitored_planning_scene',
}
HAS_MOVEIT = importlib.util.find_spec('moveit_msgs') is not None
# Element: its attributes, of which those in brackets may be missing, and its children.
STRUCTURE = {
    'policy': ({'version'}, set(), {'enclaves'}),
    'enclaves': (set(), set(), {'enclave'}),
    'enclave': ({'path'}, set(), {'profiles'}),
    'profiles': (set(), set(), {'profile'}),
    'profile': ({'ns', 'node'}, set(), {'topics', 'services'}),
    'topics': (set(), {'publish', 'subscribe'}, {'topic'}),
    'services': (set(), {'reply', 'request'}, {'service'}),
    'topic': (set(), set(), set()),
    'service': (set(), set(), set()),
}


def allowed(text, path, node):
    """Return what a node may do in the enclave of a path, as sets of names by action."""
    (profile,) = ElementTree.fromstring(text).findall(
        f'.//enclave[@path="{path}"]/profiles/profile[@node="{node}"]'
    )
    found = defaultdict(set)
    for listed in profile:
        ((action, said),) = listed.attrib.items()
        assert said == 'ALLOW'
        found[action] |= {entry.text for entry in listed}
    return found


def test_the_structure_is_that_of_the_format():
    root = ElementTree.fromstring(policy(NAMESPACE, NAME))
    assert root.tag == 'policy'
    assert root.attrib == {'version': '0.2.0'}
    for element in root.iter():
        needed, possible, children = STRUCTURE[element.tag]
        assert needed <= set(element.attrib) <= needed | possible | {'version'}, element.tag
        assert {child.tag for child in element} <= children
        assert bool(children) == bool(len(element)), element.tag
        assert bool(children) != bool((element.text or '').strip()), element.tag


@pytest.fixture
def node(tmp_path):
    """Return a node that listens to all it can listen to."""
    has_tf = importlib.util.find_spec('tf2_msgs') is not None
    process = start_node(
        *(tmp_path / 'log',),
        namespace=NAMESPACE,
        name=NAME,
        enclave=NODE,
        use_tf=has_tf,
        use_joint_states=True,
        use_planning_scene=HAS_MOVEIT,
        use_sim_time=True,
        closing_speeds=True,
        obstacles='[points,depth]',
    )
    yield process
    assert process.end() == 0, process.output()


def test_it_allows_exactly_what_a_node_has(node, lone_client):
    found = allowed(policy(NAMESPACE, NAME), NODE, NAME)
    # Those of cameras and of rules, of which there are none here.
    found['publish'] -= {f'{NODE}/{each}/*' for each in ('cameras', 'proximity_rules')}
    found['publish'] -= {'/tf', '/tf_static'}
    # The messages of OctoMap and MoveIt are no part of ours.
    found['subscribe'] -= {f'{NODE}/obstacles/octomap'}
    if not HAS_MOVEIT:
        found['subscribe'] -= MOVEIT
        found['request'] -= {'/get_planning_scene'}
        found['publish'] -= {f'{NODE}/planning_scene'}
        found['reply'] -= {f'{NODE}/check_state_validity'}
    if importlib.util.find_spec('tf2_msgs') is None:
        found['subscribe'] -= {'/tf', '/tf_static'}

    compare(lone_client, NAME, found)
    # What it hears of sensors a process of its own does.
    compare(lone_client, SENSING, allowed(policy(NAMESPACE, NAME), NODE, SENSING))
    known = lone_client.node.get_node_names_and_namespaces_with_enclaves()
    enclaves = {name: enclave for name, _, enclave in known if name in (NAME, SENSING)}
    assert enclaves == {NAME: NODE, SENSING: NODE}


def compare(lone_client, node_name, found):
    graph = lone_client.node

    def names(kind):
        ask = getattr(graph, f'get_{kind}_names_and_types_by_node')
        return {name for name, _ in ask(node_name, NAMESPACE)}

    lone_client.wait_for(
        lambda: (node_name, NAMESPACE) in graph.get_node_names_and_namespaces(), node_name
    )
    for kind, action in (
        ('publisher', 'publish'),
        ('subscriber', 'subscribe'),
        ('service', 'reply'),
        ('client', 'request'),
    ):
        lone_client.wait_for(
            lambda k=kind, a=action: names(k) >= found[a], f'what it may {action}'
        )
        assert names(kind) == found[action]


def test_clients_may_do_what_the_node_hears_and_offers_and_an_observer_changes_nothing():
    text = policy(NAMESPACE, NAME)
    server, sensors = allowed(text, NODE, NAME), allowed(text, NODE, SENSING)
    clients = {n: allowed(text, f'{NODE}/{n}', n) for n in ('observer', 'mover', 'operator')}
    logs = {'/rosout', '/parameter_events'}
    for client in clients.values():
        assert client['subscribe'] == server['publish'] - logs | {'/clock'}
        assert client['publish'] - logs <= server['subscribe'] | sensors['subscribe']
        assert client['request'] <= server['reply']
    assert clients['operator']['request'] == server['reply']
    assert clients['mover']['request'] == clients['observer']['publish'] - logs == set()
    words = 'check', 'compute', 'evaluate', 'find', 'has', 'get', 'explain', 'list', 'render'
    assert all(
        name.rpartition('/')[2].startswith(words) for name in clients['observer']['request']
    )


def test_the_command_prints_it():
    command = [sys.executable, '-m', 'drake_geom_ros.ros.policy']

    def run(*arguments):
        return subprocess.run(
            [*command, *arguments], cwd=ROOT, env=environment(), capture_output=True, text=True
        )

    options = '--namespace', '/cell', '--name', 'geometry', '--robot-description', ''
    expected = policy('/cell', 'geometry', ('', 'robot_description_semantic'))
    assert run(*options).stdout == expected
    assert '/robot_description<' not in expected
    assert '>/robot_description<' in run().stdout
    assert '>/safe/cmd_vel<' in run('--gate', 'cmd_vel_in', '/safe/cmd_vel').stdout
    wrong = run('--namespace', 'cell')
    assert wrong.returncode == 2
    assert 'must begin with /' in wrong.stderr


def test_topics_of_sensors_are_heard_by_the_process_of_sensors_and_sent_by_movers():
    text = policy(sensor_topics=['/front/scan', 'camera/camera_info'])
    profiles = {p.get('node'): p for p in ElementTree.fromstring(text).iter('profile')}
    for node, kind in (('scene_graph_sensors', 'subscribe'), ('mover', 'publish')):
        topics = [t.text for t in profiles[node].findall(f"topics[@{kind}='ALLOW']/topic")]
        assert {'/front/scan', '/camera/camera_info'} <= set(topics)


def test_commands_go_through_the_gate_and_nobody_but_the_node_publishes_what_passed():
    text = policy(namespace='/cell', gates=[('cmd_vel_in', 'cmd_vel')])
    profiles = {p.get('node'): p for p in ElementTree.fromstring(text).iter('profile')}

    def topics(node, kind):
        return [t.text for t in profiles[node].findall(f"topics[@{kind}='ALLOW']/topic")]

    assert '/cell/cmd_vel_in' in topics('scene_graph', 'subscribe')
    assert '/cell/cmd_vel_in' in topics('mover', 'publish')
    assert [n for n in profiles if '/cell/cmd_vel' in topics(n, 'publish')] == ['scene_graph']


def test_topics_of_trackers_are_heard_by_the_node_and_sent_by_movers():
    text = policy(tracked_topics=['/people/markers'])
    profiles = {p.get('node'): p for p in ElementTree.fromstring(text).iter('profile')}
    for node, kind in (('scene_graph', 'subscribe'), ('mover', 'publish')):
        topics = [t.text for t in profiles[node].findall(f"topics[@{kind}='ALLOW']/topic")]
        assert '/people/markers' in topics
