"""A build from source without the libraries: one message names all that is missing, and script/bootstrap."""

from __future__ import annotations

import shutil
import subprocess

import pytest


@pytest.mark.skipif(
    shutil.which("cmake") is None or shutil.which("c++") is None, reason="cmake and a compiler are absent"
)
def test_a_source_build_names_what_is_missing(tree, tmp_path):
    absent = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in ("Eigen3", "CLI11")]
    configure = ["cmake", "-S", tree, "-B", tmp_path, "-DSKBUILD=2", "-DTUMBLE_PYTHON=ON", *absent]
    done = subprocess.run(list(map(str, configure)), capture_output=True, text=True, check=False)
    assert done.returncode != 0
    said = " ".join(done.stderr.split())
    assert "these libraries are missing: Eigen3, CLI11." in said
    assert "script/bootstrap" in said
