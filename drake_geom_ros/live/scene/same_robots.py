"""Recognition of a robot that the scene has already, by its joints."""

from __future__ import annotations

from collections.abc import Iterable

from drake_geom_ros.geometry import ArgumentError, Role
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.math.tolerances import SAME_MODEL
from drake_geom_ros.scene_files import GeometryDescription, SceneDescription
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint


def robot_of_scene(scene: HeldScene, description: SceneDescription, *, is_named: bool) -> str:
    """Return the name of the robot of a scene that a description is of; empty: it is none.

    It has the same links and joints, and without joints the same shapes, and it is of a file: what
    came by other topics does not count. One that the user named is that of its name alone. Of
    several the one that is called as the description counts; raises ArgumentError where none is.
    """
    (robot,) = description.robots
    assert robot.tree is not None, 'a description has links'
    same = [
        each.name
        for each in scene.model.robots
        if each.tree is not None
        and each.urdf is not None
        and has_same_joints(each.tree, robot.tree)
        and (robot.tree.joints or has_same_shapes(scene, each.name, description.geometries))
    ]
    if robot.name in same:
        return robot.name
    if is_named or not same:
        return ''
    if len(same) > 1:
        raise ArgumentError(
            f'the robot {robot.name!r} has the links and joints of {some_of(same)} of the scene, '
            'and nothing says which of them it is, or that it is another one: name it by the '
            'parameter robot_descriptions'
        )
    return same[0]


def has_same_joints(one: LinkTree, other: LinkTree) -> bool:
    """Return whether two robots have the same links and joints, within rounding.

    The order in their files, limits and the names of the robots do not count.
    """
    joints = {joint.name: joint for joint in other.joints}
    return (
        set(one.links) == set(other.links)
        and len(one.joints) == len(other.joints)
        and all(j.name in joints and _is_same(j, joints[j.name]) for j in one.joints)
    )


def _is_same(one: UrdfJoint, other: UrdfJoint) -> bool:
    kinds = (one.type, one.parent, one.child), (other.type, other.parent, other.child)
    mimics = [m and (m.joint, m.multiplier, m.offset) for m in (one.mimic, other.mimic)]
    axes = zip(one.axis, other.axis, strict=True)
    return (
        kinds[0] == kinds[1]
        and one.X_PJ.IsNearlyEqualTo(other.X_PJ, SAME_MODEL)
        and all(abs(a - b) <= SAME_MODEL for a, b in axes)
        and mimics[0] == mimics[1]
        and len(one.parts) == len(other.parts)
    )


def has_same_shapes(
    scene: HeldScene, source: str, geometries: Iterable[GeometryDescription]
) -> bool:
    """Return whether the links of a robot have the shapes of a description, where it has them."""
    names, inspector = scene.model.names, scene.model.inspector
    present = {name: f for f, (owner, name) in names.labels.items() if owner == source}
    rest = {name: list(inspector.GetGeometries(f, Role.kProximity)) for name, f in present.items()}
    for each in geometries:
        if Role.kProximity not in each.roles:
            continue
        match = next(
            (
                g
                for g in rest.get(each.frame, ())
                if inspector.GetShape(g) == each.shape
                and inspector.GetPoseInFrame(g).IsNearlyEqualTo(each.X_FG, SAME_MODEL)
            ),
            None,
        )
        if match is None:
            return False
        rest[each.frame].remove(match)
    return not any(rest.values())
