import pytest

from drake_geom_ros.geometry import ProximityProperties, Role, Sphere
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    FrameDescription,
    GeometryDescription,
    Member,
)
from drake_geom_ros.scene_files.errors import Location, SceneFileError
from drake_geom_ros.scene_files.names import FileNames

PLACE = Location('a.yaml', 3, 'filters[0]')


def geometry(source, frame, name, roles=None):
    roles = {Role.kProximity: ProximityProperties()} if roles is None else roles
    return GeometryDescription(source, frame, name, Sphere(1.0), RigidTransform(), roles)


@pytest.fixture
def table():
    frames = [
        FrameDescription('left', 'hand'),
        FrameDescription('right', 'hand'),
        FrameDescription('left', 'arm/hand'),
        FrameDescription('right', 'arm'),
        FrameDescription('a', 'b::c'),
        FrameDescription('a::b', 'c'),
    ]
    geometries = [
        geometry('left', 'hand', 'ball'),
        geometry('right', 'arm', 'hand'),
        geometry('right', 'arm', 'drawn', roles={}),
        geometry('room', 'world', 'floor'),
    ]
    return FileNames(frames, geometries)


@pytest.mark.parametrize(
    ('name', 'member'),
    [
        ('left::hand', Member('left', 'hand')),
        ('arm', Member('right', 'arm')),
        ('hand/ball', Member('left', 'hand', 'ball')),
        ('left::hand/ball', Member('left', 'hand', 'ball')),
        ('world', Member('', 'world')),
        ('world/floor', Member('room', 'world', 'floor')),
        ('room::world/floor', Member('room', 'world', 'floor')),
        ('left::arm/hand', Member('left', 'arm/hand')),
        ({'source': 'left', 'frame': 'arm/hand'}, Member('left', 'arm/hand')),
        ({'source': 'a', 'frame': 'b::c'}, Member('a', 'b::c')),
        (
            {'source': 'left', 'frame': 'hand', 'geometry': 'ball'},
            Member('left', 'hand', 'ball'),
        ),
    ],
)
def test_a_name_is_found(table, name, member):
    assert table.find(name, PLACE) == member


@pytest.mark.parametrize(
    ('name', 'part'),
    [
        ('hand', "matches several: 'left::hand', 'right::hand'"),
        ('arm/hand', "matches several: 'left::arm/hand', 'right::arm/hand'"),
        ('a::b::c', 'matches several'),
        ('left::hnad', "nearest: 'left::hand'"),
        ('arm/drawn', 'nor a geometry with the proximity role'),
        ('room::world', 'is neither a frame'),
        ({'source': 'left', 'frame': 'nose'}, "'left::nose' is not in this scene"),
        ({'source': 'right', 'frame': 'arm', 'geometry': 'drawn'}, 'is not in this scene'),
    ],
)
def test_what_is_no_name_or_several_is_refused(table, name, part):
    with pytest.raises(SceneFileError) as caught:
        table.find(name, PLACE)
    assert part in caught.value.reason
    assert (caught.value.line, caught.value.key) == (3, 'filters[0]')


def test_every_member_has_a_name_that_leads_back(table):
    members = {member for found in table._members.values() for member in found}
    assert len(members) == 10
    for member in members:
        assert table.find(table.name(member), PLACE) == member
    assert table.name(Member('left', 'hand', 'ball')) == 'left::hand/ball'
    assert table.name(Member('a', 'b::c')) == {'source': 'a', 'frame': 'b::c'}
