"""Sends the answers of services without the interpreter's lock, and counts what has no answer.

With the lock, as rclpy sends it, an answer of 67 MB lets nothing else of the process run for 33 to
93 ms, and where the middleware never returns, as from a mutex in shared memory that a killed
client held, nothing ever runs again. So it is turned into a message as rclpy does it (which lets
other threads in between two fields, after at most 9 ms for 67 MB), and sent as ``unlocked`` does.
"""

from __future__ import annotations

import ctypes
import threading
from collections import OrderedDict
from functools import partial
from typing import Any, NamedTuple

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.service import Service

from drake_geom_ros.ros.outputs.unlocked import CMessage, of_rcl

_OK, _TIMEOUT = 0, 2  # RCL_RET_OK, RCL_RET_TIMEOUT
# A client may be found after its first request came; rcl waits for it 0.1 s at a time.
_ATTEMPTS = 10
_MOST_CLIENTS = 10_000  # that are remembered; 24 bytes are known of each
# An instance of a class that pybind11 wraps is a PyObject whose next word is the address of the
# wrapped value. It is used only where the value found there has the number that rclpy shows.
_OFFSET_OF_VALUE = object.__basicsize__


class _RequestId(ctypes.Structure):
    """rmw_request_id_t: who asked, and the number of the request among that client's."""

    _fields_ = (('writer_guid', ctypes.c_ubyte * 16), ('sequence_number', ctypes.c_int64))


class CallCounts(NamedTuple):
    """What became of the calls of all services."""

    answered: int
    unanswered: int  # never came out of the service's queue, or their answer could not be sent
    # Before the first of a client that came: lost, or sent before this node was there.
    before_first: int


class Answers:
    """Sends the answers of services that it is given, from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._numbers: OrderedDict[bytes, int] = OrderedDict()  # the last one of each client
        self._answered = self._unanswered = self._before_first = 0
        self._rcl = of_rcl('rcl_send_response')

    def send_for(self, service: Service[Any, Any]) -> None:
        """Send what a service answers from now on."""
        service.send_response = partial(self._send, service, service.send_response)

    def counts(self) -> CallCounts:
        """Return the counts of now."""
        with self._lock:
            return CallCounts(self._answered, self._unanswered, self._before_first)

    def _send(self, service: Service[Any, Any], send: Any, answer: Any, header: Any) -> None:
        """Send an answer; ``send`` is rclpy's way, for where this one does not fit."""
        request_id = _request_id(header)
        if request_id is None or self._rcl is None:
            send(answer, header)
            self._note(None, sent=True)
            return
        with service.handle:
            message = CMessage(answer)
            for _ in range(_ATTEMPTS):
                address = service.handle.pointer
                result = self._rcl(address, ctypes.byref(request_id), message.address)
                if result != _TIMEOUT:
                    break
        self._note(request_id, sent=result == _OK)
        if result not in (_OK, _TIMEOUT):
            raise RuntimeError(
                f'an answer of {service.srv_name} was not sent: rcl returned {result}'
            )

    def _note(self, request_id: _RequestId | None, *, sent: bool) -> None:
        """Count an answer, and the requests of the same client that were never seen."""
        with self._lock:
            self._answered += sent
            self._unanswered += not sent
            if request_id is None:
                return
            client, number = bytes(request_id.writer_guid), request_id.sequence_number
            last = self._numbers.pop(client, None)
            if last is None:
                self._before_first += max(0, number - 1)
            else:
                self._unanswered += max(0, number - last - 1)
            self._numbers[client] = max(number, last or 0)
            if len(self._numbers) > _MOST_CLIENTS:
                self._numbers.popitem(last=False)


def _request_id(header: Any) -> _RequestId | None:
    """Return what rclpy's header wraps; None where it is not found."""
    wrapped = getattr(header, 'request_id', header)
    if not isinstance(wrapped, _rclpy.rmw_request_id_t):
        return None
    address = ctypes.c_void_p.from_address(id(wrapped) + _OFFSET_OF_VALUE).value
    if address is None:
        return None
    found = _RequestId.from_address(address)
    return found if found.sequence_number == wrapped.sequence_number else None
