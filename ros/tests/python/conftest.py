"""What the tests share: where our programs are, and a DDS domain for each."""

import itertools
import os
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]

# Boards that remember what they were commanded last.
sys.path.append(str(ROOT / "python" / "tests"))


def binary(name: str) -> str:
    """Path of one of our programs, built before."""
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    path = target / os.environ.get("PNEUDRIVE_PROFILE", "debug") / name
    assert path.exists(), f"{path} is missing: build it with cargo first"
    return str(path)


def compare(file, channel, folder) -> str:
    """What `pneudrive-model` says of one channel of a file. Whether the rows are good enough for a fit depends on how busy the
    machine was when they were recorded."""
    command = [binary("pneudrive-model"), "compare", file, "--channels", channel, "--models", "linear"]
    command = [*map(str, command), "--starts", "2", "--out", str(folder / "out")]
    return subprocess.run(command, capture_output=True, text=True, timeout=300).stderr


# Domains 1 to 101 have ports below those that Linux gives away by itself.
WORKERS, DOMAINS_EACH = 4, 25
tests = itertools.count(os.getpid())


@pytest.fixture(autouse=True)
def domain(monkeypatch):
    """Each test in a DDS domain of its own, apart from tests beside it and from what the test before has left."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")) % WORKERS
    number = 1 + DOMAINS_EACH * worker + next(tests) % DOMAINS_EACH
    monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
    return number
