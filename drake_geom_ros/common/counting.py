"""Numbers with nouns and verbs for texts: 1 frame is, 2 frames are."""

from __future__ import annotations


def counted(number: int, noun: str) -> str:
    """Return a number with its noun: ``1 frame``, ``2 meshes``, ``3 geometries``."""
    return f'{number} {noun if number == 1 else plural(noun)}'


def plural(noun: str) -> str:
    """Return the plural of a noun of this package's messages."""
    if noun.endswith('y'):
        return f'{noun[:-1]}ies'
    return f'{noun}es' if noun.endswith('sh') else f'{noun}s'


def are(number: int) -> str:
    """Return ``is`` for 1, ``are`` for other numbers."""
    return 'is' if number == 1 else 'are'


def were(number: int) -> str:
    """Return ``was`` for 1, ``were`` for other numbers."""
    return 'was' if number == 1 else 'were'
