"""`check` lists how large each mesh is, whether it is closed, how it counts, and odd sizes."""

import pytest
from oracles.mesh_files import BOX, SIDES, dae, gltf

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry.meshes._obj_file import obj_text


def check(capsys, path, shapes):
    """Return the lines of `check` about meshes in a scene of these shapes."""
    lines = [f'- {{name: g{k}, shape: {shape}}}' for k, shape in enumerate(shapes)]
    (path / 'scene.yaml').write_text('\n'.join(['geometries:', *lines]))
    assert main(['check', str(path / 'scene.yaml')]) == 0
    found = capsys.readouterr().out.splitlines()
    return found[found.index('meshes') + 1 : found.index('filters')]


def test_each_mesh_is_listed_with_what_its_file_says(capsys, tmp_path):
    (tmp_path / 'box.obj').write_text(obj_text(BOX, SIDES))
    (tmp_path / 'open.obj').write_text(obj_text(BOX, SIDES[1:]))
    (tmp_path / 'box.gltf').write_text(gltf())
    (tmp_path / 'box.dae').write_text(dae('<unit meter="0.01"/>', 'Y_UP'))
    shapes = [
        *(f'{{type: mesh, uri: {name}}}' for name in ('box.obj', 'open.obj', 'box.gltf')),
        '{type: convex, uri: box.dae, scale: [1, 1, -2]}',
    ]
    solid = ', roles: {proximity: {mesh: {solid: true}}}'
    shapes[0] = f'{shapes[0]}{solid}'
    assert check(capsys, tmp_path, shapes) == [
        '  scene::world/g0: box.obj from (0, 0, 0) to (1, 2, 3) m, 12 triangles, closed, '
        'counts as a solid',
        '  scene::world/g1: open.obj from (0, 0, 0) to (1, 2, 3) m, 11 triangles, not closed, '
        'counts as its hull',
        '  scene::world/g2: box.gltf from (0, -3, 0) to (1, 0, 2) m, 12 triangles, closed, '
        'counts as its hull, turned from y up to z up',
        '  scene::world/g3: box.dae from (0, 0, -0.06) to (0.01, 0.02, 0) m, 12 triangles, '
        'closed, counts as its hull, lengths are times 0.01 m by its <unit>, its <up_axis> Y_UP '
        'is not applied, as in RViz',
    ]


@pytest.mark.parametrize(
    ('scale', 'word'),
    [(3.4, 'above 10 m'), (1000, 'above 10 m'), (3.3, ''), (4e-4, ''), (3e-4, 'below 0.001 m')],
)
def test_a_size_that_no_part_of_a_robot_has_is_warned_of(capsys, tmp_path, scale, word):
    (tmp_path / 'box.obj').write_text(obj_text(BOX, SIDES))
    lines = check(capsys, tmp_path, [f'{{type: mesh, uri: box.obj, scale: {scale}}}'])
    warnings = [line for line in lines if line.startswith('warning: scene::world/g0: ')]
    assert len(warnings) == bool(word)
    assert not warnings or f'{3 * scale:.6g} m is its largest extent, {word}' in warnings[0]


def test_a_scene_without_meshes_has_no_such_part(capsys, tmp_path):
    (tmp_path / 'scene.yaml').write_text('geometries: [{name: a, shape: {type: half_space}}]')
    assert main(['check', str(tmp_path / 'scene.yaml')]) == 0
    assert 'meshes' not in capsys.readouterr().out.splitlines()


def test_a_file_that_is_not_read_whole_is_the_exit_code(capsys, tmp_path):
    (tmp_path / 'part.fbx').write_text('PK')
    text = 'geometries: [{name: a, shape: {type: mesh, uri: part.fbx}}]'
    (tmp_path / 'scene.yaml').write_text(text)
    assert main(['check', str(tmp_path / 'scene.yaml')]) == 1
    assert 'dae, glb, gltf, obj, off, ply, stl' in capsys.readouterr().err
