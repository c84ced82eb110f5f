"""Model predictive control of twelve chambers at 100 Hz, on virtual boards or a rig.

    python python/examples/mpc.py                          # three virtual boards
    python python/examples/mpc.py --port /dev/ttyUSB0

First a model is identified: the chambers are played random steps, and the nonlinear model is fitted to what they did, with the
boards' own loop inside. Then the chambers follow a reference that is known ahead, twice: with the reference itself as set points, and with
set points that the model says will bring the pressures there. Every 10 ms the plan of each chamber, four corrections of the set point
over the next 0.2 s, is improved by one Gauss-Newton step; its derivatives are differences of one call of `simulate_batch`, five
simulations a chamber. Prints the error of both, and how long the computation took.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import pneudrive_py as pneu

STEP_S = 0.01
HORIZON = 20  # rows, STEP_S apart
KNOTS = 4
#: How much a correction of 1 kPa counts beside an error of 1 kPa in every row.
WEIGHT = 0.02
#: Difference of a correction by which derivatives are taken, kPa: a few counts of the sensor.
DELTA_KPA = 4.0
HIGHEST_KPA = 300.0

RIG = """
[supply]
pressure_kpa = 550.0
[chamber]
radius_m = 0.024
length_m = 0.2
offset_m = 0.045
[controller]
rate_hz = 1000.0
kp = 10.0
kd = 20.0
saturation = 400.0
filter = 0.8203125
[sensor]
bits = 10
zero_counts = 102.4
kpa_per_count = 0.841645
"""


class Mpc:
    """Plans set points of many chambers at once."""

    def __init__(self, parameters, rig, chambers):
        self.parameters, self.rig = parameters, rig
        self.plan_kpa = np.zeros((chambers, KNOTS))
        # A correction is interpolated between its knots.
        self.weights = np.maximum(0.0, 1.0 - np.abs(np.linspace(0, KNOTS - 1, HORIZON)[:, None] - np.arange(KNOTS)))

    def commands(self, reference_kpa, plans):
        """Set points of plans, shape (.., KNOTS), along the reference, shape (.., HORIZON)."""
        return np.clip(reference_kpa + plans @ self.weights.T, 0.0, HIGHEST_KPA)

    def step(self, measured_kpa, reference_kpa):
        """The set points to command now, kPa, shape (chambers,); `reference_kpa` is that of the rows from now on."""
        tried = self.plan_kpa[:, None, :] + DELTA_KPA * np.concatenate([np.zeros((1, KNOTS)), np.eye(KNOTS)])
        commands = self.commands(reference_kpa[:, None, :], tried)
        simulated = pneu.simulate_batch(
            "nonlinear",
            np.repeat(self.parameters, KNOTS + 1, axis=0),
            STEP_S,
            command_kpa=commands.reshape(-1, HORIZON),
            start_kpa=np.repeat(np.maximum(measured_kpa, 0.0), KNOTS + 1),
            rig=self.rig,
            controller=True,
        ).reshape(commands.shape)
        slopes = np.swapaxes(simulated[:, 1:] - simulated[:, :1], 1, 2) / DELTA_KPA  # (chambers, HORIZON, KNOTS)
        errors = simulated[:, 0] - reference_kpa
        normal = np.swapaxes(slopes, 1, 2) @ slopes + WEIGHT * HORIZON * np.eye(KNOTS)
        downhill = np.einsum("crk,cr->ck", slopes, errors) + WEIGHT * HORIZON * self.plan_kpa
        self.plan_kpa -= np.linalg.solve(normal, downhill[..., None])[..., 0]
        return self.commands(reference_kpa, self.plan_kpa)[:, 0]


def identify(poller, rig, boards, seconds):
    """Parameters of the nonlinear model of every chamber, shape (4 * boards, parameters)."""
    random = np.random.default_rng(1)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        poller.set_all(random.uniform(20.0, 250.0, (boards, 4)))
        time.sleep(random.uniform(0.2, 0.6))
    recording = pneu.Recording.from_history(poller.history(), rig=rig)
    fit = pneu.fit(recording, rig, model="nonlinear", starts=1)
    return np.array([fit.parameters.array(channel) for channel in recording.channels])


def reference(t_s, chambers):
    """Pressures that are wanted, kPa, shape (chambers, times): sines of 0.5 to 1.05 Hz, one for each chamber."""
    chamber = np.arange(chambers)[:, None]
    return 120.0 + 60.0 * np.sin(2.0 * np.pi * (0.5 + 0.05 * chamber) * t_s + chamber)


def follow(poller, boards, seconds, controller=None):
    """Follows the reference, with its own values as set points without a controller. Returns (RMS error in kPa, times of computation
    in s, cycles that came too late)."""
    chambers = 4 * boards
    ahead_s = STEP_S * np.arange(HORIZON)
    errors, computed_s, late = [], [], 0
    start = time.monotonic()
    for cycle in range(round(seconds / STEP_S)):
        now_s = time.monotonic() - start
        pause_s = cycle * STEP_S - now_s
        late += pause_s < -STEP_S
        time.sleep(max(0.0, pause_s))
        now_s = time.monotonic() - start
        wanted = reference(now_s + ahead_s, chambers)
        measured = poller.get_all().reshape(-1)
        started = time.perf_counter()
        if controller is None or np.isnan(measured).any():
            commands = wanted[:, 0]
        else:
            commands = controller.step(measured, wanted)
        computed_s.append(time.perf_counter() - started)
        poller.set_all(commands.reshape(boards, 4))
        if now_s > 1.0:  # from rest to the reference
            errors.append(measured - wanted[:, 0])
    return float(np.sqrt(np.nanmean(np.square(errors)))), np.array(computed_s), late


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", default="sim")
    parser.add_argument("--boards", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=10.0, help="of each of the two runs")
    parser.add_argument("--identify-seconds", type=float, default=20.0)
    given = parser.parse_args(arguments)
    rig = pneu.Rig.parse(RIG)
    with pneu.PressureController(given.port, given.boards, max_kpa=HIGHEST_KPA) as bus:
        bus.ping_devices()
        with bus.poll(rate_hz=200, history_s=given.identify_seconds + 5.0) as poller:
            parameters = identify(poller, rig, given.boards, given.identify_seconds)
            plain_kpa, _, _ = follow(poller, given.boards, given.seconds)
            controller = Mpc(parameters, rig, 4 * given.boards)
            error_kpa, computed_s, late = follow(poller, given.boards, given.seconds, controller)
    print(f"reference as set points: error {plain_kpa:.1f} kPa RMS")
    print(f"predictive control:      error {error_kpa:.1f} kPa RMS")
    p50_ms, p99_ms = 1e3 * np.percentile(computed_s, [50, 99])
    print(
        f"{4 * given.boards} chambers, {len(computed_s)} cycles at {1.0 / STEP_S:.0f} Hz, {late} of them late; "
        f"computed in {p50_ms:.2f} ms (median), {p99_ms:.2f} ms (99 %)"
    )
    return plain_kpa, error_kpa


if __name__ == "__main__":
    main()
