"""The renderer by VTK: the same scenes as the exact one shows, and textures."""

import pickle
import subprocess
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from geometry.render.scenes import (
    KINDS,
    images,
    instance,
    looking,
    properties,
    query_of,
    random_pose,
    random_shape,
    scene_of,
)
from oracles.mesh_files import glb, gltf
from PIL import Image

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import (
    Box,
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    FramePoseVector,
    GeometryFrame,
    InMemoryMesh,
    MakeRenderEngineVtk,
    Mesh,
    RenderCameraCore,
    RenderEngineVtkParams,
    RenderLabel,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.render.vtk import probing
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensors import CameraInfo

drawing = pytest.mark.skipif(bool(probing.why_not()), reason=probing.why_not())
WIDTH, HEIGHT = 120, 90
EMPTY = int(RenderLabel.kEmpty)
AHEAD = RigidTransform([0.0, 0.0, 3.0])
# Of a sphere of radius 0.5 with 64 corners around, and what a slope makes of it beside a rim.
TESSELLATION = 0.02  # [m]
LEAP = 0.1  # [m] between the depths of neighbours, of two surfaces


@pytest.fixture(scope='module')
def engine():
    return MakeRenderEngineVtk()


def camera(name='vtk', near=0.05, far=20.0):
    info = CameraInfo(WIDTH, HEIGHT, 100.0, 110.0, 62.5, 41.0)
    core = RenderCameraCore(name, info, ClippingRange(near, far))
    return DepthRenderCamera(core, DepthRange(near, far))


def with_vtk(engine, bodies):
    scene, source = scene_of(bodies)
    scene.AddRenderer('vtk', engine)
    return scene, source


def away_from_silhouettes(*shown):
    """Return where all neighbours have a pixel's label, and no other surface, in each image.

    A mesh may stand before itself, so that a silhouette is where depth leaps, too.
    """
    inside = np.ones((HEIGHT, WIDTH), dtype=bool)
    for made in shown:
        labels, depths = made.label.data[..., 0], made.depth.data[..., 0]
        depths = np.where(np.isfinite(depths), depths, 100.0)
        for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
            inside &= np.roll(labels, step, axis) == labels
            inside &= np.abs(np.roll(depths, step, axis) - depths) < LEAP
    return inside


@drawing
@pytest.mark.parametrize('seed', range(4))
def test_it_shows_what_the_exact_renderer_shows(engine, seed):
    """Labels are equal away from silhouettes, depths within the tessellation; x is not y."""
    random = np.random.default_rng(seed)
    kinds = [kind for kind in KINDS if kind != 'half_space']
    bodies = [
        (random_shape(random, kind), random_pose(random, 0.9)) for kind in kinds for _ in range(2)
    ]
    scene, _ = with_vtk(engine, bodies)
    pose = looking(random.uniform([1.5, 2.0, 1.0], [2.0, 2.5, 2.0]), np.zeros(3))
    theirs, ours = (images(scene, camera(name), pose) for name in ('vtk', 'exact'))
    inside = away_from_silhouettes(theirs, ours)
    labels = [made.label.data[..., 0][inside] for made in (theirs, ours)]
    depths = [made.depth.data[..., 0][inside] for made in (theirs, ours)]
    there = labels[1] != EMPTY
    # Bodies that run into each other meet along a line that tessellation moves.
    other = labels[0] != labels[1]
    assert np.count_nonzero(other) <= 2
    assert np.isinf(depths[0][~there]).all()
    gaps = np.abs(depths[0][there & ~other] - depths[1][there & ~other])
    assert np.quantile(gaps, 0.99) < 0.002
    assert gaps.max() < TESSELLATION
    assert len(np.unique(labels[0])) > 5
    assert inside.mean() > 0.6


@drawing
def test_flat_faces_have_the_depths_of_the_formula(engine):
    scene, _ = with_vtk(engine, [(Box(9, 9, 1), AHEAD)])
    made = images(scene, camera())
    np.testing.assert_allclose(made.depth.data, 2.5, rtol=0.0, atol=1e-6)
    near = images(scene, camera(near=2.6)).depth.data  # what is nearer is cut away
    np.testing.assert_allclose(near[..., 0], 3.5, rtol=0.0, atol=1e-6)
    assert np.isinf(images(scene, camera(far=2.4)).depth.data).all()
    core = camera().core()
    low = DepthRenderCamera(core, DepthRange(2.6, 4.0))
    assert (images(scene, low).depth.data == 0.0).all()
    assert (images(scene, ColorRenderCamera(core), want='label').label.data >= 0).all()


@drawing
def test_it_follows_the_scene_and_roles(engine):
    scene, source = with_vtk(engine, [])
    frame = scene.RegisterFrame(source, GeometryFrame('f'))
    picky = properties(1)
    picky.AddProperty('renderer', 'accepting', {'exact'})
    scene.RegisterAnchoredGeometry(
        source, instance(Sphere(0.1), RigidTransform([0, 0, 1.0]), 'p', picky)
    )
    context = scene.CreateDefaultContext()
    query = scene.get_query_output_port().Eval(context)

    def middle():
        made = query.render_images(camera(), scene.world_frame_id(), RigidTransform())
        return round(float(made.depth.at(62, 40)[0]), 3), int(made.label.at(62, 40)[0])

    context.UpdateFramePoses(FramePoseVector({frame: AHEAD}))
    assert middle() == (np.inf, EMPTY)
    hidden = instance(Box(1, 1, 1), RigidTransform(), 'hidden', properties())
    scene.RegisterGeometry(context, source, frame, hidden)
    assert middle() == (2.5, int(RenderLabel.kDontCare))
    assert query.render_legend('vtk') == {hidden.id(): int(RenderLabel.kDontCare)}
    context.UpdateFramePoses(FramePoseVector({frame: RigidTransform([0, 0, 4.0])}))
    assert middle() == (3.5, int(RenderLabel.kDontCare))
    scene.ChangeShape(context, source, hidden.id(), Box(2, 2, 2))
    assert middle() == (3.0, int(RenderLabel.kDontCare))
    scene.RemoveGeometry(context, source, hidden.id())
    assert middle() == (np.inf, EMPTY)


@drawing
def test_labels_that_are_left_out_and_those_that_must_be(engine):
    scene, source = with_vtk(engine, [(Box(9, 9, 1), RigidTransform([0, 0, 5.0]))])
    glass = properties()
    glass.AddProperty('label', 'id', RenderLabel.kDoNotRender)
    scene.RegisterAnchoredGeometry(source, instance(Box(9, 9, 1), AHEAD, 'glass', glass))
    made = images(scene, camera())
    assert (np.unique(made.label.data), made.depth.at(60, 40)[0]) == (0, pytest.approx(2.5))
    strict = MakeRenderEngineVtk(RenderEngineVtkParams(default_label=RenderLabel.kUnspecified))
    scene.AddRenderer('strict', strict)
    scene.RegisterAnchoredGeometry(source, instance(Sphere(1), AHEAD, 'unnamed', properties()))
    with pytest.raises(RuntimeError, match=r"unnamed.*'label'"):
        images(scene, camera('strict'))


PLATE = """mtllib {mtl}
v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
usemtl it
f 1/1 2/2 3/3\nf 1/1 3/3 4/4
"""
MATERIAL = 'newmtl it\nKd 1 1 1\nKa 0 0 0\nmap_Kd half.png\n'


@pytest.fixture
def folder(tmp_path):
    """A folder of a plate whose texture is red where x < 0 and green beyond."""
    half = np.zeros((8, 16, 3), np.uint8)
    half[:, :8, 0] = half[:, 8:, 1] = 255
    for name in ('half.png', 'beside.png'):
        Image.fromarray(half).save(tmp_path / name)
    for name, mtl in (('materials', 'it.mtl'), ('beside', 'none'), ('plain', 'none')):
        (tmp_path / f'{name}.obj').write_text(PLATE.format(mtl=mtl))
    (tmp_path / 'it.mtl').write_text(MATERIAL)
    made = trimesh.Trimesh(  # y is up in glTF: this is where the others are once it is turned
        [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]],
        [[0, 1, 2], [0, 2, 3]],
        visual=trimesh.visual.TextureVisuals(
            uv=[[0, 0], [1, 0], [1, 1], [0, 1]],
            material=trimesh.visual.material.PBRMaterial(
                baseColorTexture=Image.fromarray(half), metallicFactor=0.0, roughnessFactor=1.0
            ),
        ),
        process=False,
    )
    made.export(tmp_path / 'plate.glb')
    return tmp_path


def mesh_of(folder, kind):
    """Return a shape of a textured plate, and its ('phong', 'diffuse_map')."""
    if kind == 'memory':
        supporting = {'it.mtl': MemoryFile(MATERIAL, '.mtl', ''), 'half.png': folder / 'half.png'}
        file = MemoryFile(PLATE.format(mtl='it.mtl'), '.obj', 'plate')
        memory = InMemoryMesh(mesh_file=file, supporting_files=supporting)
        return Mesh(memory, [0.5, 0.25, 1.0]), None
    names = {'map': 'plain.obj', 'glb': 'plate.glb'}
    shape = Mesh(folder / names.get(kind, f'{kind}.obj'), [0.5, 0.25, 1.0])
    return shape, str(folder / 'half.png') if kind == 'map' else None


@drawing
@pytest.mark.parametrize('kind', ['materials', 'beside', 'map', 'glb', 'memory'])
def test_textures_are_where_coordinates_put_them(engine, folder, kind):
    """The camera looks along +z, so that x is to the right as in the file; scales count."""
    shape, diffuse_map = mesh_of(folder, kind)
    scene, source = with_vtk(engine, [])
    made = properties(3, (0.0, 0.0, 1.0))
    if diffuse_map:
        made.AddProperty('phong', 'diffuse_map', diffuse_map)
    scene.RegisterAnchoredGeometry(source, instance(shape, AHEAD, 'plate', made))
    shown = images(scene, camera())
    left, right = (shown.color.at(62 + step, 41).tolist() for step in (-10, 10))
    assert (left[0] > 100, left[1] < 60) == (True, True), left
    assert (right[0] < 60, right[1] > 100) == (True, True), right
    is_plate = (shown.label.data == 3)[..., 0]
    background = shown.color.at(0, 0)
    np.testing.assert_array_equal((shown.color.data != background).any(axis=-1), is_plate)
    assert 300 < is_plate.sum() < 4000


@drawing
@pytest.mark.parametrize('form', ['gltf', 'glb'])
def test_a_gltf_file_is_where_queries_have_it(engine, tmp_path, form):
    """Z up, moved by its node, scaled along the axes of G: in colours as in labels and depth."""
    nodes = [{'translation': [0.2, 0, 0], 'children': [1]}, {'mesh': 0, 'scale': [1, 0.5, 0.1]}]
    path = tmp_path / f'box.{form}'
    path.write_bytes(glb(nodes) if form == 'glb' else gltf(nodes).encode())
    scene, source = with_vtk(engine, [])
    shape = Mesh(path, [0.5, 1.5, 1.0])
    made = instance(shape, AHEAD, 'box', properties(3, (0.0, 0.0, 1.0)))
    scene.RegisterAnchoredGeometry(source, made)
    shown = images(scene, camera())
    is_box = (shown.label.data == 3)[..., 0]
    background = shown.color.at(0, 0)
    np.testing.assert_array_equal((shown.color.data != background).any(axis=-1), is_box)
    lows, highs = (end(shape.surface()[0], axis=0) for end in (np.min, np.max))
    np.testing.assert_allclose([lows, highs], [[0.1, -0.45, 0], [0.6, 0, 1]], rtol=0, atol=1e-7)
    nearest = np.nanmin(np.where(is_box, shown.depth.data[..., 0], np.nan))
    assert nearest == pytest.approx(AHEAD.translation()[2], abs=1e-3)
    assert 100 < is_box.sum() < 4000


@drawing
def test_a_primitive_has_a_texture_and_one_that_is_none_is_refused(engine, folder):
    scene, source = with_vtk(engine, [])
    for name, file in (('box', folder / 'half.png'), ('bad', folder / 'it.mtl')):
        made = properties(3)
        made.AddProperty('phong', 'diffuse_map', str(file))
        scene.RegisterAnchoredGeometry(source, instance(Box(1, 1, 1), AHEAD, name, made))
        if name == 'box':
            color = images(scene, camera()).color
            assert (color.data[..., :3] == 0).any()
    with pytest.raises(RuntimeError, match=r'it\.mtl'):
        images(scene, camera())


@pytest.mark.clock
@drawing
def test_a_context_is_asked_from_any_thread(engine):
    """OpenGL answers other threads than its own with stale or empty images, without a word."""
    scene, _ = with_vtk(
        engine, [(Sphere(0.5), AHEAD), (Box(1, 2, 0.5), RigidTransform([1, 0, 4]))]
    )
    query, W = query_of(scene), scene.world_frame_id()
    first, differing = query.render_images(camera(), W, RigidTransform()), []

    def ask():
        for _ in range(5):
            made = query.render_images(camera(), W, RigidTransform())
            differing.extend(a != b for a, b in zip(made, first, strict=True))

    threads = [threading.Thread(target=ask) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert differing == [False] * 45


@pytest.mark.processes
@drawing
def test_engines_come_and_go_and_the_process_ends_well():
    code = (
        'import sys, pickle\n'
        "sys.path.insert(0, 'test')\n"
        'from geometry.render.test_vtk import *\n'
        'for _ in range(2):\n'
        '    engine = pickle.loads(pickle.dumps(MakeRenderEngineVtk()))\n'
        '    scene, _ = with_vtk(engine, [(Sphere(0.5), AHEAD)])\n'
        '    assert images(scene, camera()).label.at(62, 41)[0] == 0\n'
        "print('well')\n"
    )
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, timeout=800, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, 'well\n', '')


@drawing
def test_an_image_beyond_opengl_is_refused(engine):
    scene, _ = with_vtk(engine, [])
    core = RenderCameraCore('vtk', CameraInfo(20000, 4, 1.0), ClippingRange(0.1, 1.0))
    with pytest.raises(RuntimeError, match='20000 x 4'):
        images(scene, ColorRenderCamera(core), want='color')


@pytest.mark.processes
def test_what_is_missing_is_named(monkeypatch):
    """The wheel; or the system's libraries, without which VTK ends a process by a fault."""
    monkeypatch.setattr(probing.importlib.util, 'find_spec', lambda name: None)
    assert "extra 'vtk'" in probing.why_not.__wrapped__()
    monkeypatch.setattr(probing.importlib.util, 'find_spec', lambda name: name)
    monkeypatch.setattr(probing, '_opens', lambda library: 'mesa' in library)
    fault = SimpleNamespace(returncode=-11, stdout='')
    monkeypatch.setattr(probing.subprocess, 'run', lambda *_, **__: fault)
    reason = probing.why_not.__wrapped__()
    assert 'signal 11' in reason
    assert 'not found: libEGL.so.1 (libegl1);' in reason
    assert 'apt-get install libegl1 libgl1-mesa-dri' in reason
    monkeypatch.setattr(probing, 'why_not', lambda: reason)
    with pytest.raises(RuntimeError, match='MakeRenderEngineVtk: VTK cannot draw'):
        MakeRenderEngineVtk()


def test_a_driver_that_hangs_is_a_reason_and_no_traceback(monkeypatch):
    def hang(command, **given):
        raise subprocess.TimeoutExpired(command, given['timeout'])

    monkeypatch.setattr(probing.importlib.util, 'find_spec', lambda name: name)
    monkeypatch.setattr(probing.subprocess, 'run', hang)
    assert 'nothing within 120 s' in probing.why_not.__wrapped__()


@pytest.mark.parametrize('wrong', [{'default_label': RenderLabel.kEmpty}])
def test_parameters_that_are_none_are_refused(wrong):
    with pytest.raises(RuntimeError, match=next(iter(wrong))):
        RenderEngineVtkParams(**wrong)


def test_parameters_are_records():
    assert pickle.loads(pickle.dumps(RenderEngineVtkParams())) == RenderEngineVtkParams()
    assert SceneGraph().GetRendererTypeName('vtk') == ''
