"""The examples of the documentation, run in the order of the page, and read by mypy."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import tumble

PACKAGE = Path(tumble.__file__).parent.parent
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


PAGES = ["README.md", "docs/python.md", "docs/plots.md", "docs/allantools.md", "docs/imucal.md", "docs/fleet.md"]
NEEDED = {"tumble.plot": ["matplotlib"], "import fleet": ["fsspec", "pyarrow"]}


@pytest.mark.parametrize("page", PAGES)
def test_examples_run(page, tree, tmp_path, monkeypatch):
    for name in ("examples", "plans", "tests"):
        os.symlink(tree / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = BLOCK.findall((tree / page).read_text())
    assert blocks
    for part, needed in NEEDED.items():
        if any(part in block for block in blocks):
            for module in needed:
                pytest.importorskip(module)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tumble.TumbleWarning)
        for block in blocks:
            exec(compile(block, page, "exec"), names)


def test_the_reference_is_up_to_date(tree):
    environment = {**os.environ, "TUMBLE_PACKAGE": str(PACKAGE)}
    check = [sys.executable, str(tree / "script/python_api"), "--check"]
    done = subprocess.run(check, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
