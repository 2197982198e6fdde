"""Octomap messages to cells."""

import array
from types import SimpleNamespace as Plain

import pytest

from drake_geom_ros.live.conversions.octomap import cells_from_octomap
from drake_geom_ros.sensed_maps.cells import Cells
from drake_geom_ros.sensed_maps.octree import binary_of_cells

CELLS = Cells.of_points([[0.1, 0.2, 0.3], [-1.0, 2.0, 0.0]], 0.1)
DATA = array.array('b', binary_of_cells(CELLS).data)  # int8[] as rclpy gives it


def octomap(**changes):
    return Plain(**{'id': 'OcTree', 'binary': True, 'resolution': 0.1, 'data': DATA, **changes})


def test_a_binary_octomap_is_its_cells():
    assert cells_from_octomap(octomap()).packed.tolist() == CELLS.packed.tolist()


def test_a_full_one_is_its_occupied_leaves():
    nodes = b''.join(b'\0\0\x80\x3f\1' for _ in range(16)) + b'\0\0\x80\x3f\0'
    found = cells_from_octomap(octomap(binary=False, data=array.array('b', nodes)))
    assert found.keys().tolist() == [[-32768] * 3]


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'id': 'Voxels'}, "'Voxels'"),
        ({'resolution': 0.0}, 'must lie in'),
        ({'resolution': float('nan')}, 'must lie in'),
        ({'data': DATA[:-2]}, 'truncated'),
        ({'data': DATA + DATA}, 'more follow'),
        ({'binary': False, 'data': DATA[:6]}, '5 a node'),
        ({'data': array.array('b', b'\xaa\xaa')}, 'at most'),
    ],
)
def test_an_octomap_that_lies_is_refused(changes, reason):
    with pytest.raises(ValueError, match=reason):
        cells_from_octomap(octomap(**changes))
