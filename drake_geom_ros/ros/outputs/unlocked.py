"""Hands messages to rcl without the interpreter's lock.

rclpy keeps the lock while it turns a message into C, while the middleware serialises that and
while it hands it over: for an image of 0.9 MB that is 1.5 ms, which a cycle in another thread
waits for. Here it is turned into C as rclpy does it, and handed to rcl by ctypes, which gives the
lock back meanwhile.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

from rclpy.publisher import Publisher

_OK = 0  # RCL_RET_OK


def publish(publisher: Publisher, message: Any) -> None:
    """Publish a message; raises RuntimeError where rcl refuses it."""
    send = of_rcl('rcl_publish')
    if send is None:
        publisher.publish(message)
        return
    with publisher.handle:
        copied = CMessage(message)  # kept until rcl has read it
        result = send(publisher.handle.pointer, copied.address, None)
    if result != _OK:
        raise RuntimeError(
            f'a message on {publisher.topic_name} was not sent: rcl returned {result}'
        )


class LargePublisher:
    """A publisher of messages that may be large; for an object that takes any publisher."""

    def __init__(self, publisher: Publisher) -> None:
        self._publisher = publisher

    def publish(self, message: Any) -> None:
        """Publish a message as ``publish`` does."""
        publish(self._publisher, message)

    def get_subscription_count(self) -> int:
        """Return how many listen."""
        return int(self._publisher.get_subscription_count())


class CMessage:
    """A message as the C message that rcl takes and fills; freed with this object."""

    def __init__(self, message: Any) -> None:
        self._make(type(message))
        convert = self._of_python('_CONVERT_FROM_PY', ctypes.c_bool, ctypes.py_object)
        convert(message, self.address)

    @classmethod
    def room_for(cls, kind: type[Any]) -> CMessage:
        """Return an empty message of a type, for rcl to fill."""
        room = cls.__new__(cls)
        room._make(kind)
        return room

    def to_python(self) -> Any:
        """Return the message as rclpy has it."""
        return self._of_python('_CONVERT_TO_PY', ctypes.py_object)(self.address)

    def _make(self, kind: type[Any]) -> None:
        self._support = support = type(kind)
        self._destroy = _function(support, '_DESTROY_ROS_MESSAGE', None, ctypes.c_void_p)
        self.address = _function(support, '_CREATE_ROS_MESSAGE', ctypes.c_void_p)()

    def _of_python(self, name: str, result: Any, *arguments: Any) -> Any:
        """Return a function that works on Python's objects.

        It keeps the lock, raises what it raises, and its last argument is the C message.
        """
        types = *arguments, ctypes.c_void_p
        return _function(self._support, name, result, *types, of_python=True)

    def __del__(self) -> None:
        self._destroy(self.address)


def _function(
    support: Any, name: str, result: Any, *arguments: Any, of_python: bool = False
) -> Any:
    """Return a function of a message's type support, which rosidl keeps in a capsule."""
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    kind = ctypes.PYFUNCTYPE if of_python else ctypes.CFUNCTYPE
    return kind(result, *arguments)(pointer(getattr(support, name), None))


@cache
def of_rcl(name: str) -> Any:
    """Return a function of rcl that takes three addresses; None where it is not found."""
    try:
        function = getattr(ctypes.CDLL('librcl.so'), name)
    except (OSError, AttributeError):
        return None
    function.restype = ctypes.c_int
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    return function
