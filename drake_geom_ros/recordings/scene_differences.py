"""Differences between the scene that a node published and the one of the playback."""

from __future__ import annotations

import array
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import Role, SceneGraphInspector
from drake_geom_ros.live.conversions.names import HEARTBEAT, TRACKED
from drake_geom_ros.live.conversions.shapes import fill_shape
from drake_geom_ros.recordings.recording_topics import few_of
from drake_geom_ros.recordings.tolerances import SAME

_WORLD = 'world'
_PROXIMITY = 1  # the constant PROXIMITY of Role messages
_SUBJECT = 'the scene that is played here'


class _ComparedGeometry(NamedTuple):
    """A geometry with the proximity role, as far as distances depend on it."""

    frame: str
    pose: tuple[float, ...]  # X_FG: x y z qx qy qz qw
    type: int
    dimensions: tuple[float, ...]
    vertices: int


class ComparedScene(NamedTuple):
    """Frames by full name with their parents, and the geometries with the proximity role."""

    frames: Mapping[str, str]
    geometries: Mapping[str, _ComparedGeometry]

    @property
    def names(self) -> set[str]:
        """The names of all frames and geometries."""
        return {*self.frames, *self.geometries}

    def without(self, other: ComparedScene) -> set[str]:
        """Return the names that ``other`` lacks; for a missing frame only its own name."""
        frames = self.frames.keys() - other.frames.keys()
        geometries = self.geometries.keys() - other.geometries.keys()
        return frames | {n for n in geometries if self.geometries[n].frame not in frames}

    def otherwise(self, other: ComparedScene) -> Iterator[tuple[str, str]]:
        """Yield the names that both have with differences, and the kind of the difference."""
        for name in self.frames.keys() & other.frames.keys():
            if self.frames[name] != other.frames[name]:
                yield name, 'parent'
        for name in self.geometries.keys() & other.geometries.keys():
            a, b = self.geometries[name], other.geometries[name]
            if not _is_pose(a.pose, b.pose):
                yield name, 'pose in its frame'
            sizes = a.type, a.vertices, len(a.dimensions)
            is_like = sizes == (b.type, b.vertices, len(b.dimensions))
            if not (is_like and np.allclose(a.dimensions, b.dimensions, atol=0)):
                yield name, 'shape'


def table_of_message(message: Any) -> ComparedScene:
    """Return the table of a Scene message."""
    sources = {source.id: source.name for source in message.sources}
    world = next((f.id for f in message.frames if f.id == f.parent_id), None)
    frames = {f.id: f'{sources[f.source_id]}::{f.name}' for f in message.frames if f.id != world}
    full = {**frames, world: _WORLD}
    short = {frame.id: frame.name for frame in message.frames}
    geometries = {}
    for each in message.geometries:
        if any(role.role == _PROXIMITY for role in each.roles):
            p, q = each.pose.position, each.pose.orientation
            geometries[f'{sources[each.source_id]}::{short[each.frame_id]}/{each.name}'] = _placed(
                full[each.frame_id], (p.x, p.y, p.z, q.x, q.y, q.z, q.w), each.shape
            )
    parents = {f.id: full[f.parent_id] for f in message.frames if f.id != world}
    return ComparedScene({name: parents[i] for i, name in frames.items()}, geometries)


class _PlainShape:
    """Stand-in for a Shape message, without ROS."""

    type = 0
    mesh_uri = ''

    def __init__(self) -> None:
        self.dimensions: Any = ()
        self.vertices = array.array('d')
        self.triangles: Any = ()


def table_of(inspector: SceneGraphInspector) -> ComparedScene:
    """Return the table of a scene."""
    world = inspector.world_frame_id()
    ids = [frame for frame in inspector.GetAllFrameIds() if frame != world]
    full = {world: _WORLD, **{frame: inspector.full_name(frame) for frame in ids}}
    geometries = {}
    for each in inspector.GetAllGeometryIds(Role.kProximity):
        frame, shape = inspector.GetFrameId(each), _PlainShape()
        fill_shape(shape, inspector.GetShape(each))
        pose = tuple(inspector.GetPoseInFrame(each).ToArray().tolist())
        source, name = inspector.GetOwningSourceName(each), inspector.GetName(each)
        geometries[f'{source}::{inspector.GetName(frame)}/{name}'] = _placed(
            full[frame], pose, shape
        )
    return ComparedScene({full[f]: full[inspector.GetParentFrame(f)] for f in ids}, geometries)


class SceneDifferences:
    """Collects differences between the recorded ``~/scene`` of nodes and the played scene.

    Parts of a recorded scene that the played one lacks, or has differently, count at once. Parts
    that only the played scene has count if an earlier recorded scene had them, or the last one
    lacks them, since a starting node does not yet have everything that it reads.
    """

    def __init__(self) -> None:
        self._last: dict[str, ComparedScene] = {}  # by topic
        self._seen: dict[str, set[str]] = {}
        self._differences: dict[tuple[str, str], dict[str, None]] = {}  # names by topic and kind

    def take(self, topic: str, message: Any, inspector: SceneGraphInspector) -> None:
        """Compare a recorded Scene message with the current scene."""
        recorded, played = table_of_message(message), table_of(inspector)
        if _has_trackers(played):  # bodies come and go a little sooner or later than in the node
            recorded, played = _without_bodies(recorded), _without_bodies(played)
        self._last[topic] = recorded
        self._note(topic, f'shows what {_SUBJECT} lacks', recorded.without(played))
        for name, what in sorted(recorded.otherwise(played)):
            self._note(topic, f'shows another {what} than {_SUBJECT}', [name])
        seen = self._seen.setdefault(topic, set())
        self._note(topic, _LACKS, played.without(recorded) & seen)
        seen |= recorded.names

    def in_words(self, inspector: SceneGraphInspector) -> list[str]:
        """Return texts on the differences at the end of the recording; empty for none."""
        played = table_of(inspector)
        if _has_trackers(played):
            played = _without_bodies(played)
        for topic, recorded in self._last.items():
            self._note(topic, _LACKS, played.without(recorded))
        return [
            f'{topic} {kind}: {few_of(list(names))}'
            for (topic, kind), names in self._differences.items()
        ]

    def _note(self, topic: str, kind: str, names: Any) -> None:
        if names:
            self._differences.setdefault((topic, kind), {}).update(dict.fromkeys(sorted(names)))


_LACKS = f'lacks what {_SUBJECT} has'


def _placed(frame: str, pose: tuple[float, ...], shape: Any) -> _ComparedGeometry:
    """Return a geometry of a Shape message, or of a stand-in with its fields."""
    sizes = tuple(map(float, shape.dimensions))
    return _ComparedGeometry(frame, pose, int(shape.type), sizes, len(shape.vertices))


def _has_trackers(scene: ComparedScene) -> bool:
    return f'{TRACKED}::{HEARTBEAT}' in scene.frames


def _without_bodies(scene: ComparedScene) -> ComparedScene:
    """Return a scene without the bodies of trackers."""
    prefix = f'{TRACKED}::'
    frames = {n: each for n, each in scene.frames.items() if not n.startswith(prefix)}
    geometries = {n: each for n, each in scene.geometries.items() if not n.startswith(prefix)}
    return ComparedScene(frames, geometries)


def _is_pose(first: tuple[float, ...], second: tuple[float, ...]) -> bool:
    """Return whether two poses are equal, with either sign of the quaternions."""
    a, b = np.array(first), np.array(second)
    turns = min(np.abs(a[3:] - b[3:]).max(), np.abs(a[3:] + b[3:]).max())
    scale = max(1.0, np.abs(a[:3]).max())
    return bool(np.abs(a[:3] - b[:3]).max() <= SAME * scale and turns <= SAME)
