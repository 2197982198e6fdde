"""The bar says how much is done, and leaves standard output alone."""

from drake_geom_ros.common.progress_bar import progress_bar


def test_it_ends_with_what_was_done_of_all(capsys):
    with progress_bar('states', 30) as show:
        show(10)
        show(30)
    output, errors = capsys.readouterr()
    assert output == ''
    last = errors.replace('\r', '\n').splitlines()[-1]
    assert '100%' in last
    assert '30/30' in last
    assert ' states/s' in last


def test_without_a_total_it_counts(capsys):
    with progress_bar('images') as show:
        show(7)
    assert '7 images' in capsys.readouterr().err
