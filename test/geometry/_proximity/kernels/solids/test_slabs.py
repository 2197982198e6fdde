"""Slabs between blocks of triangles, against the distances of all of these."""

import itertools

import numpy as np
import pytest
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.geometry._proximity.kernels.solids import slabs
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import (
    leaf_of_A,
    separation_of_leaves,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    SolidPair,
    body_of,
    first_of_leaf,
    noise_of,
    solid_of,
)
from drake_geom_ros.geometry._proximity.kinds import BOX, SOLID
from truth.bodies.random_bodies import random_rotation

L = kernel_form(solid('L', cuts=2))[1]
X = (1.0, 0.0, 0.0)


def _pair(R, p):
    return SolidPair(body_of(SOLID, L, R), solid_of(L), p, 12.0, 1e-9, 0.0)


def _distances(pair, triangles, others):
    """The distances (k, m) of triangles, by GJK."""
    found = [separation_of_leaves(pair, k, m, X, np.inf) for k in triangles for m in others]
    return np.array([x.upper for x in found]).reshape(len(triangles), -1)


def test_a_block_is_two_leaves():
    tree = solid_of(L).tree
    blocks = slabs.in_blocks(tree)
    assert blocks == tree._replace(leaves=tree.leaves // 2)
    firsts = [first_of_leaf(blocks, k) for k in range(blocks.leaves + 1)]
    assert firsts == [first_of_leaf(tree, 2 * k) for k in range(blocks.leaves + 1)]
    assert max(np.diff(firsts)) <= slabs.MOST_IN_BLOCK
    assert slabs.in_blocks(tree._replace(leaves=1)).leaves == 1
    assert slabs.in_blocks(tree._replace(leaves=0)).leaves == 0


@pytest.mark.parametrize('p', [(0.7, 0.2, 0.6), (4.0, -1.0, 0.5), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize('turned', [False, True])
def test_no_triangles_are_nearer_than_their_slabs_tell(p, turned):
    """And none are nearer than their blocks: some are as near, which are told to be."""
    R = random_rotation(np.random.default_rng(8)) if turned else np.eye(3)
    pair = _pair(R, p)
    A, B, _ = slabs.blocks_of(pair)
    room, told = slabs.scratch_for_blocks(), 0
    for i, j in itertools.product(range(0, A.tree.leaves, 3), range(B.tree.leaves)):
        gap = slabs.gap_of_blocks(pair, i, j, room)
        triangles, others = (
            range(first_of_leaf(tree, k), first_of_leaf(tree, k + 1))
            for tree, k in ((A.tree, i), (B.tree, j))
        )
        distances = _distances(pair, triangles, others)
        ends = room[: len(triangles), slabs.END]
        begins = room[: len(others), slabs.BEGIN]
        gaps = begins - ends[:, None]
        assert gaps.min() == gap
        assert (gaps <= distances + noise_of(pair)).all()
        told += (gaps > 0.5 * distances).sum()
        for k in triangles:
            found = slabs.leaf_in_block(pair, k, triangles[0], room)
            np.testing.assert_allclose(found, leaf_of_A(pair, k), rtol=0, atol=1e-15)
    assert told > 0


def test_a_core_has_no_slabs():
    pair = SolidPair(body_of(BOX, np.ones(3), np.eye(3)), solid_of(L), X, 9.0, 1e-9, 0.0)
    room = slabs.scratch_for_blocks()
    assert slabs.gap_of_blocks(pair, 0, 1, room) == 0.0
    assert not room[:, slabs.END].any()
    assert not room[:, slabs.BEGIN].any()
    assert slabs.leaf_in_block(pair, 0, 0, room) == leaf_of_A(pair, 0)
    assert slabs.blocks_of(pair)[1].tree == pair.B.tree
