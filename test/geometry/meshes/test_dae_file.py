"""Collada files: lengths by their unit, up as in RViz, and nothing lost on the way."""

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES, dae, primitive

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import InMemoryMesh, MeshFileError
from drake_geom_ros.geometry.meshes.source import remarks_on, surface

ONES = np.ones(3)
AT_10 = '<translate>10 0 0</translate>'
MATRIX = '<matrix>1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</matrix>'
G = '<instance_geometry url="#g"/>'


def memory(text):
    return InMemoryMesh(mesh_file=MemoryFile(text, '.dae', 'box'))


def read(text):
    return surface(memory(text), ONES)


def extents(vertices):
    return [*vertices.min(axis=0).round(6).tolist(), *vertices.max(axis=0).round(6).tolist()]


def volume(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize(
    ('unit', 'metres', 'told'),
    [
        ('', 1.0, False),
        ('<unit/>', 1.0, False),
        ('<unit name="meter" meter="1"/>', 1.0, False),
        ('<unit name="centimeter" meter="0.01"/>', 0.01, True),
        ('<unit meter="0.001"/>', 0.001, True),
        ('<unit name="inch" meter="0.0254"/>', 0.0254, True),
    ],
)
def test_lengths_are_those_of_the_unit(tmp_path, unit, metres, told):
    path = tmp_path / 'part.DAE'
    path.write_text(dae(unit))
    vertices, triangles = surface(str(path), ONES)
    np.testing.assert_array_equal(vertices, BOX * metres)
    np.testing.assert_array_equal(triangles, SIDES)
    assert bool(remarks_on(str(path))) == told


@pytest.mark.parametrize('axis', ['X_UP', 'Y_UP', 'Z_UP'])
def test_the_up_axis_is_not_applied_as_in_rviz_and_told_of(axis):
    """By assimp 6.0.5 with RViz's option IGNORE_UP_DIRECTION, too: the box stays as it is."""
    text = dae(axis=axis)
    np.testing.assert_array_equal(read(text)[0], BOX)
    told = (f'its <up_axis> {axis} is not applied, as in RViz',) if axis != 'Z_UP' else ()
    assert remarks_on(memory(text)) == told


@pytest.mark.parametrize(
    ('nodes', 'expected', 'count'),
    [
        (f'<node>{AT_10}{G}</node>', [10, 0, 0, 11, 2, 3], 12),
        (f'<node>{AT_10}<scale>2 2 2</scale>{G}</node>', [10, 0, 0, 12, 4, 6], 12),
        (f'<node><scale>2 2 2</scale>{AT_10}{G}</node>', [20, 0, 0, 22, 4, 6], 12),
        (f'<node><rotate>0 0 2 90</rotate>{G}</node>', [-2, 0, 0, 0, 1, 3], 12),
        (f'<node><scale>-1 1 1</scale>{G}</node>', [-1, 0, 0, 0, 2, 3], 12),
        (
            f'<node>{MATRIX}<node>{AT_10}{G}</node></node>',
            [15, 0, 0, 16, 2, 3],
            12,
        ),
        (f'<node>{G}</node><node>{AT_10}{G}</node>', [0, 0, 0, 11, 2, 3], 24),
        (f'<node>{G}<instance_node url="#far"/></node>', [0, 0, 0, 11, 2, 3], 24),
    ],
)
def test_nodes_place_what_they_name(nodes, expected, count):
    library = f'<library_nodes><node id="far">{AT_10}{G}</node></library_nodes>'
    vertices, triangles = read(dae('<unit meter="0.5"/>', nodes=nodes, library=library))
    assert extents(vertices) == [x / 2 for x in expected]
    assert len(triangles) == count
    scale = 8.0 if 'scale>2' in nodes else 1.0
    assert volume(vertices, triangles) == pytest.approx(6.0 / 8 * scale * count / 12)


QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


@pytest.mark.parametrize(
    'shapes',
    [
        primitive('polylist', [QUADS], '<vcount>4 4 4 4 4 4</vcount>', 6),
        primitive('polygons', QUADS, count=6),
        primitive('polylist', [QUADS[:3]], '<vcount>4 4 4</vcount>', 3)
        + primitive('triangles', [SIDES[6:]], count=6),
        primitive('trifans', QUADS, count=6),
        primitive('tristrips', [[a, b, d, c] for a, b, c, d in QUADS], count=6),
    ],
)
def test_faces_of_all_kinds_count(shapes):
    vertices, triangles = read(dae(shapes=shapes))
    assert volume(vertices, triangles) == pytest.approx(6.0)
    assert len(triangles) == 12


def test_other_inputs_of_a_face_are_passed_over():
    """Normals with an offset of their own stand between the vertices in a <p>."""
    corners = np.stack([SIDES.ravel(), np.zeros(36, int)], axis=1)
    inner = '<input semantic="NORMAL" source="#p" offset="1"/>'
    np.testing.assert_array_equal(
        read(dae(shapes=primitive(loops=[corners], inner=inner)))[1], SIDES
    )


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        (dae('<unit meter="0"/>'), 'unit meter'),
        (dae('<unit meter="nan"/>'), 'unit meter'),
        (dae('<unit meter="0,01"/>'), '0,01'),
        (
            dae('<unit meter="0.1"/>').replace('<mesh>', '<asset><unit/></asset><mesh>'),
            'one length',
        ),
        (dae(nodes='<node><instance_controller url="#skin"/></node>'), 'skin'),
        (dae(nodes='<node><instance_geometry url="#h"/></node>'), "'#h' names nothing"),
        (dae(nodes='<node><instance_geometry url="b.dae#g"/></node>'), 'other files'),
        (dae(nodes='<node id="n"><instance_node url="#n"/></node>'), 'in itself'),
        (dae(nodes=f'<node><skew>45 0 1 0 1 0 0</skew>{G}</node>'), 'skew'),
        (dae().replace('<scene>', '<extra>').replace('</scene>', '</extra>'), 'no <scene>'),
        (dae(shapes=''), '0 vertices'),
        (dae(shapes=primitive(count=13)), '13 faces of 39 corners, and has 36'),
        (dae(shapes=primitive(loops=[[0, 1, 8]], count=1)), 'vertex 8 of 8'),
        (dae(shapes=primitive('polygons', [], '<ph><p>0 1 3</p></ph>', 1)), 'holes'),
        (dae().replace('count="8"', 'count="9"'), '9 positions of 3 numbers and has 24'),
        (dae().replace('mesh>', 'spline>'), '<spline>'),
        (dae()[:-300], 'cannot be read'),
        ('solid', 'cannot be read'),
        ('<html/>', 'a web page'),
        ('<other/>', 'no Collada'),
    ],
)
def test_what_would_be_read_in_part_or_not_at_all_is_refused(text, reason):
    with pytest.raises(MeshFileError, match=reason):
        read(text)


def test_nodes_that_multiply_are_refused():
    name = [f'<node id="n{k}">{f"<instance_node url={chr(34)}#n{k + 1}{chr(34)}/>" * 2}</node>'
            for k in range(40)]  # fmt: skip
    library = f'<library_nodes>{"".join(name)}<node id="n40">{G}</node></library_nodes>'
    with pytest.raises(MeshFileError, match='too many'):
        read(dae(nodes='<node><instance_node url="#n0"/></node>', library=library))
