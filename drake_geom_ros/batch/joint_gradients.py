"""How distances change with joint values: the chain rule from frames to the joints above them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.joints import Arm
from drake_geom_ros.geometry.queries.joint_trees import JointKind, JointTree
from drake_geom_ros.geometry.queries.state_queries import PackedScene
from drake_geom_ros.math.batched import matrices_from_poses

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def joint_gradients(
    scene: PackedScene,
    arms: tuple[Arm, ...],
    states: Floats,
    of_state: Indices,
    places: tuple[Indices, Indices],
    gradients: Floats,
) -> Floats:
    """Return the derivatives (k, q) of k distances by the joint values of their states (N, q).

    ``of_state`` (k,) is which state each is of, ``places`` those of the geometries A and B, -1
    where there is none, and ``gradients`` (k, 12) the derivatives by the spatial velocities of
    their frames. Each joint moves what hangs on its link; a mimic joint counts for its leader.
    """
    found = np.zeros((len(of_state), states.shape[1]))
    carriers = _carriers(scene)
    first = 0
    for arm in arms:
        X_WLs = arm.tree.link_poses(states, arm.X_WB)
        for places_G, by_frame in zip(places, (gradients[:, :6], gradients[:, 6:]), strict=True):
            carrier, p_LFs = (values[scene.frames[places_G]] for values in carriers)
            own = (carrier >= first) & (carrier < first + len(arm.links)) & (places_G >= 0)
            rows = np.flatnonzero(own)
            links = arm.links[carrier[rows] - first]
            R_WLs, p_WLs = matrices_from_poses(X_WLs[of_state[rows], links])
            p_WFs = p_WLs + np.einsum('kij,kj->ki', R_WLs, p_LFs[rows])
            _add(arm.tree, X_WLs, of_state[rows], links, p_WFs, by_frame[rows], rows, found)
        first += len(arm.links)
    return found


def _add(
    tree: JointTree,
    X_WLs: Floats,
    of_state: Indices,
    links: Indices,
    p_WFs: Floats,
    by_frame: Floats,
    rows: Indices,
    found: Floats,
) -> None:
    """Add what the joints of a tree move of frames at p_WFs (k, 3), on its links, to some rows."""
    moved_by = _links_below(tree)
    for joint in np.flatnonzero(tree.leaders >= 0).tolist():
        some = np.flatnonzero(moved_by[joint, links])
        R_WJs, p_WJs = matrices_from_poses(X_WLs[of_state[some], tree.children[joint]])
        axes = R_WJs @ (tree.multipliers[joint] * tree.axes[joint])
        turn, shift = by_frame[some, :3], by_frame[some, 3:]
        if tree.kinds[joint] == JointKind.REVOLUTE:
            # The frame goes at a x (p_WF - p_WJ): d = a . (turn + (p_WF - p_WJ) x shift).
            felt = turn + np.cross(p_WFs[some] - p_WJs, shift)
        else:
            felt = shift
        found[rows[some], tree.leaders[joint]] += np.einsum('ki,ki->k', axes, felt)


def _links_below(tree: JointTree) -> NDArray[np.bool_]:
    """Return which links (m + 1,) hang on the link of each joint (m,), that link too."""
    below = np.zeros((len(tree.parents), len(tree.parents) + 1), dtype=np.bool_)
    for joint, (parent, child) in enumerate(zip(tree.parents, tree.children, strict=True)):
        below[:, child] = below[:, parent]  # parents come first
        below[joint, child] = True
    return below


def _carriers(scene: PackedScene) -> tuple[Indices, Floats]:
    """Return, of each frame (nf,), which moved frame carries it, and where it is in that (nf, 3).

    The number is a place in ``scene.moved``, -1 for a frame that no state moves.
    """
    count = len(scene.parents)
    carrier, p_LFs = np.full(count, -1, dtype=np.int64), np.zeros((count, 3))
    R_LFs = np.tile(np.eye(3), (count, 1, 1))
    place = {int(row): number for number, row in enumerate(scene.moved)}
    for frame, parent in enumerate(scene.parents.tolist()):
        if frame in place:
            carrier[frame] = place[frame]
        elif carrier[parent] >= 0:
            carrier[frame] = carrier[parent]
            p_LFs[frame] = p_LFs[parent] + R_LFs[parent] @ scene.p_PFs[frame]
            R_LFs[frame] = R_LFs[parent] @ scene.R_PFs[frame]
    return carrier, p_LFs
