"""Contact surfaces as they are drawn: what a picture and a page are told, and what they say."""

import numpy as np
import pytest
from viewing.scenes import PRESSING, local_scene, registered

from drake_geom_ros.geometry import ArgumentError, QueryObject, Role
from drake_geom_ros.geometry.queries.contact_queries import ContactQueries
from drake_geom_ros.viewing.notebook import show
from drake_geom_ros.viewing.patches import Patches, colours_of, in_pascals

VIEW = {'from_W': [0.3, -0.5, 0.4], 'at_W': [0.0, 0.0, 0.0], 'size': (200, 150)}
NEITHER = """
geometries:
  - {name: one, shape: {type: sphere, radius: 0.05}}
"""


def query_of(text):
    scene_graph = registered(text)
    return QueryObject(scene_graph.CreateDefaultContext())


def test_nothing_is_computed_unless_it_is_wished_for_and_somebody_takes_part(monkeypatch):
    asked = []
    compute = ContactQueries.contacts
    monkeypatch.setattr(
        ContactQueries, 'contacts', lambda self, *a, **k: asked.append(1) or compute(self, *a, **k)
    )
    scene = local_scene(PRESSING)
    moment = scene.moment(0.1, 'exact')
    assert (len(moment.patches), list(moment.remarks), asked) == (0, [], [])
    moment = local_scene(NEITHER).moment(0.1, 'exact', contacts=True)
    assert (len(moment.patches), asked) == (0, [])
    assert moment.remarks == ['no contact surfaces: no geometry has hydroelastic properties']
    assert len(scene.moment(0.1, 'exact', contacts=True).patches) > 0
    assert asked == [1]


def test_patches_are_the_surfaces_of_the_core_and_pairs_without_one_are_named():
    moment = local_scene(PRESSING).moment(0.1, 'exact', contacts=True)
    (surface,) = query_of(PRESSING).ComputeContactSurfacesWithFallback()[0]
    corners = moment.patches.vertices[moment.patches.triangles]
    sides = corners[:, 1:] - corners[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum()
    assert area == pytest.approx(surface.total_area(), rel=1e-12)
    said, missing = moment.remarks
    assert said == (
        '1 contact surface, from no pressure (dark blue) to '
        f'{in_pascals(moment.patches.max_pressure)} (yellow)'
    )
    assert missing == (
        'NOT SHOWN: 1 pair that overlaps without a contact surface: scene::world/table and '
        'scene::bare/bare: one of them has no hydroelastic properties; give it some'
    )


def test_a_picture_has_the_colours_of_the_pressures_and_a_scale():
    query = query_of(PRESSING)
    bare = show(query, see_through=0.4, max_distance=-1.0, **VIEW).pixels.astype(int)
    with pytest.warns(UserWarning, match='NOT SHOWN: 1 pair'):
        shown = show(query, see_through=0.4, max_distance=-1.0, contacts=True, **VIEW)
    drawn = shown.pixels.astype(int)
    changed = (drawn != bare).any(axis=2)
    patch = changed[:-40].nonzero()
    assert 50 < len(patch[0]) < 5000
    # The pressure grows from the edge of the patch to its middle, and so does the colour.
    most = query.contacts().surfaces.max_pressures.max()
    middle = drawn[int(patch[0].mean()), int(patch[1].mean())]
    nearest = np.abs(255.0 * colours_of(np.array([0.0, 0.5, 1.0]), 1.0) - middle).sum(axis=1)
    assert nearest.argmin() == 2
    low = np.abs(drawn - 255.0 * colours_of(np.zeros(1), most)[0]).max(axis=2)[:-40] < 40
    assert low.any()
    assert changed[-18:-8, 8:128].all()  # the scale
    assert not changed[-18:-8, 140:].any()


def test_the_nearer_of_two_patches_is_seen_and_pressures_are_mixed_in_space():
    from drake_geom_ros.math import RigidTransform
    from drake_geom_ros.sensors import CameraInfo
    from drake_geom_ros.viewing.overlays import _seen
    from drake_geom_ros.viewing.snapshot import Camera

    # A triangle that goes away from the camera, and one behind it.
    near = np.array([[-1.0, 0.5, 1.0], [1.0, 0.5, 1.0], [0.0, 0.5, 9.0]])
    far = np.array([[-9.0, -9.0, 20.0], [9.0, -9.0, 20.0], [0.0, 18.0, 20.0]])
    patches = Patches(
        np.concatenate((far, near)),
        np.array([5.0, 5.0, 5.0, 0.0, 0.0, 8.0]),
        np.array([[0, 1, 2], [3, 4, 5]]),
    )
    camera = Camera(RigidTransform(), CameraInfo(101, 101, 1.2))
    at = camera.pixels(patches.vertices)
    found = _seen((101, 101), at, patches.vertices[:, 2], patches)
    assert found[45, 50] == pytest.approx(5.0)
    for depth in (2.0, 5.0):
        column, row = camera.pixels(np.array([[0.0, 0.5, depth]]))[0].astype(int)
        ray = (row + 0.5 - camera.info.center_y()) / camera.info.focal_y()
        assert found[row, column] == pytest.approx(0.5 / ray - 1.0, abs=0.02)


def test_what_cannot_be_shown_is_refused():
    with pytest.raises(ArgumentError, match='has the role kPerception'):
        show(query_of(PRESSING), contacts=True, role=Role.kPerception)


@pytest.mark.parametrize(
    ('pressure', 'words'),
    [(0.0, '0 Pa'), (12.34, '12.3 Pa'), (88_300.0, '88.3 kPa'), (2e6, '2 MPa'), (3e9, '3 GPa')],
)
def test_pressures_in_words(pressure, words):
    assert in_pascals(pressure) == words
