"""A small recording of two one-ball robots over a box, and a Scene message, made up for tests."""

from types import SimpleNamespace as Some

import numpy as np

from drake_geom_ros.client.scene_table import Geometry, SceneTable
from drake_geom_ros.ros.demo.recording import Approach, FilterChange, Recording
from drake_geom_ros.scene_files import read_scene


def _at(x, y, z):
    X = np.eye(4)
    X[:3, 3] = x, y, z
    return X


def table(version=1):
    return SceneTable(
        [
            Geometry(1, 'left', 'hand', 'ball', 1, (0.1,), _at(0, 0, 0.05), ('left::hand',)),
            Geometry(2, 'left', 'arm', 'rod', 4, (0.05, 0.4), np.eye(4), ('left::arm',)),
            Geometry(3, 'right', 'hand', 'ball', 1, (0.1,), np.eye(4), ('right::hand',)),
            Geometry(4, 'things', 'can', 'can', 3, (0.03, 0.1), np.eye(4), ('things::can',)),
            Geometry(5, 'room', 'world', 'table', 2, (1.0, 0.6, 0.1), _at(0, 0, -0.2)),
            Geometry(6, 'room', 'world', 'floor', 6, (), np.eye(4)),
            Geometry(7, 'room', 'world', 'stone', 5, (0.05, 0.1, 0.02), _at(0.3, 0.1, -0.1)),
        ],
        version,
    )


# The same scene as a scene file.
DESCRIPTION = read_scene("""
sources: [left, right, things, room]
frames:
- {name: hand, source: left}
- {name: arm, source: left}
- {name: hand, source: right}
- {name: can, source: things}
geometries:
- name: ball
  source: left
  frame: hand
  pose: {position: [0, 0, 0.05]}
  shape: {type: sphere, radius: 0.1}
- {name: rod, source: left, frame: arm, shape: {type: cylinder, radius: 0.05, length: 0.4}}
- {name: ball, source: right, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: can, source: things, frame: can, shape: {type: capsule, radius: 0.03, length: 0.1}}
- name: table
  source: room
  pose: {position: [0, 0, -0.2]}
  shape: {type: box, size: [1.0, 0.6, 0.1]}
- {name: floor, source: room, pose: {position: [0, 0, -0.8]}, shape: {type: half_space}}
- name: stone
  source: room
  pose: {position: [0.3, 0.1, -0.1]}
  shape: {type: ellipsoid, semi_axes: [0.05, 0.1, 0.02]}
""")

POSES = {
    ('left', 'hand'): _at(-0.2, 0, 0.2),
    ('left', 'arm'): _at(-0.5, 0, 0.0),
    ('right', 'hand'): _at(0.15, 0, 0.3),
    ('things', 'can'): _at(0, 0.2, -0.07),
}


def recording(results=40):
    """Hands that close in, a can that is touched twice, two changes of the filters."""
    made = Recording(table(), ('left', 'right'), 0.5)
    for k in range(results):
        time = 100.0 + 0.1 * k
        hands = 0.3 - 0.005 * k
        depth = 0.002 if k in (10, 11, 12, 30) else 0.0
        distance = np.array([hands, -depth if depth else 0.01, 0.25])
        ids = np.array([1, 1, 2]), np.array([3, 4, 3])
        made.add_distances(time, 0.003, *ids, distance, np.full(3, 1e-9), np.array([1, 2, 1]))
        touching = distance < 0
        made.add_penetrations(time, ids[0][touching], ids[1][touching], -distance[touching])
        made.cycle_seconds.append(0.001 * (k + 1))
    made.changes = [FilterChange(100.5, 'first change'), FilterChange(102.0, 'second change')]
    made.filtered_pairs = 17
    X_WA = POSES['left', 'hand'] @ _at(0, 0, 0.05)
    p_AB = POSES['right', 'hand'][:3, 3] - X_WA[:3, 3]
    away = p_AB / np.linalg.norm(p_AB)
    p_WCa, p_WCb = X_WA[:3, 3] + 0.1 * away, POSES['right', 'hand'][:3, 3] - 0.1 * away
    gap = float(np.linalg.norm(p_AB)) - 0.2
    made.approach = Approach(103.9, 1, 3, gap, p_WCa, p_WCb, -away, POSES)
    return made


def _pose(x, y, z, q=(0.0, 0.0, 0.0, 1.0)):
    orientation = dict(zip('xyzw', q, strict=True))
    return Some(position=Some(x=x, y=y, z=z), orientation=Some(**orientation))


def _geometry(id, source, frame, name, kind, dimensions, pose):
    return Some(
        id=id, source_id=source, frame_id=frame, name=name, pose=pose,
        shape=Some(type=kind, dimensions=dimensions), roles=[Some(role=1)],
    )  # fmt: skip


SCENE = Some(
    scene_version=7,
    names_version=7,
    sources=[Some(id=1, name='room'), Some(id=2, name='arm')],
    frames=[
        Some(id=10, name='world', source_id=1, parent_id=10, part_of_robot=False),
        Some(id=11, name='hand', source_id=2, parent_id=10, part_of_robot=False),
        Some(id=12, name='tip', source_id=2, parent_id=11, part_of_robot=False),
    ],
    joints=[],
    geometries=[
        _geometry(5, 1, 10, 'table', 2, [1.0, 1.0, 0.1], _pose(0.0, 0.0, -0.05)),
        _geometry(6, 2, 12, 'ball', 1, [0.1], _pose(0.0, 0.0, 0.2)),
        _geometry(8, 2, 11, 'ring', 1, [0.1], _pose(0.0, 0.0, 0.0)),
    ],
)
