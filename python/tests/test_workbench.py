"""The program of the package has its pages and its TLS: `tumble serve`, and the verbs that Python carries out."""

from __future__ import annotations

import os
import re
import shutil
import ssl
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

PROGRAM = os.environ.get("TUMBLE_COMMAND") or shutil.which("tumble")
pytestmark = pytest.mark.skipif(PROGRAM is None, reason="there is no command tumble")


@contextmanager
def served(folder: Path, *arguments: object) -> Iterator[str]:
    """The address of a server over a folder; it ends with the block."""
    data = folder / "data"
    data.mkdir()
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache")}
    command = [str(PROGRAM), "serve", str(data), "--port", "0", *map(str, arguments)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        try:
            assert process.stdout is not None
            link = re.search(r"(https?)://[^/]+:(\d+)/", process.stdout.readline() + process.stdout.readline())
            assert link, process.stderr and process.stderr.read()
            yield f"{link[1]}://127.0.0.1:{link[2]}"
        finally:
            process.terminate()


def page(address: str, context: ssl.SSLContext | None = None) -> str:
    with urllib.request.urlopen(address, timeout=30, context=context) as answer:
        return answer.read().decode()


def test_the_workbench_has_its_pages(tmp_path):
    with served(tmp_path) as address:
        assert "app.js" in page(address + "/")
        assert len(page(address + "/app.js")) > 50_000


def test_the_workbench_speaks_tls(tmp_path):
    if shutil.which("openssl") is None:
        pytest.skip("there is no openssl to make a certificate")
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    made = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2"]
    made += ["-keyout", key, "-out", certificate, "-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1"]
    subprocess.run(list(map(str, made)), check=True, capture_output=True)
    context = ssl.create_default_context(cafile=str(certificate))
    for version in (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3):
        context.minimum_version = context.maximum_version = version
        folder = tmp_path / version.name
        folder.mkdir()
        with served(folder, "--cert", certificate, "--key", key) as address:
            assert address.startswith("https:")
            assert "app.js" in page(address + "/", context)


def test_fleet_is_a_verb_of_the_program(command):
    assert "summary" in command("fleet", "--help")
