"""Safe YAML reader: plain values with the line of each, for untrusted text.

The text is read as a stream of events with an explicit stack, so depth costs no recursion. These
are refused, each with its line: aliases (a few lines can stand for gigabytes), tags (they name
Python types), duplicate keys (the last would win silently), numbers that are not finite, a
second document, text over ``MAX_BYTES`` and nesting over ``MAX_DEPTH``.

Plain scalars follow the core schema of YAML 1.2: ``on`` and ``1:30`` are text, ``1e-3`` is a
number. PyYAML's own rules are those of 1.1, where these are true, 90 and text.
"""

import math
import re
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

import yaml

from drake_geom_ros.common.freeing import free_in_pieces
from drake_geom_ros.scene_files.errors import Location, SceneFileError

# A scene of 5000 geometries takes 1.5 MB.
MAX_BYTES = 16_000_000
# The format nests 6 deep.
MAX_DEPTH = 32
# Values without keys; reading and checking so many takes about ten seconds.
MOST_VALUES = 500_000
# Items of one list.
MOST_ITEMS = 100_000
# Longest integer that is converted: one digit more than 64 bits can hold, and a sign.
MAX_INTEGER_CHARACTERS = 21

_LOADER = getattr(yaml, 'CBaseLoader', yaml.BaseLoader)
_DEFAULT_TAGS = (None, '', '!')
_INTEGER = re.compile(r'[-+]?[0-9]+')
_FLOAT = re.compile(r'[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?')
_NOT_FINITE = re.compile(r'[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)')
_NUMBER_LIKE = re.compile(r'[-+.0-9]')  # how all numbers start
_WORDS = {
    **dict.fromkeys(('', '~', 'null', 'Null', 'NULL'), None),
    **dict.fromkeys(('true', 'True', 'TRUE'), True),
    **dict.fromkeys(('false', 'False', 'FALSE'), False),
}

KeyPath = tuple[str | int, ...]


def key_text(path: KeyPath) -> str:
    """Return a path as it is written in messages, for example ``geometries[3].shape.radius``."""
    text = ''
    for step in path:
        if isinstance(step, int):
            text += f'[{step}]'
        else:
            text += f'.{step}' if text else step
    return text


@dataclass(frozen=True)
class Document:
    """The value of a YAML text, the line of each part of it, and the tags of those with one."""

    file: str
    value: Any
    lines: dict[KeyPath, int]
    tags: dict[KeyPath, str] = field(default_factory=dict)

    def at(self, *path: str | int) -> Location:
        """Return the place of a part; if it is missing, the line of the nearest enclosing one.

        Raises KeyError for a document that was emptied.
        """
        present = path
        while present and present not in self.lines:
            present = present[:-1]
        return Location(self.file, self.lines[present], key_text(path))

    def free(self) -> None:
        """Empty a document that is read, in pieces: in one go 16 000 bodies take 27 ms."""
        sections = [each for each in self.value.values() if isinstance(each, list)]
        items = [item for section in sections for item in section]
        del sections
        self.value.clear()
        free_in_pieces(items)
        while self.lines:
            self.lines.popitem()


@dataclass
class _Open:
    """A mapping or a sequence whose end has not been read."""

    path: KeyPath
    value: dict[str, Any] | list[Any]
    key: str | None = None  # of a mapping: the key whose value comes next


def text_of(data: bytes, file: str) -> str:
    """Return the text of a file; raises SceneFileError, with the line, if it is not UTF-8."""
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        line = data.count(b'\n', 0, error.start) + 1
        reason = f'byte {data[error.start]:#x} is not UTF-8; save the file as UTF-8'
        raise SceneFileError(reason, file, line) from None


def read_yaml(
    text: str,
    file: str,
    most_items: float = math.inf,
    tags: Collection[str] = (),
    aliases: bool = False,
) -> Document:
    r"""Return the only document of ``text``; errors call it ``file``.

    ``tags`` are those that mappings and lists may have, for example ``!Rpy``; with ``aliases``
    values may be repeated by anchors and aliases, each counted as if written out. Raises
    SceneFileError for text that is not YAML, for everything that the module refuses, and, before
    the rest is read, for a list of more than ``most_items``.

    >>> document = read_yaml('frames:\n- {name: cup, group: 2}', 'cups.yaml')
    >>> document.value
    {'frames': [{'name': 'cup', 'group': 2}]}
    >>> str(document.at('frames', 0, 'group').error('...'))
    'cups.yaml:2: frames[0].group: ...'
    """
    size = len(text.encode(errors='surrogatepass'))
    if size > MAX_BYTES:
        raise SceneFileError(f'{size} bytes; at most {MAX_BYTES} are read', file)
    builder = _Builder(file, most_items, tags, aliases)
    try:
        for event in yaml.parse(text, Loader=_LOADER):
            builder.take(event)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        # At the end of the text libyaml counts one line more than there is.
        line = min(mark.line, text.count('\n')) + 1 if mark else None
        raise SceneFileError(f'not YAML: {error.problem or error.context}', file, line) from error
    except (yaml.YAMLError, UnicodeError) as error:
        reason = ' '.join(str(error).split())
        raise SceneFileError(f'not YAML: {reason}', file) from error
    if not builder.documents:
        raise SceneFileError('is empty; a scene has at least one of its keys', file)
    return Document(file, builder.root, builder.lines, builder.tags)


class _Builder:
    """Builder of the value from the parser's events."""

    def __init__(
        self, file: str, most_items: float, allowed_tags: Collection[str], with_aliases: bool
    ):
        self.file = file
        self.tags: dict[KeyPath, str] = {}
        self._most_items = most_items
        self._allowed_tags = allowed_tags
        self._anchors: dict[str, KeyPath] | None = {} if with_aliases else None
        self.root: Any = None
        self.lines: dict[KeyPath, int] = {}
        self.documents = 0
        self._values = 0
        self._open: list[_Open] = []

    def take(self, event: yaml.Event) -> None:
        """Process the next event."""
        line = event.start_mark.line + 1
        if isinstance(event, yaml.DocumentStartEvent):
            self.documents += 1
            if self.documents > 1:
                raise Location(self.file, line).error('a second document; a file holds one scene')
        elif isinstance(event, yaml.AliasEvent):
            self._repeat(event, line)
        elif isinstance(event, yaml.ScalarEvent):
            self._take_scalar(event, line)
        elif isinstance(event, yaml.MappingStartEvent):
            self._start(event, {}, line)
        elif isinstance(event, yaml.SequenceStartEvent):
            self._start(event, [], line)
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            self._open.pop()

    def _repeat(self, event: yaml.AliasEvent, line: int) -> None:
        """Add the mapping or list that an alias stands for once more."""
        place = self._place(line)
        source = (self._anchors or {}).get(event.anchor)
        if source is None:
            raise place.error(f'alias *{event.anchor}; write the value out')
        if any(opened.path == source for opened in self._open):
            raise place.error(f'alias *{event.anchor} holds itself')
        value = self.root
        for step in source:
            value = value[step]
        path = self._next_path()
        copied = {p: p[len(source) :] for p in self.lines if p[: len(source)] == source}
        self._values += len(copied)
        for inner, rest in copied.items():
            self.lines[(*path, *rest)] = self.lines[inner]
            if inner in self.tags:
                self.tags[(*path, *rest)] = self.tags[inner]
        self._add(value, line)

    def _which_tags(self) -> str:
        if not self._allowed_tags:
            return 'a scene has no tags'
        return f'mappings and lists may have {", ".join(sorted(self._allowed_tags))}'

    def _place(self, line: int) -> Location:
        """Return the place of the next value, for an error."""
        return Location(self.file, line, key_text(self._next_path()))

    def _next_path(self) -> KeyPath:
        if not self._open:
            return ()
        top = self._open[-1]
        if isinstance(top.value, list):
            return (*top.path, len(top.value))
        return top.path if top.key is None else (*top.path, top.key)

    def _expects_key(self) -> bool:
        return (
            bool(self._open)
            and isinstance(self._open[-1].value, dict)
            and (self._open[-1].key is None)
        )

    def _start(self, event: yaml.Event, value: dict[str, Any] | list[Any], line: int) -> None:
        place = self._place(line)
        if event.tag not in _DEFAULT_TAGS and event.tag not in self._allowed_tags:
            raise place.error(f'tag {event.tag}; {self._which_tags()}')
        if self._expects_key():
            raise place.error('a key must be text, not a list or a mapping')
        if len(self._open) == MAX_DEPTH:
            raise place.error(f'nested more than {MAX_DEPTH} deep')
        path = self._next_path()
        if event.tag not in _DEFAULT_TAGS:
            self.tags[path] = event.tag
        if self._anchors is not None and event.anchor:
            self._anchors[event.anchor] = path
        self._add(value, line)
        self._open.append(_Open(path, value))

    def _take_scalar(self, event: yaml.ScalarEvent, line: int) -> None:
        place = self._place(line)
        if event.tag not in _DEFAULT_TAGS:
            raise place.error(f'tag {event.tag}; {self._which_tags()}')
        if self._expects_key():
            self._take_key(event.value, line, place)
        else:
            plain = event.implicit[0]  # neither quoted nor tagged
            self._add(_plain_value(event.value, place) if plain else event.value, line)

    def _take_key(self, key: str, line: int, place: Location) -> None:
        top = self._open[-1]
        if key in top.value:
            first = self.lines[(*top.path, key)]
            raise place.error(f'key {key!r} is listed twice, first in line {first}')
        self.lines[(*top.path, key)] = line
        top.key = key

    def _add(self, value: Any, line: int) -> None:
        self._values += 1
        if self._values > MOST_VALUES:
            raise self._place(line).error(f'more than {MOST_VALUES} values in one file')
        # A value in a mapping already has the line of its key.
        self.lines.setdefault(self._next_path(), line)
        if not self._open:
            self.root = value
            return
        top = self._open[-1]
        if isinstance(top.value, list):
            if len(top.value) >= self._most_items:
                place = Location(self.file, line, key_text(top.path))
                raise place.error(f'has more than {self._most_items} items')
            top.value.append(value)
        elif top.key is not None:
            top.value[top.key] = value
            top.key = None


def is_text_without_quotes(text: str) -> bool:
    """Return whether a text reads back as the same text if written without quotes."""
    return text.isprintable() and text not in _WORDS and not _NUMBER_LIKE.match(text)


def _plain_value(text: str, place: Location) -> Any:
    """Return the value of a scalar without quotes."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        if len(text) > MAX_INTEGER_CHARACTERS or not -(2**63) <= int(text) < 2**63:
            raise place.error(f'{text[:MAX_INTEGER_CHARACTERS]}... does not fit into 64 bits')
        return int(text)
    if _FLOAT.fullmatch(text) and math.isfinite(float(text)):
        return float(text)
    if _FLOAT.fullmatch(text) or _NOT_FINITE.fullmatch(text):
        raise place.error(f'{text} must be a finite number')
    return text
