"""SceneGraph: what it refuses, how it says so, and that nothing changes then."""

import numpy as np
import pytest
from oracles.small_scene import instance

from drake_geom_ros.geometry import (
    DuplicateError,
    FrameId,
    GeometryFrame,
    GeometryId,
    GeometryProperties,
    GeometrySet,
    IllustrationProperties,
    OwnershipError,
    ProximityProperties,
    RoleAssign,
    RoleError,
    SceneGraph,
    SourceId,
    Sphere,
    UnknownIdError,
)
from drake_geom_ros.geometry.model.scene_content import content_of

WORLD = SceneGraph.world_frame_id()


REFUSED = {
    'frame of an unknown source': (
        lambda s, g: g.RegisterFrame(SourceId(10**6), GeometryFrame('f')),
        UnknownIdError,
        'is not a source of this scene; there are',
    ),
    'frame on an unknown frame': (
        lambda s, g: g.RegisterFrame(s.arm, FrameId(10**6), GeometryFrame('f')),
        UnknownIdError,
        'FrameId value=1000000> is not a frame of this scene, which has 3',
    ),
    "frame on another's frame": (
        lambda s, g: g.RegisterFrame(s.room, s.upper, GeometryFrame('f')),
        OwnershipError,
        "the frame 'upper' .* belongs to source 'arm' .* not to 'room'",
    ),
    'frame name taken': (
        lambda s, g: g.RegisterFrame(s.arm, GeometryFrame(' lower')),
        DuplicateError,
        "source 'arm': the source has a frame of the name 'lower' already",
    ),
    'no frame': (lambda s, g: g.RegisterFrame(s.arm), RuntimeError, 'frame = None'),
    'frame that is none': (
        lambda s, g: g.RegisterFrame(s.arm, s.upper, 'f'),
        RuntimeError,
        "frame = 'f' must be of type GeometryFrame",
    ),
    'source by name': (
        lambda s, g: g.RegisterFrame('arm', GeometryFrame('f')),
        RuntimeError,
        "source_id = 'arm' must be of type SourceId",
    ),
    "geometry on another's frame": (
        lambda s, g: g.RegisterGeometry(s.room, s.upper, instance('x')),
        OwnershipError,
        "not to 'room'",
    ),
    "geometry on another's geometry": (
        lambda s, g: g.RegisterGeometry(s.room, s.ball, instance('x')),
        OwnershipError,
        "the geometry 'ball' .* not to 'room'",
    ),
    'geometry on an unknown geometry': (
        lambda s, g: g.RegisterGeometry(s.arm, GeometryId(10**9), instance('x')),
        UnknownIdError,
        'which has 5; see SceneGraphInspector.GetAllGeometryIds',
    ),
    'geometry name taken in the role': (
        lambda s, g: g.RegisterGeometry(s.arm, s.upper, instance(' ball')),
        DuplicateError,
        "the frame 'upper' has a geometry of the name 'ball' with the role kProximity already",
    ),
    'no geometry': (
        lambda s, g: g.RegisterGeometry(s.arm, s.upper, None),
        RuntimeError,
        'geometry = None must be of type GeometryInstance',
    ),
    'anchored without a source': (
        lambda s, g: g.RegisterAnchoredGeometry(SourceId(10**6), instance('x')),
        UnknownIdError,
        'is not a source',
    ),
    'role anew': (
        lambda s, g: g.AssignRole(s.arm, s.ball, ProximityProperties()),
        RoleError,
        r"the geometry 'ball' .* has the roles \['kProximity'\]; kProximity can be given anew",
    ),
    'role to replace that is not there': (
        lambda s, g: g.AssignRole(s.arm, s.ball, IllustrationProperties(), RoleAssign.kReplace),
        RoleError,
        'with kReplace only if it is',
    ),
    "role of another's": (
        lambda s, g: g.AssignRole(s.room, s.ball, IllustrationProperties()),
        OwnershipError,
        "not to 'room'",
    ),
    'properties of no role': (
        lambda s, g: g.AssignRole(s.arm, s.ball, GeometryProperties),
        RuntimeError,
        'are not the properties of a role',
    ),
    'role without a name': (
        lambda s, g: g.RemoveRole(s.arm, s.ball, 'proximity'),
        RuntimeError,
        "role = 'proximity' must be of type Role",
    ),
    "removing another's": (
        lambda s, g: g.RemoveGeometry(s.room, s.ball),
        OwnershipError,
        "not to 'room'",
    ),
    'removing what is not there': (
        lambda s, g: g.RemoveGeometry(s.arm, GeometryId(10**9)),
        UnknownIdError,
        'is not a geometry',
    ),
    'a frame where a geometry is due': (
        lambda s, g: g.RemoveGeometry(s.arm, s.upper),
        RuntimeError,
        'must be of type GeometryId',
    ),
    "changing another's shape": (
        lambda s, g: g.ChangeShape(s.room, s.ball, Sphere(2)),
        OwnershipError,
        "not to 'room'",
    ),
    'a shape that is none': (
        lambda s, g: g.ChangeShape(s.arm, s.ball, 'sphere'),
        RuntimeError,
        'shape',
    ),
    'a pose that is none': (
        lambda s, g: g.ChangeShape(s.arm, s.ball, Sphere(2), np.eye(4)),
        RuntimeError,
        'X_FG',
    ),
    'renaming the world': (
        lambda s, g: g.RenameFrame(WORLD, 'room'),
        RuntimeError,
        'the world frame keeps its name',
    ),
    'renaming to a frame name that is taken': (
        lambda s, g: g.RenameFrame(s.upper, 'lower'),
        DuplicateError,
        "RenameFrame of 'upper'",
    ),
    'renaming to nothing': (lambda s, g: g.RenameGeometry(s.ball, '\t'), RuntimeError, 'empty'),
    'renaming to a geometry name that is taken': (
        lambda s, g: g.RenameGeometry(s.knob, 'ball'),
        DuplicateError,
        "'ball' with the role kProximity already",
    ),
    'excluding what is not there': (
        lambda s, g: g.ExcludeCollisionsWithin(GeometrySet([s.ball, GeometryId(10**9)])),
        RuntimeError,
        '1000000000',
    ),
    'the port of an unknown source': (
        lambda s, g: g.get_source_pose_port(SourceId(10**6)),
        UnknownIdError,
        'is not a source',
    ),
    'a context that is none': (
        lambda s, g: g.RemoveGeometry(context='c', source_id=s.arm, geometry_id=s.ball),
        RuntimeError,
        "RemoveGeometry: context = 'c'",
    ),
    'an accuracy that is none': (
        lambda s, g: g.set_default_accuracy('best'),
        RuntimeError,
        "'best' .* must be one of bound, fast, balanced, exact",
    ),
}


@pytest.mark.parametrize('case', REFUSED)
def test_refusals_say_why_and_change_nothing(scene, case):
    call, kind, words = REFUSED[case]
    version = scene.scene_graph.model_version()
    filters = content_of(scene.scene_graph).filters.version
    with pytest.raises(kind, match=words) as refusal:
        call(scene, scene.scene_graph)
    assert isinstance(refusal.value, RuntimeError)
    assert scene.scene_graph.model_version() == version
    assert content_of(scene.scene_graph).filters.version == filters


def test_an_instance_and_a_frame_can_be_registered_once(scene):
    scene_graph, ball, frame = scene.scene_graph, instance('x'), GeometryFrame('x')
    scene_graph.RegisterGeometry(scene.arm, scene.upper, ball)
    scene_graph.RegisterFrame(scene.arm, frame)
    with pytest.raises(DuplicateError, match="'x' is registered already"):
        scene_graph.RegisterGeometry(scene.arm, scene.lower, ball)
    with pytest.raises(DuplicateError, match="'x' is registered already"):
        scene_graph.RegisterFrame(scene.arm, scene.upper, frame)
