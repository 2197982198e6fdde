"""The packages are what colcon, rosdep and pip can read, and name everything that is imported."""

import ast
import re
import subprocess
import sys

import pytest
from conventions.setup_file import setup_keywords
from conventions.source_tree import PACKAGE, ROOT, SOURCES, imports_of, module_of, name_of

parse_package = pytest.importorskip('catkin_pkg.package', reason='reads package.xml').parse_package

FOLDERS = {'drake_geom_ros': ROOT, 'drake_geom_msgs': ROOT / 'msg_defs'}

# Looked up in rosdistro's rosdep/python.yaml (August 2026): python3-fcl, python3-trimesh and
# python3-mpmath, for instance, do not exist.
ROSDEP_KEYS = {
    'python-fcl-pip',
    'python3-hypothesis',
    'python3-jsonschema',
    'python3-lxml',
    'python3-matplotlib',
    'python3-mypy',
    'python3-numba',
    'python3-numpy',
    'python3-pil',
    'python3-pytest',
    'python3-pytest-timeout',
    'python3-scipy',
    'python3-tqdm',
    'python3-trimesh-pip',
    'python3-yaml',
}
# Packages of every ROS distribution, which rosdep knows by their own names.
ROS_PACKAGES = {
    'ament_cmake',
    'builtin_interfaces',
    'diagnostic_msgs',
    'geometry_msgs',
    'launch',
    'ament_index_python',
    'launch_ros',
    'lifecycle_msgs',
    'rcl_interfaces',
    'rclpy',
    'rosgraph_msgs',
    'ros2launch',
    'rosidl_default_generators',
    'rosidl_default_runtime',
    'sensor_msgs',
    'std_msgs',
    'std_srvs',
    'trajectory_msgs',
    'tf2_msgs',
    'visualization_msgs',
}
# What an import is called where it is installed: rosdep key, pip requirement.
LIBRARIES = {
    'PIL': ('python3-pil', 'pillow'),
    'fcl': ('python-fcl-pip', 'python-fcl'),
    'jsonschema': ('python3-jsonschema', 'jsonschema'),
    'llvmlite': ('python3-numba', 'numba'),
    'lxml': ('python3-lxml', 'lxml'),
    'matplotlib': ('python3-matplotlib', 'matplotlib'),
    'mpl_toolkits': ('python3-matplotlib', 'matplotlib'),
    'numba': ('python3-numba', 'numba'),
    'numpy': ('python3-numpy', 'numpy'),
    'scipy': ('python3-scipy', 'scipy'),
    'tqdm': ('python3-tqdm', 'tqdm'),
    'trimesh': ('python3-trimesh-pip', 'trimesh'),
    'yaml': ('python3-yaml', 'pyyaml'),
}
# Used where it is there.
OPTIONAL = {
    *('tf2_msgs', 'pydrake', 'coal', 'mujoco', 'pinocchio', 'mpmath', 'distributed', 'pyarrow'),
    *('viser', 'websockets', 'imageio', 'lcm', 'vtkmodules', 'xacro', 'rosbags', 'mcap'),
    *('meshio', 'lz4', 'zstandard', 'jsonschema_rs', 'casadi', 'nrrd', 'pandas'),
    *('cyipopt', 'openvdb', 'pyopenvdb'),
}


def dependencies(name):
    package = parse_package(str(FOLDERS[name] / 'package.xml'))
    fields = ('buildtool_depends', 'build_depends', 'exec_depends', 'test_depends')
    return {depend.name for field in fields for depend in getattr(package, field)}


def imported():
    """Return the libraries of others that the package imports."""
    names = {name.split('.')[0] for path in SOURCES for name in imports_of(path.read_text())}
    return names - set(sys.stdlib_module_names) - {'drake_geom_ros'}


def requirements():
    """Return {file: lines that name a package} of the pins."""
    folder = ROOT / 'requirements'
    files = sorted(folder.rglob('*.txt'))
    lines = {str(path.relative_to(folder)): path.read_text().splitlines() for path in files}
    return {name: [line for line in text if re.match(r'\w', line)] for name, text in lines.items()}


def pins():
    """Return {package: versions} of all pins."""
    found = {}
    for line in (line for lines in requirements().values() for line in lines):
        name, version = re.match(r'([\w-]+)(?:\[\w+\])?==([\w.]+)', line).groups()
        found.setdefault(name, []).append(version)
    return found


@pytest.mark.parametrize('name', FOLDERS)
def test_package_xml_is_valid(name):
    warnings = []
    package = parse_package(str(FOLDERS[name] / 'package.xml'), warnings=warnings)
    package.validate(warnings=warnings)
    assert (package.name, package.package_format, warnings) == (name, 3, [])


@pytest.mark.parametrize('name', FOLDERS)
def test_every_dependency_is_known_to_rosdep(name):
    assert dependencies(name) - {'drake_geom_msgs'} <= ROSDEP_KEYS | ROS_PACKAGES


def test_package_xml_names_all_that_is_imported():
    needed = {LIBRARIES.get(name, (name,))[0] for name in imported() - OPTIONAL}
    assert needed - dependencies('drake_geom_ros') == set()


def test_pins_name_all_that_is_imported():
    pinned = {re.match(r'[\w-]+', line).group() for line in requirements()['core.txt']}
    pinned |= {re.match(r'[\w-]+', line).group() for line in requirements()['demo.txt']}
    libraries = {LIBRARIES[name][1] for name in imported() if name in LIBRARIES}
    assert libraries - pinned == set()


def test_every_requirement_is_pinned_for_every_python_once():
    for file, lines in requirements().items():
        seen = {}
        for line in lines:
            match = re.fullmatch(
                r'(?P<name>[\w-]+)(\[\w+\])?==[\w.]+'
                r'( ; python_version (?P<range>>=|<) "(?P<bound>3\.1[12])")?'
                r'( +# .+)?',
                line,
            )
            assert match, f'{file}: {line}'
            seen.setdefault(match['name'], []).append((match['range'], match['bound']))
        for name, parts in seen.items():
            ranges = [part for part, _ in parts]
            assert ranges in ([None], ['>=', '<'], ['<'], ['>=']), f'{file}: {name}'
            assert len({bound for _, bound in parts}) == 1, f'{file}: {name}'


@pytest.mark.parametrize('distribution', ['kilted', 'jazzy'])
def test_a_pin_stands_in_one_file_only(distribution):
    names = [
        (re.match(r'[\w-]+', line).group(), file)
        for file, lines in requirements().items()
        if '/' not in file or file.startswith(distribution)
        for line in lines
    ]
    files = {}
    for name, file in names:
        files.setdefault(name, set()).add(file)
    assert {name: where for name, where in files.items() if len(where) > 1} == {}


def names(requirements):
    """Return the names of requirements such as numpy>=1.26."""
    return {re.match(r'[\w-]+', text).group() for text in requirements}


def test_the_extra_test_names_what_the_tests_of_the_core_are_pinned_to():
    keywords, pinned = setup_keywords(), requirements()
    asked_for = names([*keywords['install_requires'], *keywords['extras_require']['test']])
    files = ('core.txt', 'demo.txt', 'test.txt')
    assert asked_for == names(line for file in files for line in pinned[file])


def test_setup_py_and_package_xml_agree():
    package, keywords = parse_package(str(ROOT / 'package.xml')), setup_keywords()
    assert keywords['version'] == package.version
    assert keywords['license'] == package.licenses[0]
    assert keywords['maintainer_email'] == package.maintainers[0].email


def test_entry_points_exist():
    for entry in setup_keywords()['entry_points']['console_scripts']:
        module, function = re.fullmatch(r'\w+ = ([\w.]+):(\w+)', entry).groups()
        path = ROOT / (module.replace('.', '/') + '.py')
        functions = [
            n.name for n in ast.parse(path.read_text()).body if isinstance(n, ast.FunctionDef)
        ]
        assert function in functions


@pytest.mark.packaging
@pytest.mark.processes
def test_an_installed_package_holds_every_file(tmp_path):
    """What setup.py builds is what the source tree has: modules, data, scenes, launch files."""
    command = [sys.executable, 'setup.py', '-q', 'egg_info', '-e', str(tmp_path), 'build', '-b']
    command += [str(tmp_path / 'build'), 'install_data', '-d', str(tmp_path / 'data')]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    built = {
        path.relative_to(tmp_path / 'build/lib') for path in (tmp_path / 'build/lib').rglob('*.*')
    }
    wanted = [*SOURCES, *PACKAGE.rglob('*.json')]
    assert [name_of(path) for path in wanted if path.relative_to(ROOT) not in built] == []
    share = tmp_path / 'data/share/drake_geom_ros'
    shared = [
        path for room in ('scenes', 'launch', 'config') for path in (ROOT / room).glob('*.*')
    ]
    for path in [ROOT / 'package.xml', *shared]:
        assert (share / path.relative_to(ROOT)).read_bytes() == path.read_bytes()


def test_every_module_has_a_docstring():
    documented = {path: ast.get_docstring(ast.parse(path.read_text())) for path in SOURCES}
    assert [module_of(path) for path, text in documented.items() if not text] == []
