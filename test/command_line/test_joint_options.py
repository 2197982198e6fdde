"""``check`` and ``query`` at joint values: links stand where these put them."""

import csv

import numpy as np
import pytest
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM, expected

from drake_geom_ros.command_line.program import main
from drake_geom_ros.math import RigidTransform

X_WB = RigidTransform([1.0, 2.0, 3.0])
Q = (0.5, -0.3, 0.02)
GIVEN = [f'arm::{name}={value}' for name, value in zip(JOINTS_OF_ARM, Q, strict=True)]


@pytest.fixture
def scene(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    path = tmp_path / 'cell.yaml'
    path.write_text(
        'robots: [{name: arm, urdf: arm.urdf, pose: {position: [1, 2, 3]}, '
        'configuration: {shoulder: 0.5}}]\n'
        'geometries: [{name: post, shape: {type: sphere, radius: 0.1}}]\n'
    )
    return str(path)


def places(lines):
    """Return where the listed frames are, by name."""
    rows = (line.split(' at ') for line in lines if ' in world at ' in line)
    return {name.split()[0]: np.array(place.split(), dtype=float) for name, place in rows}


def test_check_lists_links_at_joint_values(scene, capsys):
    assert main(['check', scene, '--joints', *GIVEN[1:]]) == 0
    found = places(capsys.readouterr().out.splitlines())
    for link, X_WL in expected(Q, X_WB).items():
        np.testing.assert_allclose(found[f'arm::{link}'], X_WL[:3, 3], rtol=0, atol=1e-5)


def test_query_answers_at_joint_values(scene, capsys):
    assert main(['query', scene, '--joints', *GIVEN]) == 0
    rows = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    links = expected(Q, X_WB)
    post = {
        row['geometry_b' if 'post' in row['geometry_a'] else 'geometry_a']: row
        for row in rows
        if 'post' in row['geometry_a'] + row['geometry_b']
    }
    assert len(post) == len(links)
    for link, X_WL in links.items():
        row = post[f'arm::{link}/collision_0']
        assert float(row['distance']) == pytest.approx(np.linalg.norm(X_WL[:3, 3]) - 0.2)


@pytest.mark.parametrize('command', ['check', 'query'])
def test_what_is_no_joint_is_refused(scene, capsys, command):
    assert main([command, scene, '--joints', 'elbow=1']) != 0
    assert "'elbow': no joint is called so" in capsys.readouterr().err
    assert main([command, scene, '--joints', 'shoulder=3']) == 0
    assert 'warning: arm::shoulder is outside its limits [-1, 2]' in capsys.readouterr().err
