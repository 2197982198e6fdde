"""Validation of documents by JSON schemas (draft 7); the first fault becomes an error."""

import json
from collections.abc import Iterator
from functools import cache
from importlib import resources
from itertools import islice
from typing import Any

from drake_geom_ros.scene_files.yaml_text import Document, KeyPath

_TYPE_NAMES = {
    'object': 'a mapping',
    'array': 'a list',
    'string': 'text (in quotes where it reads as a number)',
    'number': 'a number',
    'integer': 'an integer',
    'boolean': 'true or false',
    'null': 'nothing',
}
# Only one fault is reported, and a long list of nothing but faults would take a minute.
_MOST_FAULTS = 1000
# Characters of a value that a message quotes at most.
_QUOTED = 60


@cache
def read_schema(package: str, name: str) -> dict[str, Any]:
    """Return the schema in the file ``name`` of a package."""
    schema: dict[str, Any] = json.loads((resources.files(package) / name).read_text('utf-8'))
    return schema


def scene_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 7) of scene files."""
    return read_schema('drake_geom_ros.scene_files', 'scene.schema.json')


def check_schema(document: Document, schema: dict[str, Any]) -> None:
    """Raise SceneFileError for the first line at which the document breaks the schema."""
    errors = [document.at(*path).error(why) for path, why in faults(document.value, schema)]
    if errors:
        raise min(errors, key=lambda error: error.line or 0)


def faults(value: Any, schema: dict[str, Any]) -> Iterator[tuple[KeyPath, str]]:
    """Yield the path and the reason of each fault, with the value and the allowed ones."""
    if is_surely_valid(value, schema):
        return
    import jsonschema  # slow to import, and most documents are valid

    violations = islice(jsonschema.Draft7Validator(schema).iter_errors(value), _MOST_FAULTS)
    errors = [part for error in violations for part in _parts(error)]
    unknown = {_rule_for_keys(e) for e in errors if e.validator == 'additionalProperties'}
    for error in errors:
        # A misspelt key is also reported as missing; only the misspelling is shown.
        if error.validator != 'required' or _rule_for_keys(error) not in unknown:
            yield _blamed_path(error), _reason(error)


def is_surely_valid(value: Any, schema: dict[str, Any]) -> bool:
    """Return whether a value is known to be valid; False: jsonschema is to be asked.

    16 000 bodies take a thousandth of jsonschema's time so, and the import a tenth.
    """
    try:
        import jsonschema_rs
    except ImportError:  # rosdep does not have it
        return False
    try:
        return bool(jsonschema_rs.Draft7Validator(schema).is_valid(value))
    except ValueError:  # not of JSON, as a key that is a number
        return False


_PATTERNS = {
    '[^ \\t]': 'a name has at least one character that is not blank',
    '^[A-Za-z][A-Za-z0-9_]*$': 'a source is called by a letter, then letters, digits and _',
    '^leave_out$': 'it must be leave_out, or a mapping {thickness: ...}',
    '^[~A-Za-z_/][A-Za-z0-9_/]*$': 'a topic is called by letters, digits, _ and /; ~ is the node',
}


def _parts(error: Any) -> list[Any]:
    """Return the faults of a value of several forms: those of the form that has its type.

    A value of no form's type is one fault, as is one that two forms of its type refuse.
    """
    if error.validator != 'oneOf':
        return [error]
    forms: dict[int, list[Any]] = {}
    for part in error.context:
        forms.setdefault(part.relative_schema_path[0], []).append(part)
    of_its_type = [
        form
        for form in forms.values()
        if not any(part.validator == 'type' and not part.relative_path for part in form)
    ]
    return of_its_type[0] if len(of_its_type) == 1 else [error]


def _rule_for_keys(error: Any) -> tuple[KeyPath, KeyPath]:
    """Return the path of the faulty mapping, and of the schema rule about its keys."""
    return tuple(error.absolute_path), tuple(error.absolute_schema_path)[:-1]


def _blamed_path(error: Any) -> KeyPath:
    """Return the path of the faulty key; for an unknown key its own path, not its mapping's."""
    path = tuple(error.absolute_path)
    if error.validator == 'additionalProperties':
        return (*path, _unknown_keys(error)[0])
    return path


def _unknown_keys(error: Any) -> list[str]:
    return [key for key in error.instance if key not in error.schema.get('properties', {})]


def _reason(error: Any) -> str:
    """Return the reason of a fault, with the value and the allowed ones."""
    kind, limit, value = error.validator, error.validator_value, error.instance
    if kind is None:  # a schema that is false: the key is for another form of the same thing
        return 'cannot be given together with the other keys that are here'
    if kind == 'required':
        missing = [f'`{key}`' for key in limit if key not in value]
        return f'missing {", ".join(missing)}'
    if kind == 'additionalProperties':
        return f'unknown key; allowed are {", ".join(error.schema["properties"])}'
    if kind == 'not':
        return str(limit['description'])
    if kind == 'oneOf':
        forms = str(error.schema['description']).rstrip('.')
        return f'{_quote(value)} must be {forms[:1].lower()}{forms[1:]}'
    if kind in ('minProperties', 'maxProperties'):
        keys = ', '.join(error.schema.get('properties', ()))
        one = 'exactly' if 'maxProperties' in error.schema else 'at least'
        return f'has {len(value)} keys; give {one} one{" of " if keys else ""}{keys}'
    if kind in ('minItems', 'maxItems'):
        return f'has {len(value)} items; {limit} are needed'
    if kind == 'pattern':
        return f'{_quote(value)}: {_PATTERNS.get(limit, f"it must match {limit}")}'
    return f'{_quote(value)} must be {_wanted(kind, limit)}'


def _wanted(kind: str, limit: Any) -> str:
    if kind == 'type':
        names = [limit] if isinstance(limit, str) else limit
        return ' or '.join(_TYPE_NAMES[name] for name in names)
    if kind == 'enum':
        return f'one of {", ".join(limit)}'
    relation = {'exclusiveMinimum': '>', 'minimum': '>=', 'maximum': '<='}[kind]
    return f'{relation} {limit}'


def _quote(value: Any) -> str:
    if value is None:
        return 'nothing (null)'
    text = repr(value)
    return text if len(text) <= _QUOTED else f'{text[:_QUOTED]}...'
