"""Runs bench_archive on an SQLite file and on a PostgreSQL server of the distribution, and writes a page.

    archive.py BENCH_ARCHIVE [--units 10000] [--results 20] [--output PAGE] [--only sqlite|postgresql]

It is run in the root of the repository. The server lies in a temporary folder, synchronises as it does by default, and is
stopped at the end; run by root, it belongs to the user nobody.
"""

import argparse
import os
import pathlib
import platform
import shutil
import subprocess
import tempfile


def server_programs():
    versions = sorted(pathlib.Path("/usr/lib/postgresql").glob("*/bin/initdb"))
    return versions[-1].parent if versions else None


def run_as_nobody(folder, *command):
    user = ["setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups"] if os.geteuid() == 0 else []
    subprocess.run([*user, *map(str, command)], check=True, cwd=folder, stdout=subprocess.DEVNULL)


class Server:
    def __init__(self, folder):
        self.folder, self.programs = folder, server_programs()
        folder.mkdir()
        folder.chmod(0o777)
        run_as_nobody(folder, self.programs / "initdb", "-D", folder / "data", "-A", "trust", "-U", "tumble", "-E", "UTF8",
                      "--locale=C")
        options = f"-k {folder} -c listen_addresses='' -c shared_buffers=512MB"
        run_as_nobody(folder, self.programs / "pg_ctl", "-D", folder / "data", "-w", "-l", folder / "log", "-o", options, "start")
        self.ask("postgres", "CREATE DATABASE archive")

    def ask(self, database, sql):
        subprocess.run([self.programs / "psql", "-q", "-h", self.folder, "-U", "tumble", "-c", sql, database], check=True)

    def address(self):
        return f"postgresql://tumble@/archive?host={self.folder}"

    def stop(self):
        run_as_nobody(self.folder, self.programs / "pg_ctl", "-D", self.folder / "data", "-m", "fast", "stop")


def measure(program, address, files, arguments):
    command = ["nice", "-n", "5", program, address, str(files), str(arguments.units), str(arguments.results)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--units", type=int, default=10_000)
    parser.add_argument("--results", type=int, default=20)
    parser.add_argument("--output")
    parser.add_argument("--only", choices=["sqlite", "postgresql"])
    arguments = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="tumble_archive_"))
    folder.chmod(0o755)
    page = "# Archive\n"
    try:
        if arguments.only != "postgresql":
            page += "\n## SQLite\n\n" + measure(arguments.program, str(folder / "lab.db"), folder / "files", arguments)
        if arguments.only != "sqlite" and server_programs():
            server = Server(folder / "server")
            try:
                page += "\n## PostgreSQL\n\n" + measure(arguments.program, server.address(), folder / "kept", arguments)
            finally:
                server.stop()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    load = " ".join(f"{one:.1f}" for one in os.getloadavg())
    page += f"\n{platform.machine()}, {os.cpu_count()} processors, load {load} at the end.\n"
    if arguments.output:
        pathlib.Path(arguments.output).write_text(page)
    print(page)


if __name__ == "__main__":
    main()
