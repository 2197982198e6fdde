"""``accuracy``: its options, what it needs, and where it writes."""

from pathlib import Path

import pytest
from conventions.source_tree import ROOT

from bench.accuracy import __main__ as accuracy
from drake_geom_ros.geometry import ArgumentError
from truth import peers


def test_it_runs(tmp_path, capsys):
    code = accuracy.main(
        ['--quick', '--cases', 'Sphere-Sphere', '--peers', 'none', '--samples', '1',
         '--output', str(tmp_path)]
    )  # fmt: skip
    assert code == 0, capsys.readouterr().err
    assert '[1/1] Sphere-Sphere: signed distance worst' in capsys.readouterr().out
    assert (tmp_path / 'README.md').exists()


@pytest.mark.parametrize(
    ('arguments', 'folder'),
    [
        ([], ROOT / 'docs/accuracy'),
        (['--quick'], Path('out/accuracy')),
        (['--cases', 'Box-*'], Path('out/accuracy')),
        (['--output', 'elsewhere'], Path('elsewhere')),
    ],
)
def test_where_it_writes(arguments, folder):
    assert accuracy.output_of(accuracy.parsed(arguments)) == folder


def test_peers_are_those_installed_or_named(monkeypatch):
    monkeypatch.setattr(peers, 'installed', lambda: ('python-fcl', 'Coal'))
    assert accuracy.peers_of(None) == ('python-fcl', 'Coal')
    assert accuracy.peers_of(['Coal']) == ('Coal',)
    assert accuracy.peers_of(['none']) == ()
    with pytest.raises(ArgumentError, match=r'--peers MuJoCo.*installed here: python-fcl, Coal'):
        accuracy.peers_of(['MuJoCo'])


def test_what_is_missing_is_named_with_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr(accuracy, 'find_spec', lambda name: None if name == 'mpmath' else True)
    assert accuracy.main([]) == accuracy.BAD_INPUT
    assert 'needs mpmath, which is not installed here: pip install mpmath' in (
        capsys.readouterr().err
    )


def test_an_unknown_case_is_refused_before_anything_is_written(tmp_path, capsys):
    folder = tmp_path / 'new'
    arguments = ['--cases', 'Cone-*', '--peers', 'none', '--output', str(folder)]
    assert accuracy.main(arguments) == accuracy.BAD_INPUT
    assert 'no case is called so' in capsys.readouterr().err
    assert not folder.exists()


def test_a_file_of_somebody_else_is_refused_before_anything_is_measured(tmp_path, capsys):
    for name in 'README.md', 'measurements.csv':
        (tmp_path / name).write_text('# Mine\n')
        arguments = ['--quick', '--peers', 'none', '--output', str(tmp_path)]
        assert accuracy.main(arguments) == accuracy.BAD_INPUT
        assert f'{name} is there, and not written by this command' in capsys.readouterr().err
        assert (tmp_path / name).read_text() == '# Mine\n'
        (tmp_path / name).unlink()


def test_bad_counts_are_refused(capsys):
    with pytest.raises(SystemExit):
        accuracy.parsed(['--samples', '0'])
    assert '0 must be a number >= 1' in capsys.readouterr().err


@pytest.mark.parametrize('minutes', ['0', '-1', 'inf', 'soon'])
def test_bad_minutes_are_refused(minutes, capsys):
    with pytest.raises(SystemExit) as ended:
        accuracy.parsed(['--minutes', minutes])
    assert ended.value.code == accuracy.BAD_INPUT
