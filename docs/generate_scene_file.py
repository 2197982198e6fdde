"""Writes docs/scene_file.md from the schema of scene files: python docs/generate_scene_file.py."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from bench.pages import table

ROOT = Path(__file__).resolve().parents[1]
SCHEMA = ROOT / 'drake_geom_ros/scene_files/scene.schema.json'
EXAMPLE = ROOT / 'scenes/minimal.yaml'
TARGET = ROOT / 'docs/scene_file.md'
_INTRODUCTION = """# Scene file

Generated from the schema by `python docs/generate_scene_file.py`; a test keeps it up to date. A
scene file is YAML. The smallest useful one lists frames, which move, and geometries, which are
fixed to a frame or to the world:

```yaml
{example}```

`python -m drake_geom_ros check FILE` validates a file without ROS and lists what it contains; an
error names the file, the line and the key. A node loads it by the parameter `scene_file` or by
the service `load_scene`, and `save_scene` writes one. A larger example with two robots is
[scenes/two_pandas.yaml](../scenes/two_pandas.yaml); the schema itself is
[scene.schema.json](../drake_geom_ros/scene_files/scene.schema.json).

{description} Unknown keys are errors. Keys marked with * are required.
"""
# Title of a section and the definition that it describes, in the order of the page.
_SECTIONS = (
    ('Robots', 'robot'),
    ('Frames', 'frame'),
    ('Geometries', 'geometry'),
    ('Poses', 'pose'),
    ('Shapes', 'shape'),
    ('Properties of roles', 'properties'),
    ('Hydroelastic properties', 'hydroelastic'),
    ('Filters', 'filters'),
    ('Sets of geometries', 'set'),
    ('Cameras', 'camera'),
    ('Proximity rules', 'proximity_rule'),
    ('Gates', 'gate'),
    ('Obstacle sources', 'obstacle_source'),
    ('Policies of a subscription', 'source_qos'),
)
# Keys whose value is a mapping with keys of its own.
_PARTS = {'roles': 'Roles', 'group': 'Group', 'clique': 'Clique'}
# What a value of a definition is, in words.
_KINDS = {
    'name': 'text',
    'vector': '3 numbers',
    'lengths': '3 numbers > 0',
    'length': 'number > 0',
    'pose': '[pose](#poses)',
    'shape': '[shape](#shapes)',
    'properties': '[properties](#properties-of-roles)',
    'proximity_properties': '[properties](#properties-of-roles), also '
    '[hydroelastic](#hydroelastic-properties)',
    'hydroelastic': '[hydroelastic properties](#hydroelastic-properties)',
    'filters': 'list of [filters](#filters)',
    'set': '[set](#sets-of-geometries)',
    'two_sets': 'two [sets](#sets-of-geometries)',
    'robot': '[robot](#robots)',
    'frame': '[frame](#frames)',
    'geometry': '[geometry](#geometries)',
    'statement': 'statement',
    'camera': '[camera](#cameras)',
    'frame_name': 'text',
    'proximity_rule': '[proximity rule](#proximity-rules)',
    'obstacle_source': '[obstacle source](#obstacle-sources)',
    'source_padding': 'number, or mapping of patterns to numbers',
    'source_qos': '[policies](#policies-of-a-subscription)',
    'patterns': 'text, or list of texts',
    'decelerations': 'number, list of numbers, or mapping of joints to numbers',
    'gates': '[gate](#gates), or list of these',
}


def page() -> str:
    """Return the text of the page."""
    schema = json.loads(SCHEMA.read_text())
    introduction = _INTRODUCTION.format(
        example=EXAMPLE.read_text(), description=schema['description']
    )
    parts = [introduction, f'## Keys of the file\n\n{_keys(schema)}']
    for title, name in _SECTIONS:
        parts.append(f'## {title}\n\n{_section(name, schema["definitions"])}')
    return '\n'.join(parts)


def _section(name: str, definitions: dict[str, Any]) -> str:
    """Return what a definition says, and a table of its keys where it has any."""
    definition = definitions[name]
    text = definition.get('description', '')
    if name == 'shape':
        return _shapes(definition)
    if name == 'properties':
        return (
            f'{text}\n\nA value is one of these: {_lower(definitions["value"]["description"])}\n'
        )
    if name == 'set':
        return f'{text}\n'
    keys = definition.get('items', definition)
    tables = [_keys(keys)]
    for part, title in _PARTS.items():
        if 'properties' in keys['properties'].get(part, ()):
            tables.append(f'### {title}\n\n{_keys(keys["properties"][part])}')
    return '\n\n'.join([*filter(None, [text]), *(table.rstrip('\n') for table in tables)]) + '\n'


def _shapes(definition: dict[str, Any]) -> str:
    """Return a table of the types of shapes and their keys, and one of the keys of meshes."""
    rows, sections = [], list[str]()
    for rule in definition['allOf']:
        then = rule['then']
        given = rule['if']['properties']['type']
        names = ', '.join(f'`{name}`' for name in given.get('enum', [given.get('const')]))
        properties = {key: value for key, value in then['properties'].items() if key != 'type'}
        if 'uri' in properties:
            title = 'Meshes' if 'vertices' in properties else names
            numbers = next(
                key for key in ('vertices', 'centres', 'positions') if key in properties
            )
            sections += [f'### {title}', '', _keys({**then, 'properties': properties}), '']
            rows.append((names, f'`uri`* or `{numbers}`*, see below'))
            continue
        if any('description' in value for value in properties.values()):
            sections += [f'### {names}', '', _keys({**then, 'properties': properties}), '']
            rows.append((names, ', '.join(f'`{key}`*' for key in properties) + ', see below'))
            continue
        keys = [f'`{key}`* ({kind(value)})' for key, value in properties.items()]
        rows.append((names, ', '.join(keys) or 'none'))
    head = (
        'The key `type`* chooses the shape, and with it the other keys; lengths are in metres.\n'
    )
    return '\n'.join([head, table(('type', 'keys'), rows), *sections[:-1]])


def _keys(definition: dict[str, Any]) -> str:
    """Return the table of the keys of an object."""
    required = definition.get('required', ())
    rows = [
        (f'`{key}`{"*" * (key in required)}', kind(given), given.get('description', ''))
        for key, given in definition['properties'].items()
    ]
    return table(('key', 'value', 'meaning'), rows)


def kind(given: dict[str, Any]) -> str:
    """Return in words what the value of a key is."""
    if '$ref' in given:
        return _KINDS[given['$ref'].rpartition('/')[2]]
    if 'enum' in given:
        return ' or '.join(f'`{value}`' for value in given['enum'])
    types = given['type'] if isinstance(given['type'], list) else [given['type']]
    return ' or '.join(_of_type(name, given) for name in types)


def _of_type(name: str, given: dict[str, Any]) -> str:
    if name == 'array':
        is_fixed = given.get('minItems', 0) == given.get('maxItems')
        count = f'{given["minItems"]} ' if is_fixed else 'list of '
        items = given['items']
        if items.get('type') == 'array':
            return f'{count}lists of {_of_type("array", items).removeprefix("list of ")}'
        return count + {'string': 'texts', 'number': 'numbers', 'integer': 'whole numbers'}.get(
            items.get('type'), _plural(items)
        )
    least = f' >= {given["minimum"]}' if 'minimum' in given else ''
    words = {'string': 'text', 'integer': 'whole number', 'boolean': '`true` or `false`'}
    return words.get(name, 'mapping' if name == 'object' else name) + least


def _plural(items: dict[str, Any]) -> str:
    singular = kind(items)
    irregular = {
        '3 numbers': 'lists of 3 numbers',
        '[geometry](#geometries)': '[geometries](#geometries)',
    }
    return irregular.get(
        singular, singular.replace(']', 's]') if ']' in singular else f'{singular}s'
    )


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]


if __name__ == '__main__':
    TARGET.write_text(page())
