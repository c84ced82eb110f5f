"""LMFIT with numpy and numba against this crate, on the same recording, in the same run, CPU seconds of one thread.

    python3 -m venv .venv && .venv/bin/pip install -r models/tests/oracle/requirements.txt
    .venv/bin/python models/benches/compare_lmfit.py [--repeats 3] [--starts]

Both sides make the same fits of the nonlinear model to 20,000 samples: on rates (numpy on their side), and on rollouts with the start
pressure fitted (numba, compiled beforehand). `--starts` adds twenty starts of rollouts on LMFIT's side (half a minute). The median
of the repeats is shown; both sides take turns, so that a busy machine is busy for both.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

MODELS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(MODELS / "tests" / "oracle"))

import lmfit  # noqa: E402
import numpy as np  # noqa: E402

import chamber  # noqa: E402
import fits  # noqa: E402
import recording  # noqa: E402


def timed(run):
    before = time.process_time()
    result = run()
    return result, time.process_time() - before


def median_time(run, repeats=7):
    """The other side does the same: the first run touches memory and code for the first time."""
    runs = [timed(run) for _ in range(repeats)]
    return runs[0][0], statistics.median(seconds for _, seconds in runs)


def theirs(data, starts):
    """Name, CPU seconds, sum of squares."""
    rates = fits.rate_arguments(data)
    fit, seconds = median_time(lambda: lmfit.minimize(fits.rate_residual, fits.parameters(), args=rates))
    yield "rate", seconds, fit
    first = data[5][0] * 1e-3
    rollout = lambda values: lmfit.minimize(fits.rollout_residual, fits.parameters(first, values), args=(data,))
    fit, seconds = median_time(lambda: rollout(fits.NOMINAL))
    yield "rollout", seconds, fit
    if starts:
        rng = np.random.default_rng(1)
        low, high = np.array(fits.BOUNDS).T
        points = [fits.NOMINAL] + [list(rng.uniform(low, high)) for _ in range(19)]
        results, seconds = timed(lambda: [rollout(point) for point in points])
        yield "rollout x20", seconds, min(results, key=lambda fit: fit.chisqr)
    q = np.array(fits.NOMINAL)
    run = lambda: [chamber.rollout(q, 2e5, recording.DT, *data[:4], False) for _ in range(20)]
    yield "simulate", timed(run)[1] / (20 * len(data[0])), None


def ours(directory):
    program = [os.environ.get("TIME_FITS", "target/release/examples/time_fits")]
    lines = subprocess.run(
        program + [directory / "recording.csv", directory / "rig.toml"], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    for line in map(json.loads, lines):
        if line["fit"] == "simulate":
            yield "simulate", 1 / line["steps_per_s"], None
        else:
            yield line["fit"] + (" x20" if line["starts"] == 20 else ""), line["cpu_s"], line


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--repeats", type=int, default=3)
    arguments.add_argument("--rows", type=int, default=20_000)
    arguments.add_argument("--starts", action="store_true")
    arguments = arguments.parse_args()
    data = recording.make(arguments.rows)
    list(theirs(recording.make(100), False))  # compiles
    times = {"LMFIT": {}, "PneuDrive": {}}
    results = {"LMFIT": {}, "PneuDrive": {}}
    with tempfile.TemporaryDirectory() as directory:
        recording.write(directory, arguments.rows)
        for _ in range(arguments.repeats):
            for side, run in (("LMFIT", theirs(data, arguments.starts)), ("PneuDrive", ours(Path(directory)))):
                for name, seconds, result in run:
                    times[side].setdefault(name, []).append(seconds)
                    results[side][name] = result
    print("| nonlinear model, 20,000 samples, CPU | LMFIT | PneuDrive | factor |\n| --- | --- | --- | --- |")
    for name, ours_s in times["PneuDrive"].items():
        mine = statistics.median(ours_s)
        if name not in times["LMFIT"]:
            print(f"| {name} | not run | {1e3 * mine:.1f} ms | |")
            continue
        their = statistics.median(times["LMFIT"][name])
        if name == "simulate":
            print(f"| RK4 steps per second | {1 / their:.3g} | {1 / mine:.3g} | {their / mine:.1f} |")
        else:
            print(f"| {name} | {1e3 * their:.1f} ms | {1e3 * mine:.1f} ms | {their / mine:.1f} |")
    for name in ("rate", "rollout"):
        fit, mine = results["LMFIT"][name], results["PneuDrive"][name]
        apart = max(abs(fit.params[n].value - mine["parameters"][n]) / fit.params[n].stderr for n in fits.NAMES)
        print(f"{name}: parameters differ by at most {apart:.3f} of LMFIT's standard error")


if __name__ == "__main__":
    main()
