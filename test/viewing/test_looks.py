"""Colours and layers: one colour a source, unless the scene says another."""

import numpy as np
import pytest
from viewing.scenes import registered

from drake_geom_ros.geometry import ProximityProperties, QueryObject, Role
from drake_geom_ros.viewing.looks import PALETTE, is_drawn, looks_of
from drake_geom_ros.viewing.snapshot import camera_for, picture

TEXT = """
sources: [s, t]
frames: [{name: a, source: s, pose: {}}]
geometries:
  - {name: one, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
  - {name: two, source: s, shape: {type: box, size: [1, 1, 1]}}
  - {name: other, source: t, shape: {type: sphere, radius: 0.1},
     roles: {proximity: {}, illustration: {phong: {diffuse: {rgba: [1, 0, 0, 0.5]}}},
             perception: {}}}
  - {name: floor, source: t, shape: {type: half_space}}
  - {name: solid, source: t, shape: {type: box, size: [1, 1, 1]},
     roles: {proximity: {mesh: {solid: true}}, illustration: {mesh: {solid: true}}}}
"""


def by_name(role):
    found = looks_of(registered(TEXT).model_inspector())
    return {look.name: look for look in found if look.role is role}


def test_each_source_has_a_colour_and_its_own_is_the_first():
    looks = by_name(Role.kProximity)
    assert looks['s::a/one'].colour == looks['s::world/two'].colour
    assert looks['s::a/one'].colour[:3] == PALETTE[0]
    assert looks['t::world/other'].colour[:3] == PALETTE[1]
    assert 0.0 < looks['s::a/one'].colour[3] < 1.0


def test_a_half_space_is_grey_for_it_may_fill_a_picture():
    red, green, blue, cover = by_name(Role.kProximity)['t::world/floor'].colour
    assert red == green == blue
    assert 0.0 < cover < 1.0


def test_a_role_is_a_layer_with_its_own_colour():
    assert by_name(Role.kIllustration)['t::world/other'].colour == (1.0, 0.0, 0.0, 0.5)
    assert by_name(Role.kPerception)['t::world/other'].colour == (*PALETTE[1], 1.0)
    assert 's::a/one' not in by_name(Role.kIllustration)


def test_which_meshes_are_solid_is_a_matter_of_proximity():
    assert by_name(Role.kProximity)['t::world/solid'].solid
    assert not by_name(Role.kIllustration)['t::world/solid'].solid


BALL = '- {name: %s, source: s, pose: {position: [%d,0,0]}, shape: {type: sphere, radius: 1}%s}\n'
HIDDEN = 'sources: [s]\ngeometries:\n' + BALL % ('seen', 0, '')


@pytest.mark.parametrize('accepting', ['""', '{set: [""]}'])
def test_a_geometry_that_is_for_no_renderer_is_in_no_picture(accepting):
    roles = f', roles: {{proximity: {{renderer: {{accepting: {accepting}}}}}}}'
    pixels = []
    for text in (HIDDEN, HIDDEN + BALL % ('hidden', 1, roles), HIDDEN + BALL % ('shown', 1, '')):
        scene = registered(text)
        query = QueryObject(scene.CreateDefaultContext())
        camera = camera_for(query, Role.kProximity, (40, 30), 0.8)
        pixels.append([picture(query, camera, see_through=cover) for cover in (1.0, 0.5)])
        names = [look.name for look in looks_of(scene.model_inspector())]
        assert 's::world/seen' in names
        assert 's::world/hidden' not in names
    assert np.array_equal(pixels[0], pixels[1])
    assert not np.array_equal(pixels[0], pixels[2])


@pytest.mark.parametrize('accepting', ['any', {'any'}, set()])
def test_a_geometry_that_is_for_some_or_all_renderers_is_drawn(accepting):
    properties = ProximityProperties()
    assert is_drawn(properties)
    properties.AddProperty('renderer', 'accepting', accepting)
    assert is_drawn(properties)
