"""What counts as a solid, and what is refused, with the reason."""

import numpy as np
import pytest
import trimesh
from oracles.forms import row_of
from oracles.solids import surface_of

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import (
    Box,
    GeometryInstance,
    Mesh,
    MeshData,
    MeshFileError,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import tree_of
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SOLID
from drake_geom_ros.geometry.meshes._solids import solid_of
from drake_geom_ros.geometry.shapes.mesh_facts import mesh_facts
from drake_geom_ros.geometry.shapes.primitives import for_queries
from drake_geom_ros.math import RigidTransform
from truth.bodies.grids import surface

ONES = (1.0, 1.0, 1.0)
CORNERS = np.array(list(np.ndindex(2, 2, 2)), dtype=float)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])
L = surface_of('L')


def two(vertices, triangles, *, turned=False):
    """A cube and another one of these vertices."""
    other = triangles[:, ::-1] if turned else triangles
    return MeshData(np.vstack((CORNERS, vertices)), np.vstack((CUBE, other + 8)))


def two_grids():
    """Cubes of 2 m, cut into squares of 1 m, the second a metre on along x, y and z."""
    vertices, triangles = (np.array(x) for x in surface(np.ndindex(2, 2, 2), [np.arange(3.0)] * 3))
    second = len(vertices) + triangles
    return MeshData(np.vstack((vertices, vertices + 1.0)), np.vstack((triangles, second)))


def bad_meshes():
    open_, flipped = np.array(L.triangles), np.array(L.triangles)
    flipped[0] = flipped[0][::-1]
    many = np.vstack((L.triangles, L.triangles[:1]))
    twice = np.vstack((L.triangles, L.triangles))
    return {
        'open': (MeshData(L.vertices, open_[1:]), '3 are open'),
        'one triangle turned': (MeshData(L.vertices, flipped), '3 have two triangles that run'),
        'one triangle too many': (MeshData(L.vertices, many), '3 have three or more'),
        'everything twice': (MeshData(L.vertices, twice), 'crosses itself'),
        'two that cross': (two(np.add(CORNERS, [0.5, 0.3, 0.2]), CUBE), 'crosses itself'),
        'two that cross in edges': (two(np.add(CORNERS, [0.5, 0.5, 0.5]), CUBE), 'crosses itself'),
        'two that cross along edges of both': (two_grids(), 'crosses itself'),
        'two with one top': (two(np.add(0.5 * CORNERS, [0.7, 0.2, 0.5]), CUBE), 'crosses itself'),
        'a body within a body': (two(0.5 * CORNERS + 0.25, CUBE), 'closed surfaces'),
        'a cavity in nothing': (two(0.5 * CORNERS + 3, CUBE, turned=True), 'closed surfaces'),
        'no triangles': (MeshData(CORNERS), 'no triangles'),
        'flat': (MeshData(L.vertices * [1, 1, 0], L.triangles), 'lie in a plane'),
        'a folded sheet': (
            MeshData([[0, 0, 0], [1, 0, 0], [0, 1, 1], [1, 1, 0]],
                     [[0, 1, 2], [0, 2, 1], [1, 3, 2], [1, 2, 3]]),
            'no triangles|no volume',
        ),
    }  # fmt: skip


BAD = bad_meshes()


@pytest.mark.parametrize('name', BAD)
def test_what_bounds_no_solid_is_refused_with_the_reason(name):
    mesh, words = BAD[name]
    with pytest.raises(MeshFileError, match=words):
        solid_of(mesh, ONES)


@pytest.mark.parametrize('name', ['open', 'two that cross'])
def test_a_refused_role_changes_nothing(name):
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    instance = GeometryInstance(RigidTransform(), Mesh.FromMeshData(BAD[name][0]), 'm')
    geometry = scene_graph.RegisterAnchoredGeometry(source, instance)
    properties = ProximityProperties()
    properties.AddProperty('mesh', 'solid', True)
    with pytest.raises(MeshFileError, match='counts as its convex hull'):
        scene_graph.AssignRole(source, geometry, properties)
    assert scene_graph.model_inspector().GetProximityProperties(geometry) is None
    scene_graph.AssignRole(source, geometry, ProximityProperties())  # as a hull it is well


@pytest.mark.parametrize('shape', [Mesh.FromMeshData(L), Box(1, 1, 1)])
def test_the_property_is_a_bool_and_matters_to_meshes_only(shape):
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    instance = GeometryInstance(RigidTransform(), shape, 'm')
    geometry = scene_graph.RegisterAnchoredGeometry(source, instance)
    properties = ProximityProperties()
    properties.AddProperty('mesh', 'solid', 'yes')
    if isinstance(shape, Mesh):
        with pytest.raises(RuntimeError, match=r"'solid'.*bool"):
            scene_graph.AssignRole(source, geometry, properties)
    else:
        scene_graph.AssignRole(source, geometry, properties)


def test_what_is_convex_counts_as_its_hull():
    ball = trimesh.creation.icosphere(subdivisions=2)
    fine = surface_of('L', cuts=3)  # its cells in a row, without the one beside
    for mesh in (
        MeshData(CORNERS, CUBE),
        MeshData(CORNERS, CUBE[:, ::-1]),
        MeshData(ball.vertices, ball.faces),
        two(np.add(CORNERS, [1, 0, 0]), CUBE),  # face on face: one body
    ):
        kind, parameters = solid_of(mesh, ONES)
        assert kind == CONVEX
        assert len(parameters) >= 1 + 3 * int(parameters[0])
    assert solid_of(fine, ONES)[0] == SOLID


def dented(depth):
    """A cube whose top has a small pit of a depth, the four triangles of which meet in a point."""
    ring = [[0.4, 0.4, 1], [0.6, 0.4, 1], [0.6, 0.6, 1], [0.4, 0.6, 1]]
    vertices = np.vstack((CORNERS, ring, [[0.5, 0.5, 1 - depth]]))
    sides = [t for t in CUBE.tolist() if not CORNERS[t][:, 2].all()]
    border, pit = [1, 5, 7, 3], [8, 9, 10, 11]
    top = []
    for k in range(4):
        m = (k + 1) % 4
        top += [[border[k], border[m], pit[m]], [border[k], pit[m], pit[k]], [pit[k], pit[m], 12]]
    return MeshData(vertices, sides + top)


@pytest.mark.parametrize('depth', [0.5, 1e-3, 1e-9, 1e-12])
def test_the_smallest_dent_makes_a_solid(depth):
    assert solid_of(dented(depth), ONES)[0] == SOLID


def with_junctions(mesh, edges):
    """The same surface, some edges with a vertex more on one side: no area closes the rest."""
    vertices, triangles = mesh.vertices.tolist(), mesh.triangles.tolist()
    for a, b in edges:
        (t,) = (t for t in triangles if (a, b) in zip(t, t[1:] + t[:1], strict=True))
        (c,) = set(t) - {a, b}
        m = len(vertices)
        vertices.append(np.mean([vertices[a], vertices[b]], axis=0).tolist())
        triangles.remove(t)
        triangles += [[a, m, c], [m, b, c], [a, b, m]]
    return MeshData(vertices, triangles)


def edges_of(mesh, count, seed):
    """Some edges, no two of a triangle."""
    rng, found, used = np.random.default_rng(seed), [], set()
    for k in rng.permutation(len(mesh.triangles)).tolist():
        t = mesh.triangles[k].tolist()
        edges = list(zip(t, t[1:] + t[:1], strict=True))
        a, b = edges[rng.integers(3)]
        if not used & set(t):
            used |= set(t)
            found.append((a, b))
    return found[:count]


def hidden_dent(width, depth):
    """A cube with a pit, around whose rim all edges meet triangles without area."""
    mesh = dented(depth)
    vertices = mesh.vertices.copy()
    vertices[8:12, :2] = 0.5 + (vertices[8:12, :2] - 0.5) * (width / 0.2)
    rim = [(8 + k, 8 + (k + 1) % 4) for k in range(4)]
    return with_junctions(MeshData(vertices, mesh.triangles), rim)


@pytest.mark.parametrize(('width', 'depth'), [(6e-5, 0.5), (0.2, 0.5), (0.2, 1e-9), (1e-3, 1e-4)])
def test_a_dent_behind_triangles_without_area_makes_a_solid(width, depth):
    """Across such a triangle no edge rises or falls."""
    kind, parameters = solid_of(hidden_dent(width, depth), ONES)
    assert kind == SOLID
    assert tree_of(SOLID, parameters).triangles == 10 + 8 + 8


def test_a_ball_in_a_hidden_pit_is_out_of_the_cube():
    width, depth, radius, deep = 6e-5, 0.5, 1e-6, 0.25
    pit = hidden_dent(width, depth)
    half, slope = 0.5 * width * (1.0 - deep / depth), 0.5 * width / depth
    truth = half / np.hypot(1.0, slope) - radius  # from the pit's nearest wall
    A = Body('Sphere', (radius,), p=np.array([0.5, 0.5, 1.0 - deep]))
    out = row_of(A, Body('Solid', pit.vertices, triangles=pit.triangles))
    assert abs(out[0] - truth) <= out[10]
    assert 0.0 < out[10] < 1e-12


def test_a_cube_with_junctions_counts_as_its_hull():
    for seed in range(6):
        cube = MeshData(CORNERS, CUBE)
        assert solid_of(with_junctions(cube, edges_of(cube, 3, seed)), ONES)[0] == CONVEX


@pytest.mark.parametrize('seed', range(8))
def test_triangles_without_area_belong_to_no_surface(seed):
    """A cube that touches walls of an L, with such triangles in any of its edges, touches it."""
    bare = np.array(L.triangles)
    edges = edges_of(L, 4, seed)
    mesh = with_junctions(L, edges)
    kind, parameters = solid_of(mesh, ONES)
    assert kind == SOLID
    assert len(edges) >= 2
    assert tree_of(SOLID, parameters).triangles == len(bare) + len(edges)
    B = Body('Solid', mesh.vertices, triangles=mesh.triangles)
    for corner in ([1.0, 1.0, 0.0], [1.0, 1.0, 0.5], [2.0, 0.0, 0.0], [0.25, 0.25, 1.0]):
        at = np.array(corner)
        for A in (
            Body('Box', (1.0, 1.0, 1.0), p=at + 0.5),
            Body('Solid', np.array(L.vertices), p=at, triangles=bare),
            Body('Solid', mesh.vertices, p=at, triangles=mesh.triangles),
        ):
            out = row_of(A, B)
            assert out[0] == pytest.approx(0.0, abs=1e-13), (corner, A.kind)
            assert out[10] <= 1e-12


def apart(mesh, by, seed=1):
    """A mesh of which each triangle has corners of its own, moved at random by up to ``by``."""
    vertices, triangles = np.array(mesh.vertices), np.array(mesh.triangles)
    moves = np.random.default_rng(seed).uniform(-by, by, (3 * len(triangles), 3))
    return MeshData(
        vertices[triangles].reshape(-1, 3) + moves, np.arange(len(moves)).reshape(-1, 3)
    )


@pytest.mark.parametrize('by', [1e-16, 1e-12, 2e-9])
def test_vertices_a_last_digit_apart_are_welded_and_told(by):
    """The distances to the solid are those of the mesh, as exactly as its vertices are placed."""
    mesh = apart(L, by)
    kind, parameters = solid_of(mesh, ONES)
    assert kind == SOLID
    assert tree_of(SOLID, parameters).triangles == len(L.triangles)
    ball = Body('Sphere', (0.1,), p=np.array([1.5, 1.5, 0.5]))
    rows = [
        row_of(ball, Body('Solid', np.array(m.vertices), triangles=np.array(m.triangles)))
        for m in (L, mesh)
    ]
    assert rows[1][0] == pytest.approx(rows[0][0], abs=2.0 * by + 1e-12)
    facts = mesh_facts(Mesh.FromMeshData(mesh))
    assert facts.is_closed
    (told,) = [text for text in facts.remarks if 'welded' in text]
    assert 'only so is its surface closed' in told
    assert float(told.split('at most ')[1].split(' m ')[0]) <= 4.0 * by


@pytest.mark.parametrize('by', [1e-7, 1e-3])
def test_a_gap_that_is_none_of_rounding_stays_one(by):
    with pytest.raises(MeshFileError, match='are open'):
        solid_of(apart(L, by), ONES)


def test_a_row_of_near_vertices_is_not_drawn_together():
    """Ten of them, each within the tolerance of the next, cut into an edge: what is open stays."""
    vertices, triangles = np.array(L.vertices), np.array(L.triangles)
    a, b, c = triangles[0]
    step = 1.5e-8  # L is 2 m large
    row = vertices[a] + np.outer(np.arange(1, 11) * step, [0.3, 0.5, 0.8])
    fan = [(len(vertices) + k, b, c) for k in range(10)]
    mesh = MeshData(np.vstack((vertices, row)), np.vstack((triangles[1:], fan)))
    with pytest.raises(MeshFileError, match='bounds no solid'):
        solid_of(mesh, ONES)


def test_a_closed_mesh_is_left_as_it_is():
    """Vertices that are near, but belong to a surface that is closed without welding."""
    assert mesh_facts(Mesh.FromMeshData(L)).remarks == ()


def test_how_many_triangles_have_no_area_is_told():
    shape = Mesh.FromMeshData(with_junctions(L, edges_of(L, 4, 1)))
    assert any('4 of its triangles have no area' in text for text in mesh_facts(shape).remarks)
    assert mesh_facts(Mesh.FromMeshData(L)).remarks == ()


@pytest.mark.parametrize(
    'mesh',
    [
        MeshData(L.vertices, L.triangles[:, ::-1]),
        MeshData(np.vstack((L.vertices, [[9, 9, 9]])), np.vstack((L.triangles, [[0, 0, 1]]))),
        two(np.add(CORNERS, [5, 0, 0]), CUBE),
        two(np.add(CORNERS, [1, 1, 0]), CUBE),  # they share an edge
        two(np.add(CORNERS, [1, 1, 1]), CUBE),  # they share a corner
        two(0.5 * CORNERS + 0.25, CUBE, turned=True),  # a cavity
    ],
    ids=['inverted', 'idle parts', 'two bodies', 'an edge', 'a corner', 'a cavity'],
)
def test_what_has_an_answer_is_taken(mesh):
    assert solid_of(mesh, ONES)[0] == SOLID


def test_scales_and_mirror_images():
    for scale in ((2.0, 3.0, 0.5), (-1.0, 1.0, 1.0), (-1.0, -2.0, -3.0)):
        assert solid_of(MeshData(L.vertices, L.triangles), scale)[0] == SOLID
    one, other = (Mesh.FromMeshData(each) for each in (L, surface_of('L')))
    assert for_queries(one, True).in_pairs is for_queries(other, True).in_pairs  # by content


@pytest.mark.parametrize('scale', [1e150, 1e250, 1e60])
def test_a_solid_too_large_for_products_of_lengths_is_refused_with_the_reason(scale):
    with pytest.raises(MeshFileError, match='no coordinate of it is beyond'):
        solid_of(L, (scale, 1.0, scale))
    with pytest.raises(MeshFileError, match='at least'):
        solid_of(MeshData(np.array(L.vertices) / scale, L.triangles), ONES)


@pytest.mark.parametrize('scale', [1e40, 1e-40])
def test_solids_of_any_other_size_are_taken(scale):
    kind, _ = solid_of(MeshData(np.array(L.vertices) * scale, L.triangles), ONES)
    assert kind == SOLID


@pytest.mark.parametrize('thick', [1e-8, 1e-9, 1e-11])
def test_a_prism_may_be_thin(thick):
    """A plate is a cube, an L an L, however thin."""
    assert solid_of(MeshData(CORNERS, CUBE), (1.0, 0.7, thick))[0] == CONVEX
    assert solid_of(MeshData(CORNERS * [1, 0.7, thick], CUBE), ONES)[0] == CONVEX
    assert solid_of(MeshData(np.array(L.vertices) * [1, 1, thick], L.triangles), ONES)[0] == SOLID
    plate = Body('Solid', CORNERS * [1, 0.7, thick], triangles=CUBE)
    ball = Body('Sphere', (0.1,), p=np.array([0.3, 0.3, 0.2]))
    out = row_of(ball, plate)
    assert abs(out[0] - (0.1 - thick)) <= out[10] <= 1e-12
