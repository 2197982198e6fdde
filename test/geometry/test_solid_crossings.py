"""Which surfaces cross themselves: those of cells do not, and what does is refused."""

import itertools

import numpy as np
import pytest
from numba import config
from oracles.crossings import crossings
from oracles.voxels import KINDS, filled_cells, placed, voxel_mesh

from drake_geom_ros.geometry import MeshData, MeshFileError
from drake_geom_ros.geometry.meshes._solids import solid_of
from truth.bodies.grids import surface
from truth.bodies.random_bodies import random_rotation

ONES = (1.0, 1.0, 1.0)
SEEDS, LARGEST = (2, 3) if config.DISABLE_JIT else (25, 6)


def is_taken(vertices, triangles):
    """Whether a mesh is a solid; False if it is refused because its bodies overlap."""
    try:
        solid_of(MeshData(vertices, triangles), ONES)
    except MeshFileError as error:
        if 'crosses itself' not in str(error) and 'closed surfaces' not in str(error):
            raise
        return False
    return True


@pytest.mark.parametrize('spread', [0.0, 1.0, 4.0, 8.0])
@pytest.mark.parametrize('kind', KINDS)
def test_cells_of_a_grid_are_taken(kind, spread):
    """Wherever they touch, however thin their walls and however narrow their pits are."""
    for seed in range(SEEDS):
        rng = np.random.default_rng([seed, KINDS.index(kind)])
        width = 10 ** rng.uniform(-6, 2)
        n = int(rng.integers(2, LARGEST + 1))
        vertices, triangles = voxel_mesh(rng, kind, n, width, spread)
        if spread <= 1.0:
            vertices, triangles = placed(rng, vertices, triangles, rng.choice([0, 1, 1e3]) * width)
        else:  # in single precision, or far away, the narrowest would vanish
            vertices = vertices @ random_rotation(rng).T if seed % 2 else vertices
        assert is_taken(vertices, triangles), (seed, kind)


@pytest.mark.parametrize('kind', KINDS)
def test_exact_arithmetic_finds_no_crossing_in_cells_either(kind):
    rng = np.random.default_rng(KINDS.index(kind))
    for spread, far in ((0.0, 1.0), (1.0, 1e3)):
        mesh = placed(rng, *voxel_mesh(rng, kind, 2, 0.01, spread), 0.01 * far)
        assert not crossings(*mesh)


def two_bodies(rng, n, step, scale):
    """Two sets of cells, the second moved by ``step`` and scaled; and whether they overlap."""
    filled = [filled_cells(rng, 'any', n) for _ in range(2)]
    lines = [np.tile(np.arange(n + 1.0), (3, 1)), scale * np.arange(n + 1.0) + step[:, None]]
    vertices, triangles, count = [], [], 0
    for cells, where in zip(filled, lines, strict=True):
        v, t = surface(map(tuple, np.argwhere(cells).tolist()), where)
        vertices += v
        triangles += (np.array(t) + count).tolist()
        count += len(v)
    return np.array(vertices), np.array(triangles), *relation(filled, lines)


def relation(filled, lines):
    """Whether two bodies of cells overlap, and whether they have part of a face in common.

    Faces that differ by the rounding of thirds lie on one another.
    """
    overlap = flush = False
    for i, j in itertools.product(*(np.argwhere(cells) for cells in filled)):
        at = np.arange(3)
        low = np.maximum(lines[0][at, i], lines[1][at, j])
        high = np.minimum(lines[0][at, i + 1], lines[1][at, j + 1])
        depths = high - low
        overlap |= bool((depths > ROUNDED).all())
        flush |= bool((depths >= -ROUNDED).all() and (np.abs(depths) <= ROUNDED).sum() == 1)
    return overlap, flush


ROUNDED = 1e-14  # of sums of thirds

# Along edges and faces of both, in the middle of them, and nowhere in particular.
STEPS = (0.0, 1.0, 0.5, 0.25, 0.3)


@pytest.mark.parametrize('scale', [1.0, 0.5, 2.0, 1.0 / 3.0, 2.0**-10, 2.0**-24])
def test_bodies_that_overlap_are_refused_and_those_that_touch_are_taken(scale):
    """They may cross along edges that both have, that one has, that lie in a face, or anywhere."""
    refused = taken = 0
    for seed in range(4 * SEEDS):
        rng = np.random.default_rng(seed)
        step = rng.choice(STEPS, 3) + rng.integers(-1, 3, 3) * rng.choice([1.0, scale])
        vertices, triangles, overlap, flush = two_bodies(rng, 2, step, scale)
        R = random_rotation(rng) if seed % 2 else np.eye(3)
        width = 10 ** rng.uniform(-6, 2)
        if overlap:
            assert not is_taken(width * vertices @ R.T, triangles), seed
            refused += 1
        elif not flush:
            assert is_taken(width * vertices @ R.T, triangles), seed
            taken += 1
    assert refused


PULLS = 1 if config.DISABLE_JIT else 6  # exact arithmetic takes half a second each


@pytest.mark.parametrize('pull', [0.3, 1.0, 2.5])
def test_a_vertex_that_is_pulled_through_a_face_is_seen(pull):
    """The floor of a pit, pulled down through the bottom of the block, or towards it."""
    seen = 0
    for seed in range(PULLS):
        rng = np.random.default_rng(seed)
        filled = np.ones((3, 3, 3), dtype=bool)
        filled[1, 1, 1:] = False
        vertices, triangles = surface(
            map(tuple, np.argwhere(filled).tolist()), [np.arange(4.0)] * 3
        )
        vertices, triangles = np.array(vertices), np.array(triangles)
        at = np.flatnonzero((vertices == [1.0, 1.0, 1.0]).all(axis=1))[0]
        vertices[at] += pull * np.array([*rng.uniform(-0.2, 0.2, 2), -1.0])
        crosses = bool(crossings(vertices, triangles))
        vertices = 10 ** rng.uniform(-6, 2) * vertices @ random_rotation(rng).T
        assert is_taken(vertices, triangles) != crosses
        seen += crosses
    assert seen == (PULLS if pull > 1.0 else 0)
