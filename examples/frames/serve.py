"""Plays a file of raw bytes as an instrument would send it, to try `tumble record` without an instrument.

    serve.py FILE --rate BYTES_A_SECOND [--terminal]

Prints the link for `tumble record --link`: a TCP port of this computer, at which everyone who comes gets the file from its
beginning, or a pseudo-terminal, which gets it once. After its last byte the instrument is silent. Ends when it is killed.
"""

import argparse
import os
import socket
import threading
import time
import tty


def play(path, rate, send):
    """Sends the file at a rate [byte/s]."""
    with open(path, "rb") as file:
        data = file.read()
    begin, sent = time.monotonic(), 0
    while sent < len(data):
        time.sleep(0.01)
        due = min(len(data), int((time.monotonic() - begin) * rate))
        while sent < due:
            sent += send(data[sent:due])


def serve_tcp(path, rate):
    door = socket.create_server(("127.0.0.1", 0))
    print(f"tcp:127.0.0.1:{door.getsockname()[1]}", flush=True)
    while True:
        link, _ = door.accept()
        threading.Thread(target=serve_one, args=(link, path, rate), daemon=True).start()


def serve_one(link, path, rate):
    try:
        play(path, rate, link.send)
        link.recv(1)  # until the other side ends
    except OSError:
        pass


def serve_terminal(path, rate):
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    print(f"serial:{os.ttyname(theirs)}:115200", flush=True)
    time.sleep(0.5)
    play(path, rate, lambda data: os.write(ours, data))
    while True:
        time.sleep(1.0)


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("file")
parser.add_argument("--rate", type=float, required=True)
parser.add_argument("--terminal", action="store_true")
arguments = parser.parse_args()
(serve_terminal if arguments.terminal else serve_tcp)(arguments.file, arguments.rate)
