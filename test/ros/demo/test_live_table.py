import io
import re

from ros.demo import demo_scenes as scenes

from drake_geom_ros.ros.demo.live_table import Screen, lines
from drake_geom_ros.ros.demo.recording import FilterChange, Recording


class _Terminal(io.StringIO):
    def isatty(self):
        return True


def test_lines_say_what_the_newest_result_says():
    text = '\n'.join(lines(scenes.recording(31)))
    assert re.search(r'time +3.00 s +results +31 +filtered pairs +17', text)
    assert re.search(r'left::hand - things::can +-2.00 mm', text)
    assert re.search(r'left::hand - right::hand +150.00 mm', text)
    assert re.search(r'penetration +depth\n +left::hand - things::can +2.00 mm', text)
    assert re.search(r'cycle time +p50 +16.00 ms +p99 +30.70 ms', text)
    assert re.search(r'age of the answer +p50 +3.00 ms', text)
    assert 'filters, 2.00 s: second change' in text


def test_no_contact_is_told_as_none():
    assert '   none' in lines(scenes.recording(5))


def test_the_table_keeps_its_height_and_width():
    long = scenes.recording(31)
    long.changes.append(FilterChange(103.0, 'a change of many, many words' * 9))
    for made in (scenes.recording(3), long):
        assert len(lines(made)) == len(lines(scenes.recording(12)))
        assert max(map(len, lines(made))) <= 79


def test_before_the_first_result_there_is_a_table_too():
    assert '   none' in lines(Recording(scenes.table()))


def test_a_terminal_is_redrawn_in_place():
    terminal = _Terminal()
    screen = Screen(terminal)
    screen.show(scenes.recording(3))
    first = terminal.getvalue()
    screen.show(scenes.recording(31))
    second = terminal.getvalue()[len(first) :]
    assert '\x1b[' in first
    assert f'\x1b[{first.count(chr(10))}F' in second
    assert second.count('\n') == first.count('\n')


def test_elsewhere_a_block_is_written_each_second():
    stream = io.StringIO()
    screen = Screen(stream)
    for results in range(1, 32):  # 3 s
        screen.show(scenes.recording(results))
    assert '\x1b' not in stream.getvalue()
    assert stream.getvalue().count('closest pairs') == 4
