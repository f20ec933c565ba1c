"""A rate table, a door and a room of a bench, as real servers at real sockets, for tests of what stops a rig.

They are written from the declarations alone: examples/controllers/bench_table.toml, and those below.
"""

import contextlib
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time

ONE_WORD = """title = "one word"
certainty = "maker"
[link]
tcp = 5025
[framing]
send = {tail = "\\n"}
reply = {tail = "\\n"}
"""
DOOR = ONE_WORD + """[word.door]
closed = "closed"
open = "open"
[command.state]
send = "DOOR?"
expect = "{door}"
[[vector]]
made_by_hand = true
verb = "state"
send = "DOOR?\\n"
reply = "open\\n"
words = {door = "open"}
"""
ROOM = ONE_WORD + """[word.air]
cool = "cool"
warm = "warm"
[command.state]
send = "AIR?"
expect = "{air}"
[[vector]]
made_by_hand = true
verb = "state"
send = "AIR?\\n"
reply = "warm\\n"
words = {air = "warm"}
"""
STATION = """[station]
name = "a bench of the tests"
by_hand = ["mount_pitch"]
answer_within = "60 s"

[[device]]
name = "bench"
controller = "bench_table.toml"
link = "{table}"
prepare = ["enable"]
lost_after = "5 s"
timeout = "2 s"
[[device.axis]]
rig = "table"
turns = "{turns}"
max_rate = "150 deg/s"
{limits}
settle = {{position = "0.05 deg", rate = "0.05 deg/s", hold = "0.3 s", timeout = "20 s"}}

[[device]]
name = "gate"
controller = "door.toml"
link = "tcp:127.0.0.1:{door}"
poll = "0.2 s"

[[device]]
name = "room"
controller = "room.toml"
link = "tcp:127.0.0.1:{room}"
poll = "0.2 s"

[[instrument]]
slot = "unit"

[[interlock]]
require = "gate.door == closed"

[[hold]]
require = "room.air == cool"

[[safe]]
device = "bench"
verb = "stop"
within = "5 s"
"""


class Device:
    """A server that answers lines. `heard` is what came, with its time [s]."""

    def __init__(self, tail):
        self.tail, self.heard, self.links = tail, [], []
        self.lock = threading.RLock()
        self.door = socket.create_server(("127.0.0.1", 0))
        self.port = self.door.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                link, _ = self.door.accept()
            except OSError:
                return
            link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.links.append(link)
            threading.Thread(target=self.talk, args=(link.recv, link.sendall), daemon=True).start()

    def talk(self, receive, send):
        waiting = b""
        with contextlib.suppress(OSError):
            while received := receive(4096):
                waiting += received
                while self.tail in waiting:
                    line, waiting = waiting.split(self.tail, 1)
                    with self.lock:
                        self.heard.append((time.monotonic(), line.decode("latin-1")))
                        answer = self.answer(line.decode("latin-1"))
                    send(answer.encode())

    def first(self, word, after=0.0):
        """Time at which a line that begins so came, or None."""
        return next((at for at, line in list(self.heard) if at > after and line.startswith(word)), None)

    def close(self):
        self.door.close()
        for link in self.links:
            with contextlib.suppress(OSError):
                link.shutdown(socket.SHUT_RDWR)
            link.close()


class Word(Device):
    def __init__(self, word):
        self.word = word
        super().__init__(b"\n")

    def answer(self, line):
        return self.word + "\n"


class Table(Device):
    """`factor`: how many times as fast as told it turns. `line`: at a pseudo-terminal in place of a socket."""

    acceleration = 100.0  # deg/s^2

    def __init__(self, line=False):
        self.position = self.rate = self.wanted = 0.0
        self.goal, self.factor, self.looked = None, 1.0, time.monotonic()
        self.lag, self.begins = 0.0, 0.0  # s, until it begins to go where it was told
        self.stops_flood, self.sent = threading.Event(), 0
        super().__init__(b"\r")
        self.address = f"tcp:127.0.0.1:{self.port}"
        if line:
            self.master, self.slave = os.openpty()
            self.address = f"serial:{os.ttyname(self.slave)}:9600"
            threading.Thread(target=self.talk, daemon=True,
                             args=(lambda size: os.read(self.master, size), lambda text: os.write(self.master, text))).start()

    def move(self):
        now = time.monotonic()
        while self.looked < now:
            step = min(0.01, now - self.looked)
            self.looked += step
            wanted = self.wanted * self.factor
            if self.goal is not None and self.looked >= self.begins:
                way = self.goal - self.position
                wanted = max(-60.0, min(60.0, 4.0 * way))
                if abs(way) < 1e-3:
                    self.position, self.rate, self.goal, self.wanted = self.goal, 0.0, None, 0.0
                    continue
            change = self.acceleration * step
            self.rate += max(-change, min(change, wanted - self.rate))
            self.position += self.rate * step

    def where(self):
        with self.lock:
            self.move()
            return f"{self.position:.3f} {self.rate:.4f} {'M' if abs(self.rate) > 1e-3 else 'R'}\r\n"

    def answer(self, line):
        self.move()
        if line == "WHERE":
            return self.where()
        if line == "STOP":
            self.wanted, self.goal = 0.0, None
        elif match := re.fullmatch(r"RATE (-?[\d.]+)", line):
            self.wanted, self.goal = float(match[1]), None
        elif match := re.fullmatch(r"GOTO (-?[\d.]+) ([\d.]+)", line):
            self.begins = time.monotonic() + (self.lag if self.rate == 0.0 else 0.0)
            self.goal = float(match[1])
        elif match := re.fullmatch(r"ACC ([\d.]+)", line):
            self.acceleration = float(match[1])
        elif line != "DRIVE 1":
            return "E01\r\n"
        return "OK\r\n"

    def turns(self):
        with self.lock:
            self.move()
            return self.rate

    def flood(self, rate):
        """So many lines a second without being asked; None: as fast as the socket takes them."""
        begin = time.monotonic()
        while not self.stops_flood.is_set():
            due = 5000 if rate is None else min(20000, int((time.monotonic() - begin) * rate) - self.sent)
            for link in list(self.links) if due > 0 else []:
                with contextlib.suppress(OSError):
                    link.sendall(self.where().encode() * due)
            self.sent += max(due, 0)
            if rate is not None:
                time.sleep(0.01)

    def begin_flood(self, rate):
        threading.Thread(target=self.flood, args=(rate,), daemon=True).start()


class Bench:
    """All of it, with the files of a run in a folder of its own."""

    def __init__(self, program, root, segments, line=False, turns="counted", limits="", hold=True):
        self.program = program
        self.table, self.gate, self.room = Table(line), Word("closed"), Word("cool")
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tumble-bench-"))
        plan = re.split(r"\n\[\[schedule\]\]", (root / "plans/gyro_scale_factor.toml").read_text())[0]
        for number, (duration, motion) in enumerate(segments):
            plan += f'\n[[schedule]]\nlabel = "s{number}"\nduration = "{duration} s"\ntable = {{{motion}}}\n'
        station = STATION.format(table=self.table.address, door=self.gate.port, room=self.room.port, turns=turns, limits=limits)
        if not hold:
            station = re.sub(r"\[\[hold\]\]\n.*\n", "", station)
        shutil.copy(root / "examples/controllers/bench_table.toml", self.folder)
        for name, text in (("plan.toml", plan), ("door.toml", DOOR), ("room.toml", ROOM), ("station.toml", station)):
            (self.folder / name).write_text(text)
        self.environment = {**os.environ, "TMPDIR": str(self.folder)}
        self.process = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.table.stops_flood.set()
        if self.process and self.process.poll() is None:
            self.process.kill()
        if self.process:
            self.process.wait()
        for device in (self.table, self.gate, self.room):
            device.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def run(self, environment=None, **streams):
        """Starts the run; its messages go to a file unless other streams are named."""
        log = open(self.folder / "log", "w")
        with log:
            self.process = subprocess.Popen(
                [self.program, "run", "plan.toml", "--station", "station.toml", "--unit", "unit=7", "--operator", "a test",
                 "-o", "run"], cwd=self.folder, env={**self.environment, **(environment or {})},
                **{"stdin": subprocess.DEVNULL, "stdout": log, "stderr": log, **streams})
        return self

    def log(self):
        return (self.folder / "log").read_text()

    def until(self, holds, seconds, what):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if value := holds():
                return value
            if self.process and self.process.poll() is not None and what == "the table turns":
                break
            time.sleep(0.01)
        raise AssertionError(f"not within {seconds} s: {what}\n{self.log()[-2000:]}")

    def until_turning(self, rate=19.0):
        self.until(lambda: abs(self.table.turns()) > rate, 40, "the table turns")
        return self

    def stop_after(self, cause, seconds):
        """Seconds from the cause to the first STOP at the table."""
        begin = time.monotonic()
        cause()
        return self.until(lambda: self.table.first("STOP", begin), seconds, "a STOP") - begin

    def open_door(self):
        self.gate.word = "open"

    def send(self, number):
        return lambda: os.kill(self.process.pid, number)

    def terminate(self):
        self.process.send_signal(signal.SIGTERM)
