"""Buttons and sliders by name, as Meshcat has them, in viser's panel."""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from drake_geom_ros.geometry import ArgumentError, GeometryError
from drake_geom_ros.geometry.checks import as_number

_KEYS = (
    *('ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight', 'PageUp', 'PageDown', 'Home', 'End'),
    *('Space', 'Enter', 'Escape', 'Tab', 'Backspace', 'Delete', 'Insert'),
)


@dataclass
class _Button:
    handle: Any
    keycode: str
    clicks: int = 0
    commands: list[Any] = field(default_factory=list)


@dataclass
class _Slider:
    handle: Any
    lower: float
    upper: float
    step: float
    commands: list[Any] = field(default_factory=list)

    def rounded(self, value: float) -> float:
        """Return a value within the range, at a multiple of the step as far as one is there."""
        inside = min(max(value, self.lower), self.upper)
        steps = math.copysign(math.floor(abs(inside) / self.step + 0.5), inside)
        for each in (steps, steps - 1.0, steps + 1.0):
            if self.lower <= each * self.step <= self.upper:
                return each * self.step
        return inside


class Controls:
    """Buttons and sliders; any thread may call it, beside the threads of viser's events."""

    def __init__(self, gui: Any) -> None:
        """Add controls to the panel of a viser server."""
        self._gui = gui
        self._lock = threading.RLock()
        self._buttons: dict[str, _Button] = {}
        self._sliders: dict[str, _Slider] = {}

    def add_button(self, name: str, keycode: str) -> None:
        """Add a button, or set the clicks of the one of this name to 0; see Meshcat.AddButton."""
        if keycode:
            _hotkey(keycode)  # refused before anything is changed
        with self._lock:
            if name in self._sliders:
                raise GeometryError(f'there is a slider {name!r} already')
            button = self._buttons.get(name)
            if button is None:
                button = self._buttons[name] = _Button(self._gui.add_button(name), '')
                button.handle.on_click(lambda event: self._clicked(button))
            elif keycode and button.keycode and keycode != button.keycode:
                raise GeometryError(
                    f'the button {name!r} has the keycode {button.keycode!r}, and not '
                    f'{keycode!r}; delete it before it gets another one'
                )
            button.clicks = 0
            if keycode and not button.keycode:
                button.commands += self._commands(name, {keycode: partial(self._clicked, button)})
                button.keycode = keycode

    def clicks(self, name: str) -> int:
        """Return how often a button was clicked since it was added."""
        with self._lock:
            button: _Button = _of(self._buttons, name, 'button')
            return button.clicks

    def add_slider(
        self,
        name: str,
        lower: float,
        upper: float,
        step: float,
        value: float,
        decrement_keycode: str,
        increment_keycode: str,
    ) -> float:
        """Add a slider and return its value; see Meshcat.AddSlider."""
        numbers = {'min': lower, 'max': upper, 'step': step, 'value': value}
        for key, number in numbers.items():
            if (made := as_number(number)) is None or not math.isfinite(made):
                raise ArgumentError(f'{key}={number!r} must be a finite number')
        if not lower <= upper or not step > 0.0:
            raise ArgumentError(f'min={lower!r} must be <= max={upper!r}, and step={step!r} > 0')
        keys = {decrement_keycode: -float(step), increment_keycode: float(step)}
        for key in filter(None, keys):
            _hotkey(key)  # refused before anything is changed
        with self._lock:
            for kind, there in (('button', self._buttons), ('slider', self._sliders)):
                if name in there:
                    raise GeometryError(f'there is a {kind} {name!r} already')
            slider = _Slider(None, float(lower), float(upper), float(step))
            first = slider.rounded(float(value))
            slider.handle = self._gui.add_slider(
                name, slider.lower, slider.upper, slider.step, first
            )
            self._sliders[name] = slider
            steps = {key: partial(self._step, name, by) for key, by in keys.items() if key}
            slider.commands += self._commands(name, steps)
        return first

    def slider(self, name: str) -> float:
        """Return the value of a slider."""
        with self._lock:
            return float(_of(self._sliders, name, 'slider').handle.value)

    def set_slider(self, name: str, value: float) -> float:
        """Set the value of a slider, and return the one that it has then."""
        number = as_number(value)
        if number is None or not math.isfinite(number):
            raise ArgumentError(f'value={value!r} must be a finite number')
        with self._lock:
            slider: _Slider = _of(self._sliders, name, 'slider')
            rounded = slider.rounded(number)
            slider.handle.value = rounded
        return rounded

    def names(self, kind: str) -> list[str]:
        """Return the names of all buttons, or of all sliders, in their order."""
        with self._lock:
            return sorted(self._buttons if kind == 'button' else self._sliders)

    def delete(self, name: str, kind: str, strict: bool) -> bool:
        """Remove a button or a slider and return whether it was there."""
        there: dict[str, Any] = self._buttons if kind == 'button' else self._sliders
        with self._lock:
            if name not in there and not strict:
                return False
            control = _of(there, name, kind)
            del there[name]
            for handle in (control.handle, *control.commands):
                handle.remove()
        return True

    def delete_all(self) -> None:
        """Remove all buttons and sliders."""
        with self._lock:
            for kind in ('button', 'slider'):
                for name in self.names(kind):
                    self.delete(name, kind, strict=True)

    def _step(self, name: str, by: float) -> None:
        with self._lock:
            self.set_slider(name, self.slider(name) + by)

    def _clicked(self, button: _Button) -> None:
        with self._lock:
            button.clicks += 1

    def _commands(self, name: str, by_key: Mapping[str, Callable[[], None]]) -> list[Any]:
        """Return commands of viser's palette, each by its key; raises ArgumentError."""
        made = []
        for keycode, call in by_key.items():
            command = self._gui.add_command(f'{name} ({keycode})', hotkey=_hotkey(keycode))
            command.on_trigger(lambda event, call=call: call())
            made.append(command)
        return made


def _of(there: dict[str, Any], name: str, kind: str) -> Any:
    """Return a control by its name; raises GeometryError."""
    if name not in there:
        raise GeometryError(f'there is no {kind} {name!r}, only {sorted(there)}')
    return there[name]


def _hotkey(keycode: str) -> str:
    """Return viser's name of a key by JavaScript's code of it; raises ArgumentError."""
    match = re.fullmatch(r'Key([A-Z])|Digit([0-9])', keycode)
    if match:
        return match[1] or match[2]
    if keycode in _KEYS:
        return keycode.lower()
    raise ArgumentError(
        f'keycode={keycode!r} is no key of the page; it must be KeyA to KeyZ, Digit0 to Digit9, '
        f'or one of {", ".join(_KEYS)}'
    )
