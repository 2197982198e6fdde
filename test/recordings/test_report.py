"""The report of a recording holds the figures of ``clearance``, and what is not known."""

import base64
import csv
import re
from concurrent.futures import ThreadPoolExecutor
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from recordings import recorder
from recordings.test_clearance import CELL, HERE, balls, poses, random_rows  # noqa: F401

from drake_geom_ros.command_line.program import main
from drake_geom_ros.recordings import clearance, highlights, report_plot, report_tables

FILES = ['clearance.csv', 'clearance.npz', 'clearance.png', 'report.html', 'report.json']


def approach(times, nearest=0.15):
    """Return rows of a box that comes near a ball and leaves again."""
    x = nearest + np.abs(times - times.mean())
    return [[HERE, (each, 0, 0, 0, 0, 0, 1)] for each in x]


@pytest.fixture
def run(tmp_path):
    """Return a recording in which a box touches a ball after 2 s, and nothing is said from 4 s."""
    times = 0.1 * np.arange(41)
    messages = poses(times, 'ab', approach(times)) + poses([8.0, 8.1], 'ab', approach(np.zeros(2)))
    return recorder.record(tmp_path / 'run', messages)


class Texts(HTMLParser):
    """The cells of tables, and what a page asks of elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.cells, self.links, self._in_cell = [], [], False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self._in_cell = tag == 'td'
        self.links += [value for name, value in attributes if name in ('src', 'href')]

    def handle_data(self, data):
        if self._in_cell:
            self.cells.append(data)


def test_a_report_holds_the_figures_of_clearance(tmp_path, run, balls, capsys):  # noqa: F811
    out = tmp_path / 'out'
    told = main(['report', str(run), '--scene', str(balls), '--between', 'a:b', '--out', str(out)])
    assert told == 1  # there is a gap
    moments = ['closest_1_1.png', 'closest_1_2.png']
    assert sorted(path.name for path in out.iterdir()) == sorted([*FILES, *moments])
    page = (out / 'report.html').read_text()
    for name in moments:
        assert base64.b64encode((out / name).read_bytes()).decode() in page
    again = ['report', str(run), '--scene', str(balls), '--between', 'a:b', '--out', str(out)]
    assert main([*again, '--pictures', '0']) == 1
    assert sorted(path.name for path in out.iterdir()) == FILES
    found = clearance(run, balls, between=['a:b'])
    pairs = found['a:b']
    with (out / 'clearance.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == report_tables.COLUMNS
    assert [float(row['distance_m']) for row in rows] == pairs.distance.tolist()
    assert [float(row['time_s']) for row in rows] == found.times.tolist()
    assert {row['state'] for row in rows} == {'whole'}
    arrays = np.load(out / 'clearance.npz')
    np.testing.assert_array_equal(arrays['distance_0'], pairs.distance)
    np.testing.assert_array_equal(arrays['p_WCa_0'], pairs.p_WCa)
    assert arrays['names_0'][arrays['geometry_A_0'][0]] == 's::a/ball'
    assert arrays['gaps'].tolist() == [pytest.approx([4.0, 8.0])]
    said = capsys.readouterr().out
    least = found.least('a:b', allow_incomplete=True)
    assert f'a:b: distance {least.distance:.9g} m' in said
    caption = f'1: {least.name_A} and {least.name_B}, {1e3 * least.distance:.1f} mm at '
    assert f'<figcaption>{caption}{least.time:.3f} s</figcaption>' in page
    assert 'not known: 1 gap without data, 4.000 s' in said


def test_the_page_needs_no_network_and_shows_what_is_not_known(tmp_path, run, balls):  # noqa: F811
    out = tmp_path / 'out'
    main(['report', str(run), '--scene', str(balls), '--between', 'a:b', '--out', str(out)])
    text = (out / 'report.html').read_text()
    page = Texts(text)
    plot, *moments = page.links
    assert moments
    for moment in moments:
        pixels = np.asarray(Image.open(BytesIO(base64.b64decode(moment.partition(',')[2]))))
        assert pixels.shape == (420, 640, 3)
        assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 10  # bodies, and no empty ground
    assert plot.startswith('data:image/png;base64,')
    raw = base64.b64decode(plot.partition(',')[2])
    assert raw == (out / 'clearance.png').read_bytes()
    assert 'http' not in re.sub('base64,[^"]*', '', text)
    assert '1 gap without data, 4.000 s' in text
    least = clearance(run, balls, between=['a:b']).least(allow_incomplete=True)
    assert f'{least.distance:.9g}' in page.cells
    assert 's::a/ball' in page.cells


def test_names_are_no_markup(tmp_path):
    text = 'sources: [s]\nframes: [{name: "<b>", source: s}]\ngeometries:\n' + ''.join(
        f'- {{name: "<i>{name}", source: s, frame: {frame}, shape: {{type: sphere, radius: 1}}}}\n'
        for name, frame in (('x', '"<b>"'), ('y', 'world'))
    )
    scene = tmp_path / 'scene.yaml'
    scene.write_text(text)
    messages = poses([0.0, 0.1], ['<b>'], [HERE, HERE])
    run = recorder.record(tmp_path / 'run', messages)
    out = tmp_path / 'out'
    main(['report', str(run), '--scene', str(scene), '--out', str(out)])
    assert '<i>' not in (out / 'report.html').read_text()
    assert '&lt;i&gt;x' in (out / 'report.html').read_text()


def test_a_gap_is_grey_in_the_plot(tmp_path, run, balls):  # noqa: F811
    out = tmp_path / 'out'
    main(['report', str(run), '--scene', str(balls), '--between', 'a:b', '--out', str(out)])
    pixels = np.asarray(Image.open(BytesIO((out / 'clearance.png').read_bytes())).convert('RGB'))
    middle = pixels[len(pixels) // 4]
    grey = (np.ptp(middle.astype(int), axis=1) == 0) & (middle[:, 0] == round(0.85 * 255))
    assert 0.2 < grey.mean() < 0.6  # 4 s of 8


def test_times_below_thresholds_and_what_is_known_add_up(run, balls):  # noqa: F811
    found = clearance(run, balls, between=['a:b'])
    told = highlights.highlights(found, [0.155])['a:b']
    contact = told.contacts[0]
    assert (contact.begin, contact.end) == (pytest.approx(2.0), pytest.approx(2.0))
    assert contact.deepest.distance == pytest.approx(-0.05)
    assert sum(told.held) == pytest.approx(found.duration)
    assert told.held.silent == pytest.approx(3.0)  # 4 s, of which the last pose holds 1 s
    (low,) = told.below
    # Gaps below 0.155 m are from 0.2 s before to 0.2 s after the least one, and at the end 0.1 s.
    assert low.seconds == pytest.approx(0.5 + 0.1)
    first, second, *_ = found.moments['a:b']
    assert abs(first.moment.time - second.moment.time) > 0.02 * found.duration


def test_what_was_asked_wrongly_is_said(tmp_path, run, balls, capsys):  # noqa: F811
    out = str(tmp_path / 'out')
    assert main(['report', str(tmp_path / 'none'), '--scene', str(balls), '--out', out]) == 2
    assert main(['report', str(run), '--out', out]) == 2
    assert main(['report', str(run), '--scene', str(balls), '--topic', 'x=y', '--out', out]) == 2
    said = capsys.readouterr().err
    assert 'there is no such file' in said
    assert 'no scene was given' in said
    assert 'NAME=TOPIC' in said
    assert not list(Path(out).glob('*'))


def test_all_known_is_exit_code_0(tmp_path):
    joints = 'turn', 'bend', 'roll', 'slide'
    messages = [
        (0.1 * k, '/joint_states', recorder.joint_state(0.1 * k, joints, [0.02 * k] * 4))
        for k in range(20)
    ]
    run = recorder.record(tmp_path / 'run', messages)
    out = tmp_path / 'out'
    options = ['--scene', str(CELL), '--rate', '20', '--max-distance', '0.2']
    assert main(['report', str(run), *options, '--out', str(out)]) == 0
    assert 'Every state tells of all pairs' in (out / 'report.html').read_text()


def test_closest_moments_are_those_that_things_come_near_in(tmp_path, balls):  # noqa: F811
    times = 0.05 * np.arange(201)
    x = 0.6 + 0.3 * np.cos(times * np.pi / 2.5)  # nearest after 2.5 and 7.5 s
    rows = [[HERE, (each, 0, 0, 0, 0, 0, 1)] for each in x]
    messages = poses(times, 'ab', rows) + poses(times + 0.01, 'a', [HERE] * len(times))
    messages.sort(key=lambda entry: entry[0])  # which say the same twice
    found = clearance(recorder.record(tmp_path / 'run', messages), balls, between=['a:b'])
    near = sorted(close.moment.time for close in found.moments['a:b'])
    assert near == pytest.approx([2.5, 7.5])


def test_what_a_truncated_file_does_not_tell_is_said_in_the_report(tmp_path, balls, capsys):  # noqa: F811
    times = 0.05 * np.arange(2000)
    rows = [[HERE, (1.0, 0, 0, 0, 0, 0, 1)]] * len(times)
    run = recorder.record(tmp_path / 'run', poses(times, 'ab', rows), sqlite=True)
    file = recorder.file_of(run)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    out = tmp_path / 'out'
    options = ['--scene', str(balls), '--between', 'a:b', '--out', str(out)]
    assert main(['report', str(run), *options]) == 1
    found = clearance(run, balls, between=['a:b'])
    assert 200 < len(found.times) < 1500
    told = f'it told something until {found.times[-1]:.3f} s'
    assert told in capsys.readouterr().out
    assert told in (out / 'report.html').read_text()
    np.testing.assert_allclose(found['a:b'].distance, 0.8, rtol=0, atol=1e-12)


def test_a_folder_of_runs_gets_a_report_each_and_goes_on_where_it_ended(tmp_path, balls, capsys):  # noqa: F811
    for k, height in enumerate((0.4, 0.5)):
        rows = [[(0.01 * j, 0, height, 0, 0, 0, 1), HERE] for j in range(5)]
        recorder.record(tmp_path / 'runs' / f'run_{k}', poses(0.1 * np.arange(5), 'ab', rows))
    broken = tmp_path / 'runs' / 'run_2'
    broken.mkdir()
    (broken / 'run.mcap').write_bytes(b'nothing')
    command = ['report', tmp_path / 'runs', '--scene', balls, '--out', tmp_path / 'out']
    assert main(list(map(str, command))) == 2
    told = capsys.readouterr()
    assert 'run_2' in told.err
    page = tmp_path / 'out' / 'run_1' / 'report.html'
    assert page.read_text().count('<img') == 4  # the plot, and the three closest moments
    page.unlink()
    before = (tmp_path / 'out' / 'run_0' / 'report.html').stat().st_mtime_ns
    assert main([*map(str, command), '--resume']) == 2
    assert 'run_0: there is a report' in capsys.readouterr().out
    assert page.exists()
    assert (tmp_path / 'out' / 'run_0' / 'report.html').stat().st_mtime_ns == before


def test_an_executor_changes_no_bit(tmp_path, balls):  # noqa: F811
    rows = random_rows(50, 2)
    run = recorder.record(tmp_path / 'run', poses(0.1 * np.arange(50), 'ab', rows))
    seen = []
    with ThreadPoolExecutor(2) as executor:
        found = clearance(run, balls, executor=executor, progress=lambda *told: seen.append(told))[
            'all'
        ]
    expected = clearance(run, balls)['all']
    np.testing.assert_array_equal(found.distance, expected.distance)
    assert seen[-1] == (50, pytest.approx(4.9))


def test_names_are_drawn_as_they_are(tmp_path):
    from matplotlib.text import Text

    names = '_$x', 'a$^', '$\\frac$', 'b_c'
    assert [
        Text(text=report_plot.plain(n))._preprocess_math(report_plot.plain(n)) for n in names
    ] == [(f' {n}' if n.startswith('_') else n, False) for n in names]
    frame = '_$\\frac$'  # which is no formula that could be set
    scene = tmp_path / 'scene.yaml'
    scene.write_text(f"""
sources: ['{frame}']
frames: [{{name: a, source: '{frame}'}}]
geometries:
- {{name: x, source: '{frame}', frame: a, shape: {{type: sphere, radius: 0.1}}}}
- {{name: y, source: '{frame}', frame: world, shape: {{type: sphere, radius: 0.1}}}}
""")
    times = 0.1 * np.arange(20)
    rows = [(1.0 + t, 0, 0, 0, 0, 0, 1) for t in times]
    run = recorder.record(tmp_path / 'run$\\frac$', poses(times, [f'{frame}::a'], rows))
    out = tmp_path / 'out'
    asked = ['report', run, '--scene', scene, '--out', out, '--compare', run, '--between']
    assert main([*map(str, asked), f'{frame}::a:y']) == 0
