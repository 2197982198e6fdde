"""The models in examples/models: each loads, and its pairs have the distances that it shows."""

import warnings

import numpy as np
import pytest
from conventions.source_tree import ROOT
from oracles.like_drake import compared

from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.geometry import Role
from drake_geom_ros.scene_files import read_scene, to_yaml

FOLDER = ROOT / 'examples/models'
MODELS = sorted(path.name for path in FOLDER.iterdir() if path.suffix != '.png')
# Sources, frames, geometries that distances are measured of, and the least distance [m].
FACTS = {
    'arm.urdf': (1, 3, 3, 0.25 * 5.0**0.5),
    'bracket.obj': (1, 1, 1, None),
    'cart.sdf': (1, 3, 3, 0.35),
    'cell.dmd.yaml': (2, 6, 6, None),
    'hills.sdf': (1, 2, 2, None),
    'hopper.xml': (1, 3, 4, None),
    'terrain.yaml': (2, 3, 4, None),
    'yard.world': (3, 5, 5, 0.05),
}


def posed(name):
    if name.endswith('.xml'):
        pytest.importorskip('mujoco', exc_type=ImportError)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        return OpenedScene(str(FOLDER / name))


def test_each_kind_of_model_is_here():
    assert sorted(FACTS) == MODELS


@pytest.mark.parametrize('name', MODELS)
def test_a_model_loads_whole_and_without_contact(name):
    scene = posed(name)
    sources, frames, geometries, least = FACTS[name]
    description, inspector = scene.description, scene.inspector
    assert (len(description.sources), len(description.frames)) == (sources, frames)
    assert inspector.NumGeometriesWithRole(Role.kProximity) == geometries
    assert scene.query.waiting_frames() == []
    assert not scene.query.HasCollisions()
    distances = scene.query.ComputeSignedDistancePairwiseClosestPoints().distance
    if least is not None:
        assert distances.min() == pytest.approx(least, abs=1e-9)


@pytest.mark.parametrize('name', MODELS)
def test_a_model_is_written_as_a_scene_file_and_read_again(name):
    scene = posed(name)
    again = read_scene(to_yaml(scene.description))
    assert [g.name for g in again.geometries] == [g.name for g in scene.description.geometries]


@pytest.mark.parametrize('name', ['arm.urdf', 'cart.sdf', 'cell.dmd.yaml'])
def test_a_model_is_that_of_pydrake(name):
    pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        lines = compared(FOLDER / name, [ROOT])
    assert [line for line in lines if 'distance' not in line] == []


def test_the_hills_are_as_high_as_their_image_is_bright():
    """The brightest pixel is (23, 11) of (33, 33), rows from the largest y down."""
    query = posed('hills.sdf').query
    top = np.array([-2.0 + 4.0 * 22 / 32, 2.0 - 4.0 * 11 / 32, 0.8])
    distances = query.ComputeSignedDistanceToPoint(top[None]).distance
    assert min(distances) == pytest.approx(0.0, abs=1e-12)  # the mast is farther away


def test_the_terrain_is_beneath_the_arm():
    query = posed('terrain.yaml').query
    (terrain,) = (
        id
        for id in query.inspector().GetAllGeometryIds()
        if query.inspector().GetName(id) == 'terrain'
    )
    above = query.ComputeSignedDistanceToPoint(np.array([[0.5, 0.0, -0.3]]))
    assert above.distance[above.id_G == terrain.get_value()] == pytest.approx([0.0], abs=1e-12)
