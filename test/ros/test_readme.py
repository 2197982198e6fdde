"""README, first tutorials and the pages of topics and services against a real node."""

import re
from importlib import import_module

import pytest
import yaml
from docs.pages import blocks
from ros.harness import ROOT, run_python, start_node, wait_until_ready
from ros.scene_calls import accepted

from drake_geom_ros.ros.parameters import NodeParameters
from drake_geom_ros.ros.services.table import SERVICES
from drake_geom_ros.ros.topics import OUTPUTS

pytestmark = pytest.mark.topics

README = (ROOT / 'README.md').read_text()
FIRST_SCENE = (ROOT / 'docs/tutorials/first_scene.md').read_text()
TOPICS_PAGE = (ROOT / 'docs/topics.md').read_text()
SERVICES_PAGE = (ROOT / 'docs/services.md').read_text()


def printed(tmp_path, client, script, **settings):
    """Return the block of a page that shows what a script prints beside a node of its own."""
    node = start_node(tmp_path / 'log', **settings)
    try:
        wait_until_ready(client)
        done = run_python(script)
    finally:
        node.end()
    assert done.returncode == 0, done.stderr + node.output()
    return f'```\n{done.stdout}```'


def write_blocks(page, folder):
    """Write the blocks of a page that have titles, under these; return the page's text."""
    for block in blocks(page):
        if block.title:
            (folder / block.title).write_text(block.text)
    return (ROOT / page).read_text()


@pytest.mark.parametrize(
    ('example', 'page', 'asked'),
    [
        (
            *('move_an_arm.py', README),
            {'scene_file': 'scenes/two_pandas.yaml', 'use_joint_states': True},
        ),
        (
            *('ask_the_node.py', FIRST_SCENE),
            {'scene_file': 'scenes/minimal.yaml', 'max_distance': 1.0},
        ),
    ],
    ids=['move_an_arm', 'ask_the_node'],
)
def test_an_example_prints_what_its_page_says(tmp_path, lone_client, example, page, asked):
    settings = {'max_distance': 0.3, **asked}
    assert printed(tmp_path, lone_client, f'examples/{example}', **settings) in page


def test_the_tutorial_of_a_robot_stops_it(tmp_path, lone_client):
    page = write_blocks('docs/tutorials/robot_beside_a_table.md', tmp_path)
    (tmp_path / 'arm.srdf').write_text('<robot name="arm"/>')
    settings = {'scene_file': tmp_path / 'cell.yaml', 'use_joint_states': True}
    assert printed(tmp_path, lone_client, tmp_path / 'watch.py', **settings) in page


def test_the_page_of_gates_drives_to_the_wall_and_stands(tmp_path, lone_client):
    page, scene = write_blocks('docs/gates.md', tmp_path), tmp_path / 'floor.yaml'
    assert printed(tmp_path, lone_client, tmp_path / 'drive.py', scene_file=scene) in page


def test_the_scene_of_the_first_tutorial_is_the_smallest_that_ships():
    (scene,) = [b.text for b in blocks('docs/tutorials/first_scene.md') if b.language == 'yaml']
    assert scene == (ROOT / 'scenes/minimal.yaml').read_text()


def filled(message, values):
    """Return a message with the fields of a mapping, as `ros2 service call` fills it."""
    kinds = message.get_fields_and_field_types()
    for name, value in values.items():
        kind = kinds[name]
        item = kind.removeprefix('sequence<').removesuffix('>')
        if isinstance(value, dict):
            filled(getattr(message, name), value)
        elif isinstance(value, list) and '/' in item:
            package, _, short = item.partition('/')
            made = getattr(import_module(f'{package}.msg'), short)
            setattr(message, name, [filled(made(), each) for each in value])
        else:
            whole = [float(v) for v in value] if item == 'double' and kind != item else value
            setattr(message, name, float(value) if kind == 'double' else whole)
    return message


@pytest.fixture(scope='module')
def minimal(tmp_path_factory):
    node = start_node(tmp_path_factory.mktemp('minimal') / 'log', scene_file='scenes/minimal.yaml')
    yield node
    assert node.end() == 0, node.output()


def test_every_request_in_the_table_goes_through_in_order(minimal, lone_client):
    rows = re.findall(r'^\| `(\w+)` \| `(\{.*?\})`(?= \|| \()', SERVICES_PAGE, re.M)
    kinds = {name: kind for name, kind, _ in SERVICES}
    need_a_file = {'load_obstacles', 'save_obstacles'}  # see test_obstacles
    need_an_event = {'acknowledge_rule'}  # see test_proximity_rules
    assert sorted(name for name, _ in rows) == sorted(kinds.keys() - need_a_file - need_an_event)
    for name, request in rows:
        fields = filled(kinds[name].Request(), yaml.safe_load(request))
        named = {field: getattr(fields, field) for field in fields.get_fields_and_field_types()}
        accepted(lone_client.call(kinds[name], name, **named))


def test_every_topic_in_the_table_is_there(minimal, lone_client):
    # /tf needs use_tf, and tf2_msgs, which not every installation has; joints and twists are asked
    # for.
    rows = re.findall(
        r'^\| `([\w~/]+)`(?: \((?:in|latched)\))? \| `([\w/]+)` \|', TOPICS_PAGE, re.M
    )
    listed = {
        name.replace('~', '/scene_graph') if name.startswith(('~', '/')) else f'/{name}': kind
        if '/' in kind
        else f'drake_geom_msgs/{kind}'
        for name, kind in rows
        if name not in ('joint_states', '~/frame_twists')
    }
    is_open = {name: row.is_open(NodeParameters()) for name, row in OUTPUTS.items()}
    outputs = {name.replace('~', '/scene_graph') for name, opened in is_open.items() if opened}
    assert outputs <= set(listed)
    assert len(listed) == 21

    def there():
        topics = dict(lone_client.node.get_topic_names_and_types())
        return listed.items() <= {n: k[0].replace('/msg/', '/') for n, k in topics.items()}.items()

    lone_client.wait_for(there, f'the topics {listed}')


def test_the_page_counts_the_services():
    assert f'All {len(SERVICES)} services are private' in SERVICES_PAGE
