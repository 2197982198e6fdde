"""docs/command_line.md: every command in it prints what it shows."""

import os

import pytest
from conventions.source_tree import ROOT
from docs.console import blocks, run, words_and_numbers

BLOCKS = blocks((ROOT / 'docs/command_line.md').read_text())


@pytest.mark.parametrize('block', BLOCKS, ids=lambda block: block[0][0])
def test_a_command_prints_what_is_shown(tmp_path, monkeypatch, block):
    for name in ('scenes', 'examples'):
        (tmp_path / name).symlink_to(ROOT / name)
    paths = [str(ROOT), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))
    for command, shown in block:
        words, numbers = words_and_numbers(run(command, tmp_path))
        expected_words, expected_numbers = words_and_numbers(shown)
        assert words == expected_words
        # Last digits depend on the processor.
        assert numbers == pytest.approx(expected_numbers, abs=1e-9)


def test_there_are_commands():
    assert sum(map(len, BLOCKS)) > 5
