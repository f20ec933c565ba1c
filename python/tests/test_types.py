"""mypy reads the package, the examples of the pages and the notebooks."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import tumble

pytest.importorskip("mypy")
PACKAGE = Path(tumble.__file__).parent
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def mypy(*arguments: object, folder: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "mypy",
        "--strict",
        "--cache-dir",
        str(folder.parent / "mypy"),
        *map(str, arguments),
    ]
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder, env=environment)
    assert done.returncode == 0, done.stdout


def test_the_package_passes_strictly(tree, tmp_path):
    mypy("--config-file", tree / "pyproject.toml", PACKAGE, folder=tmp_path)


def test_examples_pass_strictly(tree, tmp_path):
    for page in ("docs/python.md", "docs/plots.md", "docs/allantools.md", "docs/imucal.md", "README.md"):
        name = page.replace("/", "_").replace(".", "_") + ".py"
        (tmp_path / name).write_text("\n".join(BLOCK.findall((tree / page).read_text())))
    files = [*tmp_path.glob("*.py"), *(tree / "docs/notebooks").glob("*.py")]
    mypy("--allow-untyped-defs", "--allow-untyped-calls", "--ignore-missing-imports", *files, folder=tmp_path)
