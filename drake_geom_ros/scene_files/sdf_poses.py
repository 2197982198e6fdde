"""Poses of the frames of SDFormat, and the links that they are fixed to.

Source of the meaning: the SDFormat specification, *Pose frame semantics*.
"""

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import WORLD
from drake_geom_ros.scene_files.sdf_elements import text_of
from drake_geom_ros.scene_files.sdf_models import MODEL, Item, Scope

_Passed = tuple[tuple[int, str], ...]


def pose_of(scope: Scope, name: str, passed: _Passed = ()) -> RigidTransform:
    """Return X_MF of a frame of a scope, measured in the scope's own frame M.

    Raises ValueError, which names no line, for a name that is missing, and for poses that count
    from each other.
    """
    if name in ('', MODEL) or (scope.is_world and name == WORLD):
        return RigidTransform()
    passed = _deeper(scope, name, passed)
    if (nested := _nested(scope, name)) is not None:
        _, inner, rest = nested
        return model_pose(scope, inner, passed) @ pose_of(inner, rest, passed)
    if name in scope.proxies:
        return model_pose(scope, scope.proxies[name], passed)
    for group, default in ((scope.links, ''), (scope.frames, 'frame'), (scope.joints, 'joint')):
        if name in group:
            item = group[name]
            if default == 'frame':
                base = item.element.get('attached_to', '')
            else:
                base = text_of(item.element, 'child') if default else ''
            return pose_of(scope, _in(item, item.relative_to or base), passed) @ item.X
    raise ValueError(_missing(scope, name))


def model_pose(scope: Scope, model: Scope, passed: _Passed = ()) -> RigidTransform:
    """Return X_SM of a model in the scope that holds it."""
    X_SP = pose_of(scope, model.relative_to, passed) @ model.X
    if not model.placement_frame:
        return X_SP
    return X_SP @ pose_of(model, model.placement_frame, passed).inverse()


def link_of(scope: Scope, name: str, passed: _Passed = ()) -> str:
    """Return the name of the link that a frame of a scope is fixed to, or ``world``.

    Raises ValueError, which names no line, as ``pose_of`` does, and for a model without links.
    """
    if name == WORLD or (scope.is_world and name in ('', MODEL)):
        return WORLD
    passed = _deeper(scope, name, passed)
    if name in ('', MODEL):
        return _canonical(scope, passed)
    if (nested := _nested(scope, name)) is not None:
        first, inner, rest = nested
        link = link_of(inner, rest, passed)
        return WORLD if link == WORLD else f'{first}::{link}'
    if name in scope.links:
        return name
    if name in scope.frames:
        item = scope.frames[name]
        return link_of(scope, _in(item, item.element.get('attached_to', '')), passed)
    if name in scope.joints:
        item = scope.joints[name]
        return link_of(scope, _in(item, text_of(item.element, 'child')), passed)
    if name in scope.proxies:
        return _canonical(scope.proxies[name], passed)
    raise ValueError(_missing(scope, name))


def _canonical(scope: Scope, passed: _Passed) -> str:
    if link := scope.element.get('canonical_link', ''):
        return link_of(scope, link, passed)
    if scope.links:
        return next(iter(scope.links))
    for name, model in scope.nested.items():
        return f'{name}::{_canonical(model, passed)}'
    raise ValueError(f'the model {scope.name!r} has no link')


def _in(item: Item, name: str) -> str:
    """Return a name in an item as a name of its scope."""
    return item.base if name in ('', MODEL) else name


def _nested(scope: Scope, name: str) -> tuple[str, Scope, str] | None:
    """Return a nested model with its name, and the name in it, empty for its own frame."""
    first, _, rest = name.partition('::')
    model = scope.nested.get(first)
    return None if model is None else (first, model, rest or MODEL)


def _deeper(scope: Scope, name: str, passed: _Passed) -> _Passed:
    step = (id(scope), name)
    if step in passed:
        raise ValueError(f'the pose of {name!r} counts from itself')
    return (*passed, step)


def _missing(scope: Scope, name: str) -> str:
    shown = ', '.join(scope.names()) or 'none'
    where = 'the world' if scope.is_world else f'the model {scope.name!r}'
    return f'{where} has no frame {name!r}; there are {shown}'
