"""MoveIt's text format of planning scenes (``.scene``): objects of the world, read as scenes.

::

    table top                        the name of the scene
    * mug                            an object: its id,
    0.5 0 0.4                        its position [m]
    0 0 0 1                          and its rotation, as x y z w;
    1                                how many shapes; of each
    cylinder                         its type,
    0.04 0.1                         its dimensions [m],
    0 0 0                            its position in the object,
    0 0 0 1                          its rotation,
    0.8 0.1 0.1 1                    its colour, all 0: none;
    0                                how many subframes; of each its name, position and rotation
    .                                the end

Files of MoveIt 1 before Melodic have no pose of an object and no subframes.
"""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry import (
    Box,
    Cylinder,
    GeometryProperties,
    IllustrationProperties,
    ProximityProperties,
    Rgba,
    Role,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    WORLD,
    FrameDescription,
    GeometryDescription,
    SceneDescription,
)
from drake_geom_ros.scene_files.errors import Location, SceneFileError
from drake_geom_ros.scene_files.moveit_shapes import (
    CONE_NOTE,
    PlacedShape,
    cone,
    placed_body,
    placed_half_space,
)

SOURCE = 'planning_scene'  # as of objects that come by MoveIt's topics
SUFFIX = '.scene'
_OBJECT, _END = '*', '.'
_SIZES = {'box': 3, 'sphere': 1, 'cylinder': 2, 'cone': 2, 'plane': 4}


class _Line(NamedTuple):
    number: int
    text: str


class _Lines:
    """The lines of a file that are not empty, one after the other."""

    def __init__(self, text: str, file: str) -> None:
        self.file = file
        lines = enumerate(text.splitlines(), start=1)
        self._lines = [_Line(n, line.strip()) for n, line in lines if line.strip()]
        self._next = 0
        self.last = 1

    def peek(self) -> str:
        """Return the next line, empty at the end."""
        return self._lines[self._next].text if self._next < len(self._lines) else ''

    def take(self, what: str) -> str:
        """Return the next line; raises SceneFileError at the end of the file."""
        if self._next >= len(self._lines):
            raise SceneFileError(f'it ends where {what} is expected', self.file)
        self.last, text = self._lines[self._next]
        self._next += 1
        return text

    def numbers(self, count: int, what: str) -> list[float]:
        """Return the numbers of the next line; raises SceneFileError for others."""
        text = self.take(what)
        try:
            numbers = [float(word) for word in text.split()]
        except ValueError:
            numbers = []
        if len(numbers) != count:
            raise self.error(f'{text[:60]!r} is not {what}: {count} numbers')
        return numbers

    def count(self, what: str) -> int:
        """Return a whole number >= 0."""
        (number,) = self.numbers(1, what)
        if number < 0 or number != int(number):
            raise self.error(f'{what} is {number:g}; it must be a whole number >= 0')
        return int(number)

    def pose(self, what: str) -> RigidTransform:
        """Return the pose of the next two lines."""
        position = self.numbers(3, f'the position of {what}')
        rotation = self.numbers(4, f'the rotation of {what}')
        try:
            return RigidTransform.FromArray([*position, *rotation])
        except RuntimeError as error:
            raise self.error(f'{what}: {error}') from error

    def error(self, text: str) -> SceneFileError:
        """Return an error at the line that was taken last."""
        return Location(self.file, self.last).error(text)


def read_moveit_scene(text: str, file: str) -> SceneDescription:
    """Return the scene of a text: an object is a frame of ``planning_scene`` with its shapes.

    Objects are welded to the world; a subframe is a frame on its object. Raises SceneFileError,
    with file and line, for a text of another form.
    """
    lines = _Lines(text, file)
    if lines.peek()[:1] != _OBJECT:
        lines.take('the name of the scene')
    frames, geometries, warnings = [], [], []
    ids = set[str]()
    while (mark := lines.take('an object or the end')) != _END:
        if mark[:1] != _OBJECT or not (name := mark[1:].strip()):
            raise lines.error(f'{mark[:60]!r} is no object: `* ID`, and no end: `.`')
        if name in ids:
            raise lines.error(f'the object {name!r} is there twice')
        ids.add(name)
        where = Location(file, lines.last)
        is_old = len(lines.peek().split()) == 1  # then it is the number of shapes
        X_WO = RigidTransform() if is_old else lines.pose(f'object {name!r}')
        frames.append(_frame(name, WORLD, X_WO, where))
        for k in range(lines.count(f'the number of shapes of object {name!r}')):
            placed, colour = _shape(lines), lines.numbers(4, 'the colour of a shape')
            title = f'{placed.kind}_{k}'
            geometries.append(_geometry(name, title, placed, colour, where))
            if placed.note:
                warnings.append(f'object {name!r}: {title} {placed.note}')
        if not is_old:
            for _ in range(lines.count(f'the number of subframes of object {name!r}')):
                title = lines.take('the name of a subframe')
                X_OS = lines.pose(f'subframe {title!r}')
                frames.append(_frame(f'{name}/{title}', name, X_OS, where))
    if lines.peek():
        text = lines.take('')
        warnings.append(
            str(
                lines.error(
                    f'the scene ends above, by {_END!r}; {text[:60]!r} and what follows '
                    'is not read'
                )
            )
        )
    return SceneDescription(
        file,
        sources=(SOURCE,),
        frames=tuple(frames),
        geometries=tuple(geometries),
        warnings=tuple(warnings),
    )


def _frame(name: str, parent: str, X_PF: RigidTransform, where: Location) -> FrameDescription:
    return FrameDescription(
        SOURCE,
        name,
        parent=parent,
        X_PF=X_PF,
        static=True,
        welded=parent == WORLD,
        where=where,
    )


def _geometry(
    frame: str, name: str, placed: PlacedShape, colour: list[float], where: Location
) -> GeometryDescription:
    proximity, illustration = ProximityProperties(), IllustrationProperties()
    if placed.is_solid:
        proximity.AddProperty('mesh', 'solid', True)
    roles: dict[Role, GeometryProperties] = {Role.kProximity: proximity}
    if any(colour):
        illustration.AddProperty('phong', 'diffuse', Rgba(*colour))
    roles[Role.kIllustration] = illustration
    return GeometryDescription(SOURCE, frame, name, placed.shape, placed.X_OS, roles, where)


def _shape(lines: _Lines) -> PlacedShape:
    """Return the next shape with its pose; its colour is left."""
    kind = lines.take('the type of a shape')
    if kind == 'mesh':
        return _mesh(lines)
    if kind not in _SIZES:
        allowed = ', '.join((*_SIZES, 'mesh'))
        raise lines.error(f'the type of a shape is {kind[:60]!r}; it must be one of {allowed}')
    sizes = lines.numbers(_SIZES[kind], f'the dimensions of a {kind}')
    number = lines.last
    X_OS = lines.pose(f'a {kind}')
    try:
        if kind == 'plane':
            return placed_half_space(sizes, X_OS)
        note = CONE_NOTE if kind == 'cone' else ''
        return PlacedShape(kind, _of_sizes(kind, sizes), X_OS, note=note)
    except RuntimeError as error:
        raise Location(lines.file, number).error(str(error)) from error


def _of_sizes(kind: str, sizes: list[float]) -> Shape:
    if kind == 'box':
        return Box(*sizes)
    if kind == 'sphere':
        return Sphere(*sizes)
    radius, length = sizes
    return Cylinder(radius, length) if kind == 'cylinder' else cone(length, radius)


def _mesh(lines: _Lines) -> PlacedShape:
    vertices, triangles = (int(n) for n in lines.numbers(2, 'the counts of a mesh'))
    number = lines.last
    points = [lines.numbers(3, 'a vertex') for _ in range(vertices)]
    corners = [lines.numbers(3, 'a triangle') for _ in range(triangles)]
    X_OS = lines.pose('a mesh')
    try:
        return placed_body(points, corners, X_OS)
    except RuntimeError as error:
        raise Location(lines.file, number).error(str(error)) from error
