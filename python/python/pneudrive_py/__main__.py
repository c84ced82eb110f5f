"""``python -m pneudrive_py host|sim|model ...``: the programs of PneuDrive, and what of them is installed."""

from __future__ import annotations

import os
import shutil
import sys
import sysconfig
from pathlib import Path

from . import __version__

#: Program by its short name, and what it is for.
PROGRAMS = {
    "host": ("pneudrive-host", "polls boards, records, serves the live page"),
    "sim": ("pneudrive-sim", "virtual boards on a pty, data sets"),
    "model": ("pneudrive-model", "fits, simulates, compares and diagnoses recordings"),
}

_MISSING = "{program} is not installed: wheels bring it along, an installation from a clone does not; from there: `cargo install --path {folder}`"

_FOLDERS = {"host": "host-driver", "sim": "sim-hil", "model": "models"}


def find(program: str) -> str | None:
    """Path of a program: beside this interpreter, where pip puts it, or anywhere on the PATH."""
    beside = Path(sysconfig.get_path("scripts")) / program
    return str(beside) if os.access(beside, os.X_OK) else shutil.which(program)


def usage() -> str:
    lines = [f"pneudrive_py {__version__}", "", "usage: python -m pneudrive_py PROGRAM [ARGUMENTS ...]", ""]
    for name, (program, purpose) in PROGRAMS.items():
        where = find(program) or "not installed"
        lines.append(f"  {name:6} {program:16} {purpose} ({where})")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
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
    program = PROGRAMS[name][0]
    path = find(program)
    if path is None:
        print("error: " + _MISSING.format(program=program, folder=_FOLDERS[name]), file=sys.stderr)
        return 1
    # In this process's place, so that signals and the exit status are the program's.
    os.execv(path, [program, *arguments[1:]])


if __name__ == "__main__":
    sys.exit(main())
