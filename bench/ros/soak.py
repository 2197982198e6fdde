"""Everything at once for a while: `./run soak --minutes 10` prints what it did and what it cost.

Beside a stream of poses, eight callers change the scene, filter, ask and try the impossible (see
``mix``), hostile messages arrive (see ``hostile``), a subscriber never reads, and the player is
killed and started again; faults (see ``faults``) come in an order that the seed fixes. At the end
the scene is saved, the node is killed with SIGKILL and comes back from the file. The exit code is
1 where anything was not as expected. With ``--faults`` it is faults alone, see ``storm``; with
``--rules`` it is proximity rules, see ``rules.storm``.
"""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import linear_regression, median

import rclpy
from drake_geom_msgs import srv

from bench.ros import storm
from bench.ros.driver import SERVER, Driver, Soak, start_node, start_player
from bench.ros.faults.order import Faults, listed
from bench.ros.faults.site import NODE, PATIENCE, Site
from bench.ros.listener import QUANTILES
from bench.ros.processes import Processes, memory
from bench.ros.rules import storm as rule_storm

PLAYER_LIFE = 30.0  # [s]
FAULT_PERIOD = 5.0  # [s] between two faults
MEMORY_PERIOD = 1.0  # [s]
WARM_UP = 15.0  # [s] before memory counts: caches fill, kernels of new pairs are loaded
SHOWN = 12  # refusals listed


def run(options: argparse.Namespace, folder: Path) -> tuple[Soak, dict]:
    """Run everything; return what happened and what the listener measured."""
    soak = Soak()
    with Processes() as processes:
        node = start_node(processes, folder)
        driver = Driver(soak, options.callers, options.seed)
        player = start_player(processes, options.rate)
        processes.start('bench.ros.deaf')
        driver.spin(WARM_UP)
        listener = processes.start('bench.ros.listener')
        site = Site(driver.node, driver.spin, processes, node, SERVER, folder)
        site.pause = driver.pause
        faults = Faults(site, options.seed, options.first)
        soak.faults = faults.counts
        start = killed = faulted = time.monotonic()
        while time.monotonic() - start < 60.0 * options.minutes:
            driver.spin(MEMORY_PERIOD)
            if node.poll() is not None:
                raise RuntimeError(f'the node died with exit code {node.returncode}')
            soak.memory.append((time.monotonic() - start, memory(node.pid)))
            if time.monotonic() - faulted > FAULT_PERIOD:
                soak.tally.problems += faults.do_one()
                faulted = time.monotonic()
            if time.monotonic() - killed > PLAYER_LIFE:
                player.kill()
                player.wait()
                player, killed = start_player(processes, options.rate), time.monotonic()
                soak.player_lives += 1
        listener.terminate()
        measured = json.loads(listener.communicate(timeout=30.0)[0])
        player.terminate()
        finish(soak, driver, processes, node, folder / 'saved.yaml')
    return soak, measured


def finish(
    soak: Soak,
    driver: Driver,
    processes: Processes,
    node: subprocess.Popen[str],
    path: Path,
) -> None:
    """Stop the callers, kill the node, and let it come back from what it saved."""
    for caller in driver.callers:
        caller.stop()
    end = time.monotonic() + PATIENCE
    while not all(caller.finished for caller in driver.callers) and time.monotonic() < end:
        driver.spin(0.2)
    if not all(caller.finished for caller in driver.callers):
        soak.tally.problems.append('callers wait for answers that did not come')
    saved = driver.save(path)
    node.send_signal(signal.SIGKILL)
    node.wait()
    rclpy.shutdown()
    again = processes.start(NODE, scene_file=path)
    rclpy.init()
    newcomer = rclpy.create_node('newcomer')
    client = newcomer.create_client(srv.SaveScene, f'{SERVER}/save_scene')
    if not client.wait_for_service(60.0):
        raise RuntimeError(f'the node did not come back from {path}: {again.poll()}')
    future = client.call_async(srv.SaveScene.Request())
    rclpy.spin_until_future_complete(newcomer, future, timeout_sec=60.0)
    if not future.done() or future.result().text != saved:
        soak.tally.problems.append('the node came back with another scene than it had saved')
    rclpy.shutdown()


def medians_by_minute(samples: list[tuple[float, float]]) -> list[float]:
    """Return the median of the samples ([s], value) of each minute that has any."""
    minutes: dict[int, list[float]] = {}
    for moment, value in samples:
        minutes.setdefault(int(moment // 60.0), []).append(value)
    return [median(minutes[minute]) for minute in sorted(minutes)]


def slope(samples: list[tuple[float, float]]) -> float:
    """Return by how much samples ([s], value) grow in a minute, by least squares."""
    moments, values = zip(*samples, strict=True)
    return 60.0 * linear_regression(moments, values).slope if len(set(moments)) > 1 else 0.0


def report(soak: Soak, measured: dict, minutes: float) -> None:
    """Print what happened."""
    tally, status = soak.tally, soak.status
    print(f'{minutes:g} minutes, {measured["results"]} results to the listener')
    print(f'{status["pose messages taken"]} pose messages taken, {status["cycles"]} cycles')
    print(f'{soak.hostile} hostile messages, {status["pose messages refused"]} refused')
    print(f'{tally.calls.total()} calls of {len(tally.calls)} services; player started '
          f'{soak.player_lives} times; node killed and restarted once')  # fmt: skip
    print(f'{soak.faults.total()} faults: {listed(soak.faults)}')
    print(f'{status["service calls answered"]} calls answered by the node, '
          f'{status["service calls not answered"]} not answered')  # fmt: skip
    print(f'{tally.refusals.total()} calls refused, most often:')
    for reason, count in tally.refusals.most_common(SHOWN):
        print(f'  {count:6} {reason}')
    quantiles = zip(QUANTILES, measured['delay_ms'], strict=True)
    print('delay [ms]: ' + ', '.join(f'p{q:g} {value:.2f}' for q, value in quantiles))
    (_, first), (_, last) = soak.memory[0], soak.memory[-1]
    half = soak.memory[len(soak.memory) // 2][1]
    print(f'memory [MB]: {first:.1f} at the start, {half:.1f} half-way, {last:.1f} at the end')
    by_minute = ' '.join(f'{median:.1f}' for median in medians_by_minute(soak.memory))
    print(f'  median of each minute: {by_minute}; in the second half it grew by '
          f'{slope(soak.memory[len(soak.memory) // 2 :]):+.2f} a minute')  # fmt: skip
    print(f'{len(tally.problems)} answers that were not expected')
    for problem in tally.problems[:SHOWN]:
        print(f'  {problem}')


def main() -> int:
    """Soak, print, and return 1 where anything was not as expected."""
    parser = argparse.ArgumentParser(prog='./run soak', description=__doc__.splitlines()[0])
    parser.add_argument('--minutes', type=float, default=10.0)
    parser.add_argument('--rate', type=float, default=200.0, help='pose messages per second')
    parser.add_argument('--callers', type=int, default=8)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument(
        '--faults', type=int, help='so many faults in a row instead, and no callers that change'
    )
    parser.add_argument('--rules', action='store_true', help='proximity rules and a referee')
    parser.add_argument('--first', type=int, default=1, help='number of the first fault')
    options = parser.parse_args()
    if options.rules:
        return rule_storm.run(options)
    with tempfile.TemporaryDirectory() as folder:
        if options.faults:
            return storm.run(options, Path(folder))
        soak, measured = run(options, Path(folder))
    report(soak, measured, options.minutes)
    return 1 if soak.tally.problems or not measured['results'] else 0


if __name__ == '__main__':
    sys.exit(main())
