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


def matrix(names=(), allowed=(), defaults=()):
    """Return an AllowedCollisionMatrix; ``allowed`` are pairs, ``defaults`` a mapping."""
    names, defaults = list(names), dict(defaults)
    sets = [set(pair) for pair in allowed]
    rows = [Plain(enabled=[{a, b} in sets and a != b for b in names]) for a in names]
    return Plain(
        entry_names=names,
        entry_values=rows,
        default_entry_names=list(defaults),
        default_entry_values=list(defaults.values()),
    )


def planning_scene(objects=(), attached=(), allowed=None, is_diff=True, **fields):
    """Return a PlanningScene; ``fields`` are further ones of it or of its robot_state."""
    joints = Plain(name=fields.pop('joint_names', []))
    state = Plain(
        joint_state=joints,
        multi_dof_joint_state=Plain(joint_names=[]),
        attached_collision_objects=list(attached),
        is_diff=fields.pop('state_is_diff', is_diff),
    )
    octomap = Plain(octomap=Plain(data=fields.pop('octomap', [])))
    lists = ('fixed_frame_transforms', 'link_padding', 'link_scale', 'object_colors')
    message = {key: [] for key in lists} | {'name': '', 'robot_model_name': ''}
    message |= {'robot_state': state, 'allowed_collision_matrix': allowed or matrix()}
    message |= {'world': Plain(collision_objects=list(objects), octomap=octomap)}
    return Plain(**{**message, 'is_diff': is_diff, **fields})
