"""The tutorials as notebooks: current, and with links that lead somewhere."""

import importlib.util
import json
import re

import pytest
from conventions.source_tree import ROOT


def generator():
    path = ROOT / 'docs/generate_notebooks.py'
    spec = importlib.util.spec_from_file_location('generate_notebooks', path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize('name', generator().TUTORIALS)
def test_it_is_current_and_its_links_are_files(name):
    module = generator()
    path = module.TARGET / f'{name}.ipynb'
    assert path.read_text(encoding='utf-8') == module.notebook(name), (
        'run: python docs/generate_notebooks.py'
    )
    cells = json.loads(path.read_text(encoding='utf-8'))['cells']
    assert len({cell['id'] for cell in cells}) == len(cells)
    text = '\n'.join(''.join(c['source']) for c in cells if c['cell_type'] == 'markdown')
    for link in re.findall(r'\]\((?!https?:)([^)#]+)', text):
        assert (module.TARGET / link).exists(), link


def test_a_block_becomes_a_cell_of_its_kind():
    code = generator()._code
    assert code('python', None, 'a = 1\nprint(a)\n# 1\n') == 'a = 1\nprint(a)\n'
    assert code('console', None, '$ ls | wc\n3\n$ pwd\n') == "run('ls | wc')\nrun('pwd')"
    assert code('csv', 'a.csv', '1,2\n').endswith('Path(\'a.csv\').write_text("""\\\n1,2\n""")')
    assert code('', None, 'output of a program\n') == ''
