"""The model's rules: random registrations and removals against a reference dictionary.

The reference knows a scene as plain dictionaries and says of each step whether it is allowed. A
step that is not must raise and change nothing. Now and then a context is made, which is a copy:
from then on steps act on one or the other, and none may notice what is done to another.
"""

from dataclasses import dataclass, field, replace
from itertools import combinations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from drake_geom_ros.geometry import (
    Box,
    FrameId,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
    SceneGraphInspector,
    SourceId,
    Sphere,
)
from drake_geom_ros.geometry.model.scene_content import content_of
from drake_geom_ros.math import RigidTransform

PROPERTIES = {
    Role.kProximity: ProximityProperties,
    Role.kIllustration: IllustrationProperties,
    Role.kPerception: PerceptionProperties,
}
WORLD = SceneGraph.world_frame_id()
NO_SOURCE, NO_FRAME, NO_GEOMETRY = SourceId(10**6), FrameId(10**6), GeometryId(10**9)

numbers = st.integers(0, 60)
names = st.sampled_from(['a', 'b', ' a', 'c\t', 'd'])
new_names = st.sampled_from(['a', 'b', ' a', 'c\t', 'd', '', ' '])
some_roles = st.sets(st.sampled_from(list(PROPERTIES)))
a_role = st.sampled_from(list(PROPERTIES))


def trimmed(name):
    return name.strip(' \t')


@dataclass
class Geometry:
    """A geometry as the reference knows it; poses are steps along x."""

    source: SourceId
    frame: FrameId
    parent: GeometryId | None
    name: str
    roles: set[Role]
    x_PG: float
    size: float = 1.0
    properties: dict[Role, int] = field(default_factory=dict)


class Reference:
    """A scene as plain dictionaries."""

    def __init__(self):
        self.frames = {}  # id: (source, parent, name)
        self.geometries = {}
        self.removed = set()

    def copy(self):
        other = Reference()
        other.frames = dict(self.frames)
        other.removed = set(self.removed)
        other.geometries = {
            id: replace(g, roles=set(g.roles), properties=dict(g.properties))
            for id, g in self.geometries.items()
        }
        return other

    def clashes(self, frame, name, roles):
        return any(
            g.frame == frame and g.name == name and g.roles & roles
            for g in self.geometries.values()
        )

    def has_frame_of_name(self, source, name):
        return any(f[0] == source and f[2] == name for f in self.frames.values())

    def x_FG(self, id):
        geometry = self.geometries[id]
        return geometry.x_PG + (0.0 if geometry.parent is None else self.x_FG(geometry.parent))


@dataclass
class Side:
    """The model of a scene graph or a context's copy of it, with its reference."""

    lead: tuple  # what calls begin with: nothing, or the context
    inspector: SceneGraphInspector
    filters: object
    reference: Reference


def pick(things, k, unknown):
    """Return the k-th of some things, or now and then what is not there."""
    things = list(things)
    return things[k % len(things)] if things and k % 11 else unknown


class RandomScenes(RuleBasedStateMachine):
    """Random steps, valid and not."""

    @initialize()
    def start(self):
        self.scene_graph = SceneGraph()
        self.sources = [self.scene_graph.RegisterSource(f's{k}') for k in range(2)]
        self.serial = 0
        self.sides = []
        self.add_side((), self.scene_graph, Reference())
        self.now = self.sides[0]

    def add_side(self, lead, holder, reference):
        inspector = SceneGraphInspector(content_of(holder).model, content_of(holder).filters)
        self.sides.append(Side(lead, inspector, content_of(holder).filters, reference))

    @precondition(lambda self: len(self.sides) < 3)
    @rule()
    def make_a_context(self):
        context = self.scene_graph.CreateDefaultContext()
        self.add_side((context,), context, self.sides[0].reference.copy())

    @rule(k=numbers)
    def turn_to(self, k):
        self.now = self.sides[k % len(self.sides)]

    def attempt(self, allowed, call, *arguments):
        """Make a call that must do its work if allowed, and raise otherwise."""
        if allowed:
            return call(*self.now.lead, *arguments)
        with pytest.raises(RuntimeError, match=r'.'):
            call(*self.now.lead, *arguments)
        return None

    def a_source(self, k, owner):
        """Return the owner mostly, but also the other source or one that is not there."""
        return owner if owner and k < 50 else pick(self.sources, k, NO_SOURCE)

    @rule(k=numbers, parent=numbers, name=names, nested=st.booleans())
    def register_frame(self, k, parent, name, nested):
        reference = self.now.reference
        parent = pick(reference.frames, parent, NO_FRAME) if nested else WORLD
        owner = reference.frames.get(parent, (None,))[0]
        source = self.a_source(k, owner)
        allowed = (
            source in self.sources
            and (parent == WORLD or owner == source)
            and not reference.has_frame_of_name(source, trimmed(name))
        )
        frame = GeometryFrame(name)
        arguments = (source, parent, frame) if nested else (source, frame)
        self.attempt(allowed, self.scene_graph.RegisterFrame, *arguments)
        if allowed:
            reference.frames[frame.id()] = (source, parent, trimmed(name))

    @rule(k=numbers, parent=numbers, name=names, roles=some_roles, kind=st.integers(0, 2))
    def register_geometry(self, k, parent, name, roles, kind):
        reference = self.now.reference
        below = None
        if kind == 0:
            parent = frame = WORLD
            owner = None
        elif kind == 1:
            parent = frame = pick(reference.frames, parent, NO_FRAME)
            owner = reference.frames.get(frame, (NO_SOURCE,))[0]
        else:
            parent = below = pick(reference.geometries, parent, NO_GEOMETRY)
            record = reference.geometries.get(parent)
            frame, owner = (record.frame, record.source) if record else (None, NO_SOURCE)
        source = self.a_source(k, owner)
        self.serial += 1
        made = GeometryInstance(RigidTransform([self.serial, 0, 0]), Sphere(1), name)
        for role in roles:
            suffix = role.name[1:].lower()
            getattr(made, f'set_{suffix}_properties')(PROPERTIES[role]())
        allowed = (
            source in self.sources
            and owner in (None, source)
            and not reference.clashes(frame, trimmed(name), roles)
        )
        self.attempt(allowed, self.scene_graph.RegisterGeometry, source, parent, made)
        if allowed:
            reference.geometries[made.id()] = Geometry(
                source, frame, below, trimmed(name), set(roles), float(self.serial)
            )

    def a_geometry(self, k, source):
        """Return id and record of a geometry, a source, and whether it is the source's."""
        id = pick(self.now.reference.geometries, k, NO_GEOMETRY)
        record = self.now.reference.geometries.get(id)
        owner = record.source if record else None
        source = self.a_source(source, owner)
        return id, record, source, owner == source

    @rule(k=numbers, source=numbers, role=a_role, assign=st.sampled_from(list(RoleAssign)))
    def assign_role(self, k, source, role, assign):
        id, geometry, source, allowed = self.a_geometry(k, source)
        if allowed and assign is RoleAssign.kReplace:
            allowed = role in geometry.roles
        elif allowed:
            allowed = role not in geometry.roles and not self.now.reference.clashes(
                geometry.frame, geometry.name, {role}
            )
        self.serial += 1
        properties = PROPERTIES[role]()
        properties.AddProperty('g', 'serial', self.serial)
        self.attempt(allowed, self.scene_graph.AssignRole, source, id, properties, assign)
        if allowed:
            geometry.roles.add(role)
            geometry.properties[role] = self.serial

    @rule(k=numbers, source=numbers, role=a_role, kind=st.integers(0, 2))
    def remove_role(self, k, source, role, kind):
        reference = self.now.reference
        if kind == 0:
            of, geometry, source, allowed = self.a_geometry(k, source)
            losing = [geometry]
        else:
            of = WORLD if kind == 1 else pick(reference.frames, k, NO_FRAME)
            owner = reference.frames.get(of, (None,))[0]
            source = self.a_source(source, owner)
            allowed = source in self.sources and (of == WORLD or owner == source)
            losing = [
                g for g in reference.geometries.values() if (g.frame, g.source) == (of, source)
            ]
        count = self.attempt(allowed, self.scene_graph.RemoveRole, source, of, role)
        if allowed:
            assert count == sum(role in g.roles for g in losing)
            for geometry in losing:
                geometry.roles.discard(role)
                geometry.properties.pop(role, None)

    @rule(k=numbers, source=numbers)
    def remove_geometry(self, k, source):
        reference = self.now.reference
        id, _, source, allowed = self.a_geometry(k, source)
        self.attempt(allowed, self.scene_graph.RemoveGeometry, source, id)
        gone = {id} if allowed else set()
        while gone:
            for geometry in gone:
                del reference.geometries[geometry]
            reference.removed |= gone
            gone = {g for g, record in reference.geometries.items() if record.parent in gone}

    @rule(k=numbers, source=numbers, move=st.booleans())
    def change_shape(self, k, source, move):
        reference = self.now.reference
        id, geometry, source, allowed = self.a_geometry(k, source)
        self.serial += 1
        X_FG = [RigidTransform([self.serial, 0, 0])] if move else []
        shape = Box(self.serial, 1, 1)
        self.attempt(allowed, self.scene_graph.ChangeShape, source, id, shape, *X_FG)
        if allowed:
            geometry.size = float(self.serial)
            if move:
                below = 0.0 if geometry.parent is None else reference.x_FG(geometry.parent)
                geometry.x_PG = self.serial - below

    @rule(k=numbers, name=new_names)
    def rename_geometry(self, k, name):
        id, geometry, _, _ = self.a_geometry(k, 0)
        new = trimmed(name)
        allowed = bool(new and geometry) and (
            new == geometry.name
            or not self.now.reference.clashes(geometry.frame, new, geometry.roles)
        )
        self.attempt(allowed, self.scene_graph.RenameGeometry, id, name)
        if allowed:
            geometry.name = new

    @rule(k=numbers, name=new_names)
    def rename_frame(self, k, name):
        frames = self.now.reference.frames
        id = pick([*frames, WORLD], k, NO_FRAME)
        new = trimmed(name)
        allowed = bool(new) and id in frames
        if allowed and new != frames[id][2]:
            allowed = not self.now.reference.has_frame_of_name(frames[id][0], new)
        self.attempt(allowed, self.scene_graph.RenameFrame, id, name)
        if allowed:
            frames[id] = (*frames[id][:2], new)

    @invariant()
    def every_side_is_its_reference(self):
        for side in self.sides:
            inspector, reference = side.inspector, side.reference
            assert inspector.GetAllFrameIds() == sorted([WORLD, *reference.frames])
            for id, (source, parent, name) in reference.frames.items():
                assert inspector.GetName(id) == name
                assert inspector.GetParentFrame(id) == parent
                assert inspector.GetOwningSourceId(id) == source
            assert inspector.GetAllGeometryIds() == sorted(reference.geometries)
            for id in reference.geometries:
                self.check_geometry(inspector, reference, id)

    @staticmethod
    def check_geometry(inspector, reference, id):
        geometry, shape = reference.geometries[id], inspector.GetShape(id)
        assert inspector.GetName(id) == geometry.name
        assert inspector.GetFrameId(id) == geometry.frame
        assert inspector.GetOwningSourceId(id) == geometry.source
        assert inspector.GetPoseInFrame(id).translation()[0] == reference.x_FG(id)
        assert inspector.GetPoseInParent(id).translation()[0] == geometry.x_PG
        assert geometry.size == (shape.width() if isinstance(shape, Box) else shape.radius())
        for role in PROPERTIES:
            properties = inspector.GetProperties(id, role)
            assert (properties is not None) == (role in geometry.roles)
            serial = properties and properties.GetPropertyOrDefault('g', 'serial', None)
            assert serial == geometry.properties.get(role)

    @invariant()
    def geometries_are_found_by_frame_role_and_name(self):
        for side in self.sides:
            for frame in [WORLD, *side.reference.frames]:
                on_frame = {
                    id: g for id, g in side.reference.geometries.items() if g.frame == frame
                }
                assert side.inspector.GetGeometries(frame) == sorted(on_frame)
                for id, geometry in on_frame.items():
                    for role in geometry.roles:
                        found = side.inspector.GetGeometryIdByName(frame, role, geometry.name)
                        assert found == id

    @invariant()
    def candidates_are_all_pairs_but_for_the_invariants(self):
        for side in self.sides:
            frames = {
                id: g.frame
                for id, g in side.reference.geometries.items()
                if Role.kProximity in g.roles
            }
            pairs = combinations(sorted(frames), 2)
            expected = [(a, b) for a, b in pairs if frames[a] != frames[b]]
            assert sorted(side.inspector.GetCollisionCandidates()) == expected
            for id in [*side.reference.geometries, *side.reference.removed]:
                assert side.filters.knows([id.get_value()]) == (id in frames)


RandomScenes.TestCase.settings = settings(
    max_examples=40, stateful_step_count=50, derandomize=True
)
test_random_scenes = RandomScenes.TestCase
