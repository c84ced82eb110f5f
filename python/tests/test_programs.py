"""Data sets of the truth plant, and the programs from the command line."""

import subprocess
import sys

import pytest

import pneudrive_py as pneu
from pneudrive_py import __main__ as program


def test_a_data_set_is_made_and_can_be_simulated(tmp_path):
    made = pneu.sim.record(seconds=20.0, rate_hz=50.0, channels=2, drive=True, seed=3)
    assert len(made.recording) == 1000 and made.recording.channels == ["b0c0", "b0c1"]
    fitted = pneu.fit(made.recording, made.rig, starts=1, fit_fraction=0.5)
    assert fitted.held_out["b0c0"]["rmse_kpa"] < 20.0


def test_a_data_set_is_kept_where_it_is_wanted(tmp_path):
    first = pneu.sim.record(tmp_path / "run.csv.zst", seconds=2.0, effects=["exhaust_leak"], seed=5)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.csv.zst", "run.toml"]
    again = pneu.sim.record(seconds=2.0, effects=["exhaust_leak"], seed=5)
    assert (first.recording["b0_p0_kpa"] == again.recording["b0_p0_kpa"]).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"excitation": "wild"}, "excitation is .*it must be"),
        ({"effects": ["gremlins"]}, "gremlins"),
        ({"seconds": -1.0}, "seconds"),
        ({"drive": True, "open_loop": 0.3}, "not both"),
    ],
)
def test_data_sets_that_make_no_sense(arguments, message):
    with pytest.raises(pneu.DataError, match=message):
        pneu.sim.record(**arguments)


def run(*arguments):
    return subprocess.run([sys.executable, "-m", "pneudrive_py", *arguments], capture_output=True, text=True)


def test_the_command_line_says_what_there_is():
    done = run()
    assert done.returncode == 0 and "pneudrive-host" in done.stdout and pneu.__version__ in done.stdout
    assert run("--version").stdout.strip() == f"pneudrive_py {pneu.__version__}"
    done = run("valve")
    assert done.returncode == 2 and "no program valve; there is host, sim, model" in done.stderr


def test_a_program_gets_its_arguments_and_its_status_is_passed_on(tmp_path, monkeypatch):
    script = tmp_path / "pneudrive-model"
    script.write_text('#!/bin/sh\necho "$@"\nexit 7\n')
    script.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    if program.find("pneudrive-model") != str(script):
        pytest.skip("the programs are installed beside this interpreter")
    done = run("model", "show", "run.csv")
    assert (done.returncode, done.stdout) == (7, "show run.csv\n")


def test_a_program_that_is_not_there_is_named(monkeypatch, capsys):
    monkeypatch.setattr(program, "find", lambda name: None)
    assert program.main(["model"]) == 1
    assert "pneudrive-model is not installed" in capsys.readouterr().err
