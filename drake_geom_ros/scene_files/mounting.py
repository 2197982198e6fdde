"""Robots that a frame of another source carries: their frames and the filter at the mount."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from drake_geom_ros.geometry import Role
from drake_geom_ros.scene_files.description import (
    WORLD,
    CliqueDescription,
    FrameDescription,
    GeometryDescription,
    Member,
    RobotDescription,
)
from drake_geom_ros.scene_files.urdf_filters import links_fixed_to
from drake_geom_ros.scene_files.urdf_tree import root_links


def carried(
    frames: Iterable[FrameDescription], robot: RobotDescription, on: Member
) -> list[FrameDescription]:
    """Return the frames, with those of the robot's links mounted on the frame ``on``."""
    links = set() if robot.tree is None else set(robot.tree.links)
    return [
        replace(frame, mounted_on=on)
        if frame.source == robot.name and frame.name in links and frame.parent == WORLD
        else frame
        for frame in frames
    ]


def mount_clique(
    robot: RobotDescription,
    on: Member,
    robots: Sequence[RobotDescription],
    geometries: Iterable[GeometryDescription],
) -> Iterator[CliqueDescription]:
    """Yield the clique of the links fixed to a robot's root and to the frame that carries it.

    It treats the mount as a fixed joint. Links without shapes carry no filter.
    """
    if robot.tree is None:
        return
    (root,) = root_links(robot.tree.joints, robot.tree.links)
    carriers = [each.tree.joints for each in robots if each.name == on.source and each.tree]
    held = links_fixed_to(carriers[0], on.frame) if carriers else [on.frame]
    members = [
        *(Member(robot.name, link) for link in links_fixed_to(robot.tree.joints, root)),
        *(Member(on.source, frame) for frame in held),
    ]
    shaped = {(g.source, g.frame) for g in geometries if Role.kProximity in g.roles}
    members = [each for each in members if (each.source, each.frame) in shaped]
    if len(members) > 1:
        name = f'{robot.name}: mounted on {on.source}::{on.frame}'
        yield CliqueDescription(name, tuple(members), robot.where)
