import re
import sys

import pytest

from drake_geom_ros.scene_files.resources import ResourceResolver


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A file of package ``parts`` under tmp_path/share, and nothing from outside."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', '')
    monkeypatch.setenv('ROS_PACKAGE_PATH', '')
    folder = tmp_path / 'share' / 'parts'
    (folder / 'meshes').mkdir(parents=True)
    (folder / 'meshes' / 'a b.obj').write_text('v 0 0 0')
    (tmp_path / 'secret.txt').write_text('s')
    return folder


def test_a_package_is_found_on_the_ament_prefix_path(package, monkeypatch):
    monkeypatch.setenv('AMENT_PREFIX_PATH', f':{package.parents[2]}:{package.parents[1]}')
    found = ResourceResolver().resolve('package://parts/meshes/a b.obj', package)
    assert found == package / 'meshes' / 'a b.obj'


@pytest.mark.parametrize('slashes', ['', '/', '//'])
def test_a_third_slash_before_the_package_changes_nothing(package, slashes):
    found = ResourceResolver([package]).resolve(
        f'package://{slashes}parts/meshes/a b.obj', package
    )
    assert found == package / 'meshes' / 'a b.obj'


@pytest.mark.parametrize('up', [0, 1])
def test_a_package_is_found_in_the_roots(package, up):
    root = [package, package.parent][up]
    found = ResourceResolver([root]).resolve('package://parts/meshes/a b.obj', package)
    assert found == package / 'meshes' / 'a b.obj'


def test_a_package_is_found_beside_pip_packages(package, monkeypatch):
    site = package.parents[1] / 'site-packages'
    inner = site / 'cmeel.prefix' / 'share' / 'arms'
    inner.mkdir(parents=True)
    (inner / 'x.urdf').write_text('<robot/>')
    monkeypatch.setattr(sys, 'path', [str(site)])
    assert ResourceResolver().resolve('package://arms/x.urdf', package) == inner / 'x.urdf'


def test_a_package_is_found_in_the_environment_that_pip_installed_ours_in(package, monkeypatch):
    """PyPI's packages of ROS are there, and nobody sources anything."""
    prefix = package.parents[1]
    monkeypatch.setattr(sys, 'prefix', str(prefix))
    uri = 'package://parts/meshes/a b.obj'
    with pytest.raises(ValueError, match="no package 'parts'"):
        ResourceResolver().resolve(uri, package)
    index = prefix / 'share/ament_index/resource_index/packages'
    index.mkdir(parents=True)
    (index / 'drake_geom_ros').touch()
    assert ResourceResolver().resolve(uri, package) == package / 'meshes' / 'a b.obj'


def test_a_path_counts_from_the_folder(package):
    resolver = ResourceResolver()
    target = package / 'meshes' / 'a b.obj'
    assert resolver.resolve('meshes/a b.obj', package) == target
    assert resolver.resolve('../a b.obj', package / 'meshes' / 'x') == target
    assert resolver.resolve(str(target), package.parent) == target
    assert resolver.resolve(target.as_uri(), package.parent) == target


@pytest.mark.parametrize(
    ('uri', 'part'),
    [
        ('package://parts/../../secret.txt', 'must stay inside its package'),
        ('package://parts/meshes/../../../secret.txt', 'must stay inside its package'),
        ('package://../parts/x', 'must stay inside its package'),
        ('package:///', 'must stay inside its package'),
        ('package:///../parts/x', 'must stay inside its package'),
        ('package:///etc/passwd', "there is no package 'etc'"),
        ('package://parts//etc/passwd', 'there is no file'),
        ('package://parts/none.obj', 'there is no file'),
        ('package://nowhere/x.obj', "there is no package 'nowhere'"),
        ('http://host/x.obj', "scheme 'http'"),
        ('none.obj', 'there is no file'),
        ('meshes', 'there is no file'),
    ],
)
def test_what_cannot_be_resolved_says_why(package, uri, part):
    with pytest.raises(ValueError, match=re.escape(part)) as caught:
        ResourceResolver([package.parent]).resolve(uri, package)
    assert repr(uri) in str(caught.value)


def test_an_unknown_package_lists_where_it_was_looked_for(package, monkeypatch):
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(package.parent))
    with pytest.raises(ValueError, match='no package') as caught:
        ResourceResolver(['/roots']).resolve('package://gone/x', package)
    assert '/roots/gone' in str(caught.value)
    assert str(package.parent / 'share' / 'gone') in str(caught.value)


@pytest.mark.parametrize('up', [0, 1])
def test_a_package_is_found_on_the_ros_package_path_after_the_roots(package, monkeypatch, up):
    root = [package, package.parent][up]
    monkeypatch.setenv('ROS_PACKAGE_PATH', f':/nowhere:{root}')
    uri, file = 'package://parts/meshes/a b.obj', package / 'meshes' / 'a b.obj'
    assert ResourceResolver().resolve(uri, package) == file
    other = package.parents[1] / 'other' / 'parts' / 'meshes'
    other.mkdir(parents=True)
    (other / 'a b.obj').write_text('v 0 0 0')
    assert ResourceResolver(other.parents[1]).resolve(uri, package) == other / 'a b.obj'


@pytest.mark.parametrize('kind', [str, lambda path: path, lambda path: [path]])
def test_one_root_needs_no_list(package, kind):
    """A text was once taken for a list of its characters, of which `/` is a folder."""
    resolver = ResourceResolver(kind(package.parent), kind(package))
    uri = 'package://parts/meshes/a b.obj'
    assert resolver.resolve(uri, package) == package / 'meshes' / 'a b.obj'
    with pytest.raises(ValueError, match='outside'):
        resolver.resolve(str(package.parents[1] / 'secret.txt'), package)
    with pytest.raises(ValueError, match=r'no package .*searched [^,]*share/x, .*--package-root'):
        ResourceResolver(kind(package.parent)).resolve('package://x/y', package)
