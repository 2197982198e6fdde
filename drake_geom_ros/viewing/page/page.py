"""Page with its picture, its sections, and the thread that redraws on changes."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from drake_geom_ros.geometry import GeometryError, accuracy_of
from drake_geom_ros.viewing.extents import extent_of
from drake_geom_ros.viewing.joint_sliders import JointSliders
from drake_geom_ros.viewing.local_scene import LocalScene
from drake_geom_ros.viewing.page import sections
from drake_geom_ros.viewing.page.board import Board
from drake_geom_ros.viewing.page.browsers import Browsers
from drake_geom_ros.viewing.page.cameras import Cameras
from drake_geom_ros.viewing.page.commands import Commands
from drake_geom_ros.viewing.page.motion_control import MotionControl, PlottedPairs
from drake_geom_ros.viewing.page.options import ViewOptions
from drake_geom_ros.viewing.page.picture import MOST_NAMES, Picture
from drake_geom_ros.viewing.page.selection import SelectedBodies, Selection
from drake_geom_ros.viewing.page.serving import Served
from drake_geom_ros.viewing.shown_scene import ShownMoment, ShownScene
from drake_geom_ros.viewing.timeline import Timeline

# [s] minimum time between two pictures; many events in between, as of a dragged slider, are one
# picture.
_PERIOD = 0.04
_LOOKS = 0.1  # [s] between two checks for changes of the scene from outside
_TABLE_PERIOD = 0.25  # [s] between two updates of the tables, since nobody reads faster
_MOST_SHOWN = 5  # troubles in the status
_AMBIENT = 1.2  # intensity of the light from all sides


class Page:
    """Display of a scene on a viser server until it is closed."""

    def __init__(
        self,
        served: Served,
        scene: ShownScene,
        *,
        joints: JointSliders | None = None,
        timeline: Timeline | None = None,
        plotted: PlottedPairs | None = None,
        max_distance: float = 0.1,
        accuracy: str = 'exact',
        contacts: bool = False,
        title: str = 'scene',
        log: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Show a scene; ``joints`` and ``timeline`` move one of this process.

        The plot of the timeline is about the pairs ``plotted``, without these about all.

        ``title`` is the name of the tab. ``log`` is called with unexpected errors. With
        ``contacts``, contact surfaces are computed and shown from the beginning.
        """
        server = served.server
        self._server, self.scene, self._log = server, scene, log
        self.url = served.url  # the address to open, with its token if it needs one
        self.title = title
        self.local = scene if isinstance(scene, LocalScene) else None
        self._due, self._closed = threading.Event(), threading.Event()
        self._version: object = None
        self._table_due = 0.0  # [s] of the steady clock
        self.options = ViewOptions(
            max_distance=max_distance, accuracy=str(accuracy_of(accuracy)), contacts=contacts
        )
        self.selection = Selection()
        self._lock = threading.Lock()  # of the options and the selection
        self.moment: ShownMoment | None = None
        self.trouble = ''  # what went wrong in the last drawing
        self.board = Board()
        server.scene.set_up_direction('+z')
        # viser's environment map takes a browser without a GPU seconds, and its shadows most of
        # each frame; lights without them show shapes as well.
        server.scene.configure_environment_map(None)
        server.scene.configure_default_lights(cast_shadow=False)
        # Without it, sides that no lamp reaches are black, whatever their colour.
        server.scene.add_light_ambient('/ambient', intensity=_AMBIENT)
        self.motion = None
        if self.local is not None:
            self.motion = MotionControl(server, self.local, self.touch, joints, timeline, plotted)
        self.bodies = SelectedBodies(scene, self.touch)
        self.picture = Picture(server.scene, self.pick, self._progress)
        self.browsers = Browsers(self.board, Commands(self).execute)
        self.cameras = Cameras(
            server, lambda key, pose: self.browsers.send_to(key, 'camera', pose)
        )
        self._show_fixed()
        served.serve = self.browsers.serve
        self._thread = threading.Thread(target=self._run, name='page', daemon=True)
        self._thread.start()

    @property
    def host(self) -> str:
        """The address that it is served at."""
        return str(self._server.get_host())

    @property
    def port(self) -> int:
        """The port that it is served at."""
        return int(self._server.get_port())

    def touch(self) -> None:
        """Request another picture."""
        self._due.set()

    def set_option(self, name: str, value: Any) -> None:
        """Change an option; raises CommandError for a value that it cannot have."""
        with self._lock:
            self.options = self.options.changed(name, value)
        self.board.put('options', self.options.plain())
        self._hurry()

    def select(self, *values: int) -> None:
        """Select at most two bodies by their id values."""
        with self._lock:
            self.selection = Selection(values)
        self._hurry()

    def pick(self, value: int) -> None:
        """Handle a click on a body, by its id value."""
        if self.moment is None or value not in self.moment.geometries.names:
            return
        with self._lock:
            self.selection = self.selection.picked(value)
        self._hurry()

    def refilter(self) -> None:
        """Show filters and their reasons anew, since they changed."""
        self.bodies.explain_anew()
        self._show_filters()
        self._hurry()

    def close(self) -> None:
        """Stop drawing, and stop the server."""
        self._closed.set()
        self._due.set()
        self._thread.join()
        self.bodies.close()
        self._server.stop()

    def _hurry(self) -> None:
        """Request another picture, and new tables with it."""
        self._table_due = 0.0
        self.touch()

    def _run(self) -> None:
        while not self._closed.is_set():
            start = time.monotonic()
            try:
                self._draw_if_due()
                self.trouble = ''
            except Exception as error:  # report it and keep the page alive
                if (trouble := f'{type(error).__name__}: {error}') != self.trouble:
                    self.trouble = trouble
                    self._log(''.join(traceback.format_exception(error)))
                self.board.put('status', sections.status_section([], [trouble]))
            self._due.wait(_LOOKS)
            self._closed.wait(max(0.0, start + _PERIOD - time.monotonic()))

    def _draw_if_due(self) -> None:
        playing = self.motion is not None and self.motion.move_on()
        version = self.scene.version()
        due = self._due.is_set() or playing or version != self._version
        self._due.clear()
        if not due and self._table_due > time.monotonic():
            return
        if due:
            self._version = version
            self.draw()
        if self.moment is not None and self._table_due <= time.monotonic():
            self._table_due = time.monotonic() + _TABLE_PERIOD if due else float('inf')
            self._show_tables(self.moment)

    def draw(self) -> None:
        """Draw the current moment of the scene."""
        before = None if self.moment is None else self.moment.geometries
        options = self.options
        moment = self.scene.moment(
            options.max_distance, options.accuracy, contacts=options.contacts
        )
        if moment.geometries is not before:
            self._keep_selection(moment)
        selection = self.selection
        plain, pair = self.bodies.plain(moment, selection, options.accuracy)
        with self._server.atomic():
            self.picture.show(moment, options, selection.values, pair)
            self.picture.show_cells(self._chosen_cells(moment))
        if moment.geometries is not before and (extent := extent_of(moment)) is not None:
            self.cameras.show(extent)
        self.moment = moment
        if moment.geometries is not before:
            self.board.put('scene', sections.scene_section(moment.geometries, self.title))
        self.board.put('selection', plain)
        if self.motion is not None:
            self.board.put('clock', sections.clock_section(self.motion))
            self.board.put('values', sections.values_section(self.motion))
        if moment.geometries is not before or self._table_due == float('inf'):
            self._table_due = 0.0

    def _keep_selection(self, moment: ShownMoment) -> None:
        """Drop selected bodies that are gone."""
        there = moment.geometries.names
        with self._lock:
            values = tuple(value for value in self.selection.values if value in there)
            self.selection = replace(self.selection, values=values)

    def _chosen_cells(self, moment: ShownMoment) -> list[Any]:
        options = self.options
        return [
            layer
            for layer in moment.cells
            if layer.kind not in options.hidden_cells
            and f'sensor {layer.source}' not in options.hidden
        ]

    def _show_fixed(self) -> None:
        """Put the sections that do not depend on a moment."""
        self.board.put('options', self.options.plain())
        self.board.put('kind', {'live': self.local is None, 'title': self.title})
        if self.motion is not None:
            self.board.put('motion', sections.joints_section(self.motion))
        self._show_filters()

    def _show_filters(self) -> None:
        history = [] if self.local is None else self.local.history()
        rows = [[declared.text, declared.filter_id is not None] for declared in history]
        self.board.put('filters', rows)

    def _show_tables(self, moment: ShownMoment) -> None:
        self.board.put('pairs', sections.pairs_section(moment))
        self.board.put('rules', sections.rules_section(moment))
        self.board.put('sensors', sections.sensors_section(moment))
        self.board.put('tables', sections.tables_section(moment))
        if self.motion is not None:
            self.board.put('timeline', sections.timeline_section(self.motion))
        troubles = self.picture.troubles
        shown = list(troubles[:_MOST_SHOWN])
        if troubles:
            shown.insert(0, f'{len(troubles)} cannot be drawn, such as')
        lines = [*moment.remarks, *self._remarks(moment)]
        self.board.put('status', sections.status_section(lines, shown))

    def _remarks(self, moment: ShownMoment) -> list[str]:
        """Return what the picture does not show."""
        geometries = moment.geometries
        remarks = []
        if geometries.waiting:
            names = ', '.join(geometries.waiting[:_MOST_SHOWN])
            remarks.append(f'without a pose, and not shown: {names}')
        if self.options.hidden:
            hidden = ', '.join(sorted(self.options.hidden))
            remarks.append(f'hidden, with their lines: {hidden}')
        if self.options.names and len(geometries.ids) > MOST_NAMES:
            remarks.append(f'names of the first {MOST_NAMES} only')
        return remarks

    def _progress(self, done: int, count: int) -> None:
        if done == count or done % 100 == 0:
            self.board.put('progress', {'done': done, 'count': count})

    def number_of(self, name: str) -> int | None:
        """Return the id value of a body by its name; None if there is none."""
        if self.moment is None:
            return None
        names = self.moment.geometries.names
        return next((value for value, each in names.items() if each == name), None)

    def check_body(self, value: Any) -> int:
        """Return the id value of a body that is there; raises GeometryError otherwise."""
        is_number = isinstance(value, int) and not isinstance(value, bool)
        if is_number and self.moment is not None and value in self.moment.geometries.names:
            return int(value)
        raise GeometryError(f'{value!r} is no body of this scene')
