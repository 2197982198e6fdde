"""Error messages for names that pydrake has and this package lacks."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import NoReturn

# Names that importlib's bootstrap module may have.
_IMPORTLIB = ('importlib._bootstrap', '_frozen_importlib')


_PAGE = 'docs/differences_from_pydrake.md lists what is missing and shows how to port a script'


def refuse_missing(
    module: str, elsewhere: Mapping[str, str] | None = None
) -> Callable[[str], NoReturn]:
    """Return the ``__getattr__`` of a package with the names of a package of pydrake.

    It raises AttributeError, or ImportError during ``from module import name``, where importlib
    would replace the text of an AttributeError by its own. ``elsewhere`` has modules of this
    package by the names that are there.
    """
    pydrake = module.replace('drake_geom_ros', 'pydrake', 1)

    def get(name: str) -> NoReturn:
        text = (
            f'cannot import name {name!r} from {module!r}. Not every name of {pydrake} is here: '
            f'{_PAGE}'
        )
        if elsewhere and name in elsewhere:
            text = f'cannot import name {name!r} from {module!r}: it is in {elsewhere[name]}'
        asker = sys._getframe(1).f_globals.get('__name__')
        if asker in _IMPORTLIB and name[:1] != '_' and find_spec(f'{module}.{name}') is None:
            raise ImportError(text, name=module)
        raise AttributeError(text)

    return get


def refuse_missing_member(self: object, name: str) -> NoReturn:
    """Raise AttributeError with a reference to the docs: ``__getattr__`` of pydrake's classes."""
    kind = type(self).__name__
    text = f'{kind!r} object has no attribute {name!r}'
    if name[:1].isupper():  # as for pydrake's methods
        text += f'. Not every method of pydrake is here: {_PAGE}'
    raise AttributeError(text, name=name, obj=self)
