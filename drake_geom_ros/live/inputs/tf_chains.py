"""Chains of TF: followed by names once, then multiplied, for one moment or for many at once."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.live.inputs.tf_edges import Edge
from drake_geom_ros.live.inputs.tf_troubles import loop_of
from drake_geom_ros.live.scene.clocks import ALWAYS, Since, oldest
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import poses_from_matrices


class Placed(NamedTuple):
    """The pose of the end of a chain in the world, and since when it holds."""

    X_WF: Floats  # (4, 4)
    since: Since


WORLD = Placed(np.eye(4), ALWAYS)


@dataclass(frozen=True)
class Posing:
    """The frames of a scene that some transforms pose, and their chains; no numbers."""

    frames: tuple[FrameId, ...]
    names: tuple[str, ...]  # the TF frame that each follows
    # What each is posed in: a TF frame, a frame of the scene without TF, or None: the world.
    parents: tuple[str | FrameId | None, ...]
    steps: tuple[tuple[str, str], ...]  # child and parent, each parent before its children
    loops: tuple[str, ...]  # in words
    left_out: tuple[FrameId, ...]  # that are attached, and of whose transforms was heard
    unknown: frozenset[FrameId]  # that hang on a frame which waits for a pose from elsewhere

    @property
    def is_by_names(self) -> bool:
        """True if the chains do not depend on the poses of the scene."""
        return not self.unknown and not any(isinstance(p, FrameId) for p in self.parents)

    @cached_property
    def ids(self) -> NDArray[np.int64]:
        """The values of the frames' ids (n,)."""
        return np.array([frame.get_value() for frame in self.frames], dtype=np.int64)


class PosedByRun(NamedTuple):
    """Frames that transforms pose which come again and again."""

    ids: NDArray[np.int64]  # (n,) values of the frames' ids
    rows: Floats  # (m, n, 7) X_PF at m moments
    chains: tuple[tuple[str, ...], ...]  # of each frame the TF frames whose transforms came so
    others: tuple[Since, ...]  # and since when the rest of its chain holds


class Chains:
    """Follows chains of TF by names, to where they may end."""

    def __init__(self, edges: Mapping[str, Edge], ends: Collection[str]) -> None:
        self._edges = edges
        self._leads = dict.fromkeys(ends, True)
        self._steps: list[tuple[str, str]] = []
        self.loops: list[str] = []

    def lead(self, name: str) -> bool:
        """Return whether the chain of a TF frame leads to an end."""
        chain = []
        while name not in self._leads:
            self._leads[name] = False  # what is not known leads nowhere, and neither does a loop
            if name in self._edges:
                chain.append(name)
                name = self._edges[name].parent
        leads = self._leads[name]
        if name in chain:
            self.loops.append(loop_of(chain[chain.index(name) :]))
        self._leads |= dict.fromkeys(chain, leads)
        if leads:
            self._steps += [(child, self._edges[child].parent) for child in reversed(chain)]
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
    name: str, changed: Collection[str], answers: dict[str, bool], edges: Mapping[str, Edge]
) -> bool:
    """Return whether the chain from a TF frame to the world holds a changed transform.

    ``answers`` is of which TF frames that was found; it is added to.
    """
    chain = []
    while name in edges and name not in answers:
        chain.append(name)
        if name in changed:
            answers[name] = True
            break
        name = edges[name].parent
    hangs = answers.get(name, False)
    answers |= dict.fromkeys(chain, hangs)
    return hangs


def parts_of(
    posing: Posing,
    ends: Mapping[str, Placed],
    edges: Mapping[str, Edge],
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
                since.append(edges[name].since)
            name = parents[name]
        chains.append(tuple(chain))
        others.append(oldest(ends[name].since, *since))
    return tuple(chains), tuple(others)


def placed(
    steps: Iterable[tuple[str, str]], ends: Mapping[str, Placed], X_PCs: Mapping[str, Floats]
) -> dict[str, Floats]:
    """Return X_WF of TF frames, (4, 4), or (m, 4, 4) where a transform of the chain is that."""
    X_WFs = {name: end.X_WF for name, end in ends.items()}
    for child, parent in steps:
        X_WFs[child] = X_WFs[parent] @ X_PCs[child]
    return X_WFs


def poses_in(X_WFs: Sequence[Floats], X_WPs: Sequence[Floats | None]) -> Floats:
    """Return X_PF (n, 7) or (m, n, 7) of frames, in their parents; None: in the world."""
    X_PFs = [
        X_WF if X_WP is None else _in_parent(X_WF, X_WP)
        for X_WF, X_WP in zip(X_WFs, X_WPs, strict=True)
    ]
    moments = max((X_PF.shape[:-2] for X_PF in X_PFs), key=len)
    every = np.empty((*moments, len(X_PFs), 4, 4))
    for k, X_PF in enumerate(X_PFs):
        every[..., k, :, :] = X_PF
    flat = every.reshape(-1, 4, 4)
    rows = poses_from_matrices(flat[:, :3, :3], flat[:, :3, 3])
    return rows.reshape(*moments, len(X_PFs), 7)


def _in_parent(X_WF: Floats, X_WP: Floats) -> Floats:
    R_PW = np.swapaxes(X_WP[..., :3, :3], -1, -2)
    R_PF = R_PW @ X_WF[..., :3, :3]
    p_PF = R_PW @ (X_WF[..., :3, 3:] - X_WP[..., :3, 3:])
    X_PF = np.zeros((*R_PF.shape[:-2], 4, 4))
    X_PF[..., :3, :3], X_PF[..., :3, 3:], X_PF[..., 3, 3] = R_PF, p_PF, 1.0
    return X_PF


def held_since(
    steps: Iterable[tuple[str, str]], ends: Mapping[str, Placed], edges: Mapping[str, Edge]
) -> dict[str, Since]:
    """Return since when TF frames are where they are: as the oldest transform of the chain."""
    sinces = {name: end.since for name, end in ends.items()}
    for child, parent in steps:
        sinces[child] = oldest(sinces[parent], edges[child].since)
    return sinces
