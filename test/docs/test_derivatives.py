"""docs/derivatives.md: its Python runs, and prints what it says."""

import doctest

from conventions.source_tree import ROOT


def test_the_examples_print_what_they_say():
    failed, tried = doctest.testfile(str(ROOT / 'docs/derivatives.md'), module_relative=False)
    assert tried > 25
    assert not failed
