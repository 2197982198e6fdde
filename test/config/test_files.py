"""The files that ship in config/: every parameter with its default, and topics that exist."""

import json
import re

import pytest
import yaml
from conventions.source_tree import ROOT
from rcl_interfaces.srv import GetParameters
from ros.harness import Process

from drake_geom_ros.ros.parameters import NodeParameters
from drake_geom_ros.ros.topics import OUTPUTS

FILE = ROOT / 'config/scene_graph.yaml'


def test_the_parameter_file_names_every_parameter_with_its_default():
    ((node, content),) = yaml.safe_load(FILE.read_text()).items()
    assert node == '/**/scene_graph'
    defaults = vars(NodeParameters())
    shown = content['ros__parameters']
    assert list(shown) == list(defaults)
    assert {n: tuple(v) if isinstance(v, list) else v for n, v in shown.items()} == defaults


@pytest.mark.topics
@pytest.mark.parametrize('namespace', ['/', '/left/arm'])
def test_a_node_in_any_namespace_reads_it(tmp_path, lone_client, namespace):
    changed = tmp_path / 'my.yaml'
    changed.write_text(FILE.read_text().replace('max_distance: 0.1', 'max_distance: 0.7'))
    arguments = ['--ros-args', '--params-file', str(changed), '-r', f'__ns:={namespace}']
    node = Process(tmp_path / 'log', 'drake_geom_ros.ros.scene_graph_node', *arguments)
    lone_client.server = f'{namespace.rstrip("/")}/scene_graph'
    try:
        answer = lone_client.call(GetParameters, 'get_parameters', names=['max_distance'])
    finally:
        node.end()
    assert answer.values[0].double_value == 0.7


def test_rviz_shows_the_markers_of_the_node():
    config = yaml.safe_load((ROOT / 'config/drake_geom_ros.rviz').read_text())
    displays = {d['Class'].split('/')[1]: d for d in config['Visualization Manager']['Displays']}
    assert set(displays) == {'Grid', 'TF', 'MarkerArray'}
    assert displays['MarkerArray']['Topic']['Value'] == '/scene_graph/markers'


def panels(layout):
    """Return the panels of a layout of Foxglove, from left to right."""
    if isinstance(layout, str):
        return [layout]
    return [*panels(layout['first']), *panels(layout['second'])]


def test_foxglove_shows_topics_and_fields_of_the_node():
    content = json.loads((ROOT / 'config/foxglove.json').read_text())
    assert sorted(panels(content['layout'])) == sorted(content['configById'])
    paths = []
    for panel in content['configById'].values():
        paths += [path['value'] for path in panel.get('paths', ())]
        paths += [panel[key] for key in ('topicPath', 'topicToRender') if key in panel]
        paths += list(panel.get('topics', ()))
    assert len(paths) == 7
    for path in paths:
        topic, *fields = re.sub(r'\[:\]$', '', path).split('.')
        kind = OUTPUTS[topic.replace('/scene_graph/', '~/')].kind
        assert set(fields) <= set(kind.get_fields_and_field_types()), path
