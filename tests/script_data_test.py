"""Tests script/data against a folder and against a server on loopback: whole, missing, wrong and cut files.

    script_data_test.py REPOSITORY      exit 1 and the reason at the first fault
"""

import functools
import hashlib
import http.server
import os
import pathlib
import subprocess
import sys
import tempfile
import threading

CONTENT = {"set/a.csv": b"1,2\n" * 1000, "set/b.csv": b"3,4\n" * 10}


class Handler(http.server.SimpleHTTPRequestHandler):
    """Serves the folder; of a name that ends in .cut it announces all bytes and sends half of them."""

    def do_GET(self):
        if not self.path.endswith(".cut"):
            return super().do_GET()
        content = CONTENT["set/a.csv"]
        self.send_response(200)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content[: len(content) // 2])
        self.close_connection = True
        return None

    def log_message(self, *_):
        pass


def run(script, folder, lines, mirror=None):
    """The finished process of script/data with that list."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    listing = folder.parent / "list.txt"
    listing.write_text("# a comment\n\n" + "".join(line + "\n" for line in lines))
    environment = {"PATH": os.environ["PATH"], "TUMBLE_DATA_LIST": str(listing), "TUMBLE_DATA_FOLDER": str(folder)}
    if mirror:
        environment["TUMBLE_DATA_MIRROR"] = str(mirror)
    return subprocess.run([str(script)], env=environment, capture_output=True, text=True)


def line(name, address, content=None):
    content = CONTENT[name] if content is None else content
    return f"{name} {len(content)} {hashlib.sha256(content).hexdigest()} MIT {address}"


def expect(process, status, *words):
    said = process.stdout + process.stderr
    assert process.returncode == status, f"exit {process.returncode}, expected {status}:\n{said}"
    for word in words:
        assert word in said, f"'{word}' is not in:\n{said}"


def expect_files(folder, *names):
    """Exactly these files are there, whole; nothing half written remains."""
    there = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())
    assert there == sorted(names), f"files {there}, expected {sorted(names)}"
    for name in names:
        assert (folder / name).read_bytes() == CONTENT[name], f"{name} has other bytes"


def check(script, work, address, mirror):
    """Every case once, from the server (mirror None) or from the folder."""
    both = [line(name, f"{address}/{name}") for name in CONTENT]
    folder = work / "whole"
    expect(run(script, folder, both, mirror), 0, "2 fetched, 0 already", "0 missing")
    expect_files(folder, *CONTENT)
    expect(run(script, folder, both, "/nonexistent"), 0, "0 fetched, 2 already")  # the second run fetches nothing
    (folder / "set/b.csv").write_bytes(b"spoiled")
    expect(run(script, folder, both, mirror), 0, "1 fetched, 1 already")
    expect_files(folder, *CONTENT)

    folder = work / "wrong_sum"  # one file that is not what was compared; the other comes nevertheless
    wrong = line("set/a.csv", f"{address}/set/a.csv", content=b"other")
    expect(run(script, folder, [wrong, both[1]], mirror), 1, "is not the file that was compared", "has 4000 bytes",
           "expected are 5 bytes", "1 fetched, 0 already", "1 missing")
    expect_files(folder, "set/b.csv")

    folder = work / "missing"
    absent = line("set/c.csv", f"{address}/set/c.csv", content=b"absent")
    expect(run(script, folder, [absent, both[1]], mirror), 1, "set/c.csv could not be fetched from", "1 missing")
    expect_files(folder, "set/b.csv")


def check_cut(script, work, address):
    """A connection that ends too early, and a server that is not there: refused, and an older file remains."""
    folder = work / "cut"
    (folder / "set").mkdir(parents=True)
    (folder / "set/a.csv").write_bytes(b"old")
    expect(run(script, folder, [line("set/a.csv", f"{address}/set/a.cut")]), 1, "could not be fetched", "1 missing")
    assert (folder / "set/a.csv").read_bytes() == b"old"
    assert [p.name for p in (folder / "set").iterdir()] == ["a.csv"]
    expect(run(script, folder, [line("set/a.csv", "http://127.0.0.1:9/a")]), 1, "could not be fetched")


def check_list(repository):
    """Every line of the list has five fields; a name stands once and stays within its folder."""
    rows = [r.split() for r in (repository / "script/data.txt").read_text().splitlines() if r and not r.startswith("#")]
    assert rows, "the list is empty"
    for row in rows:
        assert len(row) == 5, f"five fields are expected: {row}"
        name, size, digest, _, address = row
        assert not name.startswith("/") and ".." not in name.split("/"), name
        assert int(size) > 0 and len(bytes.fromhex(digest)) == 32 and address.startswith("https://"), row
    assert len({row[0] for row in rows}) == len(rows), "a name stands twice"


def main(repository):
    repository = pathlib.Path(repository).resolve()
    check_list(repository)
    with tempfile.TemporaryDirectory() as temporary:
        work = pathlib.Path(temporary)
        served = work / "served"
        for name, content in CONTENT.items():
            (served / name).parent.mkdir(parents=True, exist_ok=True)
            (served / name).write_bytes(content)
        handler = functools.partial(Handler, directory=str(served))
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            address = f"http://127.0.0.1:{server.server_address[1]}"
            check(repository / "script/data", work / "by_address", address, None)
            check(repository / "script/data", work / "by_mirror", "http://127.0.0.1:9", served)
            check_cut(repository / "script/data", work, address)
            server.shutdown()


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except AssertionError as fault:
        sys.exit(f"script_data_test: {fault}")
