"""The tutorial of docs/obstacles.md against a real node: its scene file, scans and reasons."""

import re
import time

import pytest
import yaml
from docs.pages import blocks
from drake_geom_msgs import msg
from ros.harness import LATCHED, ROOT, start_node
from ros.test_readme import filled
from sensor_msgs.msg import LaserScan

pytestmark = pytest.mark.topics

PAGE = 'docs/obstacles.md'
TEXT = (ROOT / PAGE).read_text()


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    folder = tmp_path_factory.mktemp('tutorial')
    (block,) = [each for each in blocks(PAGE) if each.title == 'lidar_cell.yaml']
    (folder / block.title).write_text(block.text)
    process = start_node(folder / 'log', scene_file=folder / block.title)
    yield process
    assert process.end() == 0, process.output()


def test_the_rule_is_entered_and_left_as_the_tutorial_says(node, client):
    states = client.listen(msg.ProximityStates, 'proximity_states', LATCHED)
    scans = client.node.create_publisher(LaserScan, '/scan', 10)
    (request,) = re.findall(r"/scan \S+ '(\{.*\})'$", TEXT, re.M)
    plain = yaml.safe_load(request)
    assert plain['header'].pop('stamp') == 'now'
    scan = filled(LaserScan(), plain)

    def why():
        return states[-1].why[0] if states and states[-1].entered[0] else 0

    def sent(ranges, expected):
        def holds():
            scan.ranges = ranges
            scan.header.stamp = client.node.get_clock().now().to_msg()
            scans.publish(scan)
            client.spin_until(time.monotonic() + 0.05)
            return why() == expected

        client.wait_for(holds, f'ranges of {ranges}')

    reasons = dict(re.findall(r'`why: (\d)`\s\(`(\w+)`\)', TEXT))
    assert reasons == {'4': 'NO_POSE', '1': 'NEAR', '3': 'STALE'}
    client.wait_for(lambda: why() == 4, 'the map to be waited for')
    sent(plain['ranges'], 0)
    client.wait_for(lambda: why() == 3, 'the silent lidar')
    sent([float(each) for each in re.search(r'`ranges: \[(.*)\]`', TEXT)[1].split(',')], 1)
