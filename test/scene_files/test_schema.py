import copy
import json
import math
import sys

import jsonschema
import pytest
from conventions.source_tree import PACKAGE, name_of
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.schema import check_schema, is_surely_valid, scene_schema
from drake_geom_ros.scene_files.yaml_text import read_yaml

# Three lines that are right, so that line 4 is to blame.
HEAD = 'geometries:\n- name: a\n  shape: {type: half_space}\n'
GEOMETRY = '- {name: b, shape: {type: %s}}\n'


def check(text):
    check_schema(read_yaml(text, 'arms.yaml'), scene_schema())


@pytest.mark.parametrize('path', sorted(PACKAGE.rglob('*.schema.json')), ids=name_of)
def test_a_schema_is_itself_valid(path):
    jsonschema.Draft7Validator.check_schema(json.loads(path.read_text()))


def test_every_key_of_the_schema_can_be_used():
    check(
        """
name: all
sources: [s]
robots:
- {name: r, urdf: r.urdf, srdf: r.srdf, pose: {position: [1, 2, 3]}, adjacent_links: kept,
   self_collisions: filtered, loaded: false}
frames:
- {name: f, source: s, parent: world, group: 1, pose: {rpy: [0, 0, 1]}}
geometries:
- {name: a, source: s, frame: f, pose: {quaternion: [0, 0, 0, 1]},
   shape: {type: sphere, radius: 0}}
- {name: b, pose: {rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]},
   shape: {type: box, size: [1, 1, 1]}}
- {name: c, shape: {type: capsule, radius: 1, length: 1}, roles: {}}
- {name: d, shape: {type: cylinder, radius: 1, length: 1}}
- {name: e, shape: {type: ellipsoid, semi_axes: [1, 2, 3]}}
- {name: f, shape: {type: half_space}}
- {name: g, shape: {type: convex, uri: g.obj, scale: 2}}
- {name: h, shape: {type: mesh, uri: h.obj, scale: [1, 1, -1]}}
- name: i
  shape: {type: half_space}
  roles:
    proximity: {g: {a: true, b: 1, c: 1.5, d: text, e: [1, x, true], f: {array: [[1, 2], [3, 4]]}}}
    illustration: {phong: {diffuse: {rgba: [0, 0.5, 1, 1]}}}
    perception: {}
filters:
- group: {name: g, members: [f, {source: s, frame: f, geometry: a}], ignores: [universal]}
- clique: {name: c, members: []}
- exclude_within: [a]
- exclude_between: [[a], [b]]
- allow_within: [a]
- allow_between: [[a], [b]]
- declaration: [{exclude_within: [a]}, {allow_between: [[a], [b]]}]
- deactivate: [a]
"""
    )


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (HEAD + GEOMETRY % 'capsule, radius: -1.0, length: 1',
         '4: geometries[1].shape.radius: -1.0 must be > 0'),
        (HEAD + GEOMETRY % 'sphere, radius: -1.0',
         '4: geometries[1].shape.radius: -1.0 must be >= 0'),
        (HEAD + GEOMETRY % 'sphere, radius: big',
         "4: geometries[1].shape.radius: 'big' must be a number"),
        (HEAD + GEOMETRY % 'sphere, radius: true',
         '4: geometries[1].shape.radius: True must be a number'),
        (HEAD + GEOMETRY % 'sphere, radius: ~',
         '4: geometries[1].shape.radius: nothing (null) must be a number'),
        (HEAD + GEOMETRY % 'sphere', '4: geometries[1].shape: missing `radius`'),
        (HEAD + GEOMETRY % 'capsule', '4: geometries[1].shape: missing `radius`, `length`'),
        (HEAD + GEOMETRY % 'sphere, radius: 1, length: 2',
         '4: geometries[1].shape.length: unknown key; allowed are type, radius'),
        (HEAD + GEOMETRY % 'cube',
         "4: geometries[1].shape.type: 'cube' must be one of sphere, box, capsule, cylinder, "
         'ellipsoid, half_space, convex, mesh, height_field, '
         'occupied_cells, point_cloud, polygon'),
        (HEAD + GEOMETRY % 'box, size: [1, 2]',
         '4: geometries[1].shape.size: has 2 items; 3 are needed'),
        (HEAD + GEOMETRY % 'box, size: [1, 2, 3, 4]',
         '4: geometries[1].shape.size: has 4 items; 3 are needed'),
        (HEAD + GEOMETRY % 'box, size: [1, 0, 3]',
         '4: geometries[1].shape.size[1]: 0 must be > 0'),
        (HEAD + '- {name: b, shape: {radius: 1}}', '4: geometries[1].shape: missing `type`'),
        (HEAD + '- {name: b, shape: ball}', "4: geometries[1].shape: 'ball' must be a mapping"),
        (HEAD + '- {name: b}', '4: geometries[1]: missing `shape`'),
        (HEAD + '- {shape: {type: half_space}}', '4: geometries[1]: missing `name`'),
        (HEAD + '- {name: 7, shape: {type: half_space}}',
         '4: geometries[1].name: 7 must be text (in quotes where it reads as a number)'),
        (HEAD + '- {name: " ", shape: {type: half_space}}',
         "4: geometries[1].name: ' ': a name has at least one character that is not blank"),
        # What is misspelt is missing too.
        (HEAD + '- {nam: b, shape: {type: half_space}}',
         '4: geometries[1].nam: unknown key; allowed are name, source, frame, pose, shape, '
         'sensor, roles'),
        (HEAD + '- {name: b, shape: {type: half_space}, colour: red}',
         '4: geometries[1].colour: unknown key; allowed are name, source, frame, pose, shape, '
         'sensor, roles'),
        (HEAD + '- {name: b, shape: {type: half_space}, pose: {rpy: [0, 0, 0], '
         'quaternion: [0, 0, 0, 1]}}',
         '4: geometries[1].pose: give one of rpy, quaternion, rotation'),
        (HEAD + '- {name: b, shape: {type: half_space}, roles: {proximity: {g: {a: ~}}}}',
         '4: geometries[1].roles.proximity.g.a: nothing (null) must be true or false or an '
         'integer or a number or text (in quotes where it reads as a number) or a list or a '
         'mapping'),
        (HEAD + '- {name: b, shape: {type: half_space}, roles: {illustration: {g: {a: '
         '{rgba: [0, 0, 2, 1]}}}}}',
         '4: geometries[1].roles.illustration.g.a.rgba[2]: 2 must be <= 1'),
        (HEAD + 'geometry: []',
         '4: geometry: unknown key; allowed are name, package_roots, sources, robots, awaits, '
         'frames, '
         'geometries, '
         'filters, cameras, obstacle_sources, gate, proximity_rules'),
        (HEAD + 'filters:\n- {exclude_within: [], clique: {}}',
         '5: filters[0]: has 2 keys; give exactly one of group, clique, exclude_within, '
         'exclude_between, allow_within, allow_between, declaration, deactivate'),
        (HEAD + 'filters:\n- exclude_between: [[a]]',
         '5: filters[0].exclude_between: has 1 items; 2 are needed'),
        (HEAD + 'robots:\n- {name: r, urdf: r.urdf, adjacent_links: no}',
         "5: robots[0].adjacent_links: 'no' must be one of filtered, kept"),
        (HEAD + 'frames:\n- {name: r, group: -1}', '5: frames[0].group: -1 must be >= 0'),
        (HEAD + 'frames: {}', '4: frames: {} must be a list'),
        ('just text', "1: 'just text' must be a mapping"),
        ('{}', '1: has 0 keys; give at least one of name, package_roots, sources, robots, awaits, '
         'frames, geometries, '
         'filters, cameras, obstacle_sources, gate, proximity_rules'),
        (HEAD + f'- {{name: b, shape: {[1] * 50}}}',
         '4: geometries[1].shape: [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,... '
         'must be a mapping'),
    ],
)  # fmt: skip
def test_each_kind_of_fault_names_line_key_value_and_what_is_allowed(text, message):
    with pytest.raises(SceneFileError) as caught:
        check(text)
    assert str(caught.value) == f'arms.yaml:{message}'


def test_the_first_fault_of_several_is_told():
    with pytest.raises(SceneFileError) as caught:
        check('filters: 1\nframes: 2\ngeometries: 3\n')
    assert caught.value.line == 1


def closed_to_unknown_keys(schema):
    """Yield the mappings of a schema, and whether each says which keys it takes."""
    if isinstance(schema, dict):
        kinds = schema.get('type', ())
        if isinstance(kinds, str | list) and 'object' in kinds and 'allOf' not in schema:
            yield schema, 'additionalProperties' in schema
        for part in schema.values():
            yield from closed_to_unknown_keys(part)
    elif isinstance(schema, list):
        for part in schema:
            yield from closed_to_unknown_keys(part)


@pytest.mark.parametrize('path', sorted(PACKAGE.rglob('*.schema.json')), ids=name_of)
def test_no_level_of_a_schema_takes_unknown_keys(path):
    levels = list(closed_to_unknown_keys(json.loads(path.read_text())))
    assert len(levels) > 3
    assert [level for level, is_closed in levels if not is_closed] == []


@pytest.mark.parametrize('kind', ['sphere', 'box', 'capsule', 'ellipsoid', 'half_space', 'mesh'])
def test_a_shape_takes_no_unknown_keys(kind):
    uri = ', uri: a.obj' * (kind == 'mesh')
    with pytest.raises(SceneFileError, match='unknown key; allowed are type'):
        check(HEAD + GEOMETRY % f'{kind}{uri}, colour: red')


RIGHT = """
name: all
sources: [s]
robots: [{name: r, urdf: r.urdf, pose: {position: [1, 2, 3]}, adjacent_links: kept}]
frames: [{name: f, source: s, parent: world, group: 1, pose: {rpy: [0, 0, 1]}}]
geometries:
- {name: a, source: s, frame: f, shape: {type: sphere, radius: 0}, roles: {proximity: {}}}
- {name: b, pose: {quaternion: [0, 0, 0, 1]}, shape: {type: box, size: [1, 1, 1]}}
"""
# What JSON does not have, too: YAML does.
ODD = [
    None,
    True,
    0,
    1.0,
    -1,
    math.nan,
    math.inf,
    2**64,
    -(2**200),
    '',
    ' ',
    's',
    [],
    {},
    [1, 2, 3],
]
ODD += [
    {1: 2},
    {None: 1},
    {'position': [1, 2]},
    {'type': 'sphere', 'radius': -1},
    5e-324,
]


def places(value, path=()):
    """Yield the path to each value below one."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        yield (*path, key)
        if isinstance(inner, (dict, list)):
            yield from places(inner, (*path, key))


@given(data=st.data())
def test_what_is_surely_valid_has_no_fault(data):
    value = copy.deepcopy(read_yaml(RIGHT, 'arms.yaml').value)
    for _ in range(data.draw(st.integers(0, 2))):
        *path, key = data.draw(st.sampled_from(list(places(value))))
        inner = value
        for step in path:
            inner = inner[step]
        inner[key] = copy.deepcopy(data.draw(st.sampled_from(ODD)))
    faults = list(jsonschema.Draft7Validator(scene_schema()).iter_errors(value))
    assert not (is_surely_valid(value, scene_schema()) and faults)


def test_a_scene_is_surely_valid_where_the_fast_validator_is_there(monkeypatch):
    value = read_yaml(RIGHT, 'arms.yaml').value
    assert is_surely_valid(value, scene_schema())
    monkeypatch.setitem(sys.modules, 'jsonschema_rs', None)
    assert not is_surely_valid(value, scene_schema())
    check(RIGHT)


def test_a_valid_scene_needs_no_jsonschema(monkeypatch):
    monkeypatch.setitem(sys.modules, 'jsonschema', None)
    check(RIGHT)


@pytest.mark.parametrize(
    ('sets', 'told'),
    [
        ('5', '5 must be a name or a pattern with'),
        ('[a, 5]', '5 must be text'),
        ('[]', 'has 0 items; 1 are needed'),
    ],
)
def test_of_a_value_of_several_forms_the_fault_of_its_own_form_is_told(sets, told):
    rule = f'{{name: r, set_a: {sets}, level: stop, enter: 0.1, leave: 0.2}}'
    with pytest.raises(SceneFileError, match=told):
        check(f'proximity_rules: [{rule}]\n')
