"""XML of URDF and SRDF files -> an element tree with line numbers, safely."""

from typing import Any

from lxml import etree

from drake_geom_ros.scene_files.errors import Location, SceneFileError

# A URDF of a humanoid takes 0.2 MB.
MAX_BYTES = 16_000_000


def read_robot_xml(data: bytes, file: str) -> Any:
    """Return the ``<robot>`` element of a URDF or SRDF file, comments left out.

    Raises SceneFileError for text that is not XML, another root element, text over ``MAX_BYTES``,
    and a document type: entities are defined there, and neither format has use for them.
    """
    if len(data) > MAX_BYTES:
        raise SceneFileError(f'{len(data)} bytes; at most {MAX_BYTES} are read', file)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True
    )
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise SceneFileError(f'not XML: {error.msg}', file, error.lineno) from error
    if root.getroottree().docinfo.doctype:
        raise SceneFileError('a document type (<!DOCTYPE ...>); remove it', file)
    _leave_default_namespace(root)
    if root.tag != 'robot':
        raise place_of(root, file).error(f'root element <{root.tag}>; must be <robot>')
    return root


def _leave_default_namespace(root: Any) -> None:
    """Name elements of the root's default namespace plainly: URDF has no namespace of its own."""
    prefix = f'{{{root.nsmap.get(None)}}}'
    if root.tag.startswith(prefix):
        for element in root.iter():
            element.tag = str(element.tag).removeprefix(prefix)


def local_name(element: Any) -> str:
    """Return an element's name without namespace: ``capsule`` for ``drake:capsule``."""
    return str(etree.QName(element).localname)


def place_of(element: Any, file: str) -> Location:
    """Return the place of an element: its line, and its name or that of the nearest named one."""
    path = []
    for node in [element, *element.iterancestors()]:
        if local_name(node) != 'robot':
            name = node.get('name')
            path.append(local_name(node) + (f'[{name}]' if name else ''))
    return Location(file, element.sourceline, '.'.join(reversed(path)))


def attribute(element: Any, name: str, file: str) -> str:
    """Return an attribute that must be there; SceneFileError where it is not."""
    value = element.get(name)
    if not value:
        raise place_of(element, file).error(f'missing attribute `{name}`')
    return str(value)


def numbers(element: Any, name: str, count: int, default: str | None = None) -> list[float]:
    """Return an attribute that holds ``count`` numbers; ValueError, which names no line, if not.

    ``default`` is what a missing attribute counts as; without one it must be there.
    """
    text = element.get(name, default)
    if text is None:
        raise ValueError(f'{local_name(element)} has no attribute `{name}`')
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    # Python alone reads 1_0 as 10.
    if len(values) != count or '_' in text:
        wanted = 'a number' if count == 1 else f'{count} numbers'
        raise ValueError(f'{local_name(element)}: {name} = {text!r} must be {wanted}')
    return values
