import pytest

from drake_geom_ros.scene_files import xml_tree
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.xml_tree import (
    attribute,
    local_name,
    numbers,
    place_of,
    prefix_warning,
    read_robot_xml,
    robot_xml,
)


def fault(data):
    with pytest.raises(SceneFileError) as caught:
        read_robot_xml(data, 'r.urdf')
    return str(caught.value)


def test_elements_keep_their_lines_and_lose_comments():
    root = read_robot_xml(b'<robot name="r">\n<!-- c -->\n<link name="a"/>\n</robot>', 'r.urdf')
    (link,) = root
    assert str(place_of(link, 'r.urdf').error('x')) == 'r.urdf:3: link[a]: x'


def test_a_place_names_all_elements_around():
    text = b'<robot>\n<link name="a"><collision>\n<geometry/></collision></link></robot>'
    geometry = read_robot_xml(text, 'r.urdf')[0][0][0]
    assert place_of(geometry, 'r.urdf').key == 'link[a].collision.geometry'


@pytest.mark.parametrize('head', ['', '<?xml version="1.0"?>\n<!-- <robot> -->\n', '\ufeff'])
def test_a_known_prefix_that_is_not_declared_is_declared_at_the_root(head):
    text = f'{head}<robot name="r"><drake:capsule/></robot>'
    root = read_robot_xml(text.encode(), 'r.urdf')
    assert root[0].tag == '{http://drake.mit.edu#undeclared}capsule'
    (warning,) = prefix_warning(root, 'r.urdf')
    assert warning.startswith(f'r.urdf:{1 + head.count(chr(10))}: the prefix `drake:` is not')
    declared = read_robot_xml(b'<robot xmlns:drake="http://drake.mit.edu"/>', 'r.urdf')
    assert prefix_warning(declared, 'r.urdf') == ()


def test_a_prefix_is_no_part_of_the_local_name():
    root = read_robot_xml(b'<robot xmlns:drake="d"><drake:capsule/><box/></robot>', 'r.urdf')
    assert [local_name(element) for element in root] == ['capsule', 'box']


def test_an_attribute_must_be_there():
    root = read_robot_xml(b'<robot name="r" empty=""/>', 'r.urdf')
    assert attribute(root, 'name', 'r.urdf') == 'r'
    for name in ('other', 'empty'):
        with pytest.raises(SceneFileError, match=f'r.urdf:1: missing attribute `{name}`'):
            attribute(root, name, 'r.urdf')


@pytest.mark.parametrize(
    ('data', 'message'),
    [
        (b'', 'r.urdf: it is empty'),
        (b' ', 'r.urdf:1: not XML'),
        (b'# a part\nv 0 0 0\n', 'r.urdf: this is a mesh; name it in a URDF'),
        (b'solid part\n', 'r.urdf: this is a mesh; name it'),
        (b'ply\nformat ascii 1.0\n', 'r.urdf: this is a mesh'),
        (b'# two\ndirectives:\n- add_model: {}\n', 'r.urdf: these are model directives; load'),
        (b'sources: [a]\nrobots: []\n', 'r.urdf: this is a scene file; load it as a scene'),
        (b'<robot>\n<link></robot>', 'r.urdf:2: not XML: Opening and ending tag mismatch'),
        (b'<sdf/>', 'r.urdf:1: this is SDF; load it as a scene'),
        (b'<bot/>', 'r.urdf:1: bot: root element <bot>; must be <robot>'),
        (b'<robot><foot:capsule/></robot>', 'r.urdf:1: not XML: Namespace prefix foot'),
    ],
)
def test_what_is_no_robot_file_is_refused(data, message):
    assert fault(data).startswith(message)


def test_a_binary_mesh_is_known_by_its_suffix():
    with pytest.raises(SceneFileError, match=r'part\.STL: this is a mesh; name it'):
        read_robot_xml(bytes(range(200, 256)), 'part.STL')


def test_entities_are_refused_whatever_they_stand_for(tmp_path):
    (tmp_path / 'secret').write_text('s')
    outside = f'<!DOCTYPE r [<!ENTITY e SYSTEM "file://{tmp_path}/secret">]><robot>&e;</robot>'
    laughs = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><robot>&b;</robot>'
    for text in (outside, laughs):
        assert 'a document type' in fault(text.encode())


def test_size_is_bounded(monkeypatch):
    monkeypatch.setattr(xml_tree, 'MAX_BYTES', 8)
    assert read_robot_xml(b'<robot/>', 'r.urdf') is not None
    assert fault(b'<robot />') == 'r.urdf: 9 bytes; at most 8 are read'


def test_a_default_namespace_is_left_out_and_lines_stay():
    root = read_robot_xml(b'<robot xmlns="http://www.ros.org">\n<link name="a"/></robot>', 'f')
    assert root.tag == 'robot'
    assert [(link.tag, link.sourceline) for link in root] == [('link', 2)]


def test_numbers_of_an_attribute():
    element = read_robot_xml(b'<robot a="1 -2e1" b="x" d="1_0"/>', 'r.urdf')
    assert numbers(element, 'a', 2) == [1.0, -20.0]
    assert numbers(element, 'c', 3, '0 0 1') == [0.0, 0.0, 1.0]
    for name, count, message in (
        ('a', 3, "robot: a = '1 -2e1' must be 3 numbers"),
        ('b', 1, "robot: b = 'x' must be a number"),
        ('d', 1, "robot: d = '1_0' must be a number"),
        ('c', 1, 'robot has no attribute `c`'),
    ):
        with pytest.raises(ValueError, match=message):
            numbers(element, name, count)


def test_a_tree_is_empty_once_it_is_handed_back():
    links = ''.join(f'<link name="l{k}"><visual/></link>' for k in range(250))
    with robot_xml(f'<robot name="r"><a>{links}</a>{links}<b/></robot>'.encode(), 'r') as root:
        assert len(list(root.iter())) == 1003
        kept = root[0][0]
    assert (root.tag, len(root)) == ('robot', 0)
    assert kept.get('name') == 'l0'
    with pytest.raises(SceneFileError), robot_xml(b'<robot>', 'r'):
        pass
