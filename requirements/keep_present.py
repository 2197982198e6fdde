"""Split the pinned packages of files into those that are there, in any version, and the rest.

Usage: keep_present.py FOLDER FILE...; FOLDER/present.txt gets constraints, FOLDER/missing.txt what
is left to install. What only lock.txt names is installed by those who need it.
"""

import re
import shutil
import sys
from importlib import metadata
from pathlib import Path

COMMANDS = {'cmake': 'cmake', 'ninja': 'ninja', 'colcon-common-extensions': 'colcon'}


def main(folder: Path, files: list[str]) -> None:
    """Write both files."""
    present, missing = {}, []
    for file in files:
        for line in Path(file).read_text().splitlines(keepends=True):
            match = re.match(r'[A-Za-z0-9._-]+', line)
            if not match:
                continue
            name = match.group()
            try:
                present[name] = metadata.version(name)
            except metadata.PackageNotFoundError:
                if file != 'lock.txt' and not shutil.which(COMMANDS.get(name, '')):
                    missing.append(line)
    pins = [f'{name}=={version}\n' for name, version in present.items()]
    (folder / 'present.txt').write_text(''.join(pins))
    (folder / 'missing.txt').write_text(''.join(missing))
    print('kept:', *(pin.strip() for pin in pins))


main(Path(sys.argv[1]), sys.argv[2:])
