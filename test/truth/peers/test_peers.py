"""What can be asked of peers: the same question in the same conventions, of those installed."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from oracles.solids import surface_of

from drake_geom_ros.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, HalfSpace, Sphere
from drake_geom_ros.geometry.meshes.source import MeshData
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth import peers
from truth.bodies.random_bodies import box_corners

CUBE = Convex.FromMeshData(MeshData(box_corners()))
L_SHAPE = peers.SolidMesh.FromMeshData(surface_of('L'))
SHAPES = (Sphere(0.5), Box(1, 1, 1), Capsule(0.5, 1), Cylinder(0.5, 1), Ellipsoid(0.5, 0.6, 0.7))
# Each is 0.5 long in x: it stands at the origin, and a cube of edge 1 to the right of it.
QUARTER = RotationMatrix.MakeZRotation(np.pi / 2)
SETTINGS = 1e-4  # [m] which peers keep at their own settings in these plain poses

installed = pytest.mark.parametrize('name', peers.installed())


def question(shape, distance, swapped):
    """Return shapes and poses so that A and B are `distance` apart, along x."""
    bodies = [
        (shape, RigidTransform()),
        (CUBE, RigidTransform(QUARTER, [1.0 + distance, 0.01, 0.02])),
    ]
    (a, X_WA), (b, X_WB) = reversed(bodies) if swapped else bodies
    return (a, b), (X_WA, X_WB), np.array([1.0 if swapped else -1.0, 0.0, 0.0])


def safe(name):
    """Return the queries that do not end or hang the process of these tests."""
    return peers.QUERIES if name != 'python-fcl' else ['penetration']


@pytest.mark.processes  # of the peers that are asked in one
@installed
@pytest.mark.parametrize('swapped', [False, True])
@pytest.mark.parametrize('shape', [*SHAPES, CUBE], ids=lambda shape: type(shape).__name__)
def test_signs_and_order_are_ours(name, shape, swapped):
    peer = peers.load(name)
    shapes, poses, nhat_BA_W = question(shape, -0.1, swapped)
    for query in safe(name):
        answer = peer.pair(query, *shapes)(*poses)
        assert answer.distance == pytest.approx(-0.1, abs=SETTINGS)
        if answer.nhat_BA_W is not None:
            np.testing.assert_allclose(answer.nhat_BA_W, nhat_BA_W, rtol=0, atol=10 * SETTINGS)
        if answer.p_WCa is not None:
            gap = answer.distance * nhat_BA_W
            np.testing.assert_allclose(
                answer.p_WCa - answer.p_WCb, gap, rtol=0, atol=10 * SETTINGS
            )


@installed
def test_no_contact_is_none_and_a_prepared_pair_forgets_the_last_poses(name):
    peer = peers.load(name)
    shapes, apart, _ = question(Sphere(0.5), 0.1, False)
    _, overlapping, _ = question(Sphere(0.5), -0.1, False)
    ask = peer.pair('penetration', *shapes)
    assert [ask(*poses) is None for poses in (apart, overlapping, apart)] == [True, False, True]


@pytest.mark.parametrize('name', sorted({*peers.installed()} & {'Coal', 'python-fcl'}))
def test_a_solid_mesh_is_its_triangles_to_some(name):
    ball = Sphere(0.1)
    ask = peers.load(name).pair('signed_distance', ball, L_SHAPE)
    in_the_notch, inside = RigidTransform([1.5, 1.6, 0.5]), RigidTransform([0.5, 0.5, 0.5])
    assert ask(in_the_notch, RigidTransform()).distance == pytest.approx(0.4)
    # A surface has no inside.
    assert ask(inside, RigidTransform()).distance == pytest.approx(0.4)
    contacts = peers.load(name).pair('penetration', ball, L_SHAPE)
    assert contacts(in_the_notch, RigidTransform()) is None
    assert contacts(RigidTransform([1.05, 1.5, 0.5]), RigidTransform()).distance < 0.0


@pytest.mark.parametrize('name', sorted({*peers.installed()} & {'MuJoCo', 'pydrake'}))
def test_a_solid_mesh_is_its_hull_to_others(name):
    ask = peers.load(name).pair('signed_distance', Sphere(0.1), L_SHAPE)
    # The hull's face leads from (2, 1) to (1, 2).
    found = ask(RigidTransform([1.5, 1.6, 0.5]), RigidTransform())
    assert found.distance == pytest.approx(0.1 / 2**0.5 - 0.1, abs=SETTINGS)


@installed
@pytest.mark.parametrize('flipped', [False, True])
def test_half_spaces(name, flipped):
    bodies = [(HalfSpace(), RigidTransform([0, 0, 1])), (Sphere(0.5), RigidTransform([3, 0, 1.1]))]
    (a, X_WA), (b, X_WB) = reversed(bodies) if flipped else bodies
    peer = peers.load(name)
    for query in safe(name):
        answer = peer.pair(query, a, b)(X_WA, X_WB)
        assert answer.distance == pytest.approx(-0.4, abs=1e-9)


@pytest.mark.parametrize('name', sorted({*peers.installed()} & {'Coal', 'MuJoCo'}))
def test_a_tolerance_reaches_the_peer(name):
    shapes = Ellipsoid(0.3, 0.2, 0.1), Ellipsoid(0.1, 0.3, 0.2)
    poses = RigidTransform(), RigidTransform(QUARTER, [0.3, 0.5, 0.4])
    coarse, fine = (
        peers.load(name, tolerance).pair('signed_distance', *shapes)(*poses).distance
        for tolerance in (0.1, 1e-9)
    )
    assert 1e-8 < abs(coarse - fine) < 0.2


@pytest.mark.parametrize('name', sorted({*peers.installed()} & {'pydrake', 'python-fcl'}))
def test_a_tolerance_that_cannot_be_set_is_refused(name):
    with pytest.raises(peers.Unsupported, match='cannot be set'):
        peers.load(name, 0.1)


@installed
def test_another_query_is_refused(name):
    with pytest.raises(peers.Unsupported, match="query = 'depth'"):
        peers.load(name).pair('depth', Sphere(1), Sphere(1))


def test_names_and_versions():
    assert peers.names() == ('pydrake', 'python-fcl', 'Coal', 'MuJoCo')
    assert set(peers.installed()) <= set(peers.names())
    assert all(peers.version(name)[0].isdigit() for name in peers.installed())
    with pytest.raises(peers.Unsupported, match='no peer is called'):
        peers.load('bullet')


def test_a_peer_that_is_not_installed_is_named(monkeypatch):
    monkeypatch.setattr('truth.peers.registry.find_spec', lambda _: None)
    assert peers.installed() == ()
    with pytest.raises(peers.Unsupported, match='MuJoCo is not installed here: pip install'):
        peers.load('MuJoCo')


@pytest.mark.processes
def test_no_peer_is_imported_before_it_is_loaded():
    script = (
        'import sys; from truth import peers; peers.installed();'
        'print({"pydrake", "fcl", "coal", "mujoco"} & set(sys.modules))'
    )
    command, folder = [sys.executable, '-c', script], Path(__file__).parents[2]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.stdout.strip() == 'set()', done.stderr
