"""``python -m pneudrive_py host|sim|model ...``: the programs of PneuDrive.

They are part of the compiled module. ``pip`` makes the commands ``pneudrive-host``, ``pneudrive-sim`` and ``pneudrive-model`` of the functions
below, and ``pneudrive``, which is this module's own.
"""

from __future__ import annotations

import os
import signal
import sys
import sysconfig

from . import __version__, _pneudrive

#: Program by its short name, and what it is for.
PROGRAMS = {
    "host": ("pneudrive-host", "polls boards, records, serves the live page"),
    "sim": ("pneudrive-sim", "virtual boards on a pty, data sets"),
    "model": ("pneudrive-model", "fits, simulates, compares and diagnoses recordings"),
}


def usage() -> str:
    lines = [f"pneudrive_py {__version__}", "", "usage: python -m pneudrive_py PROGRAM [ARGUMENTS ...]", ""]
    lines += [f"  {name:6} {program:16} {purpose}" for name, (program, purpose) in PROGRAMS.items()]
    return "\n".join(lines)


def run(name: str, arguments: list[str]) -> int:
    """Does what a program does, in this process. Returns its exit status; help and unusable arguments end the process."""
    # The program decides what Ctrl-C does.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Programs find each other beside this interpreter, also where its environment is not activated.
    folders = [sysconfig.get_path("scripts"), os.environ.get("PATH", os.defpath)]
    os.environ["PATH"] = os.pathsep.join(folders)
    return _pneudrive._run_program(PROGRAMS[name][0], arguments)


def host() -> int:
    """``pneudrive-host``."""
    return run("host", sys.argv[1:])


def sim() -> int:
    """``pneudrive-sim``."""
    return run("sim", sys.argv[1:])


def model() -> int:
    """``pneudrive-model``."""
    return run("model", sys.argv[1:])


def main(arguments: list[str] | None = None) -> int:
    """``pneudrive``."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if not arguments or arguments[0] in ("-h", "--help"):
        print(usage())
        return 0
    if arguments[0] in ("-V", "--version"):
        print(f"pneudrive_py {__version__}")
        return 0
    name = arguments[0]
    if name not in PROGRAMS:
        print(f"error: no program {name}; there is {', '.join(PROGRAMS)}", file=sys.stderr)
        return 2
    return run(name, arguments[1:])


if __name__ == "__main__":
    sys.exit(main())
