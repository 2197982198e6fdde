"""docs/obstacles.md: its Python runs, and prints what it says."""

import doctest

from conventions.source_tree import ROOT


def test_the_examples_print_what_they_say():
    failed, tried = doctest.testfile(str(ROOT / 'docs/obstacles.md'), module_relative=False)
    assert tried > 15
    assert not failed
