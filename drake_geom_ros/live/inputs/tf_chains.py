"""Chains of TF: followed by names once, then multiplied, for one moment or for many at once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.live.conversions.transforms import TransformNames, names_of
from drake_geom_ros.live.inputs.tf_troubles import loop_of
from drake_geom_ros.live.scene.clocks import ALWAYS, Since, oldest, oldest_moments
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import poses_from_matrices


class Placed(NamedTuple):
    """The pose of the end of a chain in the world, and since when it holds."""

    X_WF: Floats  # (4, 4)
    since: Since


WORLD = Placed(np.eye(4), ALWAYS)


@dataclass(frozen=True)
class Levels:
    """The chains of a posing as places in a list of e + k poses in the world.

    First come e known ones: the ends of chains, then frames without TF that others are posed in.
    Behind them come k TF frames by the length of their chains.
    """

    names: TransformNames  # of the parents and the k TF frames
    parents_at: Indices  # (k,) the place of the parent of each
    parts: tuple[slice, ...]  # of the TF frames: those whose chains are equally long
    outer: tuple[FrameId, ...]  # the frames without TF
    frames_at: Indices  # (n,) the places of the frames that are posed
    in_at: Indices  # (n,) the places of what these are posed in; -1: the world


@dataclass(frozen=True)
class Posing:
    """The frames of a scene that some transforms pose, and their chains; no numbers."""

    frames: tuple[FrameId, ...]
    names: tuple[str, ...]  # the TF frame that each follows
    # What each is posed in: a TF frame, a frame of the scene without TF, or None: the world.
    parents: tuple[str | FrameId | None, ...]
    steps: tuple[tuple[str, str], ...]  # child and parent, each parent before its children
    ends: tuple[str, ...]  # where chains may end
    loops: tuple[str, ...]  # in words
    left_out: tuple[FrameId, ...]  # that are attached, and of whose transforms was heard
    unknown: frozenset[FrameId]  # that hang on a frame which waits for a pose from elsewhere

    @property
    def is_by_names(self) -> bool:
        """True if the chains do not depend on the poses of the scene."""
        return not self.unknown and not any(isinstance(p, FrameId) for p in self.parents)

    @cached_property
    def ids(self) -> Indices:
        """The values of the frames' ids (n,)."""
        return np.array([frame.get_value() for frame in self.frames], dtype=np.int64)

    @cached_property
    def together(self) -> frozenset[int]:
        """The values of all frames' ids."""
        return frozenset(self.ids.tolist())

    @cached_property
    def levels(self) -> Levels:
        """The chains, to be multiplied."""
        lengths = dict.fromkeys(self.ends, 0)
        for child, parent in self.steps:
            lengths[child] = lengths[parent] + 1
        steps = sorted(self.steps, key=lambda step: lengths[step[0]])
        counts = np.bincount(np.array([lengths[c] for c, _ in steps], dtype=np.int64))[1:]
        borders = [0, *np.cumsum(counts).tolist()]
        outer = tuple(dict.fromkeys(P for P in self.parents if isinstance(P, FrameId)))
        names = names_of(tuple((parent, child) for child, parent in steps))
        at: dict[str | FrameId | None, int] = {None: -1}
        nodes: tuple[str | FrameId, ...] = (*self.ends, *outer, *(c for c, _ in steps))
        for node in nodes:
            at[node] = len(at) - 1

        def places(nodes: Iterable[str | FrameId | None]) -> Indices:
            return np.array([at[node] for node in nodes], dtype=np.int64)

        return Levels(
            names=names,
            parents_at=places(parent for _, parent in steps),
            parts=tuple(map(slice, borders, borders[1:])),
            outer=outer,
            frames_at=places(self.names),
            in_at=places(self.parents),
        )


class PosedByRun(NamedTuple):
    """Frames that transforms pose which come again and again."""

    ids: Indices  # (n,) values of the frames' ids
    rows: Floats  # (m, n, 7) X_PF at m moments
    chains: tuple[tuple[str, ...], ...]  # of each frame the TF frames whose transforms came so
    others: tuple[Since, ...]  # and since when the rest of its chain holds


class Chains:
    """Follows chains of TF by names, to where they may end."""

    def __init__(self, parents: Mapping[str, str], ends: Collection[str]) -> None:
        self._parents = parents
        self._leads = dict.fromkeys(ends, True)
        self._steps: list[tuple[str, str]] = []
        self.loops: list[str] = []

    def lead(self, name: str) -> bool:
        """Return whether the chain of a TF frame leads to an end."""
        chain = []
        while name not in self._leads:
            self._leads[name] = False  # what is not known leads nowhere, and neither does a loop
            if name in self._parents:
                chain.append(name)
                name = self._parents[name]
        leads = self._leads[name]
        if name in chain:
            self.loops.append(loop_of(chain[chain.index(name) :]))
        self._leads |= dict.fromkeys(chain, leads)
        if leads:
            self._steps += [(child, self._parents[child]) for child in reversed(chain)]
        return leads

    def steps(self, names: Iterable[str]) -> tuple[tuple[str, str], ...]:
        """Return the steps to some TF frames, each parent before its children."""
        wanted, edges = set(names), []
        for child, parent in reversed(self._steps):
            if child in wanted:
                wanted.add(parent)
                edges.append((child, parent))
        return tuple(reversed(edges))


def hangs_on(
    name: str, changed: Collection[str], answers: dict[str, bool], parents: Mapping[str, str]
) -> bool:
    """Return whether the chain from a TF frame to the world holds a changed transform.

    ``answers`` is of which TF frames that was found; it is added to.
    """
    chain = []
    while name in parents and name not in answers:
        chain.append(name)
        if name in changed:
            answers[name] = True
            break
        name = parents[name]
    hangs = answers.get(name, False)
    answers |= dict.fromkeys(chain, hangs)
    return hangs


def parts_of(
    posing: Posing,
    ends: Mapping[str, Placed],
    since_of: Callable[[str], Since],
    coming: Collection[str],
) -> tuple[tuple[tuple[str, ...], ...], tuple[Since, ...]]:
    """Return of each frame which transforms of its chain come, and since when the rest holds."""
    parents, chains, others = dict(posing.steps), [], []
    for name in posing.names:
        chain, since = list[str](), list[Since]()
        while name in parents:
            if name in coming:
                chain.append(name)
            else:
                since.append(since_of(name))
            name = parents[name]
        chains.append(tuple(chain))
        others.append(oldest(ends[name].since, *since))
    return tuple(chains), tuple(others)


def placed(levels: Levels, X_WEs: Floats, X_PCs: Floats) -> Floats:
    """Return the poses X_WF (..., e + k, 4, 4) of all places.

    ``X_WEs`` (e, 4, 4) are those that are known, ``X_PCs`` (..., k, 4, 4) the transforms of the TF
    frames, at many moments or now.
    """
    ends = len(X_WEs)
    X_WFs = np.empty((*X_PCs.shape[:-3], ends + X_PCs.shape[-3], 4, 4))
    X_WFs[..., :ends, :, :] = X_WEs
    for part in levels.parts:
        X_WPs = X_WFs[..., levels.parents_at[part], :, :]
        here = slice(ends + part.start, ends + part.stop)
        X_WFs[..., here, :, :] = X_WPs @ X_PCs[..., part, :, :]
    return X_WFs


def poses_in(levels: Levels, X_WFs: Floats) -> Floats:
    """Return X_PF (..., n, 7) of the frames that are posed, in their parents."""
    X_PFs = X_WFs[..., levels.frames_at, :, :]
    is_nested = levels.in_at >= 0
    if is_nested.any():
        X_WPs = X_WFs[..., levels.in_at[is_nested], :, :]
        X_PFs[..., is_nested, :, :] = _in_parent(X_PFs[..., is_nested, :, :], X_WPs)
    flat = X_PFs.reshape(-1, 4, 4)
    rows = poses_from_matrices(flat[:, :3, :3], flat[:, :3, 3])
    return rows.reshape(*X_PFs.shape[:-2], 7)


def _in_parent(X_WF: Floats, X_WP: Floats) -> Floats:
    R_PW = np.swapaxes(X_WP[..., :3, :3], -1, -2)
    R_PF = R_PW @ X_WF[..., :3, :3]
    p_PF = R_PW @ (X_WF[..., :3, 3:] - X_WP[..., :3, 3:])
    X_PF = np.zeros((*R_PF.shape[:-2], 4, 4))
    X_PF[..., :3, :3], X_PF[..., :3, 3:], X_PF[..., 3, 3] = R_PF, p_PF, 1.0
    return X_PF


def held_since(levels: Levels, of_ends: Floats, of_transforms: Floats) -> Floats:
    """Return since when (n, 4) frames are where they are: as the oldest moment of the chain.

    Moments are rows as of ``tf_table``: (e, 4) of what is known, (k, 4) of the transforms.
    """
    moments = np.concatenate((of_ends, of_transforms))
    for part in levels.parts:
        here = slice(len(of_ends) + part.start, len(of_ends) + part.stop)
        moments[here] = oldest_moments(moments[levels.parents_at[part]], moments[here])
    return moments[levels.frames_at]


def groups_of(posing: Posing, moments: Floats) -> dict[frozenset[int], Since]:
    """Return since when frames are where they are, by those that are since the same moment."""
    if (moments == moments[0]).all():
        return {posing.together: Since(*moments[0].tolist())}
    different, which = np.unique(moments, axis=0, return_inverse=True)
    order, borders = np.argsort(which.ravel(), kind='stable'), np.bincount(which.ravel())
    groups = np.split(posing.ids[order], np.cumsum(borders)[:-1])
    pairs = zip(groups, different.tolist(), strict=True)
    return {frozenset(group.tolist()): Since(*moment) for group, moment in pairs}
