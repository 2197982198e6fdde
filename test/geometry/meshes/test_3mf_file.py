"""3MF files: metres by their unit, places of what is built, and dropped parts refused."""

import numpy as np
import pytest
from oracles.mesh_files import BOX, threemf

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import InMemoryMesh, MeshFileError
from drake_geom_ros.geometry.meshes.source import remarks_on, surface

COMPONENTS = (
    '<object id="2"><components><component objectid="1"/>'
    '<component objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></components></object>'
)


def mesh(content):
    return InMemoryMesh(mesh_file=MemoryFile(content, '.3mf', 'box'))


def ends(content):
    vertices, triangles = surface(mesh(content), np.ones(3))
    corners = vertices[triangles]
    return corners.min(axis=(0, 1)).tolist(), corners.max(axis=(0, 1)).tolist()


@pytest.mark.parametrize(
    ('unit', 'metres'),
    [('millimeter', 1e-3), ('centimeter', 1e-2), ('inch', 0.0254), ('foot', 0.3048)],
)
def test_lengths_are_metres_by_the_unit(unit, metres):
    assert ends(threemf(unit)) == ([0, 0, 0], (metres * BOX.max(axis=0)).tolist())
    assert remarks_on(mesh(threemf(unit))) == (f'lengths are times {metres:g} m by its unit',)


def test_components_stand_where_they_are_put():
    content = threemf(more=COMPONENTS, build='2')
    assert ends(content) == ([0, 0, 0], [6, 2, 3])
    assert len(surface(mesh(content), np.ones(3))[1]) == 24


def test_what_is_built_stands_at_its_place():
    moved = ' transform="0 1 0 -1 0 0 0 0 1 10 0 0"'
    low, high = ends(threemf(item=moved))
    np.testing.assert_allclose(low, [8, 0, 0], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(high, [10, 1, 3], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        (threemf('parsec'), "unit is 'parsec'"),
        (threemf(vertices=[['a', 0, 0]] * 8), 'box'),
        (threemf(vertices=BOX[:7].tolist()), 'box'),
        (threemf(model='model.xml'), 'no part'),
        (
            threemf(more='<object id="3"><mesh><vertices/><triangles/></mesh></object>')[:-30],
            'box',
        ),
    ],
)
def test_what_is_damaged_is_refused(content, reason):
    with pytest.raises(MeshFileError, match=reason):
        ends(content)
