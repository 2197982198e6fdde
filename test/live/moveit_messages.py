"""MoveIt's messages as plain objects, with the fields that moveit_msgs gives them."""

from types import SimpleNamespace as Plain

import numpy as np

from drake_geom_ros.sensed_maps.octree import binary_of_cells

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


def transform(*p, q=(0.0, 0.0, 0.0, 1.0)):
    """Return a Transform by x, y, z (0 where they are missing) and a quaternion x y z w."""
    x, y, z = map(float, (*p, 0.0, 0.0, 0.0)[:3])
    return Plain(translation=Plain(x=x, y=y, z=z), rotation=Plain(x=q[0], y=q[1], z=q[2], w=q[3]))


def robot_state(joints=(), several=(), attached=(), is_diff=True, frame='', **fields):
    """Return a RobotState; ``joints`` maps names to positions, ``several`` to Transforms."""
    joints, several = dict(joints), dict(several)
    stamp = Plain(sec=0, nanosec=0)
    own = {'name': list(joints), 'position': list(joints.values()), 'velocity': []}
    header = Plain(stamp=stamp, frame_id=frame)
    return Plain(
        joint_state=Plain(header=header, **{**own, **fields}),
        multi_dof_joint_state=Plain(
            header=header, joint_names=list(several), transforms=list(several.values())
        ),
        attached_collision_objects=list(attached),
        is_diff=is_diff,
    )


def octomap_of(cells, resolution=0.5, frame='world', at=None, **fields):
    """Return an OctomapWithPose of Cells; None: an empty one."""
    data = b'' if cells is None else binary_of_cells(cells).data
    header = Plain(frame_id=frame, stamp=Plain(sec=0, nanosec=0))
    kind = '' if cells is None else 'OcTree'
    map_fields = {'id': kind, 'binary': True, 'resolution': resolution, 'data': data, **fields}
    return Plain(header=header, origin=at or pose(), octomap=Plain(header=header, **map_fields))


def planning_scene(objects=(), attached=(), allowed=None, is_diff=True, **fields):
    """Return a PlanningScene; ``fields`` are further ones of it, and ``joints`` by name."""
    state_is_diff = fields.pop('state_is_diff', is_diff)
    state = fields.pop('state', None) or robot_state(
        fields.pop('joints', {}), attached=attached, is_diff=state_is_diff
    )
    octomap = fields.pop('octomap', None) or octomap_of(None)
    lists = ('fixed_frame_transforms', 'link_padding', 'link_scale', 'object_colors')
    message = {key: [] for key in lists} | {'name': '', 'robot_model_name': ''}
    message |= {'robot_state': state, 'allowed_collision_matrix': allowed or matrix()}
    message |= {'world': Plain(collision_objects=list(objects), octomap=octomap)}
    return Plain(**{**message, 'is_diff': is_diff, **fields})
