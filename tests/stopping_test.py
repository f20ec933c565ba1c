"""The rig is always stopped: whatever a terminal, a disk, a device or the end of the process does.

A real run at real sockets and pseudo-terminals. Each test prints the time that it has measured; 1 s is promised, and a
computer with much other work has five.

    stopping_test.py PROGRAM REPOSITORY
"""

import contextlib
import fcntl
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import termios
import threading
import time
import unittest

from stopping_bench import Bench

PROGRAM, ROOT = sys.argv[1], pathlib.Path(sys.argv[2])
TURNING = [(120, 'rate = "20 deg/s"')]
PROMISED = 5.0  # s, with much other work; without it 1 s

HANGING_DISK = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <unistd.h>
static int wait_and(const char* name, int file) {
  while (access(getenv("TEST_DISK_HANGS"), F_OK) == 0) usleep(10000);
  return ((int (*)(int))dlsym(RTLD_NEXT, name))(file);
}
int fsync(int file) { return wait_and("fsync", file); }
int fdatasync(int file) { return wait_and("fdatasync", file); }
"""

# Another program at the same terminal has taken what was there to be read.
TAKEN_INPUT = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <poll.h>
int poll(struct pollfd* all, nfds_t count, int wait) {
  int found = ((int (*)(struct pollfd*, nfds_t, int))dlsym(RTLD_NEXT, "poll"))(all, count, wait);
  if (count == 1 && all->fd == 0 && found == 0) all->revents = POLLIN, found = 1;
  return found;
}
"""


def preloaded(bench, text):
    """The environment in which a program calls these functions in place of those of the system."""
    (bench.folder / "between.c").write_text(text)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", "between.so", "between.c", "-ldl"], cwd=bench.folder, check=True)
    return {"LD_PRELOAD": str(bench.folder / "between.so")}


def guard_of(bench):
    return int((bench.folder / "run/guard").read_text().split("\n")[0] or 0)


def report(what, seconds):
    print(f"{what}: STOP after {seconds:.2f} s", flush=True)


class AtTerminal:
    """The run at a pseudo-terminal, whose other side is read until somebody stops it."""

    def __init__(self, bench):
        self.master, terminal = os.openpty()
        self.reads = True

        def own_terminal():
            os.setsid()
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)

        bench.run({"TERM": "xterm"}, stdin=terminal, stdout=terminal, stderr=terminal, preexec_fn=own_terminal)
        os.close(terminal)
        self.thread = threading.Thread(target=self.pump, daemon=True)
        self.thread.start()

    def pump(self):
        while self.reads:
            try:
                os.read(self.master, 65536)
            except OSError:
                return


def full_pipe():
    """The two ends of a pipe that takes nothing more."""
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
    os.set_blocking(writer, False)
    try:
        while True:
            os.write(writer, b"x" * 512)
    except BlockingIOError:
        os.set_blocking(writer, True)
    return reader, writer


class StalledOutput(unittest.TestCase):
    def stalled(self, how, cause):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            terminal = AtTerminal(bench)
            bench.until_turning()
            if how == "ctrl_s":
                os.write(terminal.master, b"\x13")
            else:
                terminal.reads = False
            # What it draws twice a second fills a terminal's 4 kB in a few seconds; the requests go on in any case.
            time.sleep(4.0)
            before = len(bench.table.heard)
            bench.until(lambda: len(bench.table.heard) > before + 10, 10, "the table is asked")
            report(f"{how}, {cause.__name__}", bench.stop_after(lambda: cause(bench), PROMISED))
            self.assertEqual(bench.process.wait(30), 3, "the exit status does not wait for the terminal")

    def test_ctrl_s_and_the_door(self):
        self.stalled("ctrl_s", Bench.open_door)

    def test_a_terminal_that_nobody_reads_and_sigterm(self):
        self.stalled("unread", Bench.terminate)

    def test_a_pipe_that_nobody_reads(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            reader, writer = full_pipe()
            bench.run(stdout=writer, stderr=writer).until_turning()
            report("full pipe", bench.stop_after(bench.open_door, PROMISED))
            self.assertEqual(bench.process.wait(30), 3)
            os.close(reader)
            os.close(writer)

    def test_a_fault_of_the_program_at_a_pipe_that_nobody_reads(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            reader, writer = full_pipe()
            bench.run(stdout=writer, stderr=writer).until_turning()
            report("full pipe and SIGSEGV", bench.stop_after(bench.send(signal.SIGSEGV), PROMISED))
            os.close(reader)
            os.close(writer)


class Input(unittest.TestCase):
    def test_standard_files_that_are_closed_are_no_devices(self):
        def close_all():
            for number in (0, 1, 2):
                os.close(number)

        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run(stdin=None, stdout=None, stderr=None, preexec_fn=close_all).until_turning()
            for number in (0, 1, 2):
                self.assertEqual(os.readlink(f"/proc/{bench.process.pid}/fd/{number}"), "/dev/null")
            report("closed standard files and the door", bench.stop_after(bench.open_door, PROMISED))
            self.assertEqual(bench.process.wait(30), 3)
            known = ("WHERE", "STOP", "RATE", "GOTO", "ACC", "DRIVE")
            self.assertEqual([line for _, line in bench.table.heard if not line.startswith(known)], [])

    @unittest.skipUnless(shutil.which("cc"), "a C compiler makes the other program at the terminal")
    def test_input_that_another_program_takes_first(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            reader, writer = os.pipe()
            bench.run(preloaded(bench, TAKEN_INPUT), stdin=reader).until_turning()
            report("taken input and the door", bench.stop_after(bench.open_door, PROMISED))
            self.assertEqual(bench.process.wait(30), 3)
            os.close(reader)
            os.close(writer)

    def test_orders_that_are_typed(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            reader, writer = os.pipe()
            bench.run(stdin=reader).until_turning()
            report("abort that is typed", bench.stop_after(lambda: os.write(writer, b"ab" + b"ort\n"), PROMISED))
            self.assertEqual(bench.process.wait(30), 3)
            os.close(reader)
            os.close(writer)


class Floods(unittest.TestCase):
    def flooded(self, rate):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run().until_turning()
            begin = time.monotonic()
            bench.table.begin_flood(rate)
            bench.open_door()
            stop = bench.until(lambda: bench.table.first("STOP", begin), PROMISED, "a STOP")
            report(f"flood of {rate or 'all that TCP takes'} lines/s and the door", stop - begin)
            memory = int(pathlib.Path(f"/proc/{bench.process.pid}/statm").read_text().split()[1]) * 4096
            self.assertLess(memory, 400e6)
            # The table says that it stands, between lines that nobody asked for; or a person is told to look.
            self.assertEqual(bench.process.wait(30), 3, bench.log())
            stored = sum(file.stat().st_size for file in (bench.folder / "run").rglob("*"))
            self.assertLess(stored, 100e6)

    def test_at_20_000_lines(self):
        self.flooded(20_000)

    def test_at_200_000_lines(self):
        self.flooded(200_000)

    def test_without_a_limit(self):
        self.flooded(None)

    def test_a_flood_is_a_reason_by_itself_and_names_the_device(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run().until_turning()
            report("flood of 50 000 lines/s alone", bench.stop_after(lambda: bench.table.begin_flood(50_000), 10.0))
            self.assertEqual(bench.process.wait(30), 3)
            self.assertIn("bench floods its link", bench.log())

    def give_orders(self, bench):
        folder = os.open(bench.folder / "run", os.O_PATH)
        name = next(path.name for path in (bench.folder / "run").iterdir() if path.is_socket())
        with socket.socket(socket.AF_UNIX) as desk, contextlib.suppress(OSError):
            desk.connect(f"/proc/self/fd/{folder}/{name}")
            os.close(folder)
            desk.settimeout(0.001)
            while not bench.table.stops_flood.is_set():
                with contextlib.suppress(TimeoutError):
                    desk.sendall(b'{"order": "resume", "who": "x"}\n' * 20)
                with contextlib.suppress(TimeoutError):
                    desk.recv(65536)

    def test_orders_without_end_from_elsewhere(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run().until_turning()
            for _ in range(3):
                threading.Thread(target=self.give_orders, args=(bench,), daemon=True).start()
            time.sleep(3.0)
            report("orders without end and the door", bench.stop_after(bench.open_door, PROMISED))
            memory = int(pathlib.Path(f"/proc/{bench.process.pid}/statm").read_text().split()[1]) * 4096
            self.assertLess(memory, 400e6)
            bench.process.wait(30)

    def test_an_order_to_stop_among_many_others(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run().until_turning()
            threading.Thread(target=self.give_orders, args=(bench,), daemon=True).start()
            time.sleep(1.0)
            stop = [PROGRAM, "stop", "run"]
            report("tumble stop among many orders", bench.stop_after(
                lambda: subprocess.run(stop, cwd=bench.folder, env=bench.environment, capture_output=True, timeout=60), PROMISED))
            self.assertEqual(bench.process.wait(30), 3)

    def test_a_controller_that_reports_by_itself_is_no_flood(self):
        with Bench(PROGRAM, ROOT, [(1, 'hold = "0 deg"'), (3, 'rate = "20 deg/s"'), (1, 'hold = "0 deg"')]) as bench:
            bench.table.begin_flood(100)
            bench.run()
            bench.process.wait(60)
            self.assertIn("carried out", bench.log())


class Endings(unittest.TestCase):
    def ended_by(self, number, line=False):
        with Bench(PROGRAM, ROOT, TURNING, line=line) as bench:
            bench.run().until_turning()
            report(f"{signal.Signals(number).name}{' at a serial line' if line else ''}",
                   bench.stop_after(bench.send(number), PROMISED))
            bench.until(lambda: abs(bench.table.turns()) < 0.1, 10, "the table stands")
            bench.process.wait(30)
            return self.words_after(bench)

    def words_after(self, bench):
        stop = subprocess.run([PROGRAM, "stop", "run"], cwd=bench.folder, env=bench.environment, capture_output=True, text=True)
        return bench.log() + stop.stdout + stop.stderr

    def test_sigkill(self):
        said = self.ended_by(signal.SIGKILL)
        self.assertIn("ended without a word", said)
        self.assertIn("sent stop to bench", said)

    def test_sigkill_at_a_serial_line(self):
        self.ended_by(signal.SIGKILL, line=True)

    def test_a_fault_of_the_program(self):
        self.assertIn("sent stop to bench", self.ended_by(signal.SIGSEGV))

    def test_sigabrt(self):
        self.ended_by(signal.SIGABRT)

    def test_signals_that_are_no_fault_end_by_the_safe_list(self):
        for number in (signal.SIGUSR1, signal.SIGXCPU):
            self.assertIn("stopped", self.ended_by(number))

    def test_a_run_that_ends_in_order_leaves_no_guard_and_no_words(self):
        said = self.ended_by(signal.SIGTERM)
        self.assertNotIn("guard", said)

    def test_a_run_that_was_killed_goes_on_and_says_what_its_guard_did(self):
        with Bench(PROGRAM, ROOT, [(2, 'rate = "20 deg/s"')]) as bench:
            bench.run().until_turning()
            bench.process.kill()
            resumed = subprocess.run([PROGRAM, "resume", "run", "--operator", "a test"], cwd=bench.folder, capture_output=True,
                                     env=bench.environment, text=True, stdin=subprocess.DEVNULL, timeout=60)
            self.assertIn("sent stop to bench", resumed.stdout)
            self.assertIn("carried out", resumed.stdout)

    def test_a_guard_that_is_killed_is_replaced(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run().until_turning()
            first = guard_of(bench)
            os.kill(first, signal.SIGKILL)
            bench.until(lambda: guard_of(bench) not in (0, first), 20, "another guard")
            report("SIGKILL to the guard, then to the run", bench.stop_after(bench.process.kill, PROMISED))
            self.assertIn("sent stop to bench", self.words_after(bench))

    def test_a_guard_that_is_stopped_itself_does_not_hold_up_the_end(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run().until_turning()
            os.kill(guard_of(bench), signal.SIGSTOP)
            report("SIGSTOP to the guard, SIGTERM to the run", bench.stop_after(bench.terminate, PROMISED))
            self.assertEqual(bench.process.wait(30), 3)

    def test_a_run_that_does_not_look_at_its_rig(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run().until_turning()
            stopped = bench.stop_after(bench.send(signal.SIGSTOP), 40.0)
            print(f"SIGSTOP: STOP after {stopped:.1f} s, 15 s are stated", flush=True)
            self.assertGreater(stopped, 14.0, "a short stop is no reason")
            bench.send(signal.SIGCONT)()
            self.assertEqual(bench.process.wait(30), 3)
            self.assertIn("the guard of the run has stopped it", bench.log())


@unittest.skipUnless(shutil.which("cc"), "a C compiler makes the disk that hangs")
class HangingDisk(unittest.TestCase):
    def hanging(self, bench):
        self.flag = bench.folder / "hangs"
        return {**preloaded(bench, HANGING_DISK), "TEST_DISK_HANGS": str(self.flag)}

    def test_the_door_is_seen_while_it_hangs(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run(self.hanging(bench)).until_turning()
            self.flag.touch()
            time.sleep(1.0)
            report("hanging disk and the door", bench.stop_after(bench.open_door, PROMISED))
            self.flag.unlink()
            self.assertEqual(bench.process.wait(30), 3)

    def test_nothing_moves_before_its_row_is_on_the_disk(self):
        with Bench(PROGRAM, ROOT, [(3, 'hold = "0 deg"'), (120, 'rate = "20 deg/s"')]) as bench:
            bench.run(self.hanging(bench))
            bench.until(lambda: "records" in bench.log(), 40, "the first segment is recorded")
            hangs = time.monotonic()  # a run that takes a rig over begins with a STOP of its own
            self.flag.touch()
            stopped = bench.until(lambda: bench.table.first("STOP", hangs), 30, "a STOP, 5 s after the row was written")
            self.assertIsNone(bench.table.first("RATE"), "its row is not on the disk")
            self.assertLess(bench.until(lambda: bench.table.heard[-1][0], 1, "a request") - stopped, 1.0)
            self.flag.unlink()
            self.assertEqual(bench.process.wait(30), 3)
            self.assertIn("the disk has not answered for 5 s", bench.log())


class Motions(unittest.TestCase):
    def test_a_hold_that_is_not_met_stops_what_moves_and_goes_on_when_it_is_met(self):
        with Bench(PROGRAM, ROOT, [(4, 'rate = "20 deg/s"')]) as bench:
            bench.run().until_turning()
            report("a hold that is not met", bench.stop_after(lambda: setattr(bench.room, "word", "warm"), PROMISED))
            bench.until(lambda: abs(bench.table.turns()) < 0.1, 10, "the table stands")
            bench.room.word = "cool"
            bench.process.wait(60)
            self.assertIn("carried out", bench.log())

    def test_a_table_that_turns_faster_than_it_was_told(self):
        for factor in (-1.0, 3.0, 8.0):
            with Bench(PROGRAM, ROOT, TURNING) as bench:
                bench.run().until_turning()
                report(f"{factor:g} times the rate", bench.stop_after(lambda: setattr(bench.table, "factor", factor), 10.0))
                bench.process.wait(30)
                self.assertRegex(bench.log(), "table turns at .* deg/s")

    def test_a_link_that_breaks_and_can_be_opened_again(self):
        with Bench(PROGRAM, ROOT, TURNING) as bench:
            bench.run().until_turning()
            report("a link that was closed", bench.stop_after(
                lambda: [link.shutdown(socket.SHUT_RDWR) for link in list(bench.table.links)], PROMISED))
            self.assertEqual(bench.process.wait(30), 3)

    def test_an_axis_that_unwinds_a_turn_after_a_while_does_as_it_was_told(self):
        with Bench(PROGRAM, ROOT, [(9, 'hold = "360 deg"'), (9, 'hold = "0 deg"')], limits='speed = "60 deg/s"') as bench:
            station = bench.folder / "station.toml"
            station.write_text(station.read_text().replace('hold = "0.3 s"', 'hold = "0.3 s", soak = "3 s"'))
            bench.table.lag = 1.0
            bench.run()
            bench.process.wait(120)
            self.assertIn("carried out", bench.log())

    def test_an_axis_that_reaches_the_end_of_its_travel_fast(self):
        with Bench(PROGRAM, ROOT, [(3, 'rate = "100 deg/s"')], turns="limited",
                   limits='lowest = "-180 deg"\nhighest = "400 deg"\nmax_acceleration = "100 deg/s^2"') as bench:
            bench.run().until_turning(90.0)
            bench.table.acceleration = 100.0
            bench.table.position = 300.0
            bench.until(lambda: abs(bench.table.turns()) < 0.1, 10, "the table stands")
            print(f"travel to 400 deg at 100 deg/s: it stands at {bench.table.position:.0f} deg")
            self.assertLess(bench.table.position, 400.0 + 0.01 * 580.0 + 100.0 * 0.5)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
