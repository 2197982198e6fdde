"""The live scene while it is held: sources that go, frames that follow others."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    FramePoseVector,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
    SceneGraphInspector,
    SourceId,
)
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.clocks import ALWAYS, Since, oldest
from drake_geom_ros.live.scene.feeders import MESSAGES
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.pose_ages import PosedFrames
from drake_geom_ros.live.scene.scene_snapshot import MAPS
from drake_geom_ros.live.scene.waiting_maps import NAMED_AS_MAPS, WaitingMaps, waiting_maps
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import LoadedScene


class Place(NamedTuple):
    """The pose of a frame whose source is replaced, and since when it holds."""

    parent: str
    X_PF: RigidTransform
    since: Since


class _Removed(NamedTuple):
    """The frames and geometries that were removed with a source."""

    frames: Sequence[FrameId]
    geometries: int


class ChangingScene(HeldScene):
    """Changes of sources, attached frames and sensed maps. RuntimeError: nothing has changed."""

    def removal(self, source: SourceId) -> Change[ChangingScene, tuple[int, int]]:
        """Return the removal of a source and all that is its: so many frames and geometries.

        That of sensed maps is refused.
        """
        self.refuse_maps(source)
        name = self.inspector.GetName(source)

        def on(graph: SceneGraph, context: SceneGraphContext | None) -> _Removed:
            inspector = inspector_of(graph, context)
            before = inspector.num_geometries()
            frames = graph.RemoveSource(context=context, source_id=source)
            return _Removed(frames, before - inspector.num_geometries())

        def then(scene: ChangingScene, removed: _Removed) -> tuple[int, int]:
            scene.forget_source(name, removed.frames)
            return len(removed.frames), removed.geometries

        return Change(on, then=then, gone=[name])

    def standing_maps(
        self, gone: Collection[str], waiting: Collection[str], margin: float = 0.0
    ) -> Change[ChangingScene, int]:
        """Return a change after which maps are ``gone`` and others are ``waiting``.

        Its result is the number of cells that were in those that are gone. With the last map its
        source goes; all other maps stay. Raises ArgumentError where the scene has a source of its
        own that is called as that of maps.
        """
        source = self.maps_source
        frames = [self.maps[name].frame for name in gone if name in self.maps]
        stay = [name for name in self.maps if name not in gone]
        new = [name for name in waiting if name not in stay]
        others = map(self.inspector.GetName, self.inspector.GetAllSourceIds())
        if source is None and new and MAPS in others:
            raise ArgumentError(NAMED_AS_MAPS)

        def on(graph: SceneGraph, context: SceneGraphContext | None) -> WaitingMaps:
            if source is not None:
                for frame in frames:
                    graph.RemoveFrame(context=context, source_id=source, frame_id=frame)
                if not stay and not new:
                    graph.RemoveSource(context=context, source_id=source)
            if not stay and not new:
                return WaitingMaps(None, {})
            return waiting_maps(graph, context, source, new, margin)

        def then(scene: ChangingScene, made: WaitingMaps) -> int:
            cells = sum(len(scene.maps[name].cells or ()) for name in gone if name in scene.maps)
            if frames:
                scene.forget_source(MAPS, frames)
            there = {name: seen_map for name, seen_map in scene.maps.items() if name in stay}
            scene.maps, scene.maps_source = {**there, **made.maps}, made.source
            return cells

        return Change(on, then=then)

    def forget_source(self, name: str, frames: Sequence[FrameId]) -> None:
        """Forget what is known of a source that has gone, and of its frames."""
        self._forget(frames)
        self.awaited.forget(name)

    def _forget(self, frames: Sequence[FrameId]) -> None:
        """Forget what is known of frames that have gone."""
        gone = [frame.get_value() for frame in frames]
        self._ages.forget(gone)
        self.feeders.forget(gone)
        if self._twists is not None:
            self._twists.forget(gone)
        self._cameras = {n: c for n, c in self._cameras.items() if c[0] not in set(frames)}

    def in_order_of_removal(self, sources: Iterable[SourceId]) -> list[SourceId]:
        """Return sources, each before those that its frames are mounted on or attached to."""
        inspector = self.inspector
        waiting, ordered = list(dict.fromkeys(sources)), list[SourceId]()
        while waiting:
            carriers = {
                inspector.GetOwningSourceId(inspector.GetParentFrame(frame))
                for source in waiting
                for frame in inspector.FramesForSource(source)
                if inspector.GetOwningSourceId(inspector.GetParentFrame(frame)) != source
            }
            free = [source for source in waiting if source not in carriers]
            ordered += free or waiting  # each hangs on the other: the scene graph refuses that
            waiting = [source for source in waiting if source not in ordered]
        return ordered

    def places_of(self, sources: Collection[SourceId]) -> dict[tuple[str, str], Place]:
        """Return where the frames of sources are, as far as they are posed and not attached."""
        places = {}
        for frame, label in self.names.labels.items():
            since = self._ages.since(frame.get_value())
            if (
                since is not None
                and self.inspector.GetOwningSourceId(frame) in sources
                and not self.inspector.IsAttached(frame)
            ):
                parent = self.inspector.GetName(self.inspector.GetParentFrame(frame))
                places[label] = Place(parent, self.query.X_PF(frame), since)
        return places

    def stay(self, places: dict[tuple[str, str], Place], loaded: LoadedScene) -> None:
        """Let frames stand where those of the same source and name did, until poses come."""
        for label, frame in loaded.frames.items():
            old = places.get(label)
            parent = self.inspector.GetName(self.inspector.GetParentFrame(frame))
            if old is not None and frame not in loaded.X_PFs and parent == old.parent:
                self._context.UpdateFramePoses(FramePoseVector({frame: old.X_PF}))
                self._ages.keep([frame.get_value()], old.since)

    def put(self, places: Mapping[tuple[str, str], RigidTransform]) -> None:
        """Have frames by source and name stand at X_PF."""
        if places:
            labels = self.names.labels.items()
            X_PFs = {frame: places[label] for frame, label in labels if label in places}
            self._context.UpdateFramePoses(FramePoseVector(X_PFs))

    def attachment(
        self,
        frame: FrameId,
        parent: FrameId,
        X_PF: RigidTransform | None,
        *,
        is_part: bool = True,
    ) -> Change[ChangingScene, RigidTransform]:
        """Return the attachment of a frame to another one, where it is or at X_PF: its X_PF.

        ``is_part``: it counts as part of what carries it in sets by name.
        """
        source = self.inspector.GetOwningSourceId(frame)
        X_now = X_PF or self._pose_in(frame, parent)

        def on(graph: SceneGraph, context: SceneGraphContext | None) -> None:
            graph.AttachFrame(
                context=context,
                source_id=source,
                frame_id=frame,
                parent_id=parent,
                X_PF=X_now,
                is_part=is_part,
            )

        def first(scene: ChangingScene) -> None:
            nonlocal X_now
            X_now = X_PF or scene._pose_in(frame, parent)

        def then(scene: ChangingScene, made: None) -> RigidTransform:
            scene._rest_at(frame, X_now)
            return X_now

        return Change(on, first, then)

    def detachment(
        self, frame: FrameId, X_PF: RigidTransform | None
    ) -> Change[ChangingScene, RigidTransform]:
        """Return the return of a frame to its home, where it is or at X_PF: its X_PF there.

        Its pose is as old as the oldest of those that led to it.
        """
        home = self.inspector.GetHomeFrame(frame)
        source = self.inspector.GetOwningSourceId(frame)
        X_now, since = X_PF or self._pose_in(frame, home), ALWAYS

        def on(graph: SceneGraph, context: SceneGraphContext | None) -> None:
            graph.DetachFrame(context=context, source_id=source, frame_id=frame, X_PF=X_now)

        def first(scene: ChangingScene) -> None:
            nonlocal X_now, since
            X_now = X_PF or scene._pose_in(frame, home)
            since = scene._since_now(None if X_PF else frame)

        def then(scene: ChangingScene, made: None) -> RigidTransform:
            scene._move_again_from(frame, X_now, since)
            return X_now

        return Change(on, first, then)

    def _pose_in(self, frame: FrameId, parent: FrameId) -> RigidTransform:
        """Return where a frame is in another one; raises ArgumentError where nobody knows."""
        self._refuse_unplaced([frame, parent], 'pose')
        return self.query.X_WF(parent).InvertAndCompose(self.query.X_WF(frame))

    def _rest_at(self, frame: FrameId, X_PF: RigidTransform) -> None:
        """Keep a frame where it hangs now, whatever has posed it before."""
        self._hang_at(frame, X_PF)
        self._ages.rest(frame.get_value())
        self._let_go(frame)

    def _move_again_from(self, frame: FrameId, X_PF: RigidTransform, since: Since) -> None:
        """Leave a frame in its home, where messages pose it from now on."""
        self._hang_at(frame, X_PF)
        self._ages.rest_no_more(frame.get_value(), since)
        # TF leaves it there until a transform of this very frame comes.
        self.feeders.note(MESSAGES, frozenset([frame.get_value()]))

    def _hang_at(self, frame: FrameId, X_PF: RigidTransform) -> None:
        """Pose a frame that hangs on another one now."""
        self._context.UpdateFramePoses(FramePoseVector({frame: X_PF}))
        self.rules.measure_again()
        if self.history is not None:
            self.history.begin_anew([frame.get_value()], self._clocks.node())

    def _since_now(self, frame: FrameId | None) -> Since:
        """Return now, or since when the pose of a frame in the world holds, if that is older."""
        since = self._clocks.arrival().since(0.0)
        return since if frame is None else oldest(since, self._since_of_line(frame))

    def _since_of_line(self, frame: FrameId) -> Since:
        """Return since when the pose of a frame in the world holds, with all that it hangs on."""
        since = ALWAYS
        while frame != self.names.world:
            own = self._ages.since(frame.get_value())
            since = oldest(since, own or ALWAYS)
            frame = self.inspector.GetParentFrame(frame)
        return since

    def _refuse_unplaced(self, frames: Iterable[FrameId], field: str) -> None:
        unplaced = [self.names.frame_names[f] for f in frames if not self.query.is_placed(f)]
        if unplaced:
            raise ArgumentError(
                f'{some_of(unplaced)} has no pose yet, so nobody knows where the frame is; pose '
                f'it first, or give `{field}` with pose_given'
            )

    def _let_go(self, frame: FrameId) -> None:
        value = frame.get_value()
        self.feeders.forget([value])
        if self._twists is not None:
            self._twists.forget([value])

    def leave_out(self, frames: Iterable[FrameId]) -> None:
        """Note that a pose came for attached frames, which is reported for a while."""
        now = self._clocks.steady()
        self._left_out.update((frame.get_value(), now) for frame in frames)

    def without_attached(
        self, poses: FramePoseVector, posed: PosedFrames
    ) -> tuple[FramePoseVector, PosedFrames]:
        """Return poses without those of attached frames."""
        attached = self.attached.intersection(*[frozenset().union(*posed)])
        if not attached:
            return poses, posed
        self.leave_out(map(FrameId, attached))
        free_poses = {f: poses.value(f) for f in poses.ids() if f.get_value() not in attached}
        rest = {frames - attached: since for frames, since in posed.items() if frames - attached}
        return FramePoseVector(free_poses), rest


def inspector_of(graph: SceneGraph, context: SceneGraphContext | None) -> SceneGraphInspector:
    """Return the inspector of a scene graph, or of a context's copy of it."""
    return graph.model_inspector() if context is None else QueryObject(context).inspector()
