"""MoveIt's messages as plain objects, with the fields that moveit_msgs gives them."""

from types import SimpleNamespace as Plain

import numpy as np

ADD, REMOVE, APPEND, MOVE = range(4)
BOX, SPHERE, CYLINDER, CONE, PRISM = range(1, 6)


def pose(*p, q=(0.0, 0.0, 0.0, 1.0)):
    """Return a Pose at x, y, z (0 where they are missing) with a quaternion x y z w."""
    x, y, z = map(float, (*p, 0.0, 0.0, 0.0)[:3])
    return Plain(position=Plain(x=x, y=y, z=z), orientation=Plain(x=q[0], y=q[1], z=q[2], w=q[3]))


def primitive(kind, *dimensions):
    return Plain(type=kind, dimensions=list(dimensions))


def ball(radius=0.1):
    return primitive(SPHERE, radius)


def mesh(vertices, triangles):
    return Plain(
        vertices=[Plain(x=x, y=y, z=z) for x, y, z in np.asarray(vertices, dtype=float).tolist()],
        triangles=[Plain(vertex_indices=list(each)) for each in triangles],
    )


def plane(*coefficients):
    return Plain(coef=list(coefficients))


def collision_object(name, operation=ADD, frame='world', at=None, **fields):
    """Return a CollisionObject; ``fields`` are lists of its shapes and their poses."""
    lists = ('primitives', 'primitive_poses', 'meshes', 'mesh_poses', 'planes', 'plane_poses')
    message = {key: [] for key in (*lists, 'subframe_names', 'subframe_poses')}
    message |= {'id': name, 'operation': bytes([operation]), 'pose': at or pose()}
    message |= {'header': Plain(frame_id=frame), 'type': Plain(key='', db='')}
    return Plain(**{**message, **fields})


def attached_object(link, message, touch_links=(), weight=0.0):
    """Return an AttachedCollisionObject."""
    return Plain(
        link_name=link,
        object=message,
        touch_links=list(touch_links),
        detach_posture=Plain(joint_names=[]),
        weight=weight,
    )
