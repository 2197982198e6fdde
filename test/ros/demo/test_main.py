"""The demo as a user starts it: three processes, a table, three files, an exit code."""

import csv
import os
import re
import signal
import subprocess
import sys

import pytest
from ros.harness import ROOT, environment, run_python

pytestmark = pytest.mark.processes

DEMO = 'drake_geom_ros.ros.demo'
PANDA = 'package://example-robot-data/robots/panda_description/urdf/panda_collision.urdf'
SCENE = f"""\
robots:
  - {{name: arm, urdf: "{PANDA}", adjacent_links: kept}}
frames:
  - {{name: ball, source: things, pose: {{position: [0.45, 0.05, 0.5]}}}}
geometries:
  - {{name: ball, source: things, frame: ball, shape: {{type: sphere, radius: 0.06}}}}
  - {{name: floor, source: room, pose: {{position: [0, 0, -0.2]}}, shape: {{type: half_space}}}}
"""
# The hand passes through the ball, which is announced as a grasp meanwhile.
MOTION = """\
robots:
  arm:
    joints: [panda_joint1, panda_joint2, panda_joint4, panda_joint6]
    waypoints:
    - {at: 0.0, q: [-0.5, -0.785, -2.356, 1.571]}
    - {at: 1.0, q: [0.1, -0.785, -2.356, 1.571]}
    - {at: 2.0, q: [-0.5, -0.785, -2.356, 1.571]}
grasps:
- {frame: things::ball, link: arm::panda_hand, start: 0.9, end: 1.1,
   gripper: [arm::panda_hand, arm::panda_leftfinger, arm::panda_rightfinger]}
"""


@pytest.fixture
def files(tmp_path):
    (tmp_path / 'arm.yaml').write_text(SCENE)
    (tmp_path / 'arm_motion.yaml').write_text(MOTION)
    return tmp_path


def _check_files(out):
    for name in ('distances.png', 'closest.png'):
        assert (out / name).read_bytes().startswith(b'\x89PNG')
    with open(out / 'results.csv', newline='') as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 50
    for row in rows:
        if row['depth']:
            assert float(row['depth']) == pytest.approx(-float(row['distance']), abs=1e-12)
    return rows


def test_it_ends_by_itself_and_leaves_its_files(files):
    arguments = '--scene', files / 'arm.yaml', '--seconds', 4, '--out', files / 'out'
    run = run_python('-m', DEMO, *arguments, timeout=800)
    assert run.returncode == 0, run.stdout + run.stderr
    rows = _check_files(files / 'out')
    for word in ('closest pairs', 'arm::panda_hand - things::ball', 'filtered pairs', 'p99'):
        assert word in run.stdout
    assert 'transient filter #' in run.stdout
    # For good, transient, removed again; as often more as the time is enough for.
    assert int(re.search(r'(\d+) filter changes', run.stdout)[1]) >= 3
    # Adjacent links overlap by more than 5 cm until the client has excluded them.
    deep = {row['time'] for row in rows if row['depth'] and float(row['depth']) > 0.05}
    assert len(deep) > 0
    assert max(map(float, deep)) < max(float(row['time']) for row in rows)


def test_its_own_scene_reports_adjacent_links_until_the_client_has_excluded_them(tmp_path):
    run = run_python('-m', DEMO, '--seconds', 4, '--out', tmp_path / 'out', timeout=800)
    assert run.returncode == 0, run.stdout + run.stderr
    with open(tmp_path / 'out/results.csv', newline='') as file:
        assert max(float(row['depth'] or 0.0) for row in csv.DictReader(file)) > 0.05


def test_an_interrupt_ends_it_with_its_files(files):
    process = subprocess.Popen(
        [sys.executable, '-m', DEMO, '--scene', files / 'arm.yaml', '--forever',
         '--out', files / 'out'],
        env=environment(), cwd=ROOT, stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    lines = []
    for line in process.stdout:
        lines.append(line)
        if 'closest pairs' in line and sum('closest pairs' in line for line in lines) == 3:
            os.kill(process.pid, signal.SIGINT)
    assert process.wait() == 0, ''.join(lines)
    _check_files(files / 'out')


def test_a_robot_without_geometries_ends_it_with_the_reason_and_no_files(files):
    bare = '<robot name="bare"><link name="a"/><link name="b"/><joint name="j" type="fixed">'
    (files / 'bare.urdf').write_text(bare + '<parent link="a"/><child link="b"/></joint></robot>')
    scene = files / 'bare.yaml'
    scene.write_text('robots: [{name: bare, urdf: bare.urdf}]\n' + SCENE[SCENE.index('frames:') :])
    arguments = '--scene', scene, '--seconds', 4, '--out', files / 'out'
    run = run_python('-m', DEMO, *arguments, timeout=800)
    assert run.returncode == 1, run.stdout + run.stderr
    assert "say nothing of a robot of the scene file: no source 'bare'" in run.stderr
    assert 'Traceback' not in run.stderr
    assert not (files / 'out' / 'results.csv').exists()


def test_a_wrong_file_is_told_before_anything_starts(tmp_path):
    arguments = '--scene', tmp_path / 'absent.yaml', '--out', tmp_path / 'out'
    run = run_python('-m', DEMO, *arguments)
    assert run.returncode == 2
    assert 'absent.yaml' in run.stderr
    assert not (tmp_path / 'out').exists()


def test_results_of_somebody_else_are_left_alone(tmp_path):
    (tmp_path / 'results.csv').write_text('mine\n')
    run = run_python('-m', DEMO, '--out', tmp_path)
    assert run.returncode == 2
    assert 'not written by this command' in run.stderr
    assert [path.name for path in tmp_path.iterdir()] == ['results.csv']
    assert (tmp_path / 'results.csv').read_text() == 'mine\n'
