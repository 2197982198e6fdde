"""Contact surfaces of many states: to the bit those of fresh contexts; what has none is told."""

import pickle

import numpy as np
import pytest
from batch.floating_bodies import Floating
from batch.test_executors import InProcess

from drake_geom_ros.batch import ContactsOfStates, evaluate, worker
from drake_geom_ros.geometry import (
    AddCompliantHydroelasticProperties,
    AddCompliantHydroelasticPropertiesForHalfSpace,
    AddRigidHydroelasticProperties,
    ArgumentError,
    Box,
    Capsule,
    Cylinder,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    PoseError,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from drake_geom_ros.math import RigidTransform

COMPLIANT, RIGID, NEITHER = 'compliant', 'rigid', 'neither'
BODIES = [
    (HalfSpace(), COMPLIANT),
    (Sphere(0.3), COMPLIANT),
    (Box(0.5, 0.4, 0.3), COMPLIANT),
    (Box(0.9, 0.8, 0.1), RIGID),
    (Cylinder(0.2, 0.5), RIGID),
    (Capsule(0.15, 0.4), NEITHER),
]
OF_SURFACES = {
    'id_M': 'id_M',
    'id_N': 'id_N',
    'area': 'areas',
    'centroid': 'centroids',
    'centre_of_pressure': 'centres_of_pressure',
    'force_on_M_W': 'forces_on_M_W',
    'torque_on_M_Wo_W': 'torques_on_M_Wo_W',
    'max_pressure': 'max_pressures',
}


def properties_of(shape, kind, padding):
    properties = ProximityProperties()
    if kind == RIGID:
        AddRigidHydroelasticProperties(0.2, properties)
    elif kind == COMPLIANT and isinstance(shape, HalfSpace):
        AddCompliantHydroelasticPropertiesForHalfSpace(0.5, 1e5, properties)
    elif kind == COMPLIANT:
        AddCompliantHydroelasticProperties(0.2, 1e5, properties)
    if padding:
        properties.AddProperty('proximity', 'padding', padding)
    return properties


class Pressing(Floating):
    """Bodies that press each other, of all kinds, and some that have no surface."""

    def __init__(self, bodies=BODIES, padding=0.0):
        self.graph, self.ids = SceneGraph(), []
        source = self.graph.RegisterSource('floating')
        for k, (shape, kind) in enumerate(bodies):
            frame = self.graph.RegisterFrame(source, GeometryFrame(f'f{k}'))
            body = GeometryInstance(RigidTransform(), shape, 'body')
            body.set_proximity_properties(properties_of(shape, kind, padding))
            self.graph.RegisterGeometry(source, frame, body)
            self.ids.append(frame)

    def contacts(self, poses):
        """Return the contacts of a context that was never asked before."""
        ids = np.array([frame.get_value() for frame in self.ids])
        context = self.graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector.FromArrays(ids, poses))
        return self.graph.get_query_output_port().Eval(context).contacts()

    def evaluated(self, poses, **given):
        return evaluate(self.graph, self.ids, poses, want='contacts', **given)


@pytest.fixture(scope='module', params=[0.0, 0.02], ids=['plain', 'padded'])
def scene(request):
    return Pressing(padding=request.param)


@pytest.fixture(scope='module')
def states(scene):
    poses = scene.states(np.random.default_rng(3), 40, 0.5)
    poses[3, :, :3] += 20.0 * np.arange(len(BODIES))[:, None]  # nobody touches anybody
    poses[3, 0] = [0, 0, -40, 0, 0, 0, 1]
    return poses


def same(a, b):
    """Tell whether two results are the same to the bit."""
    return all(
        x.dtype == y.dtype and x.tobytes() == y.tobytes() for x, y in zip(a, b, strict=True)
    )


def test_each_state_is_what_a_fresh_context_tells(scene, states):
    found = scene.evaluated(states)
    assert isinstance(found, ContactsOfStates)
    reasons = set()
    for s, poses in enumerate(states):
        surfaces, others, why = scene.contacts(poses)
        rows = slice(*found.offsets[s : s + 2])
        for name, array in OF_SURFACES.items():
            assert getattr(found, name)[rows].tobytes() == getattr(surfaces, array).tobytes(), name
        rows = slice(*found.point_offsets[s : s + 2])
        for name in ('id_A', 'id_B', 'depth', 'error_bound'):
            assert getattr(found, name)[rows].tobytes() == getattr(others, name).tobytes(), name
        assert found.reason[rows].tolist() == why.tolist()
        reasons |= set(why.tolist())
    assert len(found.area) > len(states)
    assert {NoSurface.NO_PROPERTIES, NoSurface.BOTH_RIGID} <= reasons


def test_tables_have_a_row_for_each_overlapping_pair(scene, states):
    found = scene.evaluated(states)
    columns = found.columns()
    surfaces = columns['reason'] == 0
    assert len(surfaces) == len(found.area) + len(found.depth)
    np.testing.assert_array_equal(columns['area'][surfaces], found.area)
    np.testing.assert_array_equal(columns['depth'][~surfaces], found.depth)
    np.testing.assert_array_equal(columns['name_A'][~surfaces], found.name_A)
    counts = np.diff(found.offsets) + np.diff(found.point_offsets)
    np.testing.assert_array_equal(np.bincount(columns['state'], minlength=len(states)), counts)
    assert f'{len(found.area)} surfaces' in found._repr_html_()


def test_tables_of_a_query_name_the_bodies(scene, states):
    surfaces, _, _ = scene.contacts(states[0])
    columns = surfaces.columns()
    assert len(columns['area']) == len(surfaces) > 0
    assert set(columns['name_M']) <= {f'floating::f{k}/body' for k in range(len(BODIES))}
    text = surfaces._repr_html_()
    assert f'the largest {min(10, len(surfaces))}' in text
    assert f'<td>{columns["area"].max():.6g}</td>' in text


@pytest.mark.parametrize('given', [{'threads': 1}, {'threads': 3, 'block_size': 1}])
def test_threads_and_blocks_change_no_bit(scene, states, given):
    assert same(scene.evaluated(states), scene.evaluated(states, **given))


def test_the_order_of_the_states_changes_no_bit(scene, states):
    order = np.random.default_rng(1).permutation(len(states))
    found, shuffled = scene.evaluated(states), scene.evaluated(states[order])
    for at, s in enumerate(order.tolist()):
        mine = slice(*shuffled.offsets[at : at + 2])
        its = slice(*found.offsets[s : s + 2])
        assert shuffled.force_on_M_W[mine].tobytes() == found.force_on_M_W[its].tobytes()


def test_an_executor_changes_no_bit(scene, states):
    """What it is given has gone through another process's door."""
    worker._jobs.clear()

    def run(task, *arguments):
        return pickle.loads(pickle.dumps(task(*pickle.loads(pickle.dumps(arguments)))))

    executor = InProcess(run)
    found = scene.evaluated(states[:12], executor=executor, block_size=5)
    assert executor.jobs_sent > 0
    assert same(found, scene.evaluated(states[:12]))


def test_moduli_are_part_of_the_job_that_a_worker_knows(states):
    """Two scenes that differ in nothing but a stiffness give other forces by one executor."""
    executor, forces = InProcess(), []
    worker._jobs.clear()
    for kind in (COMPLIANT, RIGID):
        scene = Pressing([(Sphere(0.3), COMPLIANT), (Box(0.5, 0.4, 0.3), kind)])
        poses = np.array([[[0, 0, 0.4, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0, 1.0]]])
        forces.append(scene.evaluated(poses, executor=executor).force_on_M_W[0, 2])
    assert forces[1] > forces[0] > 0.0


def test_areas_by_state_are_never_without_what_has_no_surface(scene, states):
    found = scene.evaluated(states)
    assert len(found.id_A)
    first = int(np.flatnonzero(np.diff(found.point_offsets))[0])
    with pytest.raises(GeometryError, match=rf'state {first} floating::.* have no surface'):
        found.total_areas()
    areas = found.total_areas(with_fallback=True)
    assert areas[3] == 0.0
    for s in range(len(states)):
        rows = slice(*found.offsets[s : s + 2])
        assert areas[s] == pytest.approx(found.area[rows].sum(), rel=1e-14)


def test_areas_where_all_that_overlaps_presses():
    scene = Pressing([(Sphere(0.3), COMPLIANT), (HalfSpace(), RIGID)])
    poses = np.zeros((3, 2, 7))
    poses[..., 6], poses[:, 0, 2] = 1.0, [0.4, 0.28, 0.25]
    found = scene.evaluated(poses)
    areas = found.total_areas()
    assert areas[0] == 0.0
    assert 0.0 < areas[1] < areas[2]
    assert found.name_M.tolist() == ['floating::f0/body'] * 2
    assert found.name_N.tolist() == ['floating::f1/body'] * 2
    np.testing.assert_allclose(found.centre_of_pressure[:, :2], 0.0, rtol=0, atol=1e-3)


def test_no_states(scene, states):
    found = scene.evaluated(states[:0])
    assert found.offsets.tolist() == found.point_offsets.tolist() == [0]
    assert found.force_on_M_W.shape == (0, 3)
    assert found.total_areas().shape == (0,)


def test_what_cannot_be_asked_is_refused(scene, states):
    with pytest.raises(ArgumentError, match=r'max_distance=0\.1'):
        scene.evaluated(states, max_distance=0.1)
    with pytest.raises(ArgumentError, match='by_joints'):
        scene.evaluated(states, by_joints=True)
    broken = states.copy()
    broken[7, 2, 3:] = 0.0
    with pytest.raises(PoseError, match='State 7'):
        scene.evaluated(broken)
    nobody = Pressing([(Sphere(0.3), NEITHER), (Sphere(0.3), NEITHER)])
    with pytest.raises(GeometryError, match='no geometry has hydroelastic properties'):
        nobody.evaluated(nobody.states(np.random.default_rng(0), 2, 0.1))
