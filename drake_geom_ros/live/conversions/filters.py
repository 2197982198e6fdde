"""Collision filter messages to declarations."""

from __future__ import annotations

from typing import Any

from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    FilterOperation,
    GeometrySet,
)
from drake_geom_ros.live.conversions.names import NameTable

OPERATIONS = dict(enumerate(FilterOperation, 1))  # by their numbers in CollisionFilterStatement


def geometry_set_from_message(message: Any, names: NameTable) -> GeometrySet:
    """Return a GeometrySet; raises UnknownNameError for what the scene does not hold."""
    frames, geometries = names.members(message)
    return GeometrySet(geometry_ids=geometries, frame_ids=frames)


def declaration_from_message(message: Any, names: NameTable) -> CollisionFilterDeclaration:
    """Return a CollisionFilterDeclaration; raises RuntimeError, naming the statement."""
    resolved: list[tuple[FilterOperation, GeometrySet, GeometrySet]] = []
    for number, statement in enumerate(message.statements):
        try:
            set_a = geometry_set_from_message(statement.set_a, names)
            set_b = geometry_set_from_message(statement.set_b, names)
        except RuntimeError as error:
            raise ArgumentError(f'statements[{number}]: {error}') from None
        operation = OPERATIONS.get(statement.operation)
        if operation is None:
            allowed = ', '.join(f'{k} ({each.name})' for k, each in OPERATIONS.items())
            raise ArgumentError(
                f'statements[{number}].operation is {statement.operation}; it must be one of '
                f'{allowed}'
            )
        resolved.append((operation, set_a, set_b))
    declaration = CollisionFilterDeclaration()
    for operation, set_a, set_b in resolved:
        sets = (set_a, set_b) if operation.takes_two_sets else (set_a,)
        declaration.Declare(operation, *sets)
    return declaration
