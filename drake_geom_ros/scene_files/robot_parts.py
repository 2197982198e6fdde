"""Parts of a robot as its file describes them, whatever the format of the file."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    FilterDescription,
    FrameDescription,
    GeometryDescription,
)
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.jointed_links import JointedLinks
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.scene_files.urdf_tree import fixed_poses, root_links

Offsets = Mapping[str, tuple[str, RigidTransform]]
_VISUAL_ONLY = (
    '{} of {} links have visuals and no collision geometry, so no query sees them: {}. Give them '
    'collision elements, or cover them by geometries of the scene file'
)
_MOST_NAMED = 40  # links in a warning


@dataclass(frozen=True)
class RobotParts:
    """Parts of a robot; ``warnings`` report elements that are not understood.

    - ``offsets``: named frames that are fixed to a link, each with its link and its pose in it.
    - ``X_WB``: the pose of the root link that the file gives, None if it gives none.
    - ``is_welded``: whether X_WB is the pose in the world, or in a link that carries the robot, of
      a root that is held there.
    - ``X_WLs``: the poses that the file gives to links below a floating joint.
    """

    frames: tuple[FrameDescription, ...]
    geometries: tuple[GeometryDescription, ...]
    filters: tuple[FilterDescription, ...]
    tree: LinkTree
    warnings: tuple[str, ...] = ()
    offsets: Offsets = field(default_factory=dict)
    X_WB: RigidTransform | None = None
    X_WLs: Mapping[str, RigidTransform] = field(default_factory=dict)
    is_welded: bool = False

    @property
    def joints(self) -> tuple[UrdfJoint, ...]:
        """The joints in the order of the file."""
        return self.tree.joints

    @property
    def link_names(self) -> list[str]:
        """The links in the order of the file."""
        return [frame.name for frame in self.frames]

    def holding(self, joints: Collection[str]) -> 'RobotParts':
        """Return the parts with some joints held: a link that no other one moves stays, too."""
        if not joints:
            return self
        links = JointedLinks(self.tree)
        needs = links.tree.needs()
        still = {
            link
            for row, link in enumerate(links.link_names)
            if all(links.joint_names[c] in joints for c in np.flatnonzero(needs[row]))
        }
        frames = (replace(f, static=None) if f.name in still else f for f in self.frames)
        return replace(self, frames=tuple(frames))

    def placed(
        self, X_WB: RigidTransform, configuration: Mapping[str, float] = MappingProxyType({})
    ) -> 'RobotParts':
        """Return the parts with initial poses of the root link B and the links fixed to it.

        Links whose joints all have a value in the configuration are posed too, and those below a
        floating joint whose pose the file gives. Raises ValueError, which names no line, if links
        have no single root.
        """
        links = dict.fromkeys((*(joint.parent for joint in self.joints), *self.link_names))
        roots = root_links(self.joints, links or self.tree.links)
        if len(roots) != 1:
            raise ValueError(
                f'the pose is that of the root link, but the links {", ".join(map(repr, roots))} '
                'have no parent each'
            )
        poses = JointedLinks(self.tree).poses_at(configuration, X_WB) if configuration else {}
        poses |= fixed_poses(self.joints, roots[0], X_WB)
        for link, X_WL in self.X_WLs.items():
            poses |= fixed_poses(self.joints, link, X_WL)
        frames = (replace(frame, X_PF=poses.get(frame.name)) for frame in self.frames)
        return replace(self, frames=tuple(frames), X_WB=X_WB)


def is_visual_only(link: Any) -> bool:
    """Return whether a link element of a URDF or SDFormat has a visual and no collision."""
    return link.find('visual') is not None and link.find('collision') is None


def visual_only_warning(names: Sequence[str], links: int, place: Location) -> tuple[str, ...]:
    """Return one warning about links, of so many, that have visuals alone; none without any."""
    if not names:
        return ()
    more = f' and {len(names) - _MOST_NAMED} more' if len(names) > _MOST_NAMED else ''
    warning = _VISUAL_ONLY.format(len(names), links, ', '.join(names[:_MOST_NAMED]) + more)
    return (str(place.error(warning)),)
