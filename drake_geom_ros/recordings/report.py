"""Files of a report: tables, plot and page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from drake_geom_ros.common.whole_files import check_outputs, whole_file
from drake_geom_ros.recordings import comparison_report
from drake_geom_ros.recordings.audit import Audit
from drake_geom_ros.recordings.comparing import SetComparison
from drake_geom_ros.recordings.highlights import highlights
from drake_geom_ros.recordings.report_page import Pictures, page
from drake_geom_ros.recordings.report_plot import draw
from drake_geom_ros.recordings.report_record import RECORD
from drake_geom_ros.recordings.report_tables import write_audit, write_csv, write_npz
from drake_geom_ros.recordings.results import RunAnalysis

CSV, NPZ, PLOT, PAGE = 'clearance.csv', 'clearance.npz', 'clearance.png', 'report.html'
AUDIT = 'audit.csv'
_MOMENT = 'closest_{}_{}.png'  # by the numbers of a set of pairs and of a moment
_ALL = (
    *(CSV, NPZ, PLOT, PAGE, AUDIT, RECORD),
    *(comparison_report.TABLE, comparison_report.PICTURE),
)


def check_folder(folder: Path, inputs: Iterable[str | Path | None]) -> None:
    """Make the folder; raises FileExistsError if a file of the report would replace an input."""
    folder.mkdir(parents=True, exist_ok=True)
    check_outputs({name: folder / name for name in _ALL}, inputs)


def leave_only(folder: Path, written: Iterable[Path]) -> None:
    """Remove files of an earlier report that the new one did not write."""
    moments = (path.name for path in folder.glob(_MOMENT.format('*', '*')))
    for name in {*_ALL, *moments} - {path.name for path in written}:
        (folder / name).unlink(missing_ok=True)


def write_report(
    run: RunAnalysis,
    folder: Path,
    title: str,
    files: Sequence[str],
    thresholds: Sequence[float],
    audited: Audit | None = None,
    pictures: Pictures | None = None,
    compared: Sequence[SetComparison] | None = None,
) -> list[Path]:
    """Write the files of a report about recorded ``files``; return them."""
    write_csv(run, folder / CSV)
    write_npz(run, folder / NPZ)
    highlights_by_set = highlights(run, thresholds)
    plot = draw(run, highlights_by_set, thresholds, title)
    with whole_file(folder / PLOT, 'wb') as picture:
        picture.write(plot)
    with whole_file(folder / PAGE) as text:
        beside = b'' if compared is None else (folder / comparison_report.PICTURE).read_bytes()
        text.write(
            page(run, highlights_by_set, title, files, plot, audited, pictures, compared, beside)
        )
    names = [
        CSV,
        NPZ,
        PLOT,
        PAGE,
        *_write_pictures(folder, list(highlights_by_set), pictures or {}),
    ]
    if audited is not None:
        write_audit(audited, folder / AUDIT)
        names.append(AUDIT)
    return [folder / name for name in names]


def _write_pictures(folder: Path, sets: Sequence[str], pictures: Pictures) -> list[str]:
    """Write the pictures of the closest moments; return their names."""
    names = []
    for (of, number), picture in pictures.items():
        names.append(_MOMENT.format(sets.index(of) + 1, number))
        with whole_file(folder / names[-1], 'wb') as file:
            file.write(picture)
    return names
