"""Pose messages and service calls that must be refused, and words that the refusal must hold."""

from __future__ import annotations

import array
import math
from collections.abc import Iterator
from typing import Any

from drake_geom_msgs import msg, srv
from geometry_msgs.msg import Point, Pose
from rcl_interfaces.msg import ParameterValue

LONG_NAME = 'n' * 1_000_000
MANY = 10_000_000

BOMB = 'a: &a [x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'{new}: &{new} [{", ".join(f"*{old}" for _ in range(9))}]\n'
    for old, new in zip('abcdefgh', 'bcdefghi', strict=True)
)
CODE = 'name: !!python/object/apply:os.system ["touch /tmp/drake_geom_ros_was_here"]\n'


def pose_messages(frames: list[str], source: str) -> Iterator[tuple[str, Any, str]]:
    """Yield (name, FramePoses, word of the refusal); ``frames`` are two frames of ``source``."""

    def message(*rows: list[float], **fields: Any) -> Any:
        flat = array.array('d', [number for row in rows for number in row])
        fields = {'source': source, 'frame_names': frames, 'poses': flat, **fields}
        return msg.FramePoses(**fields)

    far, here = [9.0, 0, 0, 0, 0, 0, 1], [0.0, 0, 0, 0, 0, 0, 1]
    yield 'not a number', message(far, [math.nan, 0, 0, 0, 0, 0, 1]), 'not finite'
    yield 'infinite', message(far, [math.inf, 0, 0, 0, 0, 0, 1]), 'not finite'
    yield 'no unit quaternion', message(far, [0.0, 0, 0, 0, 0, 0, 0]), 'quaternion'
    yield 'names without poses', message(), 'poses holds 0'
    yield 'poses without names', message(far, here, frame_names=[]), 'poses holds 14'
    yield 'one number too few', message(far, here[:6]), 'poses holds 13'
    yield 'names and ids', message(far, here, frame_ids=[1, 2]), 'both given'
    yield 'one frame twice', message(far, here, frame_names=frames[:1] * 2), 'twice'
    yield 'unknown name', message(far, here, frame_names=[frames[0], 'nobody']), 'nobody'
    yield (
        'unknown id',
        message(far, here, frame_names=[], frame_ids=[2**63, 2**64 - 1]),
        'no frame',
    )
    yield 'the world', message(far, frame_names=['world']), 'world'
    yield 'unknown source', message(far, here, source='stranger'), 'stranger'
    yield 'name of 1 MB', message(far, here, frame_names=[frames[0], LONG_NAME]), 'no frame'
    yield 'source of 1 MB', message(far, here, source=LONG_NAME), 'no source'
    wrong = message(far, here)
    wrong.header.frame_id = 'map'
    yield 'another world', wrong, "'map'"


def ten_million(frames: list[str]) -> Any:
    """Return a FramePoses message with ten million numbers for two frames."""
    return msg.FramePoses(frame_names=frames, poses=array.array('d', bytes(8 * MANY)))


def requests(source: str, frame: str, geometry: str) -> Iterator[tuple[str, Any, dict, str]]:
    """Yield (service, type, fields, word of the refusal) about a scene that holds the three."""
    ball = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.1])
    place = {'source': source, 'frame': frame, 'name': 'hostile', 'shape': ball}
    nowhere = Pose(position=Point(x=math.nan))
    infinite = msg.Shape(type=msg.Shape.SPHERE, dimensions=[math.inf])
    shapeless = msg.Shape(type=99)
    mesh = msg.Shape(type=msg.Shape.CONVEX, dimensions=[1.0], mesh_uri='/etc/hostname')
    unknown = msg.CollisionFilterDeclaration(
        statements=[
            msg.CollisionFilterStatement(
                operation=1, set_a=msg.GeometrySet(geometry_ids=[2**64 - 1])
            )
        ]
    )
    sure = msg.CollisionFilterDeclaration()
    yield 'register_source', srv.RegisterSource, {'name': source}, source
    yield 'register_frame', srv.RegisterFrame, {'source': source, 'name': frame}, frame
    yield 'register_frame', srv.RegisterFrame, {'source': LONG_NAME, 'name': 'x'}, 'no source'
    yield 'register_geometry', srv.RegisterGeometry, {**place, 'frame': 'nobody'}, 'nobody'
    yield 'register_geometry', srv.RegisterGeometry, {**place, 'pose': nowhere}, 'finite'
    yield 'register_geometry', srv.RegisterGeometry, {**place, 'shape': infinite}, 'inf'
    yield 'register_geometry', srv.RegisterGeometry, {**place, 'shape': shapeless}, '99'
    yield 'register_geometry', srv.RegisterGeometry, {**place, 'shape': mesh}, 'mesh_roots'
    yield 'assign_role', srv.AssignRole, {'geometry': geometry, 'role': msg.Role(role=77)}, '77'
    for value in (
        ParameterValue(type=3, double_value=math.nan),
        ParameterValue(type=3, double_value=-math.inf),
        ParameterValue(type=8, double_array_value=[0.5, math.inf]),
    ):
        unbounded = msg.Role(role=1, properties=[msg.Property(name='mu', value=value)])
        fields = {**place, 'roles': [unbounded]}
        yield 'register_geometry', srv.RegisterGeometry, fields, 'finite'
        fields = {'geometry': geometry, 'role': unbounded, 'assign': 1}
        yield 'assign_role', srv.AssignRole, fields, 'finite'
    yield 'remove_role', srv.RemoveRole, {'geometry': geometry, 'role': 77}, '77'
    yield 'remove_geometry', srv.RemoveGeometry, {'geometry': '#18446744073709551615'}, '#1844'
    yield 'change_shape', srv.ChangeShape, {'geometry': geometry, 'shape': shapeless}, '99'
    yield 'load_scene', srv.LoadScene, {'text': BOMB}, 'alias'
    yield 'load_scene', srv.LoadScene, {'text': CODE}, 'tag'
    for key, entry in (
        ('sources', r'"a\0b"'),
        ('frames', r'{name: "a\0b", source: nul}'),
        ('geometries', r'{name: "a\0b", source: nul, shape: {type: sphere, radius: 1}}'),
        ('filters', r'{clique: {name: "a\0b", members: []}}'),
    ):
        text = f'{"" if key == "sources" else "sources: [nul]"}\n{key}: [{entry}]\n'
        yield 'load_scene', srv.LoadScene, {'text': text}, 'NUL'
    yield 'load_scene', srv.LoadScene, {'text': '[' * 100_000 + '\n'}, 'deep'
    yield 'load_scene', srv.LoadScene, {'path': '/etc/hostname'}, 'mesh_roots'
    yield 'load_scene', srv.LoadScene, {'path': 'x', 'text': 'y'}, 'exactly one'
    yield 'save_scene', srv.SaveScene, {'path': '/etc/hostname'}, 'mesh_roots'
    yield 'apply_filter', srv.ApplyFilter, {'declaration': unknown}, 'no geometry'
    lease = {'declaration': sure, 'lease': math.nan}
    yield 'apply_transient_filter', srv.ApplyTransientFilter, lease, 'lease'
    yield 'renew_filter', srv.RenewFilter, {'filter_id': 1, 'lease': -1.0}, 'lease'
    pair = {'geometry_a': geometry, 'geometry_b': geometry}
    yield 'compute_signed_distance_pair', srv.ComputeSignedDistancePair, pair, 'self'
    level = {'accuracy': LONG_NAME}
    yield 'compute_point_pair_penetration', srv.ComputePointPairPenetration, level, 'accuracy'
    far = {'max_distance': math.nan}
    yield (
        'compute_signed_distance_pairwise',
        srv.ComputeSignedDistancePairwise,
        far,
        'max_distance',
    )
    for points, word in (([math.nan] * 3, 'not finite'), ([1.0] * 4, 'x y z')):
        fields = {'points': points}
        yield (
            'compute_signed_distance_to_point',
            srv.ComputeSignedDistanceToPoint,
            fields,
            word,
        )
    yield 'get_pose', srv.GetPose, {'frame': frame, 'geometry': geometry}, 'exactly one'
    yield 'explain_filter', srv.ExplainFilter, {'geometry_a': LONG_NAME}, 'no geometry'
