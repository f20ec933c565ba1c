"""The notebooks: their sources run, and the executed files hold the same cells. All run with TUMBLE_NOTEBOOKS=all."""

from __future__ import annotations

import json
import os
import runpy
import warnings

import pytest

EVERY_DAY = ["noise_of_my_imu", "imu_by_hand", "method_in_python"]
OTHERS = ["a_month_of_gyros", "fog_over_temperature", "rehearse_a_turntable_test", "ros_bag_to_kalibr"]


@pytest.mark.parametrize("name", EVERY_DAY + OTHERS)
def test_a_notebook_runs(name, tree, tmp_path, monkeypatch):
    if name in OTHERS and os.environ.get("TUMBLE_NOTEBOOKS") != "all":
        pytest.skip("TUMBLE_NOTEBOOKS=all runs it")
    pytest.importorskip("pandas")
    if name == "ros_bag_to_kalibr":
        pytest.importorskip("rosbags")
    pytest.importorskip("matplotlib").use("Agg")
    for link in ("examples", "plans"):
        os.symlink(tree / link, tmp_path / link)
    monkeypatch.chdir(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        runpy.run_path(str(tree / f"docs/notebooks/{name}.py"))


@pytest.mark.parametrize("name", EVERY_DAY + OTHERS)
def test_the_executed_notebook_holds_the_cells_of_its_source(name, tree):
    cells_of = runpy.run_path(str(tree / "script/notebooks"))["cells_of"]
    source = cells_of((tree / f"docs/notebooks/{name}.py").read_text())
    notebook = json.loads((tree / f"docs/notebooks/{name}.ipynb").read_text())
    assert [(cell["cell_type"], "".join(cell["source"])) for cell in notebook["cells"]] == source
    failed = [out for cell in notebook["cells"] for out in cell.get("outputs", ()) if out["output_type"] == "error"]
    assert failed == []
    assert any(cell.get("outputs") for cell in notebook["cells"])


def test_every_notebook_is_here(tree):
    assert sorted(EVERY_DAY + OTHERS) == sorted(path.stem for path in (tree / "docs/notebooks").glob("*.py"))
