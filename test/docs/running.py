"""Code blocks are run: Python in the namespace of its page, commands in a folder of their own."""

import contextlib
import doctest
import io
import math
import re
import runpy
from importlib import import_module

import numpy as np
import trimesh
import yaml
from conventions.source_tree import ROOT
from docs.console import PROGRAM, commands, run, words_and_numbers

from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.motion_file import load_motion

API = runpy.run_path(str(ROOT / 'docs/generate_python_api.py'))
PARAMETERS = ROOT / 'config/scene_graph.yaml'
# Which kernels are compiled depends on what ran before.
COMPILING = re.compile(r'^drake_geom_ros: compiling, .*\n', re.M)
# Kinds of blocks that are run; all others are commands and output, listed as exceptions.
KINDS = ('file', 'doctest', 'python', 'console', 'yaml')


def public_names():
    """Return the public names of all modules that need no ROS."""
    without_ros = [name for name in API['MODULES'] if name != 'client']
    modules = [import_module(f'drake_geom_ros.{name}') for name in without_ros]
    names = {name: thing for module in modules for name, thing in API['public'](module).items()}
    return {'math': math, **names}


def write_files_of_the_reader(folder):
    """Write the files that pages name as the reader's own: a mesh, points, cells."""
    trimesh.creation.box((0.8, 0.4, 1.9)).export(folder / 'rack.stl')
    np.savetxt(folder / 'scan.xyz', [[0.3, 0.0, 0.0], [0.32, 0.0, 0.0]])
    for command in ('convert scan.xyz scan.pcd', 'convert scan.xyz shelf.bt --resolution 0.02'):
        code, printed = run(f'{PROGRAM} {command}', folder)
        assert code == 0, printed


class PageRunner:
    """Runs the blocks of one page in order, in a folder that has the scenes and the examples."""

    def __init__(self, folder, scene_before=''):
        for name in ('scenes', 'examples'):
            (folder / name).symlink_to(ROOT / name)
        write_files_of_the_reader(folder)
        self.folder = folder
        self.scene_before = scene_before
        self.names = {'__name__': 'page'}

    def run(self, block):
        """Run a block, and compare what it prints with what the page shows."""
        if block.kind == 'file':
            (self.folder / block.title).write_text(block.text)
            return
        getattr(self, f'_{block.kind}')(block.text)

    def _python(self, text):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(text, 'page', 'exec'), self.names)
        # The comments at the end of a block that prints are the result.
        shown = re.search(r'\)\n((?:# .*\n)+)\Z', text)
        if shown and printed.getvalue():
            assert printed.getvalue() == re.sub(r'^# ', '', shown[1], flags=re.M)

    def _doctest(self, text):
        said = []
        example = doctest.DocTestParser().get_doctest(text, self.names, 'page', None, 0)
        result = doctest.DocTestRunner(verbose=False).run(
            example, out=said.append, clear_globs=False
        )
        self.names.update(example.globs)
        assert result.failed == 0, ''.join(said)

    def _console(self, text):
        for command, shown in commands(text):
            code, printed = run(command, self.folder)
            printed = COMPILING.sub('', printed)
            if not shown:  # what it prints differs from run to run, or is nothing
                assert code == 0, printed
                continue
            words, numbers = words_and_numbers(printed)
            expected_words, expected_numbers = words_and_numbers(shown)
            assert words == expected_words, printed
            # Last digits depend on the processor.
            errors = [abs(a - b) for a, b in zip(numbers, expected_numbers, strict=True)]
            assert max(errors, default=0.0) < 1e-9, f'{numbers} instead of {expected_numbers}'

    def _yaml(self, text):
        content = yaml.safe_load(text)
        if '/**/scene_graph' in content:
            assert content == yaml.safe_load(PARAMETERS.read_text())
        elif isinstance(content.get('robots'), dict):
            path = self.folder / 'motion.yaml'
            path.write_text(text)
            load_motion(path, read_scene(ROOT / 'scenes/two_pandas.yaml'))
        else:
            read_scene(text if 'frames:' in text else self.scene_before + text)
