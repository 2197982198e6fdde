"""Kinematic trees that stand in the world: several roots as free links of one tree."""

from dataclasses import replace

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import WORLD
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.scene_files.urdf_tree import root_links


def grounded(tree: LinkTree) -> LinkTree:
    """Return a tree with one root: floating joints hold several roots to the world.

    As in Drake, each of these joints is named as its link.
    """
    roots = root_links(tree.joints, tree.links)
    if len(roots) <= 1:
        return tree
    free = (floating(tree, link) for link in roots if link != WORLD)
    links = tree.links if WORLD in tree.links else (WORLD, *tree.links)
    return replace(tree, links=links, joints=(*tree.joints, *free))


def floating(tree: LinkTree, link: str) -> UrdfJoint:
    """Return a floating joint of a link in the world, with a name that no other joint has."""
    taken = {joint.name for joint in tree.joints}
    name = link
    while name in taken:
        name += '_floating'
    return UrdfJoint('floating', WORLD, link, name, RigidTransform(), (1.0, 0.0, 0.0))


def free_links(tree: LinkTree) -> list[str]:
    """Return the root of a tree, or the links that floating joints hold to the world."""
    roots = [root for root in root_links(tree.joints, tree.links) if root != WORLD]
    held = [j.child for j in tree.joints if j.parent == WORLD and j.type == 'floating']
    return roots + held


def without_world(tree: LinkTree, link: str) -> LinkTree | None:
    """Return a tree with a free link as its only root, None if the world holds others."""
    if WORLD not in tree.links:
        return tree
    of_world = [joint for joint in tree.joints if joint.parent == WORLD]
    if [joint.child for joint in of_world] != [link]:
        return None
    links = tuple(each for each in tree.links if each != WORLD)
    return replace(tree, links=links, joints=tuple(j for j in tree.joints if j not in of_world))


def fixed_in_world(tree: LinkTree, link: str, X_WL: RigidTransform) -> LinkTree:
    """Return a tree in which a fixed joint holds a free link to the link ``world``."""
    joints = (
        replace(joint, type='fixed', X_PJ=X_WL)
        if joint.parent == WORLD and joint.child == link
        else joint
        for joint in tree.joints
    )
    return replace(tree, joints=tuple(joints))
