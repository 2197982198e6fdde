"""Derivatives of distances by joint values, by the chain rule from frames to joints."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.joints import Arm
from drake_geom_ros.geometry.queries.joint_trees import JointKind, JointTree
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import matrices_from_poses


class _PosedLinks(NamedTuple):
    """Poses of all links of an arm in the world, for each state."""

    R_WLs: Floats  # (N, m + 1, 3, 3)
    p_WLs: Floats  # (N, m + 1, 3) [m]


class _Carriers(NamedTuple):
    """The moved frame L that carries each frame (nf,), or is that frame, and X_LF.

    L is a place in ``scene.moved``, or -1 for a frame that no state moves; then L is the world.
    """

    places: Indices
    R_LFs: Floats
    p_LFs: Floats


def joint_gradients(
    scene: PackedScene,
    arms: tuple[Arm, ...],
    states: Floats,
    of_state: Indices,
    places: tuple[Indices, Indices],
    gradients: Floats,
) -> Floats:
    """Return the derivatives (k, q) of k distances by the joint values of their states (N, q).

    ``of_state`` (k,) is the state of each, ``places`` are those of the geometries A and B, -1 for
    none, and ``gradients`` (k, 12) the derivatives by the spatial velocities of their frames. Each
    joint moves the descendants of its link, including mounted arms; a mimic joint contributes to
    its leader.
    """
    totals = np.zeros((len(of_state), states.shape[1]))
    carriers = _carriers(scene)
    firsts = np.concatenate(([0], np.cumsum([len(arm.links) for arm in arms])))
    posed = _posed(scene, arms, states, firsts, carriers)
    for places_G, by_frame in zip(places, (gradients[:, :6], gradients[:, 6:]), strict=True):
        rows = np.flatnonzero(places_G >= 0)
        frames = scene.frames[places_G]
        rows = rows[carriers.places[frames[rows]] >= 0]
        p_WFs = np.zeros((len(of_state), 3))
        is_first = True
        while rows.size:
            on = carriers.places[frames[rows]]
            for first, last, arm, X_WLs in zip(firsts, firsts[1:], arms, posed, strict=False):
                some = (on >= first) & (on < last)
                own, links = rows[some], arm.links[on[some] - first]
                if is_first:
                    R_WLs = X_WLs.R_WLs[of_state[own], links]
                    p_LFs = carriers.p_LFs[frames[own]]
                    p_WFs[own] = X_WLs.p_WLs[of_state[own], links]
                    p_WFs[own] += np.einsum('kij,kj->ki', R_WLs, p_LFs)
                _add(arm.tree, X_WLs, of_state, links, p_WFs, by_frame, own, totals)
            # The carrier of that arm moves it, too.
            frames[rows] = scene.parents[scene.moved[on]]
            rows, is_first = rows[carriers.places[frames[rows]] >= 0], False
    return totals


def _posed(
    scene: PackedScene,
    arms: tuple[Arm, ...],
    states: Floats,
    firsts: Indices,
    carriers: _Carriers,
) -> list[_PosedLinks]:
    """Return the poses of each arm's links in the world; arms that carry others come first."""
    posed: dict[int, _PosedLinks] = {}
    waiting = list(range(len(arms)))
    while waiting:
        number = waiting.pop(0)
        arm = arms[number]
        R_PLs, p_PLs = _matrices(arm.tree.link_poses(states, arm.X_WB))
        P = int(scene.parents[scene.moved[firsts[number + 1] - 1]]) if len(arm.links) else 0
        R_WP, p_WP, on = carriers.R_LFs[P], carriers.p_LFs[P], int(carriers.places[P])
        if on >= 0:
            other = int(np.searchsorted(firsts, on, side='right')) - 1
            if other not in posed:
                waiting.append(number)
                continue
            link = arms[other].links[on - firsts[other]]
            R_WL, p_WL = posed[other].R_WLs[:, link], posed[other].p_WLs[:, link]
            R_WP, p_WP = R_WL @ R_WP, R_WL @ p_WP + p_WL
            R_WP, p_WP = R_WP[:, np.newaxis], p_WP[:, np.newaxis]
        turned = (R_WP @ p_PLs[..., np.newaxis])[..., 0]
        posed[number] = _PosedLinks(R_WP @ R_PLs, turned + p_WP)
    return [posed[number] for number in range(len(arms))]


def _matrices(poses: Floats) -> tuple[Floats, Floats]:
    """Return rotations (..., 3, 3) and positions (..., 3) of poses (..., 7)."""
    R, p = matrices_from_poses(poses.reshape(-1, 7))
    return R.reshape(*poses.shape[:-1], 3, 3), p.reshape(*poses.shape[:-1], 3)


def _add(
    tree: JointTree,
    posed: _PosedLinks,
    of_state: Indices,
    links: Indices,
    p_WFs: Floats,
    by_frame: Floats,
    rows: Indices,
    totals: Floats,
) -> None:
    """Add to ``rows`` of totals the effect of a tree's joints on frames at p_WFs on ``links``."""
    moved_by = _links_below(tree)
    for joint in np.flatnonzero(tree.leaders >= 0).tolist():
        some = rows[moved_by[joint, links]]
        at = of_state[some], np.full(len(some), tree.children[joint])
        axes = posed.R_WLs[at] @ (tree.multipliers[joint] * tree.axes[joint])
        turn, shift = by_frame[some, :3], by_frame[some, 3:]
        if tree.kinds[joint] == JointKind.REVOLUTE:
            # The frame's velocity is a x (p_WF - p_WJ): d = a . (turn + (p_WF - p_WJ) x shift).
            felt = turn + np.cross(p_WFs[some] - posed.p_WLs[at], shift)
        else:
            felt = shift
        totals[some, tree.leaders[joint]] += np.einsum('ki,ki->k', axes, felt)


def _links_below(tree: JointTree) -> NDArray[np.bool_]:
    """Return the mask (m, m + 1) of the descendants of each joint's link, that link included."""
    below = np.zeros((len(tree.parents), len(tree.parents) + 1), dtype=np.bool_)
    for joint, (parent, child) in enumerate(zip(tree.parents, tree.children, strict=True)):
        below[:, child] = below[:, parent]  # parents come first
        below[joint, child] = True
    return below


def _carriers(scene: PackedScene) -> _Carriers:
    """Return the carrier of each frame."""
    count = len(scene.parents)
    carrier, p_LFs = np.full(count, -1, dtype=np.int64), np.zeros((count, 3))
    R_LFs = np.tile(np.eye(3), (count, 1, 1))
    place = {int(row): number for number, row in enumerate(scene.moved)}
    for frame, parent in enumerate(scene.parents.tolist()):
        if frame in place:
            carrier[frame] = place[frame]
        elif frame:
            carrier[frame] = carrier[parent]
            p_LFs[frame] = p_LFs[parent] + R_LFs[parent] @ scene.p_PFs[frame]
            R_LFs[frame] = R_LFs[parent] @ scene.R_PFs[frame]
    return _Carriers(carrier, R_LFs, p_LFs)
