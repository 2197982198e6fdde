"""The transforms of TF of the last seconds.

Kept are those of chains that pose frames of the scene, and those that somebody asked about.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from drake_geom_ros.geometry import ArgumentError, FrameId
from drake_geom_ros.live.inputs.tf_table import Edge
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.pose_history import PoseThen, Then, between
from drake_geom_ros.live.scene.tracks import Bracket, Track, UnknownThenError
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import poses_from_matrices


class Chain(NamedTuple):
    """The transforms that lead from a frame of the scene to another one, or to the world."""

    children: tuple[str, ...]
    end: FrameId


class TfPast:
    """Keeps moving transforms by the name of their child: the parts of poses by TF."""

    def __init__(self, edge: Callable[[str], Edge | None]) -> None:
        """``edge(child)`` is the newest transform of a TF frame; None: there is none."""
        self._edge = edge
        self._watched: dict[str, Track[Floats]] = {}
        self._parents: dict[str, str] = {}
        self._chains: dict[int, Chain] = {}

    @property
    def is_watching(self) -> bool:
        """True if any transforms are kept."""
        return bool(self._watched)

    def note(self, child: str) -> None:
        """Keep the newest transform of a TF frame, if it was asked about before."""
        edge = self._edge(child) if child in self._watched else None
        if edge is not None:
            if self._parents.get(child, edge.parent) != edge.parent:
                self._watched[child] = Track()  # what was is that of another parent
            self._parents[child] = edge.parent
            (row,) = poses_from_matrices([edge.R_PC], [edge.p_PC])
            self._watched[child].note(row, edge.since)

    def forget(self) -> None:
        """Forget what was, for time has gone back; what is watched stays watched."""
        self._watched = {child: Track() for child in self._watched}

    def follow(self, frame: int, chain: Chain) -> None:
        """Keep what poses a frame (value of its id) from now on."""
        if self._chains.get(frame) == chain:
            return
        self._chains[frame] = chain
        for child in chain.children:
            edge = self._edge(child)
            if child not in self._watched and edge is not None and edge.since != ALWAYS:
                self._watched[child] = Track()
                self.note(child)

    def at(self, child: str, held: float) -> RigidTransform | str:
        """Return X_PC at a time [s], or the name of the child where it is not known yet.

        Raises ArgumentError where it will never be.
        """
        track = self._watched.setdefault(child, Track())
        try:
            return RigidTransform.FromArray(_row(track.around(held)))
        except UnknownThenError as unknown:
            if unknown.is_later or track.around(held).before is None:
                return child
        raise ArgumentError(f'of the time of the stamp TF tells no transform of {child[:80]!r}')

    def around(self, time: float) -> PoseThen:
        """Return the poses at a time [s] of frames that TF poses."""
        chains = dict(self._chains)
        steps = {
            child: self._step(child, time)
            for child in {child for chain in chains.values() for child in chain.children}
        }

        def pose(frame: int, then: Then) -> Floats:
            chain = chains[frame]
            X_EF = RigidTransform()
            for child in chain.children:
                step = steps[child]
                if isinstance(step, Bracket):
                    step = RigidTransform.FromArray(_row(step))
                X_EF = step @ X_EF
            X_WF = then.X_WF(chain.end) @ X_EF
            parent = then.inspector.GetParentFrame(FrameId(frame))
            return then.X_WF(parent).InvertAndCompose(X_WF).ToArray()

        return pose

    def _step(self, child: str, time: float) -> RigidTransform | Bracket[Floats]:
        """Return a transform that holds for good, or what is known of one that moves."""
        edge = self._edge(child)
        if edge is not None and edge.since == ALWAYS:
            return RigidTransform(RotationMatrix(edge.R_PC), edge.p_PC)
        track = self._watched.get(child)
        return Bracket(time, None, None) if track is None else track.around(time)


def _row(bracket: Bracket[Floats]) -> Floats:
    first, last, share = bracket.between()
    return first if not share else between(first, last, share)
