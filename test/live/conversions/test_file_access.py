"""No file is opened for others outside the roots."""

import pytest

from drake_geom_ros.live.conversions.file_access import FileAccess


@pytest.fixture
def folders(tmp_path):
    """Return an allowed folder with a link and a forbidden one beside it, a file in each."""
    inside, outside = tmp_path / 'meshes', tmp_path / 'meshes_of_others'
    for folder in (inside, outside):
        folder.mkdir()
        (folder / 'ball.obj').write_text('v 0 0 0')
    return inside, outside


def test_a_file_in_a_root_is_found(folders):
    inside, _ = folders
    files = FileAccess([str(inside)])
    for uri in (f'{inside}/ball.obj', f'file://{inside}/ball.obj', f'{inside}/x/../ball.obj'):
        assert files.file(uri, 'mesh_uri') == inside / 'ball.obj'


def test_a_file_outside_is_refused_whichever_way_it_is_named(folders):
    inside, outside = folders
    files = FileAccess([str(inside)])
    for uri in (
        f'{outside}/ball.obj',
        f'file://{outside}/ball.obj',
        f'{inside}/../meshes_of_others/ball.obj',
        f'file://{inside}/%2e%2e/meshes_of_others/ball.obj',
        '/etc/hostname',
    ):
        with pytest.raises(RuntimeError, match=r'mesh_uri: .* outside .* mesh_roots'):
            files.file(uri, 'mesh_uri')


def test_without_roots_nothing_is_opened(folders):
    inside, _ = folders
    with pytest.raises(RuntimeError, match='none'):
        FileAccess(['']).file(f'{inside}/ball.obj', 'path')


def test_the_folder_of_the_scene_file_counts(folders):
    inside, _ = folders
    files = FileAccess([], scene_file=str(inside / 'scene.yaml'))
    assert files.file(str(inside / 'ball.obj'), 'path') == inside / 'ball.obj'


def test_a_relative_root_counts_from_the_working_folder(folders, monkeypatch):
    inside, _ = folders
    monkeypatch.chdir(inside.parent)
    assert FileAccess(['meshes']).file(str(inside / 'ball.obj'), 'path').is_file()


def test_packages(folders, monkeypatch):
    inside, _ = folders
    share = inside / 'share' / 'robot'
    share.mkdir(parents=True)
    (share / 'arm.obj').write_text('v 0 0 0')
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(inside))
    assert FileAccess(['package://']).file('package://robot/arm.obj', 'uri') == share / 'arm.obj'
    with pytest.raises(RuntimeError, match='outside'):
        FileAccess([]).file('package://robot/arm.obj', 'uri')


def test_new_files_are_made_in_a_root_only(folders):
    inside, outside = folders
    files = FileAccess([str(inside)])
    assert files.new_file(f'{inside}/new.yaml', 'path') == inside / 'new.yaml'
    (inside / 'way_out').symlink_to(outside)
    for path in (f'{outside}/new.yaml', f'{inside}/../new.yaml', f'{inside}/way_out/new.yaml'):
        with pytest.raises(RuntimeError, match='mesh_roots'):
            files.new_file(path, 'path')


def test_packages_are_looked_for_in_the_given_roots_which_may_be_opened(tmp_path):
    mesh = tmp_path / 'robots/my_robot/meshes/a.stl'
    mesh.parent.mkdir(parents=True)
    mesh.write_text('solid')
    for root in ('robots', 'robots/my_robot'):
        files = FileAccess([], package_roots=[str(tmp_path / root)])
        assert files.file('package://my_robot/meshes/a.stl', 'mesh') == mesh
    with pytest.raises(RuntimeError, match='no package'):
        FileAccess([]).file('package://my_robot/meshes/a.stl', 'mesh')
