"""``--joints a=1 b=2 SCENE`` without taking the scene for a joint."""

from collections.abc import Iterable

_OPTION = '--joints'


def spread(words: Iterable[str]) -> list[str]:
    """Return arguments in which each joint value has an option of its own.

    argparse would take all words up to the next option. A joint value has a ``=``.

    >>> spread(['query', '--joints', 'a=1', 'b=2', 'scene.yaml'])
    ['query', '--joints', 'a=1', '--joints', 'b=2', 'scene.yaml']
    """
    done: list[str] = []
    within = False
    for word in words:
        is_value = '=' in word and not word.startswith('-')
        if within and is_value and done[-1] != _OPTION:
            done.append(_OPTION)
        within = word == _OPTION or (within and is_value)
        done.append(word)
    return done
