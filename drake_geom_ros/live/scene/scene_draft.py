"""A change of the live scene on a copy, with all that cycles need of the changed scene.

What takes long is done here, beside the cycles, which go on with the scene as it was. The live
scene then becomes the draft in a moment: see ``HeldScene.take_over``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drake_geom_ros.geometry import QueryObject, SceneGraph, SceneGraphContext
from drake_geom_ros.live.scene.bound_rules import BoundRules
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.scene_model import ModelTables, SceneModel, is_large
from drake_geom_ros.live.scene.scene_rules import SceneRules

Tell = Callable[[str, int, int], None]


class SceneDraft:
    """A copy of the live scene, to be changed and made ready by one thread.

    ``context`` holds a snapshot, which ``make`` copies, or a scene of its own that is to take the
    place of the live one. The live scene is held by who makes a draft, and by nobody while that is
    copied, changed and made ready.
    """

    def __init__(
        self, model: SceneModel, rules: SceneRules, context: SceneGraphContext | None = None
    ) -> None:
        self.context: SceneGraphContext = model.context.what_if() if context is None else context
        self.robots = [] if context is not None else list(model.robots)
        self.tables: ModelTables | None = None  # None: as in the live scene
        self.rules: BoundRules | None = None
        self.is_large = model.is_large
        self.maps_source = model.maps_source
        self._world_frame, self._joints = model.world_frame, model.joints
        self._rules = rules.copy()  # as they are, whatever becomes of the live scene meanwhile
        self._change: Change[Any, Any] | None = None

    def make(self, change: Change[Any, Any]) -> Any:
        """Make a change on the copy, and return what it made."""
        self.context = self.context.copy()
        made = change.on(SceneGraph(), self.context)
        self.maps_source = change.maps_after(self.maps_source, made)
        self.follow(change)
        return made

    def follow(self, change: Change[Any, Any]) -> None:
        """Have the names, robots and rules of a change that was made."""
        self._change = change
        if change.same_content:
            return
        self.robots = change.robots_after(self.robots)
        inspector = QueryObject(self.context).inspector()
        self.is_large = is_large(inspector)
        self.tables = ModelTables.of(
            inspector, self._world_frame, self.robots, self.maps_source, self._joints
        )
        _ = self.tables.joints.entries

    def get_ready(
        self,
        rehearse: Callable[[QueryObject], object] = lambda query: None,
        tell: Tell | None = None,
    ) -> None:
        """Make all that cycles need, once the copy was changed.

        ``rehearse`` asks the queries that cycles ask.
        """
        self.context.compile_kernels(tell)
        query = QueryObject(self.context)
        rehearse(query)
        query.num_waiting_pairs()
        query.waiting_frames()
        change = self._change
        rules = self._rules.rules
        if change is not None:
            rules = self._rules.after(change.rules, change.rules_gone)
        if rules:
            self.rules = self._rules.prepared(query, rules, same_names=self.tables is None)
            rehearse(self.rules.narrowed)
        query.inspector().geometry_version()
        self.context.what_if()  # views of the scene share what this makes
