from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import ProximityProperties, Role, Sphere
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    DeactivationDescription,
    DeclarationDescription,
    FrameDescription,
    GeometryDescription,
    GroupDescription,
    Member,
    Operation,
    RobotDescription,
    SceneDescription,
    Statement,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.yaml_text import read_yaml
from drake_geom_ros.scene_files.yaml_writer import to_yaml

PROXIMITY = {Role.kProximity: ProximityProperties()}
F, G = Member('s', 'f'), Member('s', 'world', 'g')


def scene():
    return SceneDescription(
        sources=('s', 'r'),
        robots=(
            RobotDescription('r', Path('/r.urdf'), RigidTransform([1, 2, 3]), Path('/r.srdf')),
        ),
        frames=(
            FrameDescription('s', 'f', 'world', 2, RigidTransform([0, 0, 1])),
            FrameDescription('s', 'h', 'f'),
            FrameDescription('r', 'f', X_PF=RigidTransform()),
        ),
        geometries=(
            GeometryDescription('s', 'world', 'g', Sphere(1.5), RigidTransform(), PROXIMITY),
            GeometryDescription('s', 'f', 'n', Sphere(1.0), RigidTransform([1, 0, 0]), {}),
        ),
        filters=(
            GroupDescription('a', (F,), ('b', 'universal')),
            GroupDescription('b', (G,)),
            CliqueDescription('c', (F, G)),
            DeclarationDescription((Statement(Operation.EXCLUDE_BETWEEN, (F,), (G,)),)),
            DeclarationDescription(
                (
                    Statement(Operation.ALLOW_WITHIN, (F, G)),
                    Statement(Operation.EXCLUDE_WITHIN, (G,)),
                )
            ),
            DeactivationDescription((G,)),
        ),
    )


def test_a_line_for_each_thing():
    assert (
        to_yaml(scene())
        == """\
sources:
- s
- r
robots:
- {name: r, urdf: /r.urdf, srdf: /r.srdf, pose: {position: [1.0, 2.0, 3.0]}, loaded: true}
frames:
- {name: f, source: s, group: 2, pose: {position: [0.0, 0.0, 1.0]}}
- {name: h, source: s, parent: f}
- {name: f, source: r, pose: {}}
geometries:
- {name: g, source: s, shape: {type: sphere, radius: 1.5}}
- {name: n, source: s, frame: f, pose: {position: [1.0, 0.0, 0.0]}, shape: {type: sphere, \
radius: 1.0}, roles: {}}
filters:
- {group: {name: a, members: ['s::f'], ignores: [b, universal]}}
- {group: {name: b, members: ['s::world/g']}}
- {clique: {name: c, members: ['s::f', 's::world/g']}}
- {exclude_between: [['s::f'], ['s::world/g']]}
- {declaration: [{allow_within: ['s::f', 's::world/g']}, {exclude_within: ['s::world/g']}]}
- {deactivate: ['s::world/g']}
"""
    )


def test_a_scene_of_nothing_is_still_a_scene():
    text = to_yaml(SceneDescription())
    assert text == 'sources: []\n'
    assert read_yaml(text, 'a.yaml').value == {'sources': []}


@given(st.text(min_size=1), st.text(min_size=1))
def test_any_name_is_read_as_it_was(source, frame):
    description = SceneDescription(sources=(source,), frames=(FrameDescription(source, frame),))
    value = read_yaml(to_yaml(description), 'a.yaml').value
    assert value['sources'] == [source]
    assert value['frames'][0]['name'] == frame


@pytest.mark.parametrize('name', ['true', 'null', '~', '', '1', '1e-3', '.5', '-', '-.inf', '+a'])
def test_names_that_look_like_something_else_are_in_quotes(name):
    description = SceneDescription(sources=(name, 'a'))
    assert read_yaml(to_yaml(description), 'a.yaml').value == {'sources': [name, 'a']}


def test_what_the_format_cannot_say_is_refused():
    properties = ProximityProperties()
    properties.AddProperty('g', 'odd', object())
    roles = {Role.kProximity: properties}
    geometry = GeometryDescription('s', 'world', 'g', Sphere(1.0), RigidTransform(), roles)
    with pytest.raises(SceneFileError, match="cannot be saved: property 'odd'"):
        to_yaml(SceneDescription(geometries=(geometry,)))
