"""Collision filter messages to declarations."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    FilterOperation,
    GeometrySet,
)
from drake_geom_ros.live.conversions.message_types import FilterDeclarationMessage
from drake_geom_ros.live.conversions.names import NameTable, SetMembers

OPERATIONS = dict(enumerate(FilterOperation, 1))  # by their numbers in CollisionFilterStatement


class ReadDeclaration(NamedTuple):
    """A declaration of a message, and how much it is about."""

    declaration: CollisionFilterDeclaration
    num_names: int  # that its sets list
    num_geometries: int  # in its sets


def declaration_from_message(
    message: FilterDeclarationMessage, names: NameTable
) -> ReadDeclaration:
    """Return the declaration of a message; raises RuntimeError, naming the statement."""
    resolved: list[tuple[FilterOperation, list[SetMembers]]] = []
    for number, statement in enumerate(message.statements):
        try:
            both = [names.members(each) for each in (statement.set_a, statement.set_b)]
        except RuntimeError as error:
            raise ArgumentError(f'statements[{number}]: {error}') from None
        operation = OPERATIONS.get(statement.operation)
        if operation is None:
            allowed = ', '.join(f'{k} ({each.name})' for k, each in OPERATIONS.items())
            raise ArgumentError(
                f'statements[{number}].operation is {statement.operation}; it must be one of '
                f'{allowed}'
            )
        resolved.append((operation, both))
    declaration, num_names, num_geometries = CollisionFilterDeclaration(), 0, 0
    for operation, both in resolved:
        num_names += sum(len(each.frames) + len(each.geometries) for each in both)
        num_geometries += sum(each.num_geometries for each in both)
        named = both if operation.takes_two_sets else both[:1]
        sets = [GeometrySet(geometry_ids=e.geometries, frame_ids=e.frames) for e in named]
        declaration.Declare(operation, *sets)
    return ReadDeclaration(declaration, num_names, num_geometries)
