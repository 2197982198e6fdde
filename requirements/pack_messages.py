"""Packs built messages into a wheel: PREFIX DISTRIBUTION FOLDER.

The wheel is laid out as PyPI's wheels of ROS messages are. The Python package is in site-packages;
libraries are in ``lib`` of the environment, where ros-wheels-bootstrapper makes every interpreter
of the environment look; ``share`` has the definitions and the entries of the ament index.
"""

import base64
import hashlib
import re
import sys
import zipfile
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

from platform_of import platform_of

PACKAGE = 'drake_geom_msgs'
# Not parent_prefix_path, which names a folder of the machine that built it.
INDEX = ('packages', 'package_run_dependencies', 'rosidl_interfaces')
# The C library that a symbol needs at least is named in the library that uses it.
GLIBC = re.compile(rb'\0GLIBC_(\d+)\.(\d+)')
METADATA = """\
Metadata-Version: 2.1
Name: {name}
Version: {version}
Summary: Messages and services of drake_geom_ros, compiled for ROS 2 {distribution} from PyPI.
License: {license}
Maintainer: {maintainer}
Maintainer-email: {email}
Requires-Python: =={python}.*
{requirements}
Description-Content-Type: text/markdown

The messages and services of drake_geom_ros, compiled for the `ros-{low}-*` packages of PyPI.
`pip install 'drake_geom_ros[{low}]'` installs them with all that a node needs.
"""


def main(prefix: Path, distribution: str, folder: Path) -> None:
    """Write the wheel into the folder and print its path."""
    package = ElementTree.parse(prefix / f'share/{PACKAGE}/package.xml').getroot()
    name = f'{PACKAGE}_{distribution}-{package.findtext("version")}'
    files = dict(contents(prefix, f'{name}.data/data'))
    platform = platform_of('ros-rclpy')
    check_platform(files, platform)
    python = f'{sys.version_info.major}{sys.version_info.minor}'
    tag = f'cp{python}-cp{python}-{platform}'
    files[f'{name}.dist-info/METADATA'] = metadata(package, distribution).encode()
    files[f'{name}.dist-info/WHEEL'] = (
        f'Wheel-Version: 1.0\nGenerator: drake_geom_ros\nRoot-Is-Purelib: false\nTag: {tag}\n'
    ).encode()
    record = f'{name}.dist-info/RECORD'
    lines = [f'{path},sha256={digest(data)},{len(data)}\n' for path, data in files.items()]
    files[record] = ''.join([*lines, f'{record},,\n']).encode()
    folder.mkdir(parents=True, exist_ok=True)
    wheel = folder / f'{name}-{tag}.whl'
    with zipfile.ZipFile(wheel, 'w', zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            # With a fixed time equal messages give equal wheels.
            archive.writestr(zipfile.ZipInfo(path), data, zipfile.ZIP_DEFLATED)
    print(wheel)


def contents(prefix: Path, data: str) -> Iterator[tuple[str, bytes]]:
    """Yield the path in the wheel and the bytes of each file that is used at run time."""
    (site,) = prefix.glob('lib/python3*/site-packages')
    places = {
        site: [f'{PACKAGE}/**/*.py', f'{PACKAGE}/*.so'],
        prefix: [
            'lib/*.so',
            *(
                f'share/{PACKAGE}/{pattern}'
                for pattern in ('package.xml', 'msg/*.msg', 'srv/*.srv')
            ),
            *(f'share/ament_index/resource_index/{key}/*' for key in INDEX),
        ],
    }
    for root, patterns in places.items():
        for path in sorted(path for pattern in patterns for path in root.glob(pattern)):
            inside = path.relative_to(root).as_posix()
            yield inside if root == site else f'{data}/{inside}', path.read_bytes()


def metadata(package: ElementTree.Element, distribution: str) -> str:
    """Return the description of the wheel, with the messages that its libraries link to."""
    depends = sorted(depend.text.replace('_', '-') for depend in package.findall('depend'))
    needed = [f'ros-{name}~={version(f"ros-{name}")}' for name in depends]
    maintainer = package.find('maintainer')
    return METADATA.format(
        name=f'{PACKAGE}_{distribution}'.replace('_', '-'),
        version=package.findtext('version'),
        distribution=distribution.capitalize(),
        low=distribution,
        license=package.findtext('license'),
        maintainer=maintainer.text,
        email=maintainer.get('email'),
        python='.'.join(map(str, sys.version_info[:2])),
        requirements='\n'.join(f'Requires-Dist: {each}' for each in ['numpy>=1.26', *needed]),
    )


def check_platform(files: dict[str, bytes], platform: str) -> None:
    """Exit where a library needs a newer C library than the platform promises."""
    promised = re.fullmatch(r'manylinux_(\d+)_(\d+)_\w+', platform)
    allowed = tuple(map(int, promised.groups())) if promised else (0, 0)
    for path, data in files.items():
        needed = max((tuple(map(int, found)) for found in GLIBC.findall(data)), default=(0, 0))
        if path.endswith('.so') and needed > allowed:
            sys.exit(f'{path} needs glibc {needed[0]}.{needed[1]}, which {platform} may lack')


def digest(data: bytes) -> str:
    """Return the hash of a file as a RECORD has it."""
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()


if __name__ == '__main__':
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
