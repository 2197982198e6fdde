"""Panel of filters: explains whether a pair is reported, and changes it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from html import escape
from typing import Any, Protocol

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.viewing.local_scene import Declared
from drake_geom_ros.viewing.shown_scene import ShownGeometries, ShownScene


class FilteredScene(ShownScene, Protocol):
    """A scene whose filters a page may change."""

    def exclude(self, pair: tuple[int, int]) -> None:
        """Exclude a pair."""

    def allow(self, pair: tuple[int, int]) -> None:
        """Allow a pair."""

    def history(self) -> list[Declared]:
        """Return the declarations in their order."""

    def switch(self, index: int, *, on: bool) -> None:
        """Switch a declaration on or off."""


class FilterPanel:
    """Panel with two names, typed or picked in the picture, and an explanation of their pair."""

    def __init__(self, gui: Any, scene: ShownScene, changes: FilteredScene | None) -> None:
        """Explain pairs of ``scene``; ``changes`` None: filters cannot be changed."""
        self._gui = gui
        self._scene = scene
        self._changes = changes
        self._values: dict[str, int] = {}
        self._switches: list[Any] = []
        self._folder = gui.add_folder('Filters')
        with self._folder:
            self.texts = [gui.add_text(label, '') for label in ('A', 'B')]
            self.explanation = gui.add_html('Click on two geometries, or type their names.')
            if changes is not None:
                for word, change in (('exclude', changes.exclude), ('allow', changes.allow)):
                    gui.add_button(f'{word} this pair').on_click(partial(self._declare, change))
        for text in self.texts:
            text.on_update(lambda _: self.explain())

    def begin(self, geometries: ShownGeometries) -> None:
        """Use the names of other geometries from now on."""
        self._values = {name: value for value, name in geometries.names.items()}
        self.explain()

    def choose(self, name: str) -> None:
        """Set B to a picked geometry, and A to the former B."""
        first, second = self.texts
        if name != second.value:
            first.value, second.value = second.value, name

    def choose_pair(self, names: tuple[str, str]) -> None:
        """Set both names."""
        for text, name in zip(self.texts, names, strict=True):
            text.value = name

    def pair(self) -> tuple[int, int] | None:
        """Return the pair by id values; None unless both names are those of geometries."""
        values = [self._values.get(text.value.strip()) for text in self.texts]
        a, b = values
        return None if a is None or b is None else (a, b)

    def explain(self) -> None:
        """Update the explanation of the pair."""
        self.explanation.content = (
            f'<div style="padding:0 1em">{escape(self._explanation())}</div>'
        )

    def _explanation(self) -> str:
        names = [text.value.strip() for text in self.texts]
        for name in filter(None, names):
            if name not in self._values:
                return f'{name!r} is no geometry of this scene{nearest(name, self._values)}'
        pair = self.pair()
        if pair is None:
            return 'Click on two geometries, or type their names.'
        try:
            reasons = self._scene.explain(pair)
        except (GeometryError, RuntimeError) as error:
            return str(error)
        if reasons:
            return f'Filtered by: {", ".join(reasons)}.'
        return 'Reported, where it is within max_distance.'

    def _declare(self, change: Callable[[tuple[int, int]], None], event: Any) -> None:
        pair = self.pair()
        if pair is None:
            return
        try:
            change(pair)
        except GeometryError as error:
            self.explanation.content = escape(str(error))
            return
        self.show_history()
        self.explain()

    def show_history(self) -> None:
        """Add a switch for each declaration of the history that has none yet."""
        if self._changes is None:
            return
        with self._folder:
            for index, declared in enumerate(self._changes.history()):
                if index >= len(self._switches):
                    box = self._gui.add_checkbox(declared.text, declared.filter_id is not None)
                    box.on_update(partial(self._switched, index))
                    self._switches.append(box)

    def _switched(self, index: int, event: Any) -> None:
        assert self._changes is not None
        self._changes.switch(index, on=event.target.value)
        self.explain()
