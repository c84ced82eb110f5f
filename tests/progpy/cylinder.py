"""Recordings of a pneumatic valve's cylinder as progpy simulates it: its two chambers are two channels.

The plant is progpy's PneumaticValveWithWear (Daigle and Goebel, Int. J. Prognostics and Health Management 2, 2011): nitrogen at constant
temperature, nozzles, a piston with spring and friction between the chambers, leaks of each to the air and between them. Scaled here to
what soft robots have: 500 kPa, nozzles of 2 mm2. Each chamber is switched between supply and air, rhythmically, as a three-way valve does.
"""

import csv
import warnings
from dataclasses import dataclass

import numpy
from progpy.models import PneumaticValveWithWear

ATMOSPHERE_PA = 101_325.0
SUPPLY_PA = ATMOSPHERE_PA + 500e3
NOZZLE_M2 = 2e-6
STEP_S = 0.001
ROWS_HZ = 100
NOISE_KPA = 0.25

RIG = """\
# Two nozzles of the plant, each 0.62 times 2 mm2; the volume is that of the chamber below the
# piston, the one above is 1.4 times that.
[supply]
pressure_kpa = 500.0
[chamber]
volume_m3 = 0.0008107
[valve]
critical_ratio = 0.528
"""


@dataclass(frozen=True)
class Cylinder:
    """A cylinder with its faults. Leaks are areas over the nozzles', and have no coefficient of contraction."""

    seed: int
    bottom_leak: float = 0.0
    top_leak: float = 0.0
    internal_leak: float = 0.0
    spring_n_m: float = 8e4
    """As it is, the spring holds the piston at the bottom."""
    spring_offset_m: float = 0.254
    friction_n_s_m: float = 6e3
    seconds: float = 120.0

    def record(self, path):
        """Simulates it and writes a recording with drives."""
        rng = numpy.random.default_rng(self.seed)
        switched = numpy.stack([_rhythm(rng, self.seconds) for _ in range(2)], axis=1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            rows = self._rows(rng, switched)
        with open(path, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow("t_s b0_cmd0_kpa b0_p0_kpa b0_u0 b0_cmd1_kpa b0_p1_kpa b0_u1".split())
            writer.writerows(rows)

    def _rows(self, rng, switched):
        plant = PneumaticValveWithWear(
            pSupply=SUPPLY_PA, Ab=NOZZLE_M2, At=NOZZLE_M2, Av=0.0, offsetX=self.spring_offset_m, process_noise=0, measurement_noise=0
        )
        state = plant.StateContainer(self._start(plant.parameters))
        steps = round(1 / ROWS_HZ / STEP_S)
        for row, (bottom, top) in enumerate(switched.tolist()):
            read = plant.output(state)
            noise = rng.normal(0, NOISE_KPA, 2)
            pressures = [1e3 * _number(read[name]) - ATMOSPHERE_PA / 1e3 for name in ("pB", "pT")]
            cells = zip((bottom, top), pressures, noise)
            yield [row / ROWS_HZ] + [cell for on, p, e in cells for cell in (500 * on, round(p + e, 3), 2 * on - 1)]
            load = plant.InputContainer({"pL": ATMOSPHERE_PA, "pR": ATMOSPHERE_PA, "uBot": bottom, "uTop": top})
            for _ in range(steps):
                state = plant.next_state(state, load, STEP_S)
                state = plant.StateContainer({name: _number(state[name]) for name in plant.states})

    def _start(self, p):
        """Both chambers next to the air's pressure, the piston at the bottom."""

        def mass_kg(volume_m3):
            return 1.001 * ATMOSPHERE_PA * volume_m3 * p["gas_mass"] / (p["R"] * p["gas_temp"])

        return {
            "x": 0.0,
            "v": 0.0,
            "mBot": mass_kg(p["Vbot0"]),
            "mTop": mass_kg(p["Vtop0"] + p["Ap"] * p["Ls"]),
            "Aeb": self.bottom_leak * NOZZLE_M2,
            "Aet": self.top_leak * NOZZLE_M2,
            "Ai": self.internal_leak * NOZZLE_M2,
            "k": self.spring_n_m,
            "r": self.friction_n_s_m,
            "pDiff": 0.0,
            **dict.fromkeys(("wb", "wi", "wk", "wr", "wt"), 0.0),
        }


def _number(value):
    return float(numpy.ravel(value)[0])


def _rhythm(rng, seconds):
    """0 or 1 for each row: filled or vented for a while, or switched with a period of 0.1 to 0.4 s for 0.8 to 4 s."""
    rows = round(seconds * ROWS_HZ)
    switched = []
    while len(switched) < rows:
        hold = int(rng.uniform(0.8, 4) * ROWS_HZ)
        duty = rng.uniform(0.05, 0.95)
        if rng.random() < 0.3:
            switched += [int(rng.random() < 0.5)] * hold
            continue
        stretch = []
        while len(stretch) < hold:
            period = rng.uniform(0.1, 0.4) * ROWS_HZ
            stretch += [1] * round(period * duty) + [0] * max(1, round(period * (1 - duty)))
        switched += stretch[:hold]
    return numpy.array(switched[:rows])
