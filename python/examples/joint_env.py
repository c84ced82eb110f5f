"""A pneumatic joint as a Gymnasium environment.

Four chambers around a backbone bend it by two angles; the agent opens and closes their valves and has to reach a target. Chambers
and valves are simulated by ``pneudrive_py.simulate_batch``, with parameters that can come from a fit of a real rig; the joint itself
is a spring, a damper and an inertia.

    import gymnasium
    import joint_env  # registers the environment

    env = gymnasium.make("PneuDrive/Joint-v0")

``Joints`` simulates any number of joints in lockstep, for training with thousands of them at once.
"""

import math

import gymnasium
import numpy as np

import pneudrive_py as pneu

#: Parameters of the nonlinear model: see ``pneudrive_py.model_parameters("nonlinear")``.
NOMINAL_PARAMETERS = np.array([0.02, 0.02, 2.0, 0.05, -0.05, 0.1, 1.0])

RIG = pneu.Rig(
    supply={"pressure_kpa": 550.0},
    chamber={"radius_m": 0.024, "length_m": 0.2, "offset_m": 0.045},
)


class Joints:
    """``number`` joints with four chambers each: angles, rates and pressures, advanced together.

    Chambers 0 and 1 lie opposite each other and bend the joint by ``qu``, chambers 2 and 3 by ``qv``: their lengths are
    ``h + r q`` and ``h - r q``.
    """

    INTERVAL_S = 0.005
    STIFFNESS_NM_RAD = 15.0
    DAMPING_NM_S_RAD = 0.5
    INERTIA_KG_M2 = 0.02
    LIMIT_RAD = 1.2

    def __init__(self, number, rig=RIG, parameters=NOMINAL_PARAMETERS):
        chamber = rig.to_dict()["chamber"]
        self.rig = rig
        self.parameters = np.broadcast_to(parameters, (4 * number, 7))
        self.offset_m, self.length_m = chamber["offset_m"], chamber["length_m"]
        self.area_m2 = math.pi * chamber["radius_m"] ** 2
        self.angles_rad = np.zeros((number, 2))
        self.rates_rad_s = np.zeros((number, 2))
        self.pressures_kpa = np.zeros((number, 4))

    def volumes_m3(self, angles_rad):
        """Shape (joints, 4)."""
        stretch = np.repeat(angles_rad, 2, axis=1) * [1.0, -1.0, 1.0, -1.0]
        return self.area_m2 * (self.length_m + self.offset_m * stretch)

    def step(self, drive, seconds):
        """Holds the drives, shape (joints, 4), -1 (vent) to 1 (fill), for a time."""
        for _ in range(round(seconds / self.INTERVAL_S)):
            before = self.volumes_m3(self.angles_rad)
            self._bend()
            after = self.volumes_m3(self.angles_rad)
            rows = pneu.simulate_batch(
                "nonlinear",
                self.parameters,
                self.INTERVAL_S,
                drive=drive.reshape(-1, 1),
                volume_m3=np.stack([before.ravel(), after.ravel()], axis=1),
                start_kpa=self.pressures_kpa.ravel(),
                rig=self.rig,
            )
            self.pressures_kpa = rows[:, -1].reshape(-1, 4)

    def _bend(self):
        """Moves the joints for one interval: damping and spring implicitly, which no step makes unstable."""
        h, kpa = self.INTERVAL_S, 1e3
        difference = self.pressures_kpa[:, 0::2] - self.pressures_kpa[:, 1::2]
        torque = kpa * self.area_m2 * self.offset_m * difference - self.STIFFNESS_NM_RAD * self.angles_rad
        inertia = self.INERTIA_KG_M2 + h * self.DAMPING_NM_S_RAD + h * h * self.STIFFNESS_NM_RAD
        self.rates_rad_s = (self.INERTIA_KG_M2 * self.rates_rad_s + h * torque) / inertia
        moved = self.angles_rad + h * self.rates_rad_s
        self.angles_rad = np.clip(moved, -self.LIMIT_RAD, self.LIMIT_RAD)
        # A joint against its stop stands still.
        self.rates_rad_s = np.where(moved == self.angles_rad, self.rates_rad_s, 0.0)


class JointEnv(gymnasium.Env):
    """Bend a joint to a target.

    * Action, shape (4,): valve drives, -1 (vent) to 1 (fill), held for 20 ms.
    * Observation, shape (10,): two angles (rad), their rates (10 rad/s), four pressures (100 kPa), two target angles (rad).
    * Reward: minus the squared distance to the target (rad^2), and a little for air.
    * Ends (truncated) after ``seconds``.

    ``spread`` varies every valve parameter from one episode to the next by up to this share, so that what is learned does not
    depend on one valve.
    """

    metadata = {"render_modes": []}
    PERIOD_S = 0.02
    TARGET_RAD = 0.6
    AIR_COST = 1e-3

    def __init__(self, seconds=5.0, spread=0.1, rig=RIG, parameters=NOMINAL_PARAMETERS):
        self.rig, self.nominal = rig, np.asarray(parameters, dtype=float)
        self.spread, self.steps = spread, round(seconds / self.PERIOD_S)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (4,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-20.0, 20.0, (10,), np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        factors = self.np_random.uniform(1.0 - self.spread, 1.0 + self.spread, (4, 7))
        self.joint = Joints(1, self.rig, self.nominal * factors)
        self.joint.pressures_kpa = np.full((1, 4), 100.0)
        self.target = self.np_random.uniform(-self.TARGET_RAD, self.TARGET_RAD, 2)
        self.left = self.steps
        return self._observation(), {}

    def step(self, action):
        drive = np.clip(np.asarray(action, dtype=float), -1.0, 1.0)
        self.joint.step(drive[None, :], self.PERIOD_S)
        self.left -= 1
        error = self.joint.angles_rad[0] - self.target
        reward = -float(error @ error) - self.AIR_COST * float(drive @ drive)
        return self._observation(), reward, False, self.left <= 0, {"error_rad": error}

    def _observation(self):
        joint = self.joint
        parts = [joint.angles_rad[0], joint.rates_rad_s[0] / 10.0, joint.pressures_kpa[0] / 100.0, self.target]
        return np.concatenate(parts).astype(np.float32)


gymnasium.register("PneuDrive/Joint-v0", entry_point=JointEnv)
