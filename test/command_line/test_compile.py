"""`compile`: a scene's kernels in parts, for two processes; and where `ros2 run` finds it."""

import os
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

SCENE = ROOT / 'scenes/two_pandas.yaml'


def compiled(*arguments, **variables):
    command = [sys.executable, '-m', 'drake_geom_ros', 'compile', *map(str, arguments)]
    environment = {**os.environ, **variables}
    return subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=ROOT, env=environment
    )


@pytest.mark.processes
@pytest.mark.timeout(1200)
def test_the_parts_of_a_scene_are_all_that_it_needs():
    kernels = compiled(SCENE, '--part', 'kernels')
    assert kernels.returncode == 0, kernels.stderr
    assert '0 kernels' not in kernels.stdout
    cycle = compiled(SCENE, '--part', 'cycle')
    assert cycle.returncode == 0, cycle.stderr
    assert ' 0 kernels are ready' in cycle.stdout
    whole = compiled(SCENE)
    assert 'compiling' not in whole.stdout


@pytest.mark.processes
def test_a_part_needs_a_scene():
    refused = compiled('--part', 'cycle')
    assert refused.returncode == 2
    assert 'compile --part cycle needs a scene' in refused.stderr


def test_an_unknown_part_is_named(scene_context):
    with pytest.raises(ValueError, match="part 'half' is none of 'all', 'cycle', 'kernels'"):
        scene_context.compile_kernels(part='half')


@pytest.fixture
def scene_context():
    from drake_geom_ros.geometry import SceneGraph

    return SceneGraph().CreateDefaultContext()


@pytest.mark.packaging
@pytest.mark.processes
def test_ros2_run_finds_the_programs_that_are_no_console_scripts(tmp_path):
    command = [sys.executable, 'setup.py', '-q', 'egg_info', '-e', str(tmp_path)]
    command += ['install_data', '-d', str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    programs = tmp_path / 'lib/drake_geom_ros'
    assert {path.name for path in programs.iterdir()} == {'compile', 'record', 'status'}
    assert all(os.access(path, os.X_OK) for path in programs.iterdir())
