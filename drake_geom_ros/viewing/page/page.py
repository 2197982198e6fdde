"""Page with its panels, its picture, and the thread that redraws on changes."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable
from html import escape

import numpy as np

from drake_geom_ros.viewing.extents import extent_of
from drake_geom_ros.viewing.joint_sliders import JointSliders
from drake_geom_ros.viewing.local_scene import LocalScene
from drake_geom_ros.viewing.page.answer_panel import AnswerPanel
from drake_geom_ros.viewing.page.copy_panel import CopyPanel
from drake_geom_ros.viewing.page.filter_panel import FilterPanel
from drake_geom_ros.viewing.page.motion_panel import MotionPanel
from drake_geom_ros.viewing.page.picture import MOST_NAMES, Picture
from drake_geom_ros.viewing.page.rules_panel import RulesPanel
from drake_geom_ros.viewing.page.sensors_panel import SensorsPanel
from drake_geom_ros.viewing.page.serving import Served
from drake_geom_ros.viewing.shown_scene import ShownMoment, ShownScene
from drake_geom_ros.viewing.timeline import Timeline

# [s] minimum time between two pictures; many events in between, as of a dragged slider, are one
# picture.
_PERIOD = 0.04
_LOOKS = 0.1  # [s] between two checks for changes of the scene from outside
_TABLE_PERIOD = 0.25  # [s] between two updates of the table, since nobody reads faster
_VIEW = np.array([0.55, -0.7, 0.45])  # direction to the viewer, of unit length
_AWAY, _MARGIN = 0.9, 0.2  # distance of the viewer: times the size of the scene, and [m]
_MOST_SHOWN = 5  # troubles in the status


class Page:
    """Display of a scene on a viser server until it is closed."""

    def __init__(
        self,
        served: Served,
        scene: ShownScene,
        *,
        joints: JointSliders | None = None,
        timeline: Timeline | None = None,
        max_distance: float = 0.1,
        accuracy: str = 'exact',
        contacts: bool = False,
        log: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Show a scene; ``joints`` and ``timeline`` move one of this process.

        ``log`` is called with unexpected errors. With ``contacts``, contact surfaces are computed
        and shown from the beginning.
        """
        server = served.server
        self._server, self._scene, self._log = server, scene, log
        self.url = served.url  # the address to open, with its token if it needs one
        local = scene if isinstance(scene, LocalScene) else None
        self._due, self._closed = threading.Event(), threading.Event()
        self._version: object = None
        self._table_due = 0.0  # [s] of the steady clock
        self.selected: tuple[int, int] | None = None
        self.moment: ShownMoment | None = None
        self.trouble = ''  # what went wrong in the last drawing
        server.gui.configure_theme(
            control_width='large',
            # Sharing would send the scene through a third party's relay.
            show_share_button=False,
            show_logo=False,
        )
        server.gui.main_panel.dock_right()
        server.scene.set_up_direction('+z')
        # viser's environment map takes a browser without a GPU seconds, and its shadows most of
        # each frame; lights without them show shapes as well.
        server.scene.configure_environment_map(None)
        server.scene.configure_default_lights(cast_shadow=False)
        self._status = server.gui.add_html('')
        self.answer = AnswerPanel(
            *(server.gui, self.touch, self.select, max_distance, accuracy), contacts=contacts
        )
        self.rules = RulesPanel(server.gui)
        self.sensors = SensorsPanel(server.gui, self.touch)
        self.filters = FilterPanel(server.gui, scene, local)
        self.motion = None
        if local is not None:
            self.motion = MotionPanel(server, local, self.touch, joints, timeline)
        self.copying = CopyPanel(server.gui, local)
        self.picture = Picture(server.scene, self.choose, self._progress)
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

    def select(self, pair: tuple[int, int]) -> None:
        """Select a pair of id values: mark it in picture and table, and explain its filters."""
        self.selected = pair
        if self.moment is not None:
            names = self.moment.geometries.names
            self.filters.choose_pair((names[pair[0]], names[pair[1]]))
        self._table_due = 0.0
        self.touch()

    def choose(self, value: int) -> None:
        """Handle a click on a geometry, by its id value."""
        if self.moment is None or value not in self.moment.geometries.names:
            return
        self.filters.choose(self.moment.geometries.names[value])
        pair = self.filters.pair()
        self.selected = None if pair is None else (min(pair), max(pair))
        self._table_due = 0.0
        self.touch()

    def close(self) -> None:
        """Stop drawing, and stop the server."""
        self._closed.set()
        self._due.set()
        self._thread.join()
        self._server.stop()

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
                self._status.content = _in_red(trouble)
            self._due.wait(_LOOKS)
            self._closed.wait(max(0.0, start + _PERIOD - time.monotonic()))

    def _draw_if_due(self) -> None:
        playing = self.motion is not None and self.motion.move_on()
        version = self._scene.version()
        due = self._due.is_set() or playing or version != self._version
        self._due.clear()
        if not due and self._table_due > time.monotonic():
            return
        if due:
            self._version = version
            self.draw()
        if self.moment is not None and self._table_due <= time.monotonic():
            self._table_due = time.monotonic() + _TABLE_PERIOD if due else float('inf')
            self._show_words(self.moment)

    def draw(self) -> None:
        """Draw the current moment of the scene."""
        before = None if self.moment is None else self.moment.geometries
        moment = self._scene.moment(
            self.answer.max_distance.value,
            self.answer.accuracy,
            contacts=self.answer.contacts.value,
        )
        with self._server.atomic():
            self.picture.show(moment, self.answer.display_options(), self.selected)
            self.picture.show_cells(self.sensors.chosen(moment.cells))
        if moment.geometries is not before:
            self._aim(moment)
            self.filters.begin(moment.geometries)
        self.moment = moment
        if moment.geometries is not before or self._table_due == float('inf'):
            self._table_due = 0.0

    def _aim(self, moment: ShownMoment) -> None:
        """Aim the initial camera at the geometries, except half spaces.

        viser moves the views of new browsers, and of those that wait for contents. For others it
        changes only the target of "reset view", since their users may have moved the view.
        """
        extent = extent_of(moment)
        if extent is not None:
            low, high = extent
            middle, size = (low + high) / 2.0, float(np.linalg.norm(high - low))
            camera = self._server.initial_camera
            # A browser moves its view once, by the first message, so send both in one.
            with self._server.atomic():
                camera.look_at = middle
                camera.position = middle + (_MARGIN + _AWAY * size) * _VIEW

    def _show_words(self, moment: ShownMoment) -> None:
        self.answer.show(moment, self.selected)
        self.rules.show(moment.rules)
        self.sensors.show(moment.cells)
        if self.motion is not None:
            self.motion.show()
        lines = [*moment.remarks, *self._remarks(moment)]
        troubles = self.picture.troubles
        if troubles:
            lines.append(f'{len(troubles)} cannot be drawn, such as')
        shown = ''.join(f'<div>{escape(line)}</div>' for line in lines)
        shown += ''.join(_in_red(trouble) for trouble in troubles[:_MOST_SHOWN])
        self._status.content = f'<div style="padding:0 1em">{shown}</div>'

    def _remarks(self, moment: ShownMoment) -> list[str]:
        """Return the remarks above the panels."""
        geometries, pairs = moment.geometries, moment.pairs
        touching = int((pairs.distance < 0.0).sum())
        remarks = [
            f'{len(geometries.ids)} geometries; {len(pairs)} pairs within '
            f'{self.answer.max_distance.value:g} m, {touching} of them overlap'
        ]
        if geometries.waiting:
            names = ', '.join(geometries.waiting[:_MOST_SHOWN])
            remarks.append(f'without a pose, and not shown: {names}')
        if self.answer.display_options().names and len(geometries.ids) > MOST_NAMES:
            remarks.append(f'names of the first {MOST_NAMES} only')
        return remarks

    def _progress(self, done: int, count: int) -> None:
        if done == count or done % 100 == 0:
            self._status.content = f'<div style="padding:0 1em">drawn {done} of {count}</div>'


def _in_red(text: str) -> str:
    return f'<div style="color:#c00;padding:0 1em">{escape(text)}</div>'
