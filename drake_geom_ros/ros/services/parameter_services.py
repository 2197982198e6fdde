"""The services that rclpy opens for every node answer whatever a request holds.

rclpy's own callbacks raise for a parameter of a type that is none, and the caller of a callback
that raises waits for ever.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node

_Serve = Callable[[Any, Any], Any]


def answer_always(node: Node) -> None:
    """Have the services that set a node's parameters refuse what they cannot read."""
    answers = {SetParameters: _set_each, SetParametersAtomically: _set_together}
    for service in node.services:
        if (answer := answers.get(service.srv_type)) is not None:
            service.callback = partial(answer, service.callback)


def _set_each(serve: _Serve, request: Any, response: Any) -> Any:
    """Set parameters one by one: what is wrong with one does not reach the others."""
    for parameter in request.parameters:
        try:
            one = SetParameters.Request(parameters=[parameter])
            response.results += serve(one, SetParameters.Response()).results
        except Exception as error:
            response.results.append(_refusal(error))
    return response


def _set_together(serve: _Serve, request: Any, response: Any) -> Any:
    """Set all parameters or none."""
    try:
        return serve(request, response)
    except Exception as error:
        response.result = _refusal(error)
        return response


def _refusal(error: Exception) -> SetParametersResult:
    return SetParametersResult(successful=False, reason=str(error) or repr(error))
