"""A scene that TF poses, and messages of TF that stand for those of ROS."""

from types import SimpleNamespace as Plain

from drake_geom_ros.math import RigidTransform

TEXT = """
sources: [left, right]
frames:
  - {name: base, source: left}
  - {name: hand, source: left, parent: base}
  - {name: base, source: right}
  - {name: tool, source: right}
"""


def transform(parent, child, X=None, stamp=0.0):
    x, y, z, qx, qy, qz, qw = (X or RigidTransform()).ToArray().tolist()
    return Plain(
        header=Plain(frame_id=parent, stamp=Plain(sec=int(stamp), nanosec=int(stamp % 1 * 1e9))),
        child_frame_id=child,
        transform=Plain(translation=Plain(x=x, y=y, z=z), rotation=Plain(x=qx, y=qy, z=qz, w=qw)),
    )


def message(*transforms):
    return Plain(transforms=list(transforms))


def take(tf, scene, *messages, static):
    """Have messages heard together, and return how many frames were posed by them."""
    for each in messages:
        tf.hear(each, static=static)
    return tf.pose(scene)


def at(x):
    return RigidTransform([x, 0.0, 0.0])


def position(scene, name):
    return scene.query.X_WF(scene.model.names.frame(name)).translation().tolist()
