"""A status in words, for a terminal."""

from __future__ import annotations

from drake_geom_ros.common.counting import counted
from drake_geom_ros.ros.status.gathering import Status, TopicTraffic

_MOST_NAMES = 20


def in_words(status: Status) -> str:
    """Return what was gathered as lines."""
    values = status.values
    lines = [
        f'{status.node}: {status.level.upper()}, {status.summary}',
        f'cycles: {values.get("cycles", "?")}, {values.get("cycle rate [Hz]", "?")} a second; '
        f'worst delay {values.get("delay worst [ms]", "?")} ms',
        '',
        f'scene, version {status.scene_version}:',
    ]
    for source in status.sources:
        frames = counted(len(source['frames']), 'frame')
        lines.append(
            f'  {source["name"]}: {frames}, {counted(source["geometries"], "geometry")}'
            f'{_listed(source["frames"])}'
        )
    waiting, stale = status.waiting_frames, status.stale_frames
    lines += [
        f'waiting for a first pose: {len(waiting)}{_listed(waiting)}; '
        f'pairs left out for them: {status.waiting_pairs}',
        f'stale: {len(stale)}{_listed(stale)}',
        '',
        'refusals:' if status.refused else 'refusals: none',
        *(f'  {count} x {reason}' for reason, count in status.refused.items()),
    ]
    if status.refused:
        lines.append(f'  the last: {status.latest_refusal}')
    lines += [
        f'filters: {counted(status.filters["filtered_pairs"], "pair")} filtered; transient: '
        f'{status.filters["active"]}',
        '',
        'topics (others: subscribers of what it publishes, publishers of what it reads):',
    ]
    width = max((len(topic.name) for topic in status.topics), default=0)
    lines += [_topic_line(topic, width) for topic in status.topics]
    return '\n'.join(lines)


def _topic_line(topic: TopicTraffic, width: int) -> str:
    way = 'out' if topic.published else 'in '
    if topic.rate is not None:
        rate = f'{topic.rate:7.1f} Hz'
    elif topic.others:
        rate = 'not counted'
    else:
        rate = 'nobody reads it' if topic.published else 'nobody sends'
    return f'  {way} {topic.name:{width}}  {topic.others} others  {rate}'


def _listed(names: list[str]) -> str:
    if not names:
        return ''
    more = f' and {len(names) - _MOST_NAMES} more' if len(names) > _MOST_NAMES else ''
    return f': {", ".join(names[:_MOST_NAMES])}{more}'
