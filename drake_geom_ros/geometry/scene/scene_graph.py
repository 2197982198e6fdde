"""``SceneGraph``: registration of sources, frames and geometries, contexts, and ports."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from drake_geom_ros.autodiffutils import AutoDiffXd
from drake_geom_ros.common.tables import html_table
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry.checks import checked_pose, checked_type
from drake_geom_ros.geometry.errors import PoseError
from drake_geom_ros.geometry.ids import FrameId, GeometryId, SourceId
from drake_geom_ros.geometry.model import _attachments
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model._records import WORLD_FRAME_ID
from drake_geom_ros.geometry.model.collision_filter_declaration import CollisionFilterDeclaration
from drake_geom_ros.geometry.model.collision_filter_manager import CollisionFilterManager
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.model.geometry_set import GeometrySet
from drake_geom_ros.geometry.model.instances import GeometryFrame, GeometryInstance
from drake_geom_ros.geometry.model.properties import (
    GeometryProperties,
    ProximityProperties,
    Role,
    RoleAssign,
)
from drake_geom_ros.geometry.model.scene_content import (
    SceneContent,
    SceneHolder,
    add_to_filters,
    content_of,
)
from drake_geom_ros.geometry.model.scene_graph_config import SceneGraphConfig, checked_config
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.queries.accuracy import Accuracy, AccuracyLike, accuracy_of
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
from drake_geom_ros.geometry.render.render_engine import RenderEngine
from drake_geom_ros.geometry.render.renderers import Renderers
from drake_geom_ros.geometry.scene._applied_defaults import configure, share, with_defaults
from drake_geom_ros.geometry.scene._or_on_context import or_on_context
from drake_geom_ros.geometry.scene._ports import PoseBundlePort, QueryPort, SourcePosePort
from drake_geom_ros.geometry.shapes.primitives import Shape
from drake_geom_ros.math import RigidTransform, ScalarTemplate
from drake_geom_ros.math.missing import refuse_missing_member


class SceneGraph(SceneHolder):
    """The scene: geometry sources, their frames, the geometries on them, and collision filters.

    A source registers frames, which move, and geometries on them, or anchored ones on the world.
    It owns them: changes need the source's id. Proximity queries consider geometries with the
    proximity role.

    Methods that register or change something act on this scene's model, or, with a context before
    their other arguments, on that context's copy of it. Changes of the model do not reach existing
    contexts, nor the reverse. A method that raises RuntimeError has changed nothing.

        >>> scene_graph = SceneGraph()
        >>> source_id = scene_graph.RegisterSource('robot')
        >>> frame_id = scene_graph.RegisterFrame(source_id, GeometryFrame('hand'))
        >>> ball = GeometryInstance(RigidTransform(), Sphere(0.1), 'ball')
        >>> ball.set_proximity_properties(ProximityProperties())
        >>> ball_id = scene_graph.RegisterGeometry(source_id, frame_id, ball)
        >>> context = scene_graph.CreateDefaultContext()
        >>> poses = FramePoseVector({frame_id: RigidTransform([0, 0, 1])})
        >>> scene_graph.get_source_pose_port(source_id).FixValue(context, poses)
        >>> query_object = scene_graph.get_query_output_port().Eval(context)
        >>> query_object.GetPoseInWorld(ball_id).translation().tolist()
        [0.0, 0.0, 1.0]
    """

    _context_type = SceneGraphContext

    def __init__(
        self, config: SceneGraphConfig | None = None, *, accuracy: AccuracyLike = 'exact'
    ) -> None:
        """Make an empty scene.

        ``accuracy`` is the default of queries: bound, fast, balanced, exact or a length [m].
        ``config`` is that of ``set_config``.
        """
        self._state = SceneContent(Model(), FilterState())
        self.set_config(SceneGraphConfig() if config is None else config)
        self.set_default_accuracy(accuracy)

    def __repr__(self) -> str:
        inspector = self.model_inspector()
        near = inspector.NumGeometriesWithRole(Role.kProximity)
        return (
            f'<{type(self).__name__}: {inspector.num_sources()} sources, '
            f'{inspector.num_frames()} frames, {inspector.num_geometries()} geometries, '
            f'{near} with the proximity role>'
        )

    def _repr_html_(self) -> str:
        """Return the sources and what they registered as a table, for notebooks."""
        inspector = self.model_inspector()
        sources = inspector.GetAllSourceIds()
        names = [inspector.GetName(source) for source in sources]
        frames = [inspector.NumFramesForSource(source) for source in sources]
        return html_table(repr(self), {'source': names, 'frames': frames})

    if not TYPE_CHECKING:  # mypy would take any method for one that is there
        __getattr__ = refuse_missing_member

    # Registration.

    @or_on_context
    def RegisterSource(self, on: SceneContent, name: str = '') -> SourceId:
        """Register a source and return its id; without a name it becomes ``Source_<id>``.

        Raises RuntimeError if the name is taken.
        """
        return on.model.register_source(name)

    @or_on_context
    def RegisterFrame(
        self,
        on: SceneContent,
        source_id: SourceId,
        parent_id: FrameId | GeometryFrame | None = None,
        frame: GeometryFrame | None = None,
    ) -> FrameId:
        """Register ``(source_id, frame)`` on the world or ``(source_id, parent_id, frame)``.

        Returns the frame's id. Its poses X_PF are those in the parent. Raises RuntimeError if the
        source is not registered or does not own the parent, or if the frame's id or name is taken.
        """
        if isinstance(parent_id, GeometryFrame) and frame is None:
            parent_id, frame = None, parent_id
        parent: Any = WORLD_FRAME_ID if parent_id is None else parent_id
        definition = checked_type(frame, GeometryFrame, 'RegisterFrame: frame')
        return on.model.register_frame(source_id, definition, parent)

    @or_on_context
    def RegisterGeometry(
        self,
        on: SceneContent,
        source_id: SourceId,
        frame_id: FrameId | GeometryId | None = None,
        geometry: GeometryInstance | None = None,
        *,
        geometry_id: GeometryId | None = None,
    ) -> GeometryId:
        """Register a geometry on a frame, on the world frame, or on a geometry; return its id.

        Its pose X_PG in this parent is fixed. It gets the roles whose properties the instance has.
        Raises RuntimeError if the source is not registered or does not own the parent, if the id
        is registered already, or if the name is taken for one of the roles on that frame.
        """
        parent: Any = geometry_id if frame_id is None else frame_id
        instance = checked_type(geometry, GeometryInstance, 'RegisterGeometry: geometry')
        return _register_geometry(on, source_id, parent, instance)

    @or_on_context
    def RegisterAnchoredGeometry(
        self, on: SceneContent, source_id: SourceId, geometry: GeometryInstance
    ) -> GeometryId:
        """Register an anchored geometry, on the world; see ``RegisterGeometry``."""
        instance = checked_type(geometry, GeometryInstance, 'RegisterAnchoredGeometry: geometry')
        return _register_geometry(on, source_id, WORLD_FRAME_ID, instance)

    @or_on_context
    def RemoveGeometry(
        self, on: SceneContent, source_id: SourceId, geometry_id: GeometryId
    ) -> None:
        """Remove a geometry, and those that were registered on it.

        Raises RuntimeError if it is not the source's.
        """
        for record in on.model.remove_geometry(source_id, geometry_id):
            if record.proximity is not None:
                on.filters.remove(record.id.get_value())

    # Changes.

    @or_on_context
    def AssignRole(
        self,
        on: SceneContent,
        source_id: SourceId,
        geometry_id: GeometryId,
        properties: GeometryProperties,
        assign: RoleAssign = RoleAssign.kNew,
    ) -> None:
        """Assign the role of ``properties`` to a geometry, or replace its properties in that role.

        Raises RuntimeError if the geometry is not the source's, it has the role already (kNew) or
        has it not yet (kReplace), or its name is taken for that role on its frame.
        """
        record = on.model.assign_role(source_id, geometry_id, properties, assign)
        if assign is RoleAssign.kNew and isinstance(properties, ProximityProperties):
            add_to_filters(on, record)

    @or_on_context
    def RemoveRole(
        self,
        on: SceneContent,
        source_id: SourceId,
        geometry_id: GeometryId | FrameId | None = None,
        role: Role | None = None,
        *,
        frame_id: FrameId | None = None,
    ) -> int:
        """Remove a role from a geometry, or from all of the source's geometries on a frame.

        Returns the number of geometries that had it. Raises RuntimeError if geometry or frame is
        not the source's.
        """
        of: Any = frame_id if geometry_id is None else geometry_id
        losing = on.model.remove_role(source_id, of, checked_type(role, Role, 'RemoveRole: role'))
        if role is Role.kProximity:
            for record in losing:
                on.filters.remove(record.id.get_value())
        return len(losing)

    @or_on_context
    def ChangeShape(
        self,
        on: SceneContent,
        source_id: SourceId,
        geometry_id: GeometryId,
        shape: Shape,
        X_FG: RigidTransform | None = None,
    ) -> None:
        """Replace the shape of a geometry and, with ``X_FG``, its pose in the frame.

        Roles and filters stay. Geometries that were registered on it keep their poses in it.
        Raises RuntimeError if it is not the source's.
        """
        on.model.change_shape(source_id, geometry_id, shape, X_FG)

    @or_on_context
    def RenameFrame(self, on: SceneContent, frame_id: FrameId, name: str) -> None:
        """Rename a frame; raises RuntimeError if its source has a frame of that name."""
        on.model.rename_frame(frame_id, name)

    @or_on_context
    def RenameGeometry(self, on: SceneContent, geometry_id: GeometryId, name: str) -> None:
        """Rename a geometry; raises RuntimeError if the name is taken for one of its roles."""
        on.model.rename_geometry(geometry_id, name)

    # Collision filters.

    def collision_filter_manager(
        self, context: SceneGraphContext | None = None
    ) -> CollisionFilterManager:
        """Return the manager of the collision filters of the model, or of a context."""
        if context is not None:
            checked_type(context, SceneGraphContext, 'collision_filter_manager: context')
        on = content_of(context or self)
        return CollisionFilterManager(on.model, on.filters)

    # Renderers.

    @or_on_context
    def AddRenderer(self, on: SceneContent, name: str, renderer: RenderEngine) -> None:
        """Add a renderer for cameras to use by this name; raises RuntimeError if it is taken."""
        Renderers(on.model).add(name, renderer)

    @or_on_context
    def HasRenderer(self, on: SceneContent, name: str) -> bool:
        """Return whether a renderer of this name exists."""
        return name in on.model.renderers

    @or_on_context
    def RendererCount(self, on: SceneContent) -> int:
        """Return the number of renderers."""
        return len(on.model.renderers)

    @or_on_context
    def RegisteredRendererNames(self, on: SceneContent) -> list[str]:
        """Return the names of the renderers."""
        return list(on.model.renderers)

    @or_on_context
    def GetRendererTypeName(self, on: SceneContent, name: str) -> str:
        """Return the class name of a renderer, empty if there is none of this name."""
        renderer = on.model.renderers.get(name)
        return '' if renderer is None else type(renderer).__name__

    @or_on_context
    def RemoveRenderer(self, on: SceneContent, name: str) -> None:
        """Remove a renderer; raises RuntimeError if there is none of this name."""
        Renderers(on.model).remove(name)

    # Inspection, contexts and ports.

    @staticmethod
    def world_frame_id() -> FrameId:
        """Return the id of the world frame, the same for all scenes."""
        return WORLD_FRAME_ID

    def model_inspector(self) -> SceneGraphInspector:
        """Return the inspector of this scene's model; a query object has that of its context."""
        return SceneGraphInspector(self._state.model, self._state.filters)

    def model_version(self) -> int:
        """Return a number that grows with each change of sources, frames, geometries, config."""
        return self._state.model.versions.any

    def names_version(self) -> int:
        """Return model_version() at the last change of the set of objects, of names or of roles.

        Shapes, properties and poses in frames may have changed since.
        """
        return self._state.model.versions.names

    def default_accuracy(self) -> Accuracy:
        """Return the default accuracy of later contexts."""
        return self._default_accuracy

    def set_default_accuracy(self, accuracy: AccuracyLike) -> None:
        """Set the default accuracy of later contexts, a level or a length [m]."""
        self._default_accuracy = accuracy_of(accuracy)

    @or_on_context
    def SetFirstPoses(self, on: SceneContent, poses: FramePoseVector) -> None:
        """Set the poses X_PF with which frames begin in later contexts.

        On a context, they apply to copies of it that a scene takes over, see ``TakeOver``. The
        poses of a scene file are set in this way. Raises RuntimeError for an unknown frame and for
        the world; nothing changes then.
        """
        checked_type(poses, FramePoseVector, 'SetFirstPoses: poses')
        first = {on.model.frame(frame).id: poses.value(frame) for frame in poses.ids()}
        if WORLD_FRAME_ID in first:
            raise PoseError('SetFirstPoses: the world frame has no pose')
        # A new dictionary, so that a ``SceneMark`` of the old one detects the change.
        on.model.first_X_PFs = on.model.first_X_PFs | first

    def CreateDefaultContext(self) -> SceneGraphContext:
        """Return a context: a copy of the model and its filters.

        Geometries get the default properties of the config that they lack. Frames have the poses
        of ``SetFirstPoses``, such as those of a scene file, or none. Queries raise PoseError, with
        the names of the frames, until each frame has a pose.
        """
        own = self._state.copy()
        with_defaults(own.model)
        return self._context_type(own.model, own.filters, self._default_accuracy)

    def TakeOver(
        self, context: SceneGraphContext, shared: SceneGraphContext | None = None
    ) -> bool:
        """Adopt the content of a changed copy of a shared context, and return whether it did.

        A long change, of thousands of frames, can be made on a copy (``copy()`` of the result of
        ``CreateSharedContext``) while others use this scene. This call then applies it in a
        moment, with the same ids. It returns False and changes nothing if this scene has changed
        since the copy was made. The context must not be used any more. Poses are not adopted.

        ``shared`` is the context of this scene that was copied. It keeps its poses and continues
        with what queries of the copy have prepared; without it, its next query prepares all that.
        """
        checked_type(context, SceneGraphContext, 'TakeOver: context')
        if not self._state.take_over(content_of(context)):
            return False
        if shared is not None:
            state_of(shared).go_on_as(state_of(context))
        return True

    def Clone(self) -> SceneGraph:
        """Return an independent copy, with the same ids, filters and default accuracy."""
        return self._copied_to(type(self))

    def ToAutoDiffXd(self) -> SceneGraph:
        """Return an independent copy for poses of AutoDiffXd, with the same ids and filters."""
        return self._copied_to(SceneGraph_[AutoDiffXd])

    def _copied_to(self, kind: type[SceneGraph]) -> SceneGraph:
        other = kind(accuracy=self._default_accuracy)
        other._state = self._state.copy()
        return other

    def CreateSharedContext(self, *, partial: bool = False) -> SceneGraphContext:
        """Return a context that shares this model and its filters, and sees their later changes.

        It is for programs with one changing scene, such as a ROS node: nothing is copied. With
        ``partial``, queries answer while frames have no first pose, and leave out the geometry on
        these and on their descendants: see ``QueryObject.waiting_frames`` and
        ``QueryObject.num_waiting_pairs``. Raises GeometryError for a config with a compliance
        type.
        """
        share(self._state.model)
        return self._context_type(
            self._state.model, self._state.filters, self._default_accuracy, partial
        )

    def get_source_pose_port(self, source_id: SourceId) -> SourcePosePort:
        """Return the input port for the poses of a source's frames.

        Raises RuntimeError if the source is not registered.
        """
        self._state.model.source_name(source_id)
        return SourcePosePort(source_id)

    def get_query_output_port(self) -> QueryPort:
        """Return the output port for the query object of a context."""
        return QueryPort()

    def get_pose_bundle_output_port(self) -> PoseBundlePort:
        """Return the output port for the poses of a context's frames, for a visualiser."""
        return PoseBundlePort()

    # Settings.

    def get_config(self, context: SceneGraphContext | None = None) -> SceneGraphConfig:
        """Return a copy of the settings, or of those that a context was made with."""
        if context is not None:
            checked_type(context, SceneGraphContext, 'get_config: context')
        return checked_config(content_of(context or self).model.config.config)

    def set_config(self, config: SceneGraphConfig) -> None:
        """Set the default contact properties of geometries in later contexts.

        Geometries that lack them get them, also those that are registered in such a context or get
        the proximity role there. There are no defaults if their compliance type is 'undefined'. A
        change of the settings changes ``model_version()``. Raises RuntimeError for a value that a
        property cannot have, and for a compliance type if ``CreateSharedContext`` was called.
        """
        configure(self._state.model, checked_config(config))

    # Removal and attachment, which pydrake lacks: there sources, frames and parents are final.

    @or_on_context
    def RemoveSource(self, on: SceneContent, source_id: SourceId) -> list[FrameId]:
        """Remove a source with its frames and geometries; return the removed frames.

        Collision filters of its geometries are removed, too. Raises RuntimeError if the source is
        not registered, and while frames of other sources are attached to its frames.
        """
        removed = _attachments.remove_source(on.model, source_id)
        _remove_from_filters(on, removed)
        return removed.frames

    @or_on_context
    def RemoveFrame(self, on: SceneContent, source_id: SourceId, frame_id: FrameId) -> None:
        """Remove a frame with the geometries on it; all others keep their ids.

        Collision filters of its geometries are removed, too. Raises RuntimeError if the frame is
        not the source's, and while it has child frames.
        """
        _remove_from_filters(on, _attachments.remove_frame(on.model, source_id, frame_id))

    @or_on_context
    def AttachFrame(
        self,
        on: SceneContent,
        source_id: SourceId,
        frame_id: FrameId,
        parent_id: FrameId,
        X_PF: RigidTransform,
        is_part: bool = True,
    ) -> None:
        """Attach a frame, with its descendants, to a frame of any source, at X_PF in that one.

        X_PF becomes its pose, with which later contexts begin. With ``is_part``, sets by name that
        stand for the other frame, or for its source, include this one. A weld of the frame to the
        world ends. Collision filters do not change. Raises RuntimeError if the frame is not the
        source's, or if the other one is the world or a descendant of it.
        """
        pose = checked_pose(X_PF, 'AttachFrame: X_PF')
        frame = _attachments.attach_frame(
            on.model, source_id, frame_id, parent_id, is_part=is_part
        )
        on.begin_at(frame, pose)

    @or_on_context
    def MountFrame(
        self,
        on: SceneContent,
        source_id: SourceId,
        frame_id: FrameId,
        parent_id: FrameId,
    ) -> None:
        """Give a frame a permanent parent of any source, as if it had been registered there.

        An example is a robot on another one's flange. The poses X_PF, which the frame's own source
        still sets, are then those in the new parent. Raises RuntimeError if the frame is not the
        source's, is attached, or if the other one is a descendant of it.
        """
        _attachments.mount_frame(on.model, source_id, frame_id, parent_id)

    @or_on_context
    def DetachFrame(
        self,
        on: SceneContent,
        source_id: SourceId,
        frame_id: FrameId,
        X_PF: RigidTransform,
    ) -> None:
        """Return an attached frame to the parent that it was registered on, at X_PF in that one.

        Raises RuntimeError if the frame is not the source's, or is not attached.
        """
        pose = checked_pose(X_PF, 'DetachFrame: X_PF')
        on.begin_at(_attachments.detach_frame(on.model, source_id, frame_id), pose)

    # Older names of pydrake, of 2020.

    @or_on_context
    def ExcludeCollisionsWithin(self, on: SceneContent, set: GeometrySet) -> None:
        """Exclude all pairs within a set; the older form of a persistent declaration."""
        declaration = CollisionFilterDeclaration().ExcludeWithin(set)
        CollisionFilterManager(on.model, on.filters).Apply(declaration)

    @or_on_context
    def ExcludeCollisionsBetween(
        self, on: SceneContent, setA: GeometrySet, setB: GeometrySet
    ) -> None:
        """Exclude all pairs between two sets; the older form of a persistent declaration."""
        declaration = CollisionFilterDeclaration().ExcludeBetween(setA, setB)
        CollisionFilterManager(on.model, on.filters).Apply(declaration)


def _register_geometry(
    on: SceneContent, source_id: SourceId, parent: FrameId | GeometryId, instance: GeometryInstance
) -> GeometryId:
    """Register a geometry in a model, and in its filters if it has the proximity role."""
    record = on.model.register_geometry(source_id, parent, instance)
    if record.proximity is not None:
        add_to_filters(on, record)
    return record.id


def _remove_from_filters(on: SceneContent, removed: _attachments.RemovedObjects) -> None:
    """Remove the collision filters of removed frames and geometries."""
    for record in removed.geometries:
        if record.proximity is not None:
            on.filters.remove(record.id.get_value())
    for frame in removed.frames:
        on.filters.welded.pop(frame.get_value(), None)


# ``scalar_templates`` adds the instantiation for AutoDiffXd.
SceneGraph_ = ScalarTemplate(SceneGraph)
