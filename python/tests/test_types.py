"""mypy reads the package, the examples of the pages and the notebooks; pyright the examples, as an editor does."""

from __future__ import annotations

import json
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


def write_examples(tree: Path, folder: Path) -> list[Path]:
    for page in (
        "docs/python.md",
        "docs/plots.md",
        "docs/allantools.md",
        "docs/imucal.md",
        "docs/fleet.md",
        "README.md",
    ):
        name = page.replace("/", "_").replace(".", "_") + ".py"
        (folder / name).write_text("\n".join(BLOCK.findall((tree / page).read_text())))
    return [*folder.glob("*.py"), *(tree / "docs/notebooks").glob("*.py")]


def test_examples_pass_strictly(tree, tmp_path):
    files = write_examples(tree, tmp_path)
    mypy("--allow-untyped-defs", "--allow-untyped-calls", "--ignore-missing-imports", *files, folder=tmp_path)


def test_examples_pass_pyright(tree, tmp_path):
    pytest.importorskip("pyright")
    for file in write_examples(tree, tmp_path):
        (tmp_path / file.name).write_text(file.read_text())
    settings = {"extraPaths": [str(PACKAGE.parent)], "pythonVersion": "3.10", "reportUnusedExpression": False}
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings))
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "."]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 errors" in done.stdout
