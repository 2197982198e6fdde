"""What size costs: every pace, a row for each library, a page and a picture."""

from bench.peers import sizes
from bench.peers.motion import PACES


def test_sizes_are_measured_and_drawn(tmp_path, capsys):
    growth = sizes.Growth(seconds=1e-6)
    for count in (5, 20):
        growth.size(count)
    growth.write(tmp_path)
    page = (tmp_path / 'sizes.md').read_text()
    for count in (5, 20):
        assert f'{count} balls: ' in page
        for pace in PACES:
            assert f'| {count} | {pace} | ours |' in page
    assert (tmp_path / 'sizes.png').stat().st_size > 10_000
    assert 'sizes.png' in capsys.readouterr().out
