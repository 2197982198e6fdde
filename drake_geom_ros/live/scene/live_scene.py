"""The one live scene of a node, behind its lock.

Times are plain seconds, messages any objects with the right fields.

Several threads meet here, and there are three ways in::

    view = live.view()                # a snapshot to keep: queries take long, and run on it
    with live.reading() as scene: ... # nobody changes the scene meanwhile
    with live.editing() as scene: ... # nobody else has the scene meanwhile
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from drake_geom_ros.geometry import AccuracyLike, GeometryError, QueryObject, SceneGraph
from drake_geom_ros.geometry.render import CameraProperties
from drake_geom_ros.live.conversions.file_access import ALL_PACKAGES, FileAccess
from drake_geom_ros.live.conversions.message_types import (
    FramePosesMessage,
    JointPositionsMessage,
)
from drake_geom_ros.live.conversions.names import WORLD
from drake_geom_ros.live.scene.change import Change, unchanged
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.map_sources import MapSources
from drake_geom_ros.live.scene.prepared_scene import PreparedScene, prepared
from drake_geom_ros.live.scene.robot_following import pose_followers, refuse_twice_posed
from drake_geom_ros.live.scene.scene_draft import SceneDraft
from drake_geom_ros.live.scene.scene_snapshot import SceneSnapshot
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import RobotOptions, SceneDescription, camera_of

_Result = TypeVar('_Result')
_TRIES = 3  # of a change beside others who change the scene all the time


class LiveScene:
    """Hands the scene out, to one thread at a time; whoever has it may ask for it again."""

    def __init__(
        self,
        accuracy: AccuracyLike,
        clocks: Clocks,
        world_frame: str = WORLD,
        version: int = 0,
    ) -> None:
        """``clocks`` measure the ages of poses and the leases of filters.

        ``version`` is that of the scene while it is empty: it grows from there.
        """
        self.clocks = clocks
        self.files = FileAccess([ALL_PACKAGES])
        self.map_sources = MapSources()
        self.robot_options = RobotOptions()  # of robots that come by topic or as a URDF
        # Called with name, number and last of what has to be compiled, while queries wait for it.
        self.tell_compiling: Callable[[str, int, int], None] | None = None
        self.time_budget = 0.0  # [s] of what an answer may leave out for want of time; 0: none
        # Called when the tables of a large scene were made, which are there to stay.
        self.have_settled: Callable[[], object] = lambda: None
        # Asks a query object of a scene that is to come what the cycles ask.
        self.rehearse: Callable[[QueryObject], object] = lambda query: None
        self.stale_after = math.inf  # [s] age from which on answers name a pose as stale
        self.world_frame = world_frame
        self._lock = threading.RLock()
        self._turn = threading.RLock()  # of who takes a draft over; taken before the scene
        self._closed = self._interrupted = False
        self._scene = HeldScene(SceneGraph(accuracy=accuracy), clocks, world_frame, version)

    @property
    def most_megabytes(self) -> float:
        """The largest answer [MB], and the largest images of a camera."""
        return self._scene.cameras.limits.megabytes

    @most_megabytes.setter
    def most_megabytes(self, limit: float) -> None:
        self._scene.cameras.limits.megabytes = limit

    def name_cameras_for(self, node: str) -> None:
        """Refuse cameras whose topics would have too long names, below a node's full name."""
        self._scene.cameras.limits.of_node(node)

    @contextmanager
    def editing(self) -> Iterator[HeldScene]:
        """Hand the scene out to be changed; raises RuntimeError once it is closed."""
        with self._lock:
            if self._closed:
                raise GeometryError(
                    'the scene was closed by cleanup or shutdown of the node; nothing was changed'
                )
            yield self._scene

    def close(self) -> None:
        """Let nobody change the scene any more: who began before, and comes late, is refused."""
        with self._lock:
            self._closed = True

    def interrupt(self) -> None:
        """Let answers that take long end: nobody will wait for them."""
        self._interrupted = True

    def must_stop(self) -> bool:
        """Return whether what takes long is to end, without an answer; it takes no lock."""
        return self._interrupted or self._closed

    @contextmanager
    def reading(self) -> Iterator[HeldScene]:
        """Hand the scene out to be looked at, a closed one too."""
        with self._lock:
            yield self._scene

    def view(
        self,
        poses: FramePosesMessage | None = None,
        joints: JointPositionsMessage | None = None,
    ) -> SceneView:
        """Return the scene of now, with other poses and joint values where these are given.

        ``poses`` is a FramePoses, ``joints`` a JointPositions. Frames that are not named, nor
        moved by a joint that is, keep their live poses, but for links, which follow the base of
        their robot as they do live; where nothing is named, the view knows how
        all move, if anybody watches that. Raises RuntimeError for a message that
        ``ScenePoses.take`` would refuse, for joints that are none, and for a frame that both pose.
        """
        with self.reading() as scene:
            read = None if poses is None else scene.model.reader.read(poses)
            if joints is not None and not (len(joints.names) or len(joints.positions)):
                joints = None
            posed = set() if read is None else set(read.frames)
            is_now = not posed and joints is None
            view = scene.view(moving=poses is not None and is_now, stale_after=self.stale_after)
            replaced = posed
            if read is not None and posed:
                view.context.UpdateFramePoses(read.poses)
                pose_followers(scene, view, posed)
            if joints is not None:
                positions = np.asarray(joints.positions, dtype=np.float64)
                moved = scene.model.joints.moved(joints.names, positions, view.query)
                by_values = set(moved.id_values().tolist())
                refuse_twice_posed(scene, posed & by_values)
                view.context.UpdateFramePoses(moved)
                pose_followers(scene, view, posed | by_values)
                named = scene.model.joints.places(joints.names)
                replaced = posed | by_values - scene.poses.links_of_stale_joints(
                    self.stale_after, named
                )
        return replace(view, replaced=frozenset(replaced))

    def compile_kernels(self) -> list[str]:
        """Compile what queries of the scene run, beside the cycle; return the kernels.

        Where the scene has cameras, what takes images too: by an image of one pixel. Where it has
        maps, what measures points, for rules about what sensors see beside bodies.
        """
        with self.reading() as scene:
            cameras, has_maps = scene.cameras.by_name(), bool(scene.maps.by_name)
            view = scene.view()
        kernels = view.context.compile_kernels(self.tell_compiling)
        if has_maps:
            view.query.ComputeSignedDistanceToPoint(np.zeros((1, 3)), 0.0)
        for _, camera in list(cameras.values())[:1]:
            name = camera_of(camera).core().renderer_name()
            pixel = CameraProperties(1, 1, 1.0, name)
            view.query.render_images(pixel, view.names.world, RigidTransform())
        return kernels

    def make_ready(self, change: Change[HeldScene, Any]) -> tuple[SceneDraft, Any]:
        """Make a change on a copy of the scene, and what queries need of the changed scene.

        So files are read and kernels compiled beside the cycle, before the change is made in
        earnest: the scene is held only while it is copied. Returns the draft, and what the change
        made there; raises what it raises.
        """
        with self.reading() as scene:
            draft = SceneDraft(scene.model, scene.rules)
        made = draft.make(change)
        self._get_ready(draft)
        return draft, made

    def _get_ready(self, draft: SceneDraft) -> None:
        draft.get_ready(self.rehearse, self.tell_compiling)
        if draft.is_large:
            self.have_settled()

    def change(
        self,
        change: Change[HeldScene, _Result],
        *,
        calls_for_more: bool = False,
        is_short: bool = False,
    ) -> _Result:
        """Make a change, and return its result.

        Cycles go on meanwhile, where the scene is large or the change ``calls_for_more`` kernels:
        it is made on a draft, which the scene becomes. One that ``is_short`` is made at once in a
        large scene, too.
        """
        for left in reversed(range(_TRIES)):
            with self.reading() as scene:
                if not calls_for_more and (is_short or not scene.model.is_large):
                    break
            with self._alone(left):
                draft, made = self.make_ready(change)
                with self._turn, self.editing() as scene:
                    change.first(scene)
                    if scene.take_over(draft):
                        return change.then(scene, made)
            calls_for_more = False
        with self.editing() as scene:
            return scene.make(change)

    def _alone(self, left: int) -> AbstractContextManager[object]:
        """Let drafts of others wait during the last try, with none left: it is not in vain."""
        return nullcontext() if left else self._turn

    def replace(
        self,
        describe: Callable[[SceneSnapshot], SceneDescription],
        gone: str,
    ) -> tuple[int, int]:
        """Put another scene in the place of this one; return its frames and geometries.

        ``describe`` returns it for the scene as it is, without the source that is ``gone`` or is
        another one; frames of all others stay where they are. It is made ready beside the cycles,
        and made again if the scene changed meanwhile.
        """
        for left in reversed(range(_TRIES)):
            with self._alone(left):
                with self.reading() as scene:
                    before = scene.snapshot()
                other = self._prepared(describe(before))
                with self._turn, self.editing() as scene:
                    if scene.mark().matches(before.mark):
                        return self._replace(scene, other, before, gone)
        with self.editing() as scene:
            before = scene.snapshot()
            return self._replace(scene, self._prepared(describe(before)), before, gone)

    def replace_all(
        self,
        description: SceneDescription,
        first: Callable[[HeldScene], object] = lambda scene: None,
    ) -> tuple[int, int]:
        """Put what is described in the place of all; return its frames and geometries.

        ``first`` looks at the scene that goes.
        """
        other = self._prepared(description)
        with self.editing() as scene:
            first(scene)
            return self._replace(scene, other)

    def _prepared(self, description: SceneDescription) -> PreparedScene:
        """Return a scene with all that cycles need of it, made beside them."""
        sources = self.map_sources
        with self.reading() as scene:
            accuracy = scene.accuracy
        other = prepared(description, list(sources.fed), sources.margin, accuracy)
        with self.reading() as scene:
            draft = SceneDraft(scene.model, scene.rules, other.context)
        draft.maps_source = other.maps.source
        draft.follow(Change(unchanged, robots=description.robots, rules=description.rules))
        self._get_ready(draft)
        return replace(other, draft=draft)

    def _replace(
        self,
        scene: HeldScene,
        other: PreparedScene,
        before: SceneSnapshot | None = None,
        gone: str = '',
    ) -> tuple[int, int]:
        """Replace the scene; frames that moved since a snapshot stay, but those that are gone."""
        moved = {} if before is None else scene.moved_since(before)
        added = scene.replace(other)
        scene.poses.put({label: X_PF for label, X_PF in moved.items() if label[0] != gone})
        for feeder in self.map_sources.fed.values():
            feeder.forget()
        return added
