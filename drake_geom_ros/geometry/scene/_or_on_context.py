"""Decorator for methods of a scene graph that act on its model or on a context's copy of it."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar, cast, overload

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.model.scene_content import SceneContent, SceneHolder, content_of
from drake_geom_ros.geometry.queries.context import SceneGraphContext

_Scene = TypeVar('_Scene', bound=SceneHolder)  # the scene graph, which imports this file
_P = ParamSpec('_P')
_R = TypeVar('_R', covariant=True)


class _WithOrWithoutContext(Protocol[_P, _R]):
    """Signature of such a method for callers: its arguments, with or without a context first."""

    @overload
    def __call__(self, *args: _P.args, **kwargs: _P.kwargs) -> _R: ...

    @overload
    def __call__(
        self, context: SceneGraphContext | None, *args: _P.args, **kwargs: _P.kwargs
    ) -> _R: ...


def or_on_context(
    method: Callable[Concatenate[_Scene, SceneContent, _P], _R],
) -> _WithOrWithoutContext[_P, _R]:
    """Wrap a method so that it can be called with or without a context before its arguments.

    The method gets the model and the filters to change: those of the context, or without one the
    scene graph's own.
    """

    @functools.wraps(method)
    def call(self: _Scene, *args: Any, **kwargs: Any) -> _R:
        if args and isinstance(args[0], SceneGraphContext):
            return method(self, content_of(args[0]), *args[1:], **kwargs)
        context = kwargs.pop('context', None)
        if context is not None:
            checked_type(context, SceneGraphContext, f'{method.__name__}: context')
        return method(self, content_of(context or self), *args, **kwargs)

    # help() shows the arguments for callers.
    shown = inspect.signature(method)
    parameters = [p for name, p in shown.parameters.items() if name != 'on']
    parameters.append(inspect.Parameter('context', inspect.Parameter.KEYWORD_ONLY, default=None))
    call.__signature__ = shown.replace(parameters=parameters)  # type: ignore[attr-defined]
    return cast('_WithOrWithoutContext[_P, _R]', call)
