"""Boards on a pty that keep what they were commanded last, and programs that drive them and end in some way.

They understand both packet formats, but know nothing of pages and sessions, and have no command timeout. So they show how a
program left them.
"""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import tty

ATMOSPHERE_COUNTS = 102
REQUEST_BYTES = 10

# Nothing waits so long that goes right, s.
PATIENCE_S = 120


def crc_16_dnp(data):
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA6BC if crc & 1 else 0)
    return crc ^ 0xFFFF


#: A checked answer with the values of its request differs from it by this in its CRC: the
#: direction, `R` or `A`, is covered.
ANSWER_CRC = crc_16_dnp(b"R" * 11) ^ crc_16_dnp(b"A" + b"R" * 10)


def crc_of(words):
    """What the spare bits of a checked packet's data words say, but for the four highest: its sequence number."""
    bits = 0
    for word in words[1:]:
        bits = bits << 5 | word >> 10
    return bits & 0xFFFF


def fits(words):
    """Whether it is an unchecked request, or a checked one whose CRC says so. A page request's CRC says something else."""
    if max(words[1:]) <= 0x3FF:
        return True
    bare = [words[0], words[1] & ~(1 << 10)] + [word & 0x3FF for word in words[2:]]
    return crc_of(words) == crc_16_dnp(b"R" + b"".join(word.to_bytes(2, "big") for word in bare))


def answer(words):
    """The answer that holds the request's own values: its bytes, or for a checked request those with another CRC."""
    if max(words[1:]) > 0x3FF:
        words = [words[0]] + [word ^ (ANSWER_CRC >> 5 * (3 - k) & 0x1F) << 10 for k, word in enumerate(words[1:])]
    return b"".join(word.to_bytes(2, "big") for word in words)


class Boards:
    """Answers requests on a pty, and remembers every command that it obeyed."""

    def __init__(self, count=1, obeys=lambda board, counts: True):
        self.count = count
        #: Whether a board follows a request, and answers.
        self.obeys = obeys
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.port = os.ttyname(self.slave)
        #: (board, four counts), oldest first
        self.commands = []
        self.closing = False
        self.thread = threading.Thread(target=self.serve)
        self.thread.start()

    def serve(self):
        pending = b""
        while not self.closing:
            pending += os.read(self.master, 4096)
            while len(pending) >= REQUEST_BYTES:
                words = [int.from_bytes(pending[at : at + 2], "big") for at in range(0, REQUEST_BYTES, 2)]
                board = 0xFFFF - words[0]
                if board >= self.count or max(words[1:]) > 0x7FFF:
                    pending = pending[1:]
                    continue
                pending = pending[REQUEST_BYTES:]
                counts = [word & 0x3FF for word in words[1:]]
                if not fits(words):
                    continue
                if self.obeys(board, counts):
                    self.commands.append((board, counts))
                    os.write(self.master, answer(words))

    def last(self, board=0):
        """What it was commanded last, counts."""
        return next((values for number, values in reversed(self.commands) if number == board), None)

    def is_vented(self, board=0):
        # A host that ends says farewell to checked boards with four commands of 0 counts, below the
        # atmosphere.
        return max(self.last(board)) <= ATMOSPHERE_COUNTS

    def were_under_pressure(self):
        return any(min(values) > ATMOSPHERE_COUNTS for _, values in self.commands)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.closing = True
        os.write(self.slave, b"\0")
        self.thread.join()
        os.close(self.master)
        os.close(self.slave)


PRELUDE = """
import gc, os, signal, sys, threading, time
import numpy as np
import pneudrive_py as pneu

port = sys.argv[1]


def interrupt_soon(after_s=0.3):
    def interrupt():
        time.sleep(after_s)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt, daemon=True).start()


def until(condition):
    while not condition():
        time.sleep(0.005)
"""


def run(program, boards):
    """Runs `program` on the boards' port in a process of its own. Returns its status, and what it said on both outputs."""
    program = PRELUDE + textwrap.dedent(program)
    done = subprocess.run(
        [sys.executable, "-c", program, boards.port],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        # Whoever starts the tests in the background may have had Ctrl-C ignored, and Python would
        # keep it so.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    return done.returncode, done.stdout, done.stderr
