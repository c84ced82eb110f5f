"""Makes the notebooks' outputs, or compares them with those that are committed.

    python python/notebooks/run.py                 # runs all and writes their outputs into them
    python python/notebooks/run.py --check         # runs all and compares; exit status 1 where one differs
    python python/notebooks/run.py --check 04      # those whose name begins so

With ``PNEUDRIVE_SHORT=1`` experiments are fewer and shorter, and numbers that depend on that are not compared.

Compared is, cell by cell, of which kinds the outputs are (text, picture, table), their words, and their numbers: within 0.1 % and
1e-9, or what the cell's metadata say, ``"pneudrive": {"relative": 0.05, "absolute": 1.0}``. ``"numbers": "length"`` there says that they
depend on the length of experiments, ``"numbers": "machine"`` that they depend on the machine's speed: those must only be there.
Pictures are not compared by their pixels, which depend on fonts.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

HERE = Path(__file__).parent
NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d+)?|\bnan\b|\binf\b")
PTY = re.compile(r"/dev/pts/\d+")
TIMEOUT_S = 900
# Pictures are text, too: lines that a diff shows, and no date in them.
DRAWN = {
    "figure_formats": "{'svg'}",
    "print_figure_kwargs": "{'bbox_inches': 'tight', 'metadata': {'Date': None, 'Creator': None, 'Format': None, 'Type': None}}",
    "rc": "{'svg.hashsalt': 'pneudrive'}",
}


@dataclass(frozen=True)
class Rule:
    """How the numbers of a cell are compared."""

    relative: float = 1e-3
    absolute: float = 1e-9
    numbers: str = "same"

    @classmethod
    def of(cls, cell) -> Rule:
        rule = cls(**cell.metadata.get("pneudrive", {}))
        if rule.numbers not in ("same", "length", "machine"):
            raise ValueError(f'numbers is {rule.numbers!r}; it must be "same", "length" or "machine"')
        return rule

    def applies(self, short: bool) -> bool:
        return self.numbers == "same" or (self.numbers == "length" and not short)


def text_of(outputs) -> str:
    """What a cell printed and showed, as text. A kernel hands on what is printed in pieces, as it comes."""
    printed = "".join(output["text"] for output in outputs if output.output_type == "stream" and output.name == "stdout")
    shown = [output.get("data", {}).get("text/plain", "") for output in outputs if output.output_type != "stream"]
    return PTY.sub("/dev/pts/N", "\n".join([printed, *shown]))


def kinds_of(outputs) -> list[str]:
    """`stdout`, however often, and the kinds of what is shown; warnings are the machine's."""
    printed = {output.name for output in outputs if output.output_type == "stream" and output.name != "stderr"}
    shown = [kind for output in outputs if output.output_type != "stream" for kind in output.get("data", {})]
    return sorted([*printed, *shown])


def differences(committed, made, rule: Rule, short: bool) -> list[str]:
    """What differs between two lists of outputs, in words."""
    if kinds_of(committed) != kinds_of(made):
        return [f"outputs are {', '.join(kinds_of(made)) or 'none'}, committed {', '.join(kinds_of(committed)) or 'none'}"]
    before, after = text_of(committed), text_of(made)
    # Where lengths differ, so do the words that depend on them.
    if not rule.applies(short):
        return [] if bool(before.strip()) == bool(after.strip()) else [f"text is {after!r}, committed {before!r}"]
    # Columns are as wide as their numbers, and arrays pad the numbers that have no sign.
    words = [re.sub(r"[\s─-]+", "", NUMBER.sub("#", text)) for text in (before, after)]
    if words[0] != words[1]:
        return [f"text is {after!r}, committed {before!r}"]
    found = []
    for was, now in zip(NUMBER.findall(before), NUMBER.findall(after), strict=True):
        a, b = float(was), float(now)
        if was != now and not abs(a - b) <= rule.absolute + rule.relative * abs(a):
            found.append(f"{now}, committed {was}")
    return found


def run(path: Path):
    """The notebook with what its cells put out now."""
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    client = NotebookClient(
        notebook,
        timeout=TIMEOUT_S,
        resources={"metadata": {"path": str(HERE)}},
        record_timing=False,
        extra_arguments=[f"--InlineBackend.{name}={value}" for name, value in DRAWN.items()],
    )
    client.execute()
    # Dates, and the version of Python, are not the notebook's.
    notebook.metadata = {"kernelspec": notebook.metadata["kernelspec"], "language_info": {"name": "python"}}
    return notebook


def check(path: Path, short: bool) -> list[str]:
    """What differs from the committed outputs, in words."""
    committed, made = nbformat.read(path, as_version=4), run(path)
    found = []
    for number, (before, after) in enumerate(zip(committed.cells, made.cells, strict=True)):
        if after.cell_type == "code":
            found += [f"cell {number}: {what}" for what in differences(before.outputs, after.outputs, Rule.of(after), short)]
    return found


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    parser.add_argument("names", nargs="*", metavar="NAME", help="beginnings of file names; all by default")
    given = parser.parse_args(arguments)
    short = bool(os.environ.get("PNEUDRIVE_SHORT"))
    if short and not given.check:
        parser.error("PNEUDRIVE_SHORT is set: outputs of shortened experiments are not committed; unset it, or pass --check")
    paths = sorted(HERE.glob("*.ipynb"))
    if given.names:
        paths = [path for path in paths if path.name.startswith(tuple(given.names))]
    if not paths:
        parser.error(f"no notebook begins with {', '.join(given.names)}")
    failed = 0
    for path in paths:
        try:
            if given.check:
                found = check(path, short)
            else:
                nbformat.write(run(path), path)
                found = []
        except CellExecutionError as error:
            found = [str(error)]
        failed += bool(found)
        print(f"{path.name}: {'FAILED' if found else 'ok'}", *found, sep="\n    ", flush=True)
    print(f"{len(paths) - failed} passed" + (f", {failed} failed" if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
