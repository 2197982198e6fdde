"""The compiled walk through an octree, against a recursion that says the same in three lines."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from drake_geom_ros.sensed_maps.tree_walk import put_paths

LEVELS = 4


class TooDeepError(Exception):
    pass


def paths_below(path, nodes, level):
    """Yield the path of each node of a subtree, whose nodes come from an iterator."""
    children = next(nodes, None)
    if children is None:
        raise EOFError
    if level > LEVELS:
        raise TooDeepError
    yield path
    for child in range(8):
        if children >> child & 1:
            yield from paths_below(path * 8 + child, nodes, level + 1)


def walk(children):
    paths = np.zeros(len(children), dtype=np.int64)
    return put_paths(np.array(children, dtype=np.uint8), LEVELS, paths), paths.tolist()


@given(st.lists(st.sampled_from([0, 0, 0, 1, 2, 128, 129, 255]), max_size=60))
@example([255, *[0] * 8])
@example([1, 1, 1, 1, 0])
@example([1, 1, 1, 1, 1])
@example([0, 0])
def test_it_is_that_of_a_recursion(children):
    found, paths = walk(children)
    nodes, expected = iter(children), []
    try:
        for path in paths_below(1, nodes, 0):
            expected.append(path)
    except TooDeepError:
        assert found.too_deep
    except EOFError:
        assert (found.nodes, found.too_deep) == (len(children), False)
        assert found.open_branches > 0
    else:
        assert found == (len(expected), 0, False)
    assert paths[: len(expected)] == expected


def test_it_reports_each_branch_that_is_missing():
    assert walk([255, 0])[0] == (2, 7, False)
