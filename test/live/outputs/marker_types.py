"""A scene with something to see, and marker messages that stand for those of ROS."""

from types import SimpleNamespace as Plain

TEXT = """
sources: [s]
frames:
  - {name: a, source: s, pose: {}}
  - {name: b, source: s, pose: {position: [1, 0, 0]}}
geometries:
  - {name: capsule, source: s, frame: a, shape: {type: capsule, radius: 0.1, length: 0.4}}
  - {name: ball, source: s, frame: b, shape: {type: sphere, radius: 0.1},
     roles: {proximity: {}, illustration: {phong: {diffuse: {rgba: [1, 0, 0, 0.5]}}}}}
  - {name: seen, source: s, frame: b, shape: {type: sphere, radius: 0.2},
     roles: {illustration: {}}}
"""


def vector(**numbers):
    return Plain(**{'x': 0.0, 'y': 0.0, 'z': 0.0, **numbers})


def new_marker(**fields):
    return Plain(
        **{'type': 0, 'ns': '', 'id': 0, 'action': 0, 'points': [], **fields},
        header=Plain(frame_id='', stamp=Plain(sec=0, nanosec=0)),
        pose=Plain(position=vector(), orientation=vector(w=0.0)),
        scale=vector(),
        color=Plain(r=0.0, g=0.0, b=0.0, a=0.0),
    )


TYPES = Plain(Marker=new_marker, MarkerArray=Plain, Point=vector)
