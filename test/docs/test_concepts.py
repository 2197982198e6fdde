"""docs/concepts.md: the worked table is what its Python prints."""

import re

from conventions.source_tree import ROOT

TEXT = (ROOT / 'docs/concepts.md').read_text()


def test_the_table_is_what_the_python_prints():
    rows = re.findall(r'^\| [^|]+ ((?:\| x? ?){6}\|)$', TEXT, re.M)
    table = [['x' in cell for cell in row.split('|')[1:-1]] for row in rows]
    lines = re.findall(r'^((?:(?:[a-d]{2}|--) ?){6})$', TEXT, re.M)
    printed = [[word != '--' for word in line.split()] for line in lines]
    assert len(table) == 9
    assert table == printed
