"""Joints that cannot be meant are refused; those that others read in another way are named."""

import re

import pytest

from drake_geom_ros.command_line.program import main
from drake_geom_ros.scene_files import SceneFileError, read_scene

BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
LINKS = ''.join(f'<link name="{name}">{BALL}</link>' for name in 'abc')
RANGE = '<limit lower="-1" upper="2" effort="1" velocity="1"/>'


def joint(name, kind, parent, child, inside=''):
    return (
        f'\n<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'{inside}</joint>'
    )


def robot(*joints):
    return f'<robot name="r">{LINKS}{"".join(joints)}</robot>'


def warnings_of(*joints):
    return read_scene(robot(*joints), 'urdf').warnings


REFUSED = [
    ('Revolute', RANGE, "type 'Revolute' is no joint type.*; write 'revolute'"),
    ('hinge', '', "type 'hinge' is no joint type, which are revolute, continuous, prismatic"),
    ('revolute', f'<axis xyz="0 0 0"/>{RANGE}', "axis xyz = '0 0 0' has no direction"),
    ('continuous', '<axis xyz="0 -0 0.0"/>', 'it must not be zero'),
    ('planar', '<axis xyz="0 0 0"/>', 'it must not be zero'),
    ('prismatic', f'<axis/>{RANGE}', '<axis/> has no attribute `xyz`'),
    (
        'revolute',
        '<limit lower="2" upper="-1" effort="1" velocity="1"/>',
        'lower = 2 is above upper = -1',
    ),
    ('prismatic', '<limit lower="0.1" velocity="1"/>', 'lower = 0.1 is above upper = 0'),
]


@pytest.mark.parametrize(('kind', 'inside', 'reason'), REFUSED)
def test_what_no_reader_could_follow_is_refused(tmp_path, capsys, kind, inside, reason):
    text = robot(joint('j', kind, 'a', 'b', inside))
    with pytest.raises(SceneFileError, match=rf':2: joint\[j\]: .*{reason}'):
        read_scene(text, 'urdf')
    (tmp_path / 'r.urdf').write_text(text)
    assert main(['check', str(tmp_path / 'r.urdf')]) == 1
    assert re.search(reason, capsys.readouterr().err)


@pytest.mark.parametrize('kind', ['fixed', 'floating'])
def test_what_has_no_axis_may_say_anything_of_one(kind):
    for inside in ('<axis/>', '<axis xyz="0 0 0"/>', '<limit lower="2" upper="1" velocity="1"/>'):
        assert not warnings_of(joint('j', kind, 'a', 'b', inside))


WARNED = [
    ('revolute', '', 'a revolute joint without <limit>: read as one without limits'),
    ('prismatic', '<limit effort="1" velocity="1"/>', 'a <limit> without lower and upper'),
    (
        'revolute',
        '<limit lower="0" upper="1" velocity="-1"/>',
        'a velocity limit of -1: read as none',
    ),
    ('revolute', f'{RANGE}<mimic joint="none"/>', "it mimics 'none', which is not a joint"),
]


@pytest.mark.parametrize(('kind', 'inside', 'words'), WARNED)
def test_what_others_read_in_another_way_is_named_once(tmp_path, capsys, kind, inside, words):
    one = joint('j', kind, 'a', 'b', inside)
    (warning,) = warnings_of(one)
    assert f':2: joint[j]: {words}' in warning
    assert 'more' not in warning
    (warning,) = warnings_of(one, joint('k', kind, 'b', 'c', inside))
    assert warning.endswith('(so do 1 more: k)')
    (tmp_path / 'r.urdf').write_text(robot(one))
    assert main(['check', str(tmp_path / 'r.urdf')]) == 0
    assert words in capsys.readouterr().err


def test_a_velocity_limit_below_0_is_none():
    text = robot(joint('j', 'revolute', 'a', 'b', '<limit lower="0" upper="1" velocity="-1"/>'))
    (found,) = read_scene(text, 'urdf').robots
    assert found.tree.joints[0].max_speed == float('inf')


@pytest.mark.parametrize(
    ('multiplier', 'offset', 'own', 'ends'),
    [
        (1.0, 0.0, (-1.0, 2.0), None),
        (-1.0, 0.0, (-2.0, 1.0), None),
        (0.5, 0.1, (-0.4, 1.1), None),
        (1.0, 0.0, (-1.0, 1.9995), None),  # as many digits as limits are written with
        (1.0, 0.0, (0.0, 2.0), '-1 to 2'),
        (-1.0, 0.0, (-1.0, 2.0), '-2 to 1'),
        (1.0, 0.5, (-1.0, 2.0), '-0.5 to 2.5'),
    ],
)
def test_a_mimic_that_its_leader_takes_beyond_its_limits_is_named(multiplier, offset, own, ends):
    mimic = f'<mimic joint="j" multiplier="{multiplier}" offset="{offset}"/>'
    limit = f'<limit lower="{own[0]}" upper="{own[1]}" velocity="1"/>'
    found = warnings_of(
        joint('j', 'revolute', 'a', 'b', RANGE), joint('k', 'revolute', 'b', 'c', mimic + limit)
    )
    if ends is None:
        assert not found
    else:
        assert len(found) == 1
        assert f"joint[k]: it mimics 'j', whose limits take it from {ends}, beyond" in found[0]


def test_a_leader_without_limits_takes_its_mimic_beyond_any():
    leader = joint('j', 'continuous', 'a', 'b')
    (found,) = warnings_of(leader, joint('k', 'revolute', 'b', 'c', f'{RANGE}<mimic joint="j"/>'))
    assert 'from -inf to inf' in found
    assert not warnings_of(
        leader, joint('k', 'revolute', 'b', 'c', f'{RANGE}<mimic joint="j" multiplier="0"/>')
    )


DECLARED = '<?xml version="1.0" encoding="iso-8859-1"?>\n'


def test_utf_8_behind_another_declaration_is_read_as_what_it_is(tmp_path):
    """As urdfdom does: it was called by six letters, the third of them two others."""
    file = tmp_path / 'r.urdf'
    text = DECLARED + f'<robot name="r"><link name="träger">{BALL}</link></robot>'
    file.write_bytes(text.encode())
    found = read_scene(file)
    assert found.frames[0].name == 'träger'
    (warning,) = found.warnings
    assert "encoding 'iso-8859-1' is declared, and the bytes are UTF-8" in warning
    file.write_bytes(text.encode('latin-1'))
    found = read_scene(file)
    assert (found.frames[0].name, found.warnings) == ('träger', ())
    file.write_bytes(text.replace('iso-8859-1', 'utf-8').encode())
    assert not read_scene(file).warnings
