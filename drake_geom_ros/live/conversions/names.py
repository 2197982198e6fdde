"""Names of the ROS surface: what `source::frame/geometry` and `#<id>` stand for.

The table is made from an inspector.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import islice
from types import MappingProxyType
from typing import NamedTuple, TypeVar

from drake_geom_ros.common.counting import plural
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import (
    FrameId,
    GeometryError,
    GeometryId,
    SceneGraphInspector,
    SourceId,
)
from drake_geom_ros.live.conversions.message_types import GeometrySetMessage
from drake_geom_ros.scene_files.drake_names import drake_name

WORLD = 'world'
MAPS = 'obstacles'  # the source of sensed maps
TRACKED = 'tracked'  # the source of bodies that trackers see
HEARTBEAT = 'heartbeat'  # its frame that is no body: how long ago the trackers spoke
_LONGEST = 80  # letters of a name that are shown
_MOST_HINTS = 64  # that are kept
_MOST_LOOKED_AT = 5000  # names that are compared with one of them, some 10 us each
_ID = re.compile('#[0-9]{1,20}')  # uint64 has no more digits
_Id = TypeVar('_Id', FrameId, GeometryId)


class UnknownNameError(GeometryError):
    """A name or an id that the scene does not hold, or that several things bear."""


def some_of(names: Sequence[object], most: int = 5) -> str:
    """Return the first names with commas, and dots where there are more, or a name is long."""
    return ', '.join(shortened(str(n)) for n in names[:most]) + (
        ' ...' if len(names) > most else ''
    )


def shortened(name: str) -> str:
    """Return a name as messages show it: a name may have a million letters."""
    return name if len(name) <= _LONGEST else f'{name[: _LONGEST - 3]}...'


class SetMembers(NamedTuple):
    """The members of a GeometrySet message."""

    frames: list[FrameId]
    geometries: list[GeometryId]
    num_geometries: int  # with those on the frames


class NameTable:
    """Sources, frames and geometries of one version of a scene by name."""

    def __init__(
        self,
        inspector: SceneGraphInspector,
        world_frame: str = WORLD,
        prefixes: Mapping[str, str] = MappingProxyType({}),
        maps: SourceId | None = None,
    ) -> None:
        """``world_frame`` is what the world is called in answers; ``world`` means it too.

        ``prefixes`` are what TF puts before the names of a source's frames, where it does. Frames
        of the source ``maps`` of sensed maps have no names but full ones, and none that TF has:
        what sensors see moves by no transform.
        """
        self._prefixes = prefixes
        self._sources = {inspector.GetName(s): s for s in inspector.GetAllSourceIds()}
        self._frames: dict[str, list[FrameId]] = defaultdict(list)
        # Names may hold `::` and `/`: they are compared as pairs or whole, and never split.
        self.labels: dict[FrameId, tuple[str, str]] = {}  # source and name, not of the world
        self.of_maps: set[FrameId] = set()
        self._owners: dict[FrameId | GeometryId, str] = {}
        self._called: dict[str, list[FrameId]] = defaultdict(list)
        self._geometries: dict[str, list[GeometryId]] = defaultdict(list)
        self._num_on: Counter[FrameId] = Counter()  # geometries on each frame
        self.frame_names: dict[FrameId, str] = {}
        self.geometry_names: dict[GeometryId, str] = {}
        world = inspector.world_frame_id()
        self._world_names = {WORLD, world_frame}
        self.frame_names[world] = world_frame
        short = {world: WORLD}
        self.world = world
        for frame in inspector.GetAllFrameIds():
            if frame == world:
                continue
            name = inspector.GetName(frame)
            source = inspector.GetOwningSourceName(frame)
            full = f'{source}::{name}'
            self.labels[frame] = source, name
            self._owners[frame] = source
            short[frame] = name
            self.frame_names[frame] = full
            if maps is not None and inspector.GetOwningSourceId(frame) == maps:
                self.of_maps.add(frame)
                self._frames[full].append(frame)
                continue
            self._called[name].append(frame)
            for alias in {name, full}:
                self._frames[alias].append(frame)
        for geometry in inspector.GetAllGeometryIds():
            name = inspector.GetName(geometry)
            source, frame = inspector.GetOwningSourceName(geometry), inspector.GetFrameId(geometry)
            self._owners[geometry] = source
            self._num_on[frame] += 1
            self.geometry_names[geometry] = f'{source}::{short[frame]}/{name}'
            frames = self._world_names if frame == world else {short[frame]}
            aliases = {f'{called}/{name}' for called in frames}
            for key in aliases | {f'{source}::{alias}' for alias in aliases}:
                self._geometries[key].append(geometry)
        self._add_drake_names(inspector)
        self.has_heartbeat = (TRACKED, HEARTBEAT) in self.labels.values()
        self.frame_values = tuple(frame.get_value() for frame in self.labels)  # of ids
        self._hints: dict[tuple[str, str], str] = {}
        self._known_frames: dict[int | None, FrameId] = {
            f.get_value(): f for f in self.frame_names
        }
        self._known_geometries: dict[int | None, GeometryId] = {
            g.get_value(): g for g in self.geometry_names
        }

    def _add_drake_names(self, inspector: SceneGraphInspector) -> None:
        """Let Drake's names of geometries stand for them where no own name is equal."""
        more: dict[str, list[GeometryId]] = defaultdict(list)
        for geometry, full in self.geometry_names.items():
            if name := drake_name(inspector.GetProximityProperties(geometry)):
                own = inspector.GetName(geometry)
                alias = f'{full.removesuffix(own)}{name}'
                for key in (alias, alias.removeprefix(f'{self._owners[geometry]}::')):
                    more[key].append(geometry)
        for key, geometries in more.items():
            if key not in self._geometries:
                self._geometries[key] = geometries

    def source(self, name: str) -> SourceId:
        """Return the source of that name or ``#<id>``.

        Raises UnknownNameError for what stands for nothing, or for two sources.
        """
        by_value = {s.get_value(): s for s in self._sources.values()}
        named, by_id = self._sources.get(name), by_value.get(_value(name) or -1)
        if named is not None and by_id not in (None, named):
            other = next(text for text, source in self._sources.items() if source == by_id)
            raise UnknownNameError(
                f'{name!r} is the name of a source (#{named.get_value()}) and the id of another, '
                f'{other!r}: name them by {other!r} and #{named.get_value()}.'
            )
        if (meant := named or by_id) is not None:
            return meant
        raise UnknownNameError(
            f'There is no source {name[:80]!r}{nearest(name, self._sources)}. Sources: '
            f'{_some(self._sources)}. '
            'See register_source and the topic ~/scene.'
        )

    def frame(self, name: str, source: str = '') -> FrameId:
        """Return the frame of that name, looked for in ``source`` alone when that is given.

        The world's name stands for the world; a frame that bears it too needs its source's name.
        Raises UnknownNameError for what stands for nothing, or for several frames.
        """
        candidates = list(self._frames.get(name, ()))
        if name in self._world_names:
            candidates = [f for f in candidates if self.frame_names[f] == name] + [self.world]
        elif (
            by_id := self._known_frames.get(_value(name))
        ) is not None and by_id not in candidates:
            candidates.append(by_id)
        if source and self.world not in candidates:
            own = [f for f in candidates if self.labels[f][0] == source]
            meant = [
                f for f in candidates if name == self.frame_names[f] or _value(name) is not None
            ]
            if meant and not own:
                raise UnknownNameError(
                    f"frame '{shortened(self.frame_names[meant[0]])}' does not belong to source "
                    f"'{shortened(source)}'"
                )
            candidates = own
        if len(candidates) == 1:
            return candidates[0]
        key = f'{source}::{name}' if source and _value(name) is None else name
        raise UnknownNameError(self._problem('frame', key, candidates, self.frame_names))

    def frames_called(self, name: str) -> list[FrameId]:
        """Return all frames of that name, which is without the source's."""
        return list(self._called.get(name, ()))

    @cached_property
    def tf_claims(self) -> dict[str, list[FrameId]]:
        """The frames that each TF name, ``source/frame`` or ``frame``, may stand for."""
        claims: dict[str, list[FrameId]] = defaultdict(list)
        for frame in self.labels:
            for name in self.tf_names(frame):
                claims[name].append(frame)
        return dict(claims)

    def tf_names(self, frame: FrameId) -> tuple[str, ...]:
        """Return what TF may call a frame, the name that counts more first.

        None of a map or of a tracked body: their messages alone pose them.
        """
        source, name = self.labels[frame]
        if frame in self.of_maps or (source == TRACKED and self.has_heartbeat):
            return ()
        if prefix := self._prefixes.get(source):
            return (f'{prefix}{name}'.removeprefix('/'),)
        return (f'{source}/{name}', name)

    def geometry(self, name: str) -> GeometryId:
        """Return the geometry of that name or ``#<id>``."""
        candidates = list(self._geometries.get(name, ()))
        by_id = self._known_geometries.get(_value(name))
        if by_id is not None and by_id not in candidates:
            candidates.append(by_id)
        if len(candidates) == 1:
            return candidates[0]
        raise UnknownNameError(self._problem('geometry', name, candidates, self.geometry_names))

    def frame_of_value(self, value: int) -> FrameId:
        """Return the frame with that id."""
        if value in self._known_frames:
            return self._known_frames[value]
        raise UnknownNameError(self._problem('frame', f'#{value}', [], self.frame_names))

    def geometry_of_value(self, value: int) -> GeometryId:
        """Return the geometry with that id."""
        if value in self._known_geometries:
            return self._known_geometries[value]
        raise UnknownNameError(self._problem('geometry', f'#{value}', [], self.geometry_names))

    def members(self, geometry_set: GeometrySetMessage) -> SetMembers:
        """Return what a GeometrySet message names, by name and by id."""
        frames = [self.frame(name) for name in geometry_set.frames]
        frames += [self.frame_of_value(value) for value in geometry_set.frame_ids]
        geometries = [self.geometry(name) for name in geometry_set.geometries]
        geometries += [self.geometry_of_value(value) for value in geometry_set.geometry_ids]
        on_frames = sum([self._num_on[frame] for frame in frames])
        return SetMembers(frames, geometries, len(geometries) + on_frames)

    def name_of_value(self, value: int) -> str:
        """Return the name of the geometry with that id; empty for 0, which names none."""
        return self.geometry_names[self.geometry_of_value(value)] if value else ''

    def _problem(
        self, kind: str, name: str, candidates: Sequence[_Id], names: Mapping[_Id, str]
    ) -> str:
        shown = shortened(name)
        if candidates:
            # Names may be the same, of other sources: `b::c` of `a`, and `c` of `a::b`.
            whole = [names[i] for i in candidates]
            ids = ', '.join(
                f"'{n}'{self._of(i) if whole.count(n) > 1 else ''} (#{i.get_value()})"
                for i, n in zip(candidates, whole, strict=True)
            )
            return (
                f'{len(candidates)} {plural(kind)} share the name {shown!r}: {ids}. '
                'Add the source, as in `source::name`, or give `#<id>`.'
            )
        # A stream may name the same thing again and again, and to look for what is like it takes
        # a while; what is like a name too long to be shown is no help.
        key = (kind, shown)
        if key not in self._hints:
            if len(self._hints) >= _MOST_HINTS:
                self._hints.clear()
            self._hints[key] = self._hint(kind, name) if shown == name else ''
        return (
            f'There is no {kind} {shown!r} in the scene{self._hints[key]}. It holds '
            f'{len(names)}: {_some(names.values())}. See the topic ~/scene.'
        )

    def _of(self, id: FrameId | GeometryId) -> str:
        """Return in words whose a frame or a geometry is."""
        return ', the world' if id == self.world else f" of source '{self._owners[id]}'"

    def _hint(self, kind: str, name: str) -> str:
        """Return what else a name stands for, or which names are like it."""
        if kind == 'frame' and name in self._geometries:
            return '; that is a geometry'
        if kind == 'geometry' and (name in self._frames or name in self._world_names):
            on_it = [n for n in self._geometries if n.rpartition('/')[0] == name]
            return f'; that is a frame, and on it there is {_some(on_it)}'
        names = self._frames if kind == 'frame' else self._geometries
        return nearest(name, islice(names, _MOST_LOOKED_AT))


def _value(name: str) -> int | None:
    """Return the id that ``#<id>`` stands for; None for what is a name."""
    return int(name[1:]) if _ID.fullmatch(name) else None


def _some(all_names: Iterable[str], count: int = 4) -> str:
    names = list(all_names)
    more = f' and {len(names) - count} more' if len(names) > count else ''
    return (', '.join(f"'{n}'" for n in names[:count]) or 'none') + more
