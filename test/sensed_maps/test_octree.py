"""OctoMap's bytes, against a reading by hand and against OctoMap's own reader and writer."""

import struct

import fcl  # noqa: TID251
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.sensed_maps import tree_walk
from drake_geom_ros.sensed_maps.cells import Cells, MapError
from drake_geom_ros.sensed_maps.octree import (
    HALF,
    binary_of_cells,
    cells_of_binary,
    cells_of_full,
)
from drake_geom_ros.sensed_maps.octree_file import octree_file, parse_octree_file

keys = st.lists(st.tuples(*[st.integers(-HALF, HALF - 1)] * 3), max_size=30)
near = st.lists(st.tuples(*[st.integers(-3, 3)] * 3), max_size=60)


def cells_of(some):
    return Cells.of_keys(np.array(some, dtype=np.int64).reshape(-1, 3), 0.5)


@given(keys | near)
def test_a_binary_tree_gives_back_the_cells(some):
    cells = cells_of(some)
    tree = binary_of_cells(cells)
    assert cells_of_binary(tree.data, 0.5).packed.tobytes() == cells.packed.tobytes()


def path_words(*last):
    """Return a tree with one branch: child 0 at each level but the last, whose word is given."""
    return struct.pack('<15H', *[3] * 15) + struct.pack(f'<{len(last)}H', *last)


def test_bits_by_hand():
    # The lowest corner; children 0 (free), 3 (occupied) and 6 (occupied) of the last node.
    word = 1 | 2 << 2 * 3 | 2 << 2 * 6
    found = cells_of_binary(path_words(word), 1.0)
    assert (found.keys() + HALF).tolist() == [[0, 1, 1], [1, 1, 0]]


def test_a_coarse_leaf_is_all_its_cells():
    word = struct.pack('<14H', *[3] * 14) + struct.pack('<H', 2 << 2 * 5)  # child 5: x and z
    found = cells_of_binary(word, 1.0).keys() + HALF
    assert len(found) == 8
    assert found.min(axis=0).tolist() == [2, 0, 2]
    assert found.max(axis=0).tolist() == [3, 1, 3]


@pytest.mark.parametrize(
    ('data', 'reason'),
    [
        (b'\x03', 'two a node'),
        (struct.pack('<H', 3), 'truncated'),
        (struct.pack('<2H', 1, 1), 'more follow'),
        (struct.pack('<2H', 3, 0), 'no children'),
        (struct.pack('<H', 0), 'no children'),
        (struct.pack('<17H', *[3] * 16, 1), 'more than 16 levels'),
        (struct.pack('<H', 2), 'at most'),
        (struct.pack('<H', 0xAAAA), 'at most'),
    ],
)
def test_bytes_that_are_no_binary_tree_are_refused(data, reason):
    with pytest.raises(MapError, match=reason):
        cells_of_binary(data, 0.1)


@given(st.binary(max_size=300))
@settings(max_examples=300)
def test_garbage_is_refused_or_read_but_never_raises_otherwise(data):
    for read in (cells_of_binary, cells_of_full):
        try:
            read(data, 0.1)
        except MapError:
            continue


def test_a_full_tree_by_hand():
    inner = struct.pack('<fB', 1.0, 1)
    leaves = struct.pack('<fB', 0.0, 0) + struct.pack('<fB', -0.1, 0)
    data = inner * 15 + struct.pack('<fB', 1.0, 1 | 1 << 7) + leaves
    assert (cells_of_full(data, 1.0).keys() + HALF).tolist() == [[0, 0, 0]]
    coloured = b''.join(
        data[k : k + 4] + b'rgb' + data[k + 4 : k + 5] for k in range(0, len(data), 5)
    )
    assert len(cells_of_full(coloured, 1.0, 'ColorOcTree')) == 1
    with pytest.raises(MapError, match='finite'):
        cells_of_full(struct.pack('<fB', np.nan, 0), 1.0)
    with pytest.raises(MapError, match='SomeTree'):
        cells_of_full(data, 1.0, 'SomeTree')


def test_trees_of_both_kinds_run_the_walk_that_is_compiled_at_the_start():
    # A second version would be compiled at the first message that needs it.
    cells_of_binary(binary_of_cells(cells_of([(0, 0, 0)])).data, 0.5)
    cells_of_full(struct.pack('<fB', -1.0, 0), 0.5)
    assert len(tree_walk._put_paths.signatures) == 1


@given(near)
@settings(max_examples=25)
def test_fcl_reads_the_same_tree(some):
    """python-fcl's OcTree is OctoMap's reader: a ball collides where a cell is, and only there."""
    cells = cells_of(some)
    if not len(cells):
        return
    data = np.frombuffer(binary_of_cells(cells).data, np.int8).tolist()
    tree = fcl.CollisionObject(fcl.OcTree(0.5, data))
    held = {tuple(key) for key in cells.keys().tolist()}
    for key in np.indices((9, 9, 9)).reshape(3, -1).T[::7] - 4:
        ball = fcl.CollisionObject(fcl.Sphere(0.2), fcl.Transform((key + 0.5) * 0.5))
        result = fcl.CollisionResult()
        fcl.collide(tree, ball, fcl.CollisionRequest(), result)
        assert result.is_collision == (tuple(key.tolist()) in held)


def test_octomap_itself_reads_what_is_written_and_we_read_what_it_writes(tmp_path):
    octomap = pytest.importorskip('pyoctomap')
    random = np.random.default_rng(5)
    cells = Cells.of_points(random.normal(size=(3000, 3)), 0.125)
    (tmp_path / 'ours.bt').write_bytes(octree_file(cells))
    tree = octomap.OcTree(1.0)
    assert tree.readBinary(str(tmp_path / 'ours.bt'))
    assert tree.size() == binary_of_cells(cells).nodes
    seen = np.array(
        [leaf.getCoordinate() for leaf in tree.begin_leafs() if tree.isNodeOccupied(leaf)]
    )
    assert Cells.of_points(seen, 0.125).packed.tobytes() == cells.packed.tobytes()

    made = octomap.OcTree(0.125)
    for centre in cells.centres()[::3]:
        made.updateNode(centre, True)
    for centre in cells.centres()[1::3]:
        made.updateNode(centre, False)
    made.updateInnerOccupancy()
    expected = Cells.of_points(cells.centres()[::3], 0.125).packed.tobytes()
    for suffix, write in (('.ot', made.write), ('.bt', made.writeBinary)):
        path = tmp_path / f'theirs{suffix}'
        assert write(str(path)) is not False
        found = parse_octree_file(path.read_bytes(), suffix)
        assert found.resolution == 0.125
        assert found.packed.tobytes() == expected
