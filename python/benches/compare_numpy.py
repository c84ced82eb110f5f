"""Batch simulation against a NumPy loop of the same model: same numbers, how much faster.

NumPy does all chambers at once, array by array, and loops over the rows in Python: the usual way to write it. The model is the
nonlinear one (docs/models.md), integrated with the same Runge-Kutta steps.

    python python/benches/compare_numpy.py [--chambers 4096] [--rows 500]
"""

import argparse
import os
import time

import numpy as np

import pneudrive_py as pneu

GAMMA, GAS_CONSTANT, TEMPERATURE_K, AMBIENT_PA = 1.4, 287.05, 293.15, 101_325.0
PSI_MAX = (2.0 / (GAMMA + 1.0)) ** (1.0 / (GAMMA - 1.0)) * np.sqrt(GAMMA / (GAMMA + 1.0))
FILLING_SPEED = GAMMA * np.sqrt(2.0 * GAS_CONSTANT * TEMPERATURE_K)
CRITICAL_RATIO, LAMINAR_RATIO = 0.3, 0.999


def flow_pressure(upstream, downstream):
    """psi(r) p_u after ISO 6358 with a laminar segment; negative when the flow runs backwards."""
    high, low = np.maximum(upstream, downstream), np.minimum(upstream, downstream)
    z_high = np.maximum(low - CRITICAL_RATIO * high, 0.0) / (1.0 - CRITICAL_RATIO)
    z = (LAMINAR_RATIO - CRITICAL_RATIO) / (1.0 - CRITICAL_RATIO)
    slope = PSI_MAX * np.sqrt(1.0 - z * z) / (1.0 - LAMINAR_RATIO)
    value = np.where(low > LAMINAR_RATIO * high, (high - low) * slope, PSI_MAX * np.sqrt(high * high - z_high * z_high))
    return np.where(upstream < downstream, -value, value)


def opening_mm2(leak, gain, opening, corner):
    x = gain * opening - leak
    return leak + 0.5 * (np.sqrt(x * x + corner * corner) + x)


def numpy_loop(parameters, drive, interval_s, start_kpa, supply_kpa, volume_m3):
    """Pressures in kPa gauge, shape (chambers, rows)."""
    leak_in, leak_out, gain, threshold_in, threshold_out, corner, _ = parameters.T
    supply = AMBIENT_PA + 1e3 * supply_kpa
    pressure = np.full(len(parameters), AMBIENT_PA + 1e3 * start_kpa)
    result = np.empty(drive.shape)
    conductance = 1e-6 * FILLING_SPEED / volume_m3
    for row in range(drive.shape[1]):
        result[:, row] = pressure
        u = drive[:, row]
        fill = conductance * opening_mm2(leak_in, gain, u - threshold_in, corner)
        vent = conductance * opening_mm2(leak_out, gain, threshold_out - u, corner)

        def rate(p, fill=fill, vent=vent):
            return fill * flow_pressure(supply, p) - vent * flow_pressure(p, AMBIENT_PA)

        k1 = rate(pressure)
        k2 = rate(pressure + 0.5 * interval_s * k1)
        k3 = rate(pressure + 0.5 * interval_s * k2)
        k4 = rate(pressure + interval_s * k3)
        pressure = pressure + interval_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return (result - AMBIENT_PA) * 1e-3


def best(work, repetitions):
    """Shortest time and CPU time (all threads) of some runs, s, and the result: what disturbs only makes them longer."""
    times, cpu_times, result = [], [], None
    for _ in range(repetitions):
        began, cpu_began = time.perf_counter(), time.process_time()
        result = work()
        times.append(time.perf_counter() - began)
        cpu_times.append(time.process_time() - cpu_began)
    return (min(times), min(cpu_times)), result


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--chambers", type=int, default=4096)
    arguments.add_argument("--rows", type=int, default=500)
    arguments.add_argument("--repetitions", type=int, default=5)
    options = arguments.parse_args()
    random = np.random.default_rng(1)
    nominal = np.array([0.02, 0.02, 2.0, 0.05, -0.03, 0.1, 1.0])
    parameters = nominal * random.uniform(0.9, 1.1, (options.chambers, 7))
    drive = random.uniform(-0.5, 0.5, (options.chambers, options.rows))
    inputs = {"start_kpa": 100.0, "supply_kpa": 550.0, "volume_m3": 3.6e-4}

    def batch(**more):
        return pneu.simulate_batch("nonlinear", parameters, 0.01, drive=drive, **inputs, **more)

    one = slice(0, 1)
    alone, _ = best(lambda: numpy_loop(parameters[one], drive[one], 0.01, **inputs), options.repetitions)
    loop, expected = best(lambda: numpy_loop(parameters, drive, 0.01, **inputs), options.repetitions)
    batched, pressures = best(batch, options.repetitions)
    duals, _ = best(lambda: batch(sensitivities=True), options.repetitions)
    difference = np.abs(pressures - expected).max()
    steps = options.chambers * options.rows
    print(f"{options.chambers} chambers, {options.rows} rows; NumPy {np.__version__}; {os.cpu_count()} cores")
    print(f"largest difference {difference:.1e} kPa")
    print(f"{'ns per chamber and row':32} {'time':>9} {'CPU time':>9} {'faster':>8} {'by CPU time':>12}")
    lines = [
        ("NumPy, one chamber", alone, options.rows),
        ("NumPy, all chambers at once", loop, steps),
        ("simulate_batch", batched, steps),
        ("  with seven sensitivities", duals, steps),
    ]
    for name, (wall, cpu), number in lines:
        faster, by_cpu = loop[0] / steps / (wall / number), loop[1] / steps / (cpu / number)
        print(f"{name:32} {1e9 * wall / number:9.1f} {1e9 * cpu / number:9.1f} {faster:8.1f} {by_cpu:12.1f}")
    if not difference < 1e-6:
        raise SystemExit("the two do not simulate the same model")


if __name__ == "__main__":
    main()
