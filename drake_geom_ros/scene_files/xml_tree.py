"""Safe XML parsing of robot and model files to an element tree with line numbers."""

import codecs
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from lxml import etree

from drake_geom_ros.common.stand_ins import stand_in
from drake_geom_ros.scene_files.errors import Location, SceneFileError

# A URDF of a humanoid takes 0.2 MB.
MAX_BYTES = 16_000_000
XACRO_FIRST = (
    'run xacro first (`xacro arm.urdf.xacro > arm.urdf`); a file is expanded by itself where '
    "PyPI's `xacro` is installed, one that comes through a service or topic never"
)
_DECLARED = re.compile(rb'<\?xml[^>]*?encoding\s*=\s*["\']([A-Za-z0-9._-]+)')
_MOST_DECLARED = 200  # bytes of a declaration
_BLANKS = b' \t\r\n'
_WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
# Root elements of other formats, and advice about such a file.
_OTHERS = {
    'robot': 'this is a URDF',
    'sdf': 'this is SDF; load it as a scene',
    'mujoco': 'this is MJCF, a model of MuJoCo; load it as a scene',
    'mujocoinclude': 'this is a part of MJCF; load the model that includes it',
    'COLLADA': 'this is a mesh; name it in a URDF or a scene file',
}
# Beginnings and keys of files that are no XML.
_MESH = 'this is a mesh; name it in a URDF or a scene file, or load it as a scene'
_BINARY_MESHES = ('.stl', '.glb', '.ply', '.3mf')
_OTHER_TEXTS = {
    rb'\A(?:ply\s|solid\s|C?OFF\s|glTF|(?:\s|#[^\n]*\n)*(?:mtllib|usemtl|[vog])\s)': _MESH,
    rb'^directives:': 'these are model directives; load them as a scene',
    rb'^(?:robots|sources|frames|geometries):': 'this is a scene file; load it as a scene',
}
_PROLOGUE = re.compile(rb'(?:\s|<\?.*?\?>|<!--.*?-->|<![^-].*?>)*<([^\s/>]+)', re.DOTALL)
# Prefixes that files of Drake's and ROS's users leave undeclared.
_PREFIXES = {
    'drake': 'http://drake.mit.edu',
    'xacro': 'http://www.ros.org/wiki/xacro',
    'gz': 'http://gazebosim.org/schema',
}
_FEW = 100  # elements that are freed in one go
_UNDECLARED = re.compile(r'[Nn]amespace prefix (\w+)')


def is_xml(data: bytes) -> bool:
    """Return whether a file is XML, by its first characters."""
    if data.startswith(_WIDE):
        return data[2:4].strip(b'\0') == b'<'
    return data.removeprefix(codecs.BOM_UTF8).lstrip(_BLANKS).startswith(b'<')


def root_tag(data: bytes) -> str:
    """Return the name of the first element of XML in an encoding like ASCII, '' if none."""
    match = _PROLOGUE.match(data.removeprefix(codecs.BOM_UTF8))
    return match[1].decode(errors='replace') if match else ''


def is_utf8(data: bytes) -> bool:
    """Return whether bytes are UTF-8 beyond ASCII, whatever encoding they declare.

    Text in another encoding is hardly ever valid UTF-8. urdfdom and Drake read everything as
    UTF-8, and text from a topic is UTF-8 whatever its declaration says.
    """
    if data.isascii() or data.startswith(_WIDE):
        return False
    try:
        data.decode('utf-8')
    except UnicodeDecodeError:
        return False
    return True


def encoding_warning(data: bytes, root: Any, file: str) -> tuple[str, ...]:
    """Return a warning if a file declares another encoding than UTF-8 and is UTF-8."""
    declared = _DECLARED.search(data.lstrip(_BLANKS)[:_MOST_DECLARED])
    name = declared[1].decode('ascii', 'replace') if declared else 'utf-8'
    if not is_utf8(data) or name.lower() in ('utf-8', 'utf8'):
        return ()
    warning = f'encoding {name!r} is declared, and the bytes are UTF-8: they are read as that'
    return (str(place_of(root, file).error(warning)),)


@contextmanager
def robot_xml(data: bytes, file: str) -> Iterator[Any]:
    """Hand out the ``<robot>`` element of a file, and free its tree in pieces at the end.

    Else lxml frees it in one go and in the interpreter's lock: for 10 ms, of a robot of 4000
    links. Elements that are still referred to are freed with that reference. Raises what
    ``read_robot_xml`` raises.
    """
    root = read_robot_xml(data, file)
    try:
        yield root
    finally:
        free_below(root)


def free_below(element: Any) -> None:
    """Remove and free all elements below one, a few at a time."""
    for _ in range(len(element)):
        if len(element[0]) > _FEW:
            free_below(element[0])
        del element[0]


def read_robot_xml(data: bytes, file: str) -> Any:
    """Return the ``<robot>`` element of a URDF or SRDF file; errors are those of ``read_xml``."""
    return read_xml(data, file, 'robot')


def read_xml(data: bytes, file: str, tag: str) -> Any:
    """Return the root element of a file, which must be ``tag``, without comments.

    Blank lines before the XML declaration are skipped, and counted in line numbers. A prefix of
    ``drake:``, ``xacro:`` or ``gz:`` may be undeclared, see ``prefix_warning``. Raises
    SceneFileError for text that is not XML, another root element, text over ``MAX_BYTES``, and a
    document type, which could define entities that no format needs.
    """
    if reason := stand_in(data):
        raise SceneFileError(reason, file)
    if len(data) > MAX_BYTES:
        raise SceneFileError(f'{len(data)} bytes; at most {MAX_BYTES} are read', file)
    text = data.lstrip(_BLANKS)
    above = data[: len(data) - len(text)].count(b'\n')
    try:
        root = _parsed(text)
    except etree.XMLSyntaxError as error:
        line = (error.lineno or 1) + above
        if kind := _other_kind(text, file):
            raise SceneFileError(kind, file) from error
        raise SceneFileError(f'not XML: {_reason(error, text)}', file, line) from error
    if above:
        for element in root.iter():
            element.sourceline += above
    if root.getroottree().docinfo.doctype:
        raise SceneFileError('a document type (<!DOCTYPE ...>); remove it', file)
    _leave_default_namespace(root)
    if root.tag != tag:
        fault = _OTHERS.get(local_name(root), f'root element <{root.tag}>; must be <{tag}>')
        raise place_of(root, file).error(fault)
    return root


def _parsed(text: bytes) -> Any:
    """Return the root element; undeclared prefixes that are known are declared at the root."""
    parser = etree.XMLParser(
        encoding='utf-8' if is_utf8(text) else None,
        resolve_entities=False,
        no_network=True,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        return etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        prefix = _UNDECLARED.match(str(error.msg))
        root = _PROLOGUE.match(text.removeprefix(codecs.BOM_UTF8))
        if prefix is None or prefix[1] not in _PREFIXES or root is None:
            raise
        end = root.end() + len(text) - len(text.removeprefix(codecs.BOM_UTF8))
        declared = f' xmlns:{prefix[1]}="{_PREFIXES[prefix[1]]}#undeclared"'.encode()
        return _parsed(text[:end] + declared + text[end:])


def prefix_warning(root: Any, file: str) -> tuple[str, ...]:
    """Return a warning if a file uses a prefix that it does not declare."""
    names = [name for name, uri in root.nsmap.items() if (uri or '').endswith('#undeclared')]
    if not names:
        return ()
    name = names[0]
    warning = (
        f'the prefix `{name}:` is not declared; it is read as if the root element had '
        f'xmlns:{name}="{_PREFIXES[name]}"'
    )
    return (str(place_of(root, file).error(warning)),)


def _other_kind(text: bytes, file: str) -> str:
    """Return a remark about a file of another format that is no XML; empty if none is known."""
    if file.lower().endswith(_BINARY_MESHES):
        return _MESH
    kinds = (kind for key, kind in _OTHER_TEXTS.items() if re.search(key, text, re.MULTILINE))
    return next(kinds, '')


def _reason(error: etree.XMLSyntaxError, text: bytes) -> str:
    """Return the reason why text is not XML, with a remedy if its bytes are not UTF-8."""
    try:
        text.decode('utf-8-sig')
    except UnicodeDecodeError as wrong:
        if not text.startswith(_WIDE):
            return (
                f'byte {text[wrong.start]:#x} is not UTF-8. Save the file as UTF-8, or declare '
                'its encoding, as <?xml version="1.0" encoding="iso-8859-1"?>'
            )
    return str(error.msg)


def _leave_default_namespace(root: Any) -> None:
    """Remove the root's default namespace from tags, since URDF has no namespace of its own."""
    prefix = f'{{{root.nsmap.get(None)}}}'
    if root.tag.startswith(prefix):
        for element in root.iter():
            element.tag = str(element.tag).removeprefix(prefix)


def local_name(element: Any) -> str:
    """Return an element's name without namespace: ``capsule`` for ``drake:capsule``."""
    return str(element.tag).rpartition('}')[2]


def place_of(element: Any, file: str) -> Location:
    """Return the place of an element: its line, and its path of tags and names."""
    path = []
    for node in [element, *element.iterancestors()]:
        if local_name(node) not in ('robot', 'sdf'):
            name = node.get('name')
            path.append(local_name(node) + (f'[{name}]' if name else ''))
    return Location(file, element.sourceline, '.'.join(reversed(path)))


def attribute(element: Any, name: str, file: str) -> str:
    """Return a required attribute; SceneFileError if it is missing or empty."""
    value = element.get(name)
    if not value:
        raise place_of(element, file).error(f'missing attribute `{name}`')
    return str(value)


def numbers(element: Any, name: str, count: int, default: str | None = None) -> list[float]:
    """Return an attribute of ``count`` numbers; ValueError, which names no line, for others.

    A missing attribute counts as ``default``; without a default it is required.
    """
    text = element.get(name, default)
    if text is None:
        raise ValueError(f'{local_name(element)} has no attribute `{name}`')
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    # Only Python reads 1_0 as 10.
    if len(values) != count or '_' in text:
        wanted = 'a number' if count == 1 else f'{count} numbers'
        raise ValueError(f'{local_name(element)}: {name} = {text!r} must be {wanted}{_how(text)}')
    return values


def _how(text: str) -> str:
    """Return a clause on how to write numbers if a text has commas, else ''."""
    return ', a point for decimals and blanks between numbers, without commas' * (',' in text)
