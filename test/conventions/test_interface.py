"""The message definitions are those of the contract, and a reader finds every field explained."""

import re

from conventions.interface import MESSAGES, SERVICES
from conventions.source_tree import ROOT
from every import check, report

FOLDER = ROOT / 'msg_defs'
DEFINITIONS = sorted([*FOLDER.glob('msg/*.msg'), *FOLDER.glob('srv/*.srv')])
LINE = re.compile(r'(?P<field>[\w/]+(\[\d*\])? \w+(=\w+)?)( \w+)? *(# ?(?P<comment>.*))?')


def check_definitions(judge):
    """Put a judge to each definition."""
    check(judge, DEFINITIONS, lambda path: path.name)


def code_lines(text):
    """Return the lines of a definition that declare a field or a constant."""
    return [
        line for line in text.splitlines() if line.strip() and not line.startswith(('#', '---'))
    ]


def parts_of(path):
    """Return the fields and constants of each part of a definition: two parts of a service."""
    parts = [code_lines(part) for part in path.read_text().split('---')]
    return [[LINE.fullmatch(line)['field'] for line in part] for part in parts]


def listed(text):
    return [entry.strip() for entry in text.split(',') if entry.strip()]


def in_order(wanted, fields):
    """Return whether all wanted entries stand among the fields in the wanted order."""
    rest = iter(fields)
    return all(entry in rest for entry in wanted)


def test_all_definitions_of_the_contract_are_there():
    assert {path.stem for path in FOLDER.glob('msg/*.msg')} >= set(MESSAGES)
    assert {path.stem for path in FOLDER.glob('srv/*.srv')} >= set(SERVICES)


def test_a_message_keeps_its_fields():
    def judge(name):
        (fields,) = parts_of(FOLDER / f'msg/{name}.msg')
        assert in_order(listed(MESSAGES[name]), fields), fields

    check(judge, MESSAGES)


def test_a_service_keeps_its_fields():
    def judge(name):
        request, answer = parts_of(FOLDER / f'srv/{name}.srv')
        wanted_request, wanted_answer = SERVICES[name].split('---')
        assert in_order(listed(wanted_request), request), request
        assert answer[:2] == ['bool success', 'string message']
        assert in_order(listed(wanted_answer), answer[2:]), answer

    check(judge, SERVICES)


def test_a_field_out_of_its_order_is_seen():
    assert in_order(['a', 'c'], ['a', 'b', 'c'])
    assert not in_order(['c', 'a'], ['a', 'b', 'c'])


def test_every_field_is_explained():
    def judge(path):
        bare = [x for x in code_lines(path.read_text()) if not LINE.fullmatch(x)['comment']]
        assert bare == []

    check_definitions(judge)


def test_every_definition_says_what_it_is_for():
    def judge(path):
        first = path.read_text().splitlines()[0]
        assert re.fullmatch(r'# [A-Z].+', first), first

    check_definitions(judge)


def test_arrays_of_numbers_tell_their_shape():
    def judge(path):
        fields = [LINE.fullmatch(line) for line in code_lines(path.read_text())]
        arrays = [match for match in fields if re.match(r'u?(int|float)\d+\[\]', match['field'])]
        untold = {
            m['field'] for m in arrays if not re.match(r'.*\(\w( \+ 1)?,( \d)?\)', m['comment'])
        }
        # How many dimensions there are depends on the type; a set of ids is as long as it is.
        assert untold <= {'float64[] dimensions', 'uint64[] frame_ids', 'uint64[] geometry_ids'}

    check_definitions(judge)


def test_lengths_and_times_tell_their_unit():
    without = []
    units = re.compile(
        r'\[(m|m\^2|N|N m|Pa|s|-|m/s|rad/s|rad/s\^2 or m/s\^2|rad|Hz|pixels'
        r'|m, unit quaternion x y z w)\]'
    )
    lines = [(path.name, line) for path in DEFINITIONS for line in code_lines(path.read_text())]
    for path, line in lines:
        match = LINE.fullmatch(line)
        if re.match(r'float64|geometry_msgs', match['field']) and not units.search(
            match['comment']
        ):
            without.append(f'{path}: {line}')
    report(without)


def test_numbers_of_constants_are_unique_within_a_family():
    def judge(path):
        for part in parts_of(path):
            values = [field.split('=')[1] for field in part if '=' in field]
            assert len(set(values)) == len(values)

    check_definitions(judge)
