"""What the comparison of notebooks' outputs lets pass, and what it does not; and that outputs are committed."""

import importlib.util
import sys
from pathlib import Path

import nbformat
import pytest

NOTEBOOKS = Path(__file__).parent.parent / "notebooks"

spec = importlib.util.spec_from_file_location("notebooks_run", NOTEBOOKS / "run.py")
run = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = run  # where dataclasses look for their types
spec.loader.exec_module(run)


def printed(text):
    return [nbformat.v4.new_output("stream", name="stdout", text=text)]


def shown(text, **kinds):
    return [nbformat.v4.new_output("display_data", data={"text/plain": text, **kinds})]


LENGTH, MACHINE = run.Rule(numbers="length"), run.Rule(numbers="machine")


@pytest.mark.parametrize(
    "committed, made, rule, short",
    [
        (printed("error 12.34 kPa"), printed("error 12.341 kPa"), run.Rule(), False),
        (printed("error 12.3 kPa"), printed("error 14.0 kPa"), run.Rule(relative=0.2), False),
        (printed("a   1.0 |"), printed("a 1.0001 |"), run.Rule(), False),
        (printed("10 trials"), printed("3 trials"), LENGTH, True),
        (printed("in 0.31 s"), printed("in 2.55 s"), MACHINE, False),
        (shown("on /dev/pts/3"), shown("on /dev/pts/12"), run.Rule(), False),
        (shown("Figure", **{"image/svg+xml": "AAAA"}), shown("Figure", **{"image/svg+xml": "BBBB"}), run.Rule(), False),
        (shown("array([-0.3, -0.3])"), shown("array([ 0.5, -0.3])"), run.Rule(absolute=5.0), False),
        (printed("one 1"), [*printed("one"), *printed(" 1")], run.Rule(), False),
        ([], [], run.Rule(), False),
    ],
)
def test_what_passes(committed, made, rule, short):
    assert run.differences(committed, made, rule, short) == []


@pytest.mark.parametrize(
    "committed, made, rule, short",
    [
        (printed("error 12.34 kPa"), printed("error 12.44 kPa"), run.Rule(), False),
        (printed("error 12.34 kPa"), printed("error nan kPa"), run.Rule(), False),
        (printed("valve_lag 0.1"), printed("valve_bias 0.1"), run.Rule(), False),
        (printed("1.0 2.0"), printed("1.0"), run.Rule(), False),
        (printed("10 trials"), printed("3 trials"), LENGTH, False),
        (printed("in 0.31 s"), printed(""), MACHINE, False),
        (printed("in 0.31 s"), [], MACHINE, True),
        (shown("Figure", **{"image/svg+xml": "AAAA"}), shown("Figure"), run.Rule(), False),
    ],
)
def test_what_does_not(committed, made, rule, short):
    assert run.differences(committed, made, rule, short)


def test_a_rule_that_is_none():
    cell = nbformat.v4.new_code_cell("1", metadata={"pneudrive": {"numbers": "never"}})
    with pytest.raises(ValueError, match='numbers is \'never\'; it must be "same", "length" or "machine"'):
        run.Rule.of(cell)


@pytest.mark.parametrize("path", sorted(NOTEBOOKS.glob("*.ipynb")), ids=lambda path: path.stem)
def test_outputs_are_committed(path):
    cells = [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]
    assert all(cell.execution_count for cell in cells), "run: python python/notebooks/run.py"
    kinds = {kind for cell in cells for output in cell.outputs for kind in output.get("data", {})}
    assert [kind for kind in kinds if kind.startswith("image/")] == ["image/svg+xml"], "run: python python/notebooks/run.py"
    assert not any(output.output_type == "error" for cell in cells for output in cell.outputs)
