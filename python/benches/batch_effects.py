"""What a row of `simulate_batch` costs with effects, beside one without: ns of CPU time per chamber and row.

    python python/benches/batch_effects.py [--chambers 256] [--rows 500]
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

import pneudrive_py as pneu

MODEL = """schema = "pneudrive-extended/1"
model = "nonlinear"
[rig.supply]
pressure_kpa = 550.0
[rig.chamber]
volume_m3 = 3.6e-4
[rig.controller]
rate_hz = 1000.0
kp = 10.0
kd = 0.0
saturation = 400.0
[rig.sensor]
bits = 10
zero_counts = 102.4
kpa_per_count = 0.841645
[channels.b0c0]
drive = "spool"
noise_kpa = 0.3
command_range_kpa = 300.0
parameters = { leak_in = 0.02, leak_out = 0.02, gain = 2.0, threshold_in = 0.05, threshold_out = -0.05, corner = 0.1, \
volume_weight = 1.0 }
"""
LAG = "[channels.b0c0.effects.valve_lag]\ntime_constant = 0.02\n"
MORE = LAG + "[channels.b0c0.effects.valve_hysteresis]\nhalf_width = 0.03\n[channels.b0c0.effects.transport_delay]\ndelay = 0.0113\n"


def load(effects):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "extended.toml"
        path.write_text(MODEL + effects)
        return pneu.ExtendedModel.load(path)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--chambers", type=int, default=256)
    parser.add_argument("--rows", type=int, default=500)
    parser.add_argument("--repetitions", type=int, default=10)
    options = parser.parse_args()
    shape = (options.chambers, options.rows)
    drive = np.repeat(np.random.default_rng(1).uniform(-0.5, 0.5, (shape[0], shape[1] // 20)), 20, axis=1)
    command = 150.0 + 200.0 * drive
    values = [p["value"] for p in pneu.model_parameters(load(""))]
    rig = load("").rig
    ways = {
        "no effects, in lockstep": lambda: pneu.simulate_batch("nonlinear", values, 0.01, drive=drive, rig=rig),
        "an extended model without effects": lambda: pneu.simulate_batch(load(""), None, 0.01, drive=drive),
        "with valve_lag": lambda: pneu.simulate_batch(load(LAG), None, 0.01, drive=drive),
        "with valve_lag, valve_hysteresis, transport_delay": lambda: pneu.simulate_batch(load(MORE), None, 0.01, drive=drive),
        "the same with sensitivities": lambda: pneu.simulate_batch(load(MORE), None, 0.01, drive=drive, sensitivities=True),
        "the same behind the board's loop": lambda: pneu.simulate_batch(load(MORE), None, 0.01, command_kpa=command, controller=True),
    }
    print(f"{shape[0]} chambers, {shape[1]} rows of 10 ms\n| | ns of CPU time |\n| --- | --- |")
    for name, way in ways.items():
        spent = []
        for _ in range(options.repetitions):
            began = time.process_time()
            way()
            spent.append(time.process_time() - began)
        print(f"| {name} | {1e9 * min(spent) / (shape[0] * (shape[1] // 20 * 20)):.3g} |")


if __name__ == "__main__":
    main()
