"""Service requests whose values are converted to the types of their fields, or refused.

In its default mode rclpy checks no types: it sends the bits of an integer as those of a double,
reads every value but ``True`` itself as false, and drops what overflows.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.common.nearest import nearest

_BITS = {'int8': 8, 'int16': 16, 'int32': 32, 'int64': 64}
_FLOATS = ('double', 'float')
_INTEGERS = {
    **{name: (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for name, bits in _BITS.items()},
    **{f'u{name}': (0, 2**bits - 1) for name, bits in _BITS.items()},
    **dict.fromkeys(('octet', 'byte', 'char'), (0, 255)),
}


class RequestError(RuntimeError):
    """A request has an unknown field, or a value that its field's type excludes."""


def request_of(kind: Any, fields: dict[str, Any], service: str) -> Any:
    """Return a request of type ``kind`` with each value converted to its field's type.

    Integers, NumPy scalars and other values that convert exactly are converted, also within
    nested messages; the caller's messages are not modified. Raises RequestError for an unknown
    field and for a value that does not convert.
    """
    types = kind.get_fields_and_field_types()
    for name in fields:
        if name not in types:
            raise RequestError(
                f'{service}: there is no field {name!r}{nearest(name, types)}; the request has '
                f'{", ".join(types) or "no fields"}'
            )
    converted = {
        name: _converted(value, types[name], f'{service}: {name}')
        for name, value in fields.items()
    }
    return kind(**converted)


def _converted(value: Any, kind: str, path: str) -> Any:
    """Return a value converted to a field's type; ``value`` itself if it needs no conversion."""
    element = kind.removeprefix('sequence<').partition('[')[0].partition(',')[0].rstrip('>')
    if element == kind:
        return _converter(kind)(value, kind, path)
    return _array(value, element, path)


def _converter(kind: str) -> Callable[[Any, str, str], Any]:
    if kind in _FLOATS:
        return _float
    if kind in _INTEGERS:
        return _integer
    if kind == 'boolean':
        return _boolean
    return _message if '/' in kind else _text


def _float(value: Any, kind: str, path: str) -> float:
    if type(value) is float:
        return value
    if isinstance(value, (bool, np.bool_, str, bytes)):
        raise _refusal(value, kind, path)
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise _refusal(value, kind, path) from None


def _integer(value: Any, kind: str, path: str) -> Any:
    if isinstance(value, bytes) and len(value) == 1:  # a field of bytes
        return value
    if isinstance(value, (bool, np.bool_)):
        raise _refusal(value, kind, path)
    try:
        number = operator.index(value)
    except TypeError:
        raise _refusal(value, kind, path) from None
    lowest, highest = _INTEGERS[kind]
    if not lowest <= number <= highest:
        raise RequestError(f'{path} is {number}; {kind} goes from {lowest} to {highest}')
    return number


def _boolean(value: Any, kind: str, path: str) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise _refusal(value, kind, path)
    return bool(value)


def _text(value: Any, kind: str, path: str) -> str:
    if not isinstance(value, str):
        raise _refusal(value, kind, path)
    return value


def _message(value: Any, kind: str, path: str) -> Any:
    """Return a message whose fields are all of their types."""
    if not hasattr(value, 'get_fields_and_field_types'):
        raise _refusal(value, kind, path)
    changed = {}
    for name, of_field in value.get_fields_and_field_types().items():
        before = getattr(value, name)
        after = _converted(before, of_field, f'{path}.{name}')
        if after is not before:
            changed[name] = after
    if not changed:
        return value
    names = value.get_fields_and_field_types()
    return type(value)(**{name: changed.get(name, getattr(value, name)) for name in names})


def _array(value: Any, element: str, path: str) -> Any:
    """Return a sequence whose elements are all of their type."""
    if isinstance(value, (str, set)) or not hasattr(value, '__len__'):
        raise _refusal(value, f'a sequence of {element}', path)
    if element in _FLOATS:
        return _numbers(value, element, path)
    if isinstance(value, (bytes, bytearray)):  # a field of bytes
        return value
    converter = _converter(element)
    after = [converter(each, element, f'{path}[{k}]') for k, each in enumerate(value)]
    is_same = all(a is b for a, b in zip(after, value, strict=True))
    return value if is_same else after


def _numbers(value: Any, element: str, path: str) -> Any:
    """Return floating-point numbers as a sequence; arrays of doubles pass unchanged."""
    if getattr(value, 'typecode', '') == 'd':
        return value
    try:
        numbers = np.asarray(value)
        if numbers.dtype.kind not in 'fiu' and numbers.size:
            raise TypeError
        floats = numbers.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise _refusal(value, f'numbers ({element})', path) from None
    if floats.ndim != 1:
        raise RequestError(f'{path} has the shape {floats.shape}; it must be flat, (n,)')
    is_same = isinstance(value, np.ndarray) and floats.dtype == value.dtype
    return value if is_same else floats.tolist()


def _refusal(value: Any, kind: str, path: str) -> RequestError:
    shown = repr(value)
    shown = shown if len(shown) <= 80 else f'{shown[:77]}...'
    return RequestError(f'{path} is {shown} ({type(value).__name__}); it must be {kind}')
