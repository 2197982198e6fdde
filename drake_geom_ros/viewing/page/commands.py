"""Commands of browsers: their names, what they take, and what each does to the page."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.common.frame_names import AmbiguousNameError
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.viewing.local_scene import LocalScene
from drake_geom_ros.viewing.page.motion_control import SPEEDS, MotionControl
from drake_geom_ros.viewing.page.options import CommandError, flag, number, text, vector
from drake_geom_ros.viewing.texts import as_csv, as_yaml

Replies = dict[str, Any] | None
_FORMATS = {'yaml': as_yaml, 'csv': as_csv}
_MOST_STEPS = 1000
_PAIR, _BODY = 0.3, 0.5  # [m] what a camera sees around a pair, or a body, that it flies to


class Commands:
    """The methods ``do_NAME`` carry out commands; their arguments are those of the message."""

    def __init__(self, page: Any) -> None:
        """Command ``page``, a ``Page``, whose module imports this one."""
        self._page = page

    def execute(self, key: str, command: dict[str, Any]) -> dict[str, Any]:
        """Carry out a command of the browser with a key; return sections for that browser.

        Raises CommandError, with the reason, for what cannot be done.
        """
        arguments = dict(command)
        name = arguments.pop('do')
        method: Callable[..., Replies] | None = getattr(self, f'do_{name}', None)
        if method is None:
            names = [each[3:] for each in dir(self) if each.startswith('do_')]
            raise CommandError(f'{name!r} is no command{nearest(name, names)}')
        try:
            inspect.signature(method).bind(key, **arguments)
        except TypeError as error:
            raise CommandError(f'{name}: {error}') from None
        try:
            return method(key, **arguments) or {}
        except (GeometryError, OSError, RuntimeError) as error:
            raise CommandError(f'{name}: {error}') from error

    # What is shown.

    def do_option(self, key: str, name: Any, value: Any) -> Replies:
        """Change an option of the page."""
        self._page.set_option(text(name, 'name'), value)
        return None

    def do_select(self, key: str, bodies: Any) -> Replies:
        """Select bodies by their id values, at most two."""
        if (
            not isinstance(bodies, list)
            or len(set(map(str, bodies))) != len(bodies)
            or (len(bodies) > 2)
        ):
            raise CommandError(f'bodies must be at most two different ids, not {bodies!r}')
        self._page.select(*map(self._page.check_body, bodies))
        return None

    def do_select_names(self, key: str, names: Any) -> Replies:
        """Select bodies by their names; those that are not there are left out."""
        if not isinstance(names, list) or len(names) > 2:
            raise CommandError(f'names must be at most two texts, not {names!r}')
        values = [self._page.number_of(text(name, 'names')) for name in dict.fromkeys(names)]
        self._page.select(*[value for value in values if value is not None])
        return None

    def do_pick(self, key: str, body: Any) -> Replies:
        """Do what a click on a body in the picture does."""
        self._page.pick(self._page.check_body(body))
        return None

    # Where a browser looks.

    def do_view(self, key: str, name: Any) -> Replies:
        """Look at the whole scene from a side."""
        self._page.cameras.preset(key, text(name, 'name'))
        return None

    def do_look(self, key: str, position: Any, look_at: Any) -> Replies:
        """Place the camera."""
        self._page.cameras.place(
            key, vector(position, 'position [m]', 3), vector(look_at, 'look_at [m]', 3)
        )
        return None

    def do_fly(self, key: str) -> Replies:
        """Look at what is selected from near by."""
        page = self._page
        shown = page.board.value('selection') or {}
        pair = shown.get('pair') or {}
        if 'p_WCa' in pair:
            ends = np.array([pair['p_WCa'], pair['p_WCb']])
            gap = float(np.linalg.norm(ends[1] - ends[0]))
            page.cameras.fly_to(key, ends.mean(axis=0), max(gap, _PAIR))
            return None
        poses = [] if page.moment is None else map(page.moment.pose_of, page.selection.values)
        places = [X.translation() for X in poses if X is not None]
        if not places:
            raise CommandError('nothing is selected that has a pose')
        page.cameras.fly_to(key, np.mean(places, axis=0), _BODY)
        return None

    def do_visit(self, key: str, bodies: Any) -> Replies:
        """Select a pair, and look at its nearest points from near by."""
        self.do_select(key, bodies)
        page = self._page
        pair, moment = page.selection.pair, page.moment
        row = None if pair is None or moment is None else moment.pairs.find(pair)
        if moment is None or row is None:
            return self.do_fly(key)
        ends = moment.pairs.segments()[row]
        page.cameras.fly_to(key, ends.mean(axis=0), max(_PAIR, abs(moment.pairs.distance[row])))
        return None

    def do_dark(self, key: str, on: Any) -> Replies:
        """Draw on a dark ground, or on a light one."""
        self._page.cameras.darken(key, dark=flag(on, 'on'))
        return None

    def do_picture(self, key: str) -> Replies:
        """Keep what the browser sees as a file."""
        self._page.cameras.save(key, f'{self._page.title}.png')
        return None

    # What moves.

    def do_time(self, key: str, value: Any) -> Replies:
        """Go to a time [s] of the motion."""
        self._motion().go_to(number(value, 'value [s]'))
        return None

    def do_play(self, key: str, on: Any) -> Replies:
        """Play the motion, or pause."""
        self._motion().play(on=flag(on, 'on'))
        return None

    def do_speed(self, key: str, value: Any) -> Replies:
        """Play the motion so many times as fast."""
        self._motion().speed = number(value, 'value', *SPEEDS)
        self._page.touch()
        return None

    def do_step(self, key: str, count: Any) -> Replies:
        """Go on by some of the times of the motion, back if negative."""
        self._motion().step(round(number(count, 'count', -_MOST_STEPS, _MOST_STEPS)))
        return None

    def do_least(self, key: str) -> Replies:
        """Go to the time of the minimum distance."""
        self._motion().go_to_least()
        return None

    def do_joint(self, key: str, name: Any, value: Any) -> Replies:
        """Set a joint [rad] or [m]."""
        self._motion().move_joint(text(name, 'name'), number(value, 'value [rad] or [m]'))
        return None

    def do_reset(self, key: str) -> Replies:
        """Put joints, frames and time back to the beginning."""
        self._motion().reset()
        return None

    def do_frame(self, key: str, name: Any) -> Replies:
        """Put the gizmo on a frame, or nowhere."""
        self._motion().take_frame(text(name, 'name'))
        self._page.touch()
        return None

    def do_poses(self, key: str, format: Any) -> Replies:
        """Return the poses of now as a text."""
        if format not in _FORMATS:
            raise CommandError(f'format must be one of {", ".join(_FORMATS)}, not {format!r}')
        try:
            content = _FORMATS[format](self._local().poses())
        except AmbiguousNameError as error:
            raise CommandError(f'the poses cannot be written in this form: {error}') from None
        return {'file': {'name': f'poses.{format}', 'text': content}}

    # Filters.

    def do_declare(self, key: str, allow: Any) -> Replies:
        """Exclude the selected pair, or allow it."""
        pair = self._page.selection.pair
        if pair is None:
            raise CommandError('select two bodies first')
        local = self._local()
        (local.allow if flag(allow, 'allow') else local.exclude)(pair)
        self._page.refilter()
        return None

    def do_switch(self, key: str, row: Any, on: Any) -> Replies:
        """Switch one of the declarations on or off."""
        local = self._local()
        count = len(local.history())
        local.switch(int(number(row, 'row', 0, count - 1)), on=flag(on, 'on'))
        self._page.refilter()
        return None

    def _motion(self) -> MotionControl:
        motion: MotionControl | None = self._page.motion
        if motion is None:
            raise CommandError('the scene of a running node is not moved from here')
        return motion

    def _local(self) -> LocalScene:
        local: LocalScene | None = self._page.local
        if local is None:
            raise CommandError('the scene of a running node is not changed from here')
        return local
