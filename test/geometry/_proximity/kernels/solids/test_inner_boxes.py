"""Boxes within solids: all of a union of boxes, and none that leaves the body."""

import numpy as np
import pytest
import trimesh
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.solids.inner_boxes import goes_into
from drake_geom_ros.geometry._proximity.kernels.solids.solid import INNER_BOX, tree_of
from drake_geom_ros.geometry._proximity.kinds import SOLID
from truth.bodies.grids import surface


def boxes_of(body):
    kind, shape = kernel_form(body)
    assert kind == SOLID
    tree = tree_of(SOLID, shape)
    return shape[tree.boxes_at : tree.boxes_at + INNER_BOX * tree.boxes].reshape(-1, INNER_BOX)


@pytest.mark.parametrize('cuts', [1, 3])
@pytest.mark.parametrize(
    ('name', 'expected'),
    [
        ('L', {(0, 0, 0, 2, 1, 1), (0, 0, 0, 1, 2, 1)}),
        ('U', {(0, 0, 0, 3, 1, 1), (0, 0, 0, 1, 2, 1), (2, 0, 0, 3, 2, 1)}),
        (
            'ring',
            {(0, 0, 0, 3, 1, 1), (0, 2, 0, 3, 3, 1), (0, 0, 0, 1, 3, 1), (2, 0, 0, 3, 3, 1)},
        ),
    ],
)
def test_a_union_of_boxes_has_its_largest_boxes(name, expected, cuts):
    assert set(map(tuple, boxes_of(solid(name, cuts=cuts)).tolist())) == expected


def test_boxes_of_cells_of_any_size_are_in_cells():
    rng = np.random.default_rng(5)
    for _ in range(20):
        filled = rng.random((3, 3, 3)) < 0.6
        lines = [np.cumsum(rng.uniform(0.1, 2.0, 4)) for _ in range(3)]
        filled[0, 0, 0] = filled[1, 0, 0] = filled[0, 1, 0] = True
        filled[1, 1, 0] = False
        cells = [tuple(cell) for cell in np.argwhere(filled).tolist()]
        vertices, triangles = map(np.array, surface(cells, lines))
        boxes = boxes_of(Body('Solid', vertices, triangles=triangles))
        volume = 0.0
        for box in boxes:
            first = [np.flatnonzero(lines[k] == box[k]).item() for k in range(3)]
            last = [np.flatnonzero(lines[k] == box[k + 3]).item() for k in range(3)]
            assert filled[tuple(slice(i, j) for i, j in zip(first, last, strict=True))].all()
            volume = max(volume, float(np.prod(box[3:] - box[:3])))
        assert volume > 0.0
        for cell in cells:  # each is in one
            low = np.array([lines[k][cell[k]] for k in range(3)])
            assert ((boxes[:, :3] <= low) & (low < boxes[:, 3:])).all(axis=1).any()


def test_boxes_of_a_torus_are_in_it():
    torus = trimesh.creation.torus(1.0, 0.4, 48, 24)
    boxes = boxes_of(Body('Solid', np.array(torus.vertices), triangles=np.array(torus.faces)))
    assert len(boxes) > 4
    for box in boxes:
        corners = np.array([[box[3 * i], box[1 + 3 * j], box[2 + 3 * k]]
                            for i, j, k in np.ndindex(2, 2, 2)])  # fmt: skip
        assert trimesh.proximity.signed_distance(torus, corners).min() > -1e-9


@pytest.mark.parametrize(
    ('triangle', 'told'),
    [
        (((0, 0, 0), (1, 0, 0), (0, 1, 0)), False),  # on a face
        (((0, 0, 0.5), (1, 0, 0.5), (0, 1, 0.5)), True),
        (((2, 0.1, 0.1), (0.1, 2, 0.1), (2, 2, 0.1)), False),  # past an edge
        (((1.5, 0.1, 0.1), (0.1, 1.5, 0.1), (2, 2, 0.1)), True),
        (((-1, -1, 0.5), (3, -1, 0.5), (-1, 3, 0.5)), True),  # all of it between
    ],
)
def test_which_triangles_go_into_a_box(triangle, told):
    corners = [tuple(map(float, corner)) for corner in triangle]
    assert goes_into(*corners, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)) == told
