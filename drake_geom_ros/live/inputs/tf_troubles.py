"""Faults of the tree of TF for the frames of a scene, in words."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.geometry import FrameId
from drake_geom_ros.live.conversions.names import NameTable, some_of

_BY_TURNS = 1.0  # [s] who goes back to a parent that soon has two, and is not handed over
_REMEMBERED = 5.0  # [s] for which two parents are told after they were seen
SHOWN = 5  # names in a sentence, and sentences of a kind


class Claims:
    """TF frames that have two parents by turns; to change the parent once is no fault."""

    def __init__(self) -> None:
        # The former parent, and when [s] it was left.
        self._left: dict[str, tuple[str, float]] = {}
        # What is wrong, and since when [s].
        self._claims: dict[str, tuple[str, float]] = {}

    def notice(self, child: str, parent: str, previous_parent: str, now: float) -> None:
        """Notice a transform of a frame whose ``previous_parent`` parent is another one."""
        former, left = self._left.get(child, ('', -math.inf))
        if former == parent and now - left < _BY_TURNS:
            both = ' and '.join(repr(name[:80]) for name in sorted((previous_parent, parent)))
            text = f'the TF frame {child[:80]!r} has two parents in turn: {both}. Stop one sender'
            self._claims[child] = text, now
        self._left[child] = previous_parent, now

    def told(self, now: float) -> list[str]:
        """Return what is wrong now."""
        claims = [text for text, heard in self._claims.values() if now - heard < _REMEMBERED]
        return claims[:SHOWN]


def loop_of(names: Iterable[str]) -> str:
    """Return in words that a chain leads back to where it began."""
    loop = ', '.join(sorted(repr(name[:80]) for name in list(names)[:SHOWN]))
    return f'these TF frames form a loop: {loop}'


def unlinked(
    parents: Mapping[str, str],
    followed: Iterable[tuple[FrameId, tuple[str, ...]]],
    good: Sequence[str],
) -> list[str]:
    """Return in words which frames come by TF whose chain ends where nobody knows it to be.

    ``parents`` are those that TF has, by child.
    ``followed`` are the frames of the scene with the TF names that each answers to, ``good`` are
    the TF frames that chains may end in, the world frame first.
    """
    ends: dict[str, str] = dict.fromkeys(good, '')
    lost: dict[str, list[str]] = defaultdict(list)
    for _, names in followed:
        name = next((n for n in names if n in parents), None)
        if name is not None and (end := _end(name, parents, ends)):
            lost[end].append(repr(name[:80]))
    return [
        f'{counted(len(names), "frame")} from TF cannot be posed: {some_of(names, SHOWN)}; the '
        f'chain ends in {end[:80]!r}. Publish the transform from the world frame {good[0]!r} '
        f'to {end[:80]!r}, or let {end[:80]!r} be the world frame: world_frame:={end[:80]} of a '
        f'node, --world-frame {end[:80]} of a report'
        for end, names in list(lost.items())[:SHOWN]
    ]


def _end(name: str, parents: Mapping[str, str], ends: dict[str, str]) -> str:
    """Return where the chain of a TF frame ends; empty for the world, and for a loop."""
    chain = []
    while name not in ends:
        ends[name] = ''  # of a loop, which is told elsewhere
        chain.append(name)
        if name not in parents:
            ends[name] = name
            break
        name = parents[name]
    ends |= dict.fromkeys(chain, ends[name])
    return ends[name]


def shared(children: Collection[str], names: NameTable) -> list[str]:
    """Return in words which TF names are borne by frames of several sources.

    Nobody follows such a name, unless TF has the name with the source too.
    """
    names_by_sources: dict[tuple[str, ...], list[str]] = defaultdict(list)
    unclear = []
    for name in children:
        labels = [names.labels[f] for f in names.tf_claims.get(name, ())]
        if len(labels) < 2:
            continue
        if any(label[1] != name for label in labels):  # source `a/b`, frame `c`: also a, b/c
            both = ' and '.join(repr(f'{source}::{short}'[:80]) for source, short in labels)
            unclear.append(
                f'the TF frame {name[:80]!r} is not followed: it stands for {both}. Rename one'
            )
        elif not any(f'{source}/{name}' in children for source, _ in labels):
            names_by_sources[tuple(source for source, _ in labels)].append(name[:80])
    return unclear[:SHOWN] + [
        f'{counted(len(shorts), "TF frame")} {are(len(shorts))} not followed: '
        f'{some_of([repr(n) for n in shorts], SHOWN)}; '
        f'frames of the sources {" and ".join(map(repr, sources))} have these names. If this '
        "is one robot twice, start the node with robot_description_topic:='' or remove it from "
        f'the scene file; if they are different robots, send TF as {f"{sources[0]}/{shorts[0]}"!r}'
        for sources, shorts in list(names_by_sources.items())[:SHOWN]
    ]
