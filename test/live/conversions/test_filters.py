"""Collision filter messages with plain objects: no message class, no ROS."""

import re
from types import SimpleNamespace as Plain

import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.live.conversions.filters import (
    OPERATIONS,
    declaration_from_message,
)


def test_operations_have_the_numbers_of_the_messages():
    message = (ROOT / 'msg_defs/msg/CollisionFilterStatement.msg').read_text()
    numbers = re.findall(r'^uint8 ((?:EXCLUDE|ALLOW)_\w+)=(\d+)', message, re.MULTILINE)
    assert numbers == [(each.name, str(number)) for number, each in OPERATIONS.items()]


def test_declarations(scene, names):
    everything = {'frames': [], 'geometries': [], 'frame_ids': [], 'geometry_ids': []}
    both = Plain(**{**everything, 'geometries': ['left::arm/ball', 'right::arm/ball']})
    nothing = Plain(**everything)
    statement = Plain(operation=1, set_a=both, set_b=nothing)
    declaration, *counts = declaration_from_message(Plain(statements=[statement]), names)
    assert counts == [2, 2]
    manager = scene.collision_filter_manager()
    a, b = names.geometry('left::arm/ball'), names.geometry('right::arm/ball')
    manager.Apply(declaration)
    assert scene.model_inspector().CollisionFiltered(a, b)
    statement.operation = 3
    manager.Apply(declaration_from_message(Plain(statements=[statement]), names).declaration)
    assert not scene.model_inspector().CollisionFiltered(a, b)
    by_frame = Plain(**{**everything, 'frames': ['left::arm']})
    other = Plain(**{**everything, 'geometry_ids': [b.get_value()]})
    statement = Plain(operation=2, set_a=by_frame, set_b=other)
    manager.Apply(declaration_from_message(Plain(statements=[statement]), names).declaration)
    assert scene.model_inspector().CollisionFiltered(a, b)
    statement.operation = 9
    with pytest.raises(RuntimeError, match=r'statements\[0\].operation is 9'):
        declaration_from_message(Plain(statements=[statement]), names)
    statement.set_a = Plain(**{**everything, 'frame_ids': [10**9]})
    with pytest.raises(RuntimeError, match=r'statements\[0\]: .*#1000000000'):
        declaration_from_message(Plain(statements=[statement]), names)


def test_a_geometry_set_is_the_union_of_all_it_names(scene, names):
    a, b = names.geometry('left::arm/ball'), names.geometry('right::arm/ball')
    frame = names.frame('left::arm')
    message = Plain(
        frames=['left::arm'], frame_ids=[], geometries=[f'#{b.get_value()}'], geometry_ids=[]
    )
    members = names.members(message)
    assert (members.frames, members.geometries) == ([frame], [b])
    assert members.num_geometries == 2  # a is on the frame
    message.frames, message.geometry_ids = [], [a.get_value()]
    assert names.members(message) == ([], [b, a], 2)
