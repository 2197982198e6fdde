"""The live table: what the results say now, as lines of text."""

from typing import TextIO

from drake_geom_ros.ros.demo.recording import RecordedPairs, Recording, percentiles

_WIDTH = 78
_SHOWN = 4
_RECENT = 500  # results whose times are shown


def lines(recording: Recording) -> list[str]:
    """Return the table of the newest result, one string a line."""
    latest = recording.pairs[-1] if recording.pairs else None
    now = latest.time - recording.start if latest else 0.0
    filtered = '-' if recording.filtered_pairs is None else str(recording.filtered_pairs)
    text = [
        f' time {now:6.2f} s    results {len(recording.pairs):6d}'
        f'    filtered pairs {filtered:>6s}',
        _times(' cycle time', recording.cycle_seconds[-_RECENT:]),
        _times(' age of the answer', [pairs.age for pairs in recording.pairs[-_RECENT:]]),
        ' closest pairs'.ljust(_WIDTH - 8) + 'distance',
        *_pair_lines(recording, latest),
        ' deepest penetration'.ljust(_WIDTH - 8) + '   depth',
        _contact_line(recording),
    ]
    if recording.changes:
        change = recording.changes[-1]
        text.append(
            _cut(f' filters, {change.time - recording.start:.2f} s: {change.text}', _WIDTH)
        )
    return text


def _times(name: str, seconds: list[float]) -> str:
    p50, p99 = percentiles(seconds)
    return name.ljust(_WIDTH - 40) + f'p50 {p50 * 1e3:8.2f} ms    p99 {p99 * 1e3:8.2f} ms'


def _pair_lines(recording: Recording, latest: RecordedPairs | None) -> list[str]:
    """Return the closest pairs of bodies, padded so that the table does not jump."""
    rows = []
    if latest is not None:
        closest = list(zip(latest.id_a, latest.id_b, latest.distance, strict=True))[:_SHOWN]
        rows = [_row(recording.scene.pair_name(a, b), float(d)) for a, b, d in closest]
    return rows + ['   -'] * (_SHOWN - len(rows))


def _contact_line(recording: Recording) -> str:
    contact = recording.contacts[-1] if recording.contacts else None
    if contact is None or contact.depth == 0.0:
        return '   none'
    return _row(recording.scene.pair_name(contact.id_a, contact.id_b), contact.depth)


def _row(name: str, metres: float) -> str:
    return f'   {_cut(name, _WIDTH - 18)}'.ljust(_WIDTH - 12) + f'{metres * 1e3:9.2f} mm'


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else f'{text[: width - 3]}...'


class Screen:
    """Shows the table: redrawn in place on a terminal, else as a block every second."""

    def __init__(self, stream: TextIO):
        self._stream = stream
        self._in_place = stream.isatty()
        self._period = 0.1 if self._in_place else 1.0  # [s]
        self._next = 0.0
        self._drawn = 0

    def show(self, recording: Recording) -> None:
        """Draw where it is time to: the time is that of the newest result."""
        now = recording.pairs[-1].time - recording.start if recording.pairs else 0.0
        if now < self._next:
            return
        self._next = now + self._period
        text = lines(recording)
        if self._in_place:
            # Up to the first line drawn before, and each line cleared to its end.
            up = f'\x1b[{self._drawn}F' if self._drawn else ''
            self._stream.write(up + ''.join(f'{line}\x1b[K\n' for line in text) + '\x1b[J')
        else:
            self._stream.write('\n'.join(text) + '\n\n')
        self._drawn = len(text)
        self._stream.flush()
