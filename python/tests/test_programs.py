"""Data sets of the truth plant, and the programs from the command line."""

import json
import os
import signal
import subprocess
import sys
import sysconfig

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


def run(*arguments, folder=None):
    command = [sys.executable, "-m", "pneudrive_py", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder)


def test_the_command_line_says_what_there_is():
    done = run()
    assert done.returncode == 0 and "pneudrive-host" in done.stdout and pneu.__version__ in done.stdout
    assert run("--version").stdout.strip() == f"pneudrive_py {pneu.__version__}"
    done = run("valve")
    assert done.returncode == 2 and "no program valve; there is host, sim, model" in done.stderr


def test_a_program_gets_its_arguments_and_its_status_is_passed_on(tmp_path):
    done = run("model", "show", str(tmp_path / "nothing.csv"))
    assert done.returncode == 2 and "nothing.csv" in done.stderr and "Traceback" not in done.stderr
    done = run("sim", "record", "--seconds", "2", "--out", "run.csv", folder=tmp_path)
    assert done.returncode == 0 and "200 rows" in done.stderr, done.stderr
    done = run("model", "show", "run.csv", folder=tmp_path)
    assert done.returncode == 0 and "200 rows" in done.stderr and "run.html" in done.stdout, done.stdout + done.stderr


@pytest.mark.parametrize("name", ["host", "sim", "model"])
def test_help_and_unusable_arguments_are_those_of_the_program(name):
    assert run(name, "--version").stdout.strip() == f"pneudrive-{name} {pneu.__version__}"
    done = run(name, "--help")
    assert done.returncode == 0 and f"pneudrive-{name}" in done.stdout
    done = run(name, "--nonsense")
    assert done.returncode == 2 and "--nonsense" in done.stderr and f"Usage: pneudrive-{name}" in done.stderr


def test_what_a_program_writes_says_how_it_was_called(tmp_path):
    run("sim", "record", "--seconds", "4", "--drive", "--out", "run.csv", "--rig-out", "run.toml", folder=tmp_path)
    arguments = ["fit", "run.csv", "--rig", "run.toml", "--model", "nonlinear", "--starts", "1", "--out", "fitted.toml"]
    done = run("model", *arguments, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    provenance = pneu.Parameters.load(tmp_path / "fitted.toml").to_dict()["provenance"]
    assert provenance["command"] == " ".join(["pneudrive-model", *arguments])


def test_ctrl_c_belongs_to_the_program():
    command = [sys.executable, "-m", "pneudrive_py", "sim", "--devices", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
        assert program.stdout.readline().startswith("/dev/pts/")
        program.send_signal(signal.SIGINT)
        said, errors = program.communicate(timeout=60)
    assert program.returncode == 0 and json.loads(said) and "Traceback" not in errors


def test_programs_find_each_other_beside_the_interpreter(monkeypatch):
    monkeypatch.setattr(program._pneudrive, "_run_program", lambda name, arguments: (name, os.environ["PATH"]))
    monkeypatch.setenv("PATH", "/usr/bin")
    before = signal.getsignal(signal.SIGINT)
    try:
        assert program.main(["host"]) == ("pneudrive-host", f"{sysconfig.get_path('scripts')}:/usr/bin")
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_program_that_is_not_there_is_named():
    with pytest.raises(ValueError, match="no program pneudrive-valve"):
        program._pneudrive._run_program("pneudrive-valve", [])
