"""Takes the requests of services and sends the answers without the interpreter's lock.

With the lock, as rclpy sends it, an answer of 67 MB lets nothing else of the process run for 33 to
93 ms, and where the middleware never returns, as from a mutex in shared memory that a killed
client held, nothing ever runs again. So it is turned into a message as rclpy does it (which lets
other threads in between two fields, after at most 9 ms for 67 MB), and sent as ``unlocked`` does.

The number that rcl gives with a request says whom the answer is for. rclpy keeps that to
itself, so the request is taken here, too, by the executors of ``spinning``; under another executor
rclpy takes it, and sends the answer. What has no answer is counted by these numbers.
"""

from __future__ import annotations

import ctypes
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.service import Service

from drake_geom_ros.ros.outputs.unlocked import CMessage, of_rcl

_OK, _TIMEOUT, _NOTHING_THERE = 0, 2, 601  # RCL_RET_OK, _TIMEOUT, _SERVICE_TAKE_FAILED
# A client may be found after its first request came; rcl waits for it 0.1 s at a time.
_ATTEMPTS = 10
_MOST_CLIENTS = 10_000  # that are remembered; 24 bytes are known of each


class RequestId(ctypes.Structure):
    """rmw_request_id_t: who asked, and the number of the request among that client's."""

    _fields_ = (('writer_guid', ctypes.c_ubyte * 16), ('sequence_number', ctypes.c_int64))


class CallCounts(NamedTuple):
    """Counts of the calls of all services."""

    answered: int
    unanswered: int  # never came out of the service's queue, or their answer could not be sent
    # Before the first of a client that came: lost, or sent before this node was there.
    before_first: int


class Calls:
    """The calls of one service: called with an answer and whose it is, it sends that."""

    def __init__(self, service: Service[Any, Any], note: Callable[..., None]) -> None:
        self._service, self._note = service, note
        self._send_by_rclpy = service.send_response
        self._send, self._take = of_rcl('rcl_send_response'), of_rcl('rcl_take_request')

    @property
    def is_there(self) -> bool:
        """True if rcl's functions were found; otherwise rclpy does all."""
        return self._send is not None and self._take is not None

    def take(self) -> tuple[Any, RequestId] | None:
        """Take a request and whose it is; None where none is there.

        Raises RuntimeError where rcl refuses, and rclpy's InvalidHandle of a service that was
        closed.
        """
        service = self._service
        message, request_id = CMessage.room_for(service.srv_type.Request), RequestId()
        with service.handle:
            address = service.handle.pointer
            result = self._take(address, ctypes.byref(request_id), message.address)
        if result == _NOTHING_THERE:
            return None
        if result != _OK:
            raise RuntimeError(
                f'a request of {service.srv_name} was not taken: rcl returned {result}'
            )
        return message.to_python(), request_id

    def __call__(self, answer: Any, request_id: Any) -> None:
        """Send an answer; ``request_id`` is that of ``take``, or rclpy's header of a request.

        Raises RuntimeError where rcl refuses it.
        """
        if not isinstance(request_id, RequestId):
            self._send_by_rclpy(answer, request_id)
            self._note(None, sent=True)
            return
        service = self._service
        with service.handle:
            message = CMessage(answer)
            for _ in range(_ATTEMPTS):
                address = service.handle.pointer
                result = self._send(address, ctypes.byref(request_id), message.address)
                if result != _TIMEOUT:
                    break
        self._note(request_id, sent=result == _OK)
        if result not in (_OK, _TIMEOUT):
            raise RuntimeError(
                f'an answer of {service.srv_name} was not sent: rcl returned {result}'
            )


class Answers:
    """Sends the answers of services that it is given, from any thread, and counts them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._numbers: OrderedDict[bytes, int] = OrderedDict()  # the last one of each client
        self._answered = self._unanswered = self._before_first = 0

    def send_for(self, service: Service[Any, Any]) -> None:
        """Take what a service is asked, and send what it answers, from now on."""
        service.send_response = Calls(service, self._note)

    def counts(self) -> CallCounts:
        """Return the counts of now."""
        with self._lock:
            return CallCounts(self._answered, self._unanswered, self._before_first)

    def _note(self, request_id: RequestId | None, *, sent: bool) -> None:
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
