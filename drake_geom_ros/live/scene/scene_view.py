"""One moment of the live scene, for queries that run while the scene moves on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ClosingSpeeds,
    CollisionFilterManager,
    FrameId,
    PenetrationResults,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphContext,
    SignedDistanceResults,
    closing_speeds,
)
from drake_geom_ros.live.conversions.names import NameTable
from drake_geom_ros.live.conversions.scene import Attachment
from drake_geom_ros.live.scene.bound_rules import hanging
from drake_geom_ros.live.scene.driven_robot import JointEntry
from drake_geom_ros.live.scene.half_spaces import overlapping_half_spaces
from drake_geom_ros.live.scene.pose_ages import Oldest, UnknownAges
from drake_geom_ros.live.scene.seen_shells import NOTHING_BESIDE, BesideBodies
from drake_geom_ros.live.scene.waiting import Waiting, waiting

_MOST_STALE = 20  # names of frames in an answer


@dataclass(frozen=True)
class SceneStamp:
    """The scene and the poses that a result is for."""

    version: int
    names_version: int  # the version since which ids and names hold
    newest_stamp: Any  # builtin_interfaces/Time; None before the first pose
    oldest: Oldest  # the pose that is the oldest
    world_frame: str

    def after(self, seconds: float) -> SceneStamp:
        """Return the stamp of the same poses for a message that is sent some seconds later."""
        return replace(self, oldest=self.oldest.after(seconds))

    def stamp(self, message: Any) -> None:
        """Say in a result which poses and which scene it answers for, and whose ids it holds."""
        self.stamp_report(message)
        message.names_version = self.names_version

    def stamp_report(self, message: Any) -> None:
        """Say in a message without ids which poses and which scene it is about."""
        self.stamp_header(message)
        self.tell_oldest(message)

    def stamp_header(self, message: Any) -> None:
        """Say in a message which poses and which scene it is about, and not how old they are."""
        self.stamp_poses(message)
        message.scene_version = self.version

    def stamp_poses(self, message: Any) -> None:
        """Say in a message that is about no version of a scene which poses it is about."""
        message.header.frame_id = self.world_frame
        # A message that is filled again may bear the stamp of an earlier scene.
        stamp = self.newest_stamp
        message.header.stamp = type(message.header.stamp)() if stamp is None else stamp

    @property
    def oldest_pose_age(self) -> float:
        """The age [s] of the oldest pose."""
        return self.oldest.age

    def tell_oldest(self, message: Any) -> None:
        """Say in a message how old the oldest pose is, and of which frame."""
        message.oldest_pose_age, message.oldest_frame = self.oldest


@dataclass(frozen=True)
class SceneView:
    """The scene at a moment: nobody changes it, so that any thread may ask it, for any time."""

    context: SceneGraphContext
    query: QueryObject  # of the context
    names: NameTable
    moment: SceneStamp
    filter_owners: Mapping[int, str]  # of the active transient filters, by id
    unknown_ages: UnknownAges
    joints: tuple[JointEntry, ...] = ()  # of the robots
    twists: Mapping[FrameId, NDArray[np.float64]] | None = None  # V_WF (6,); None: nobody watches
    beside: BesideBodies = NOTHING_BESIDE
    stale: Mapping[int, float] = field(default_factory=dict)  # ages [s] of old poses, by frame
    absent: frozenset[int] = frozenset()  # frames that left, for which nobody waits
    replaced: frozenset[int] = frozenset()  # frames that a question poses, by values of ids
    # Full names of the geometries that attached frames may touch.
    touch_links: Mapping[FrameId, tuple[str, ...]] = field(default_factory=dict)

    @property
    def filters(self) -> CollisionFilterManager:
        """The collision filters of this moment."""
        return SceneGraph().collision_filter_manager(self.context)

    def closing_speeds(
        self, results: SignedDistanceResults | PenetrationResults
    ) -> ClosingSpeeds | None:
        """Return how fast pairs come together at the twists of this moment; None: nobody knows."""
        return None if self.twists is None else closing_speeds(results, self.twists)

    def attachments(self) -> dict[FrameId, Attachment]:
        """Return the attachments of the attached frames that have a pose."""
        inspector, unposed = self.query.inspector(), set(self.query.waiting_frames())
        return {
            frame: Attachment(self.query.X_PF(frame), self.touch_links.get(frame, ()))
            for frame in inspector.GetAllFrameIds()
            if inspector.IsAttached(frame) and frame not in unposed
        }

    def stale_frames(self) -> list[str]:
        """Return the names of frames with a stale pose on which geometries hang, the oldest first.

        But for frames that the question poses. At most 20.
        """
        stale = {frame: age for frame, age in self.stale.items() if frame not in self.replaced}
        if not stale:
            return []
        inspector = self.query.inspector()
        hung = hanging(inspector, inspector.GetAllGeometryIds(Role.kProximity))
        names = {frame.get_value(): name for frame, name in self.names.frame_names.items()}
        stale_first = sorted((f for f in stale if f in hung), key=lambda f: (-stale[f], names[f]))
        return [names[frame] for frame in stale_first[:_MOST_STALE]]

    def waiting(self) -> Waiting:
        """Return what an answer leaves out for want of poses."""
        return waiting(self.query, self.names, self.beside, self.absent)

    def reservations(self) -> str:
        """Return in words what an answer leaves out, and which poses it should not be built on."""
        said = self.waiting().in_words(), self.beside.in_words(), self.unknown_ages.in_words()
        return '; '.join(filter(None, said))

    def reservations_of_list(self) -> str:
        """Return the same of a list of pairs, which leaves out pairs of half spaces, too."""
        said = overlapping_half_spaces(self.query, self.names), self.reservations()
        return '; '.join(filter(None, said))
