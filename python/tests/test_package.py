"""What `import tumble` does: the names of the package are loaded when they are first used."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import tumble


def test_type_checkers_see_the_names_that_are_loaded():
    stub = ast.parse(Path(tumble.__file__).with_suffix(".pyi").read_text())
    homes = {
        alias.name: node.module
        for node in stub.body
        if isinstance(node, ast.ImportFrom) and node.module != "tumble"
        for alias in node.names
    }
    assert homes == {name: f"tumble.{module}" for name, module in tumble._HOMES.items()}
    listed = next(node.value for node in stub.body if isinstance(node, ast.Assign))
    assert ast.literal_eval(listed) == tumble.__all__
    modules = [node.names[0].name for node in stub.body if isinstance(node, ast.ImportFrom) and node.module == "tumble"]
    assert modules == list(tumble._MODULES)


@pytest.mark.parametrize("name", tumble.__all__)
def test_every_name_is_there(name):
    assert getattr(tumble, name) is getattr(tumble, name)
    assert name in dir(tumble)


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match=r"module 'tumble' has no attribute 'identifi'"):
        _ = tumble.identifi


@pytest.mark.parametrize("module", ["archive", "compat.allantools", "compat.imucal", "fleet", "importers", "plot"])
def test_a_module_is_there_when_it_is_first_used(module):
    program = f"import sys, tumble; print(tumble.{module} is sys.modules['tumble.{module}'])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"
    assert module.split(".")[0] in dir(tumble)


def test_an_import_loads_the_module_and_nothing_else():
    program = "import sys, tumble; print([m for m in sys.modules if m.startswith('tumble.') or m == 'numpy'])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "['tumble._tumble']\n"
