"""The box around a shown scene: that of each shape, at any pose."""

import numpy as np
import pytest
from oracles.mesh_files import BOX
from viewing.scenes import local_scene

from drake_geom_ros.viewing.extents import extent_of

HALF = '- {name: floor, shape: {type: half_space}}\n'
POINTS = [[float(x) for x in point] for point in BOX]
SHAPES = {
    'sphere': ('{type: sphere, radius: 0.5}', [-0.5] * 3, [0.5] * 3),
    'box': ('{type: box, size: [1, 2, 3]}', [-0.5, -1, -1.5], [0.5, 1, 1.5]),
    'capsule': ('{type: capsule, radius: 0.1, length: 1}', [-0.1, -0.1, -0.6], [0.1, 0.1, 0.6]),
    'hull': (f'{{type: convex, vertices: {POINTS}}}', [0, 0, 0], [1, 2, 3]),
    'cells': (
        '{type: occupied_cells, resolution: 0.5, centres: [[0, 0, 0], [1, 2, 3]]}',
        [-0.25, -0.25, -0.25],
        [1.25, 2.25, 3.25],
    ),
}


def moment_of(geometries):
    return local_scene(f'geometries:\n{geometries}').moment(0.1, 'exact')


@pytest.mark.parametrize(('shape', 'low', 'high'), SHAPES.values(), ids=SHAPES)
def test_a_shape_along_the_axes_has_its_own_box(shape, low, high):
    at = np.array([1.0, -2.0, 3.0])
    found = extent_of(
        moment_of(f'- {{name: g, shape: {shape}, pose: {{position: {at.tolist()}}}}}')
    )
    np.testing.assert_allclose(found.low, low + at, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.high, high + at, rtol=0, atol=1e-12)


def test_a_turned_box_reaches_as_far_as_its_corners():
    turned = 'pose: {position: [1, 0, 0], rpy: [0.3, 0.5, 0.7]}'
    moment = moment_of(f'- {{name: g, shape: {SHAPES["box"][0]}, {turned}}}\n' + HALF)
    corners = np.array(list(np.ndindex(2, 2, 2))) * [1, 2, 3] - [0.5, 1, 1.5]
    row = moment.geometries.row_of(moment.geometries.looks[0].geometry.get_value())
    p_WCs = corners @ moment.R_WGs[row].T + moment.p_WGs[row]
    found = extent_of(moment)
    np.testing.assert_allclose(found.low, p_WCs.min(axis=0), rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.high, p_WCs.max(axis=0), rtol=0, atol=1e-12)


def test_half_spaces_alone_have_no_extent():
    assert extent_of(moment_of(HALF)) is None
