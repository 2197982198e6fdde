"""The wheel: what it holds, and that it works in an environment that has nothing else, nor ROS."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest
from conventions.source_tree import PACKAGE, ROOT, SOURCES, imports_of, name_of
from conventions.test_packages import LIBRARIES, pins, requirements
from packaging.requirements import Requirement

pytestmark = [pytest.mark.packaging, pytest.mark.processes]

# What a build or a set-up leaves in the tree, or is large: no part of what is built from.
LEFT_OUT = shutil.ignore_patterns('.*', 'build', 'install', 'log', 'out', '__pycache__', 'docs')
PINS = [part for name in ('core', 'lock') for part in ('-c', ROOT / f'requirements/{name}.txt')]
SHARE = 'share/drake_geom_ros'
# What an import is called where it is installed.
PEERS = {
    'cyipopt': 'cyipopt-wheels',
    'jsonschema_rs': 'jsonschema-rs',
    'nrrd': 'pynrrd',
    'pydrake': 'drake',
    'vtkmodules': 'vtk',
}
ON_NO_INDEX = {'openvdb', 'pyopenvdb'}
# What python3-NAME is on the system of Jazzy and Kilted. A script of colcon may refuse to start
# where a version that is there is out of the range that setup.py says.
UBUNTU_24_04 = {
    'jsonschema': '4.10.3',
    'lxml': '5.2.1',
    'matplotlib': '3.6.3',
    'numpy': '1.26.4',
    'pyyaml': '6.0.1',
    'scipy': '1.11.4',
}


@pytest.fixture(scope='module')
def wheel(tmp_path_factory):
    """Return the path of a wheel that pip built from a copy of the tree."""
    folder = tmp_path_factory.mktemp('wheel')
    shutil.copytree(ROOT, folder / 'tree', ignore=LEFT_OUT)
    pip = [sys.executable, '-m', 'pip', 'wheel', '--no-deps', '--no-cache-dir', '-w', folder]
    run(*pip, folder / 'tree', cwd=folder)
    (path,) = folder.glob('*.whl')
    return path


@pytest.fixture(scope='module')
def prefix(wheel, tmp_path_factory):
    """Return the prefix of an environment that has the wheel, and what it asks for, pinned."""
    folder = tmp_path_factory.mktemp('installed') / 'venv'
    run(sys.executable, '-m', 'venv', folder, cwd=folder.parent)
    pip = [folder / 'bin/python', '-m', 'pip', 'install', '--no-compile', *PINS]
    run(*pip, wheel, cwd=folder.parent)
    return folder


def run(*command, cwd, **variables):
    """Return what a command prints, run with nothing of this environment but pip's settings."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if name in ('HOME', 'NUMBA_CACHE_DIR') or name.lower().startswith(('pip_', 'http'))
    }
    done = subprocess.run(
        list(map(str, command)),
        cwd=cwd,
        env={**kept, 'PATH': os.defpath, **variables},
        capture_output=True,
        text=True,
        timeout=800,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def test_it_holds_all_that_is_read_at_run_time_and_no_tests(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    inside = {name for name in names if name.startswith('drake_geom_ros/')}
    page = (PACKAGE / 'viewing/page/static').iterdir()
    data = [PACKAGE / 'py.typed', *PACKAGE.rglob('*.json'), *page]
    assert inside == {name_of(path) for path in [*SOURCES, *data]}
    shared = {name.partition(f'.data/data/{SHARE}/')[2] for name in names} - {''}
    rooms = [path for room in ('scenes', 'launch', 'config') for path in (ROOT / room).glob('*.*')]
    assert shared == {'package.xml', *map(name_of, rooms)}
    assert {Path(name).parts[0].split('-')[0] for name in names} == {'drake_geom_ros'}


@pytest.fixture(scope='module')
def asked_for(wheel):
    """Return what the wheel asks for, by itself and for its extras."""
    with zipfile.ZipFile(wheel) as archive:
        (path,) = [name for name in archive.namelist() if name.endswith('/METADATA')]
        metadata = message_from_bytes(archive.read(path))
    return [Requirement(text) for text in metadata.get_all('Requires-Dist')]


OF_THIS_VERSION = {'drake-geom-msgs-kilted', 'drake-geom-msgs-jazzy'}


def test_the_pins_lie_within_its_ranges(asked_for):
    pinned = pins()
    for each in (each for each in asked_for if each.name not in OF_THIS_VERSION):
        assert pinned[each.name], each
        assert [v for v in pinned[each.name] if v not in each.specifier] == [], each


def test_its_ranges_are_open_above_but_for_numba(asked_for):
    """A bound that nobody knows the need of would shut out each version of the years to come."""
    bounds = {(each.name, bound.operator) for each in asked_for for bound in each.specifier}
    of_this_version = {(name, '==') for name in OF_THIS_VERSION}
    assert {each for each in bounds if each[1] != '>='} == {('numba', '<'), *of_this_version}


@pytest.mark.parametrize('distribution', ['kilted', 'jazzy'])
def test_an_extra_has_what_a_set_up_takes_of_ros(asked_for, distribution):
    lines = requirements()[f'{distribution}/ros.txt']
    pinned = {re.match(r'[\w-]+(\[\w+\])?', line).group() for line in lines}
    extra = f'extra == "{distribution}"'
    named = {str(each).partition(';')[0] for each in asked_for if extra in str(each.marker)}
    assert {name for name in named if name.startswith('ros-')} == pinned


@pytest.mark.parametrize('version', UBUNTU_24_04.items(), ids=lambda item: item[0])
def test_its_ranges_admit_what_rosdep_installs(asked_for, version):
    name, there = version
    assert [each for each in asked_for if each.name == name and there not in each.specifier] == []


def test_it_asks_for_all_that_is_imported_without_ros(asked_for):
    with_ros = {'ros', 'client'}
    sources = [p for p in SOURCES if with_ros.isdisjoint(p.relative_to(PACKAGE).parts)]
    names = {name.split('.')[0] for path in sources for name in imports_of(path.read_text())}
    names -= {*sys.stdlib_module_names, 'drake_geom_ros'}
    needed = {LIBRARIES[name][1] if name in LIBRARIES else PEERS.get(name, name) for name in names}
    assert needed - ON_NO_INDEX - {each.name for each in asked_for} == set()


@pytest.mark.parametrize('library', ['rclpy', 'drake_geom_msgs', 'yourdfpy', 'fcl', 'pytest'])
def test_nothing_else_is_there(prefix, tmp_path, library):
    script = f'from importlib.util import find_spec; print(find_spec({library!r}))'
    assert run(prefix / 'bin/python', '-c', script, cwd=tmp_path) == 'None\n'


def test_the_core_example_prints_what_its_page_says(prefix, tmp_path):
    page = (ROOT / 'docs/installation.md').read_text()
    examples = re.findall(r'^```python\n(.*?)^```$', page, re.S | re.M)
    (script,) = [each for each in examples if 'off by at most' in each]
    printed = run(prefix / 'bin/python', '-c', script, cwd=tmp_path)
    assert script.rstrip().endswith(f'# {printed.strip()}')


def test_check_runs_as_a_script_and_as_a_module(prefix, tmp_path):
    scene = prefix / SHARE / 'scenes/minimal.yaml'
    told = run(prefix / 'bin/drake_geom_ros', 'check', scene, cwd=tmp_path)
    assert told.startswith(f'{scene}: sources 1, frames 1, geometries 3, filters 0\n')
    module = prefix / 'bin/python', '-m', 'drake_geom_ros'
    assert run(*module, 'check', scene, cwd=tmp_path) == told
    for command in (('drake_geom_ros',), ('python', '-m', 'drake_geom_ros')):
        usage = run(prefix / 'bin' / command[0], *command[1:], '-h', cwd=tmp_path)
        assert usage.startswith(f'usage: {" ".join(command)} ')


def test_it_answers_about_a_hull(prefix, tmp_path):
    """Hulls take what a scene of primitives does not: trimesh, and SciPy beneath it."""
    scene = tmp_path / 'scene.yaml'
    corners = '[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]'
    scene.write_text(
        'frames: [{name: ball, pose: {position: [-1, 0.2, 0.2]}}]\n'
        'geometries:\n'
        f'- {{name: hull, shape: {{type: convex, vertices: {corners}}}}}\n'
        '- {name: ball, frame: ball, shape: {type: sphere, radius: 0.5}}\n'
    )
    query = prefix / 'bin/drake_geom_ros', 'query', scene
    # Uncompiled: the kernel of hulls takes a minute to compile, and compiles in the example above.
    rows = run(*query, cwd=tmp_path, NUMBA_DISABLE_JIT='1').splitlines()
    assert float(rows[1].split(',')[2]) == pytest.approx(0.5, abs=1e-12)


def test_its_types_are_there_to_be_checked(prefix, tmp_path):
    script = tmp_path / 'script.py'
    script.write_text(
        'from drake_geom_ros.geometry import Sphere\nreveal_type(Sphere(1).radius())\n'
    )
    mypy = [sys.executable, '-m', 'mypy', '--python-executable', prefix / 'bin/python']
    assert 'Revealed type is "float"' in run(*mypy, script, cwd=tmp_path)
