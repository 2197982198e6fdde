"""Objects of MoveIt's planning scene: messages change the source ``planning_scene``, whole or not.

World objects are frames of that source by their ids, with a geometry for each shape, and they
count as anchored. Attached objects follow their link; subframes are frames on their object.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError, GeometryId, OccupiedCells
from drake_geom_ros.live.conversions.allowed_collisions import AllowedCollisions
from drake_geom_ros.live.conversions.collision_objects import (
    attached_from_message,
    is_own,
    request_from_message,
)
from drake_geom_ros.live.conversions.planning_scene import scene_from_message
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.scene_state import SceneState, read_state
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes.map_update import Sighting, shape_of, showing
from drake_geom_ros.live.scene.changes.standing_maps import standing_maps
from drake_geom_ros.live.scene.changes.together import together
from drake_geom_ros.live.scene.changes.world_change import (
    SceneChangedError,
    adds_shapes,
    changed_paddings,
    changes_nothing,
    world_change,
)
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.link_paddings import Enlargement, Padded, padded_geometries
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.world_objects import OCTOMAP_MAP, PlanningWorld

_TRIES = 5  # of a change beside others who change the scene all the time


@dataclass(frozen=True)
class _Kept:
    """Matrix and paddings that also hold for objects and links that come later."""

    matrix: AllowedCollisions | None = None
    links: Mapping[str, Enlargement] = field(default_factory=dict)
    padded: Mapping[GeometryId, Padded] = field(default_factory=dict)


class PlanningSceneInput:
    """Takes MoveIt's messages into the live scene.

    Each call returns in words what was done and what was ignored, for the log. It raises
    RuntimeError to refuse a message, naming the object and the reason; nothing has changed then.
    """

    def __init__(
        self,
        live: LiveScene,
        changed: Callable[[], object] = lambda: None,
        joints: Callable[[], JointInput | None] = lambda: None,
        node: str = '',
    ) -> None:
        """Take messages into ``live``; ``changed`` is called after each that changed it.

        ``joints`` returns what takes the values of joints. ``node`` is the full name of the node,
        whose own objects are left out where they come back.
        """
        self._node = node
        self._live, self._changed, self._joints = live, changed, joints
        self._kept = _Kept()
        self._names_version = -1
        self._noted: set[str] = set()  # of states, which come again and again
        self.taken: set[str] = set()  # ids of objects that messages named

    def take_object(self, message: Any) -> str:
        """Take a CollisionObject."""
        if is_own(message, self._node):
            return ''
        request = request_from_message(message)
        self.taken.add(request.id)
        return self._change(lambda world: world.take(request))

    def take_attached(self, message: Any) -> str:
        """Take an AttachedCollisionObject."""
        if is_own(message.object, self._node):
            return ''
        request = attached_from_message(message)
        self.taken.add(request.object.id)
        return self._change(lambda world: world.take_attached(request))

    def take_scene(self, message: Any) -> str:
        """Take a PlanningScene, full or a diff; the text is empty where nothing came of it."""
        request = scene_from_message(message, self._node)
        self.taken.update(each.id for each in request.objects)
        self.taken.update(each.object.id for each in request.attached)
        cells = None if request.octomap is None else request.octomap.cells
        shape = None if cells is None else shape_of(cells, self._live.map_sources.margin)
        return self._change(lambda world: world.take_scene(request), request.state, shape)

    def renew(self) -> None:
        """Have what a scene said of links hold for robots that came since."""
        with self._live.reading() as scene:
            version = scene.model.names_version
        if version == self._names_version:
            return
        if self._kept.matrix is not None or self._kept.links:
            self._change(PlanningWorld.allow_again)
        self._names_version = version

    def _change(
        self,
        alter: Callable[[PlanningWorld], None],
        robot_state: Any = None,
        shape: OccupiedCells | None = None,
    ) -> str:
        """Alter the objects of the scene of now, and return what became of them."""
        is_new = self._stand_octomap() if shape is not None else False
        try:
            return self._altered(alter, robot_state, shape)
        except RuntimeError:
            if is_new:
                with self._live.editing() as scene:
                    gone = standing_maps(scene, [OCTOMAP_MAP], [])
                self._live.change(gone)
            raise

    def _altered(
        self,
        alter: Callable[[PlanningWorld], None],
        robot_state: Any,
        shape: OccupiedCells | None,
    ) -> str:
        joints = self._joints()
        for _ in range(_TRIES):
            with self._live.editing() as scene:
                state = None if robot_state is None else read_state(scene, joints, robot_state)
                query = None if state is None else state.query(scene)
                world = PlanningWorld(scene, self._kept.matrix, self._kept.links, query)
                alter(world)
                padded = padded_geometries(scene, world.enlarged, self._kept.padded)
                change = _with_octomap(scene, world, shape, world_change(scene, world, padded))
                has_changes = bool(changed_paddings(scene, padded))
                is_idle = not has_changes and changes_nothing(world)
                if is_idle and state is not None and joints is not None and not state.is_empty:
                    state.take(scene, joints)
            if state is not None and joints is not None and not state.is_empty and not is_idle:
                change = _then(change, partial(state.take, joints=joints))
            more = adds_shapes(world) or has_changes or shape is not None
            try:
                if not is_idle:
                    self._live.change(change, calls_for_more=more)
            except SceneChangedError:
                continue
            self._kept = _Kept(world.matrix, world.enlarged, padded)
            if not is_idle or (state is not None and not state.is_empty):
                self._changed()
            return self._in_words(world, state, is_idle=is_idle)
        raise ArgumentError('the scene changes all the time; send the message again')

    def _stand_octomap(self) -> bool:
        """Have the scene hold the map of the octomap; return whether it is new."""
        with self._live.editing() as scene:
            if OCTOMAP_MAP in scene.maps.by_name:
                return False
            change = standing_maps(scene, [], [OCTOMAP_MAP], self._live.map_sources.margin)
        self._live.change(change, calls_for_more=True)
        return True

    def _in_words(self, world: PlanningWorld, state: SceneState | None, *, is_idle: bool) -> str:
        """Return what was done, and notes; those of states once, for they come all the time."""
        notes = [note for note in state.notes if note not in self._noted] if state else []
        self._noted.update(notes)
        if is_idle and state is not None and not world.notes and not notes:
            return ''
        return _in_words(world, notes)


def _with_octomap(
    scene: HeldScene,
    world: PlanningWorld,
    shape: OccupiedCells | None,
    change: Change[HeldScene, None],
) -> Change[HeldScene, None]:
    """Return a change with that of the octomap, if a message says something of it."""
    octomap = world.octomap
    if octomap is None:
        return change
    if shape is None or octomap.cells is None:
        if OCTOMAP_MAP not in scene.maps.by_name:
            return change
        return together(change, standing_maps(scene, [OCTOMAP_MAP], []))
    stamp = scene.poses.ages.newest_stamp
    sighting = Sighting(octomap.cells, shape, world.X_WM, ALWAYS, stamp)
    return together(change, showing(scene, OCTOMAP_MAP, sighting))


def _then(
    change: Change[HeldScene, None], after: Callable[[HeldScene], None]
) -> Change[HeldScene, None]:
    """Return a change after which something else is done at once."""

    def then(scene: HeldScene, made: Any) -> None:
        change.then(scene, made)
        after(scene)

    return replace(change, then=then)


def _in_words(world: PlanningWorld, notes: Sequence[str]) -> str:
    attached = sum(each.link is not None for each in world.objects.values())
    done = (
        f'planning scene: {counted(len(world.objects) - attached, "object")} in the world, '
        f'{attached} attached'
    )
    return '; '.join([done, *world.notes, *notes])
