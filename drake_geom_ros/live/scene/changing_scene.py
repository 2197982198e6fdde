"""The live scene while it is held: sources that go, frames that follow others."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    FramePoseVector,
    SceneGraph,
    SceneGraphContext,
    SourceId,
)
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.clocks import ALWAYS, Since, oldest
from drake_geom_ros.live.scene.feeders import MESSAGES
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.pose_ages import PosedFrames
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import LoadedScene, SceneDescription, warm_up


class _Kept(NamedTuple):
    """The pose of a frame whose source is replaced, and since when it holds."""

    parent: str
    X_PF: RigidTransform
    since: Since


class ChangingScene(HeldScene):
    """Removes sources, attaches frames. A method that raises RuntimeError changed nothing."""

    def remove_source(self, source: SourceId) -> tuple[int, int]:
        """Remove a source and all that is its; return frames, geometries removed.

        That of sensed maps is refused.
        """
        self.refuse_maps(source)
        return self._remove(source)

    def remove_maps(self, names: Iterable[str]) -> None:
        """Remove sensed maps; with the last one their source goes, and all others stay."""
        gone = [name for name in self.maps if name in set(names)]
        if len(gone) == len(self.maps) and self.maps_source is not None:
            self._remove(self.maps_source)
            return
        for name in gone:
            frame = self.maps.pop(name).frame
            self._scene_graph.RemoveFrame(self.inspector.GetOwningSourceId(frame), frame)
            self._forget([frame])

    def _remove(self, source: SourceId) -> tuple[int, int]:
        name, geometries = self.inspector.GetName(source), self.inspector.num_geometries()
        frames = self._scene_graph.RemoveSource(source)
        self.forget_source(source, name, frames)
        return len(frames), geometries - self.inspector.num_geometries()

    def forget_source(self, source: SourceId, name: str, frames: Sequence[FrameId]) -> None:
        """Forget what is known of a source that has gone, and of its frames."""
        self._forget(frames)
        self.awaited.forget(name)
        self._robots = [robot for robot in self._robots if robot.name != name]
        if source == self.maps_source:
            self.maps, self.maps_source = {}, None

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

    def make_room(
        self, sources: Sequence[SourceId], description: SceneDescription
    ) -> dict[tuple[str, str], _Kept]:
        """Remove sources for what is described to take their place; return what they leave.

        Raises RuntimeError where what is described could not be registered then.
        """
        rehearse_swap(SceneGraph(), self._scene_graph.CreateDefaultContext(), sources, description)
        places = {}
        for frame, label in self.names.labels.items():
            since = self._ages.since(frame.get_value())
            if (
                since is not None
                and self.inspector.GetOwningSourceId(frame) in sources
                and not self.inspector.IsAttached(frame)
            ):
                parent = self.inspector.GetName(self.inspector.GetParentFrame(frame))
                places[label] = _Kept(parent, self.query.X_PF(frame), since)
        for source in sources:
            self.remove_source(source)
        return places

    def stay(self, places: dict[tuple[str, str], _Kept], loaded: LoadedScene) -> None:
        """Let frames stand where those of the same source and name did, until poses come."""
        for label, frame in loaded.frames.items():
            old = places.get(label)
            parent = self.inspector.GetName(self.inspector.GetParentFrame(frame))
            if old is not None and frame not in loaded.X_PFs and parent == old.parent:
                self._context.UpdateFramePoses(FramePoseVector({frame: old.X_PF}))
                self._ages.keep([frame.get_value()], old.since)

    def attach(
        self,
        frame: FrameId,
        parent: FrameId,
        X_PF: RigidTransform | None,
        *,
        is_part: bool = True,
    ) -> RigidTransform:
        """Let a frame follow another one, where it is now or at X_PF; return X_PF.

        ``is_part``: it counts as part of what carries it in sets by name.
        """
        if X_PF is None:
            self._refuse_unplaced([frame, parent], 'pose')
            X_PF = self.query.X_WF(parent).InvertAndCompose(self.query.X_WF(frame))
        source = self.inspector.GetOwningSourceId(frame)
        self._scene_graph.AttachFrame(source, frame, parent, X_PF, is_part)
        self._context.UpdateFramePoses(FramePoseVector({frame: X_PF}))
        self.rules.measure_again()
        self._hang_elsewhere(frame)
        self._ages.rest(frame.get_value())
        self._let_go(frame)
        return X_PF

    def detach(self, frame: FrameId, X_PF: RigidTransform | None) -> RigidTransform:
        """Put a frame back, where it is now or at X_PF in its home; return X_PF.

        Its pose is as old as the oldest of those that led to it.
        """
        home = self.inspector.GetHomeFrame(frame)
        since = self._clocks.arrival().since(0.0)
        if X_PF is None:
            self._refuse_unplaced([frame, home], 'pose')
            X_PF = self.query.X_WF(home).InvertAndCompose(self.query.X_WF(frame))
            since = oldest(since, self._since_of_line(frame))
        self._scene_graph.DetachFrame(self.inspector.GetOwningSourceId(frame), frame, X_PF)
        self._context.UpdateFramePoses(FramePoseVector({frame: X_PF}))
        self.rules.measure_again()
        self._hang_elsewhere(frame)
        self._ages.rest_no_more(frame.get_value(), since)
        # TF leaves it there until a transform of this very frame comes.
        self.feeders.note(MESSAGES, frozenset([frame.get_value()]))
        return X_PF

    def _hang_elsewhere(self, frame: FrameId) -> None:
        if self.history is not None:
            self.history.begin_anew([frame.get_value()], self._clocks.node())

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


def rehearse_swap(
    graph: SceneGraph,
    context: SceneGraphContext,
    sources: Iterable[SourceId],
    description: SceneDescription,
) -> None:
    """Remove sources and register what is described in a context alone."""
    for source in sources:
        graph.RemoveSource(context, source)
    warm_up(graph, description, context)
