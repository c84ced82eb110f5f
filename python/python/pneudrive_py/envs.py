"""Gymnasium environments of calibrated joints. Importing this module registers them::

    import gymnasium
    import pneudrive_py.envs

    gymnasium.register_envs(pneudrive_py.envs)  # or nothing: it only says that the import is meant
    env = gymnasium.make("pneudrive/ContinuumJoint-v0", parameters="fit.toml")
    many = gymnasium.make_vec(
        "pneudrive/ContinuumJoint-v0", num_envs=1000, vectorization_mode="vector_entry_point", parameters="fit.toml"
    )

Without an import, ``gymnasium.make("pneudrive_py.envs:pneudrive/ContinuumJoint-v0")`` does it. Needs ``gymnasium`` 1.0 or later
(``pip install 'pneudrive_py[gymnasium]'``).
"""

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from .joints import Joints, Randomisation

__all__ = ["ContinuumJointEnv", "ContinuumJointVectorEnv"]

PERIOD_S = 0.02
TARGET_RAD = 0.6
START_KPA = 100.0
AIR_COST = 1e-3


def _spaces():
    action = gymnasium.spaces.Box(-1.0, 1.0, (4,), np.float32)
    observation = gymnasium.spaces.Box(-20.0, 20.0, (10,), np.float32)
    return action, observation


def _observations(joints, targets):
    scaled = [joints.angles_rad, joints.rates_rad_s / 10.0, joints.pressures_kpa / 100.0, targets]
    return np.concatenate(scaled, axis=1).astype(np.float32)


def _advance(joints, targets, actions):
    """One period under the actions: errors (rad) and rewards."""
    drives = np.clip(np.asarray(actions, dtype=float), -1.0, 1.0)
    joints.step(drives, PERIOD_S)
    errors = joints.angles_rad - targets
    return errors, -(errors**2).sum(axis=1) - AIR_COST * (drives**2).sum(axis=1)


class ContinuumJointEnv(gymnasium.Env):
    """Bend a joint to a target.

    * Action, shape (4,): valve drives, -1 (vent) to 1 (fill), held for 20 ms.
    * Observation, shape (10,): two angles (rad), their rates (10 rad/s), four pressures (100 kPa), two target angles (rad).
    * Reward: minus the squared distance to the target (rad^2), and a little for air.
    * Ends (truncated) after ``seconds``.

    Parameters
    ----------
    seconds : float
        Length of an episode.
    parameters : Parameters or path, optional
        A fit, from whose covariance the valves of each episode are drawn: :class:`pneudrive_py.joints.Randomisation`.
    spread : float
        Share by which every valve parameter is varied besides.
    """

    metadata = {"render_modes": []}

    def __init__(self, seconds=5.0, parameters=None, spread=0.1):
        self.randomisation = Randomisation(parameters, spread)
        self.steps = round(seconds / PERIOD_S)
        self.action_space, self.observation_space = _spaces()

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.joints = Joints(1, self.randomisation.rig, self.randomisation.draw(self.np_random, 4))
        self.joints.pressures_kpa[:] = START_KPA
        self.targets = self.np_random.uniform(-TARGET_RAD, TARGET_RAD, (1, 2))
        self.left = self.steps
        return _observations(self.joints, self.targets)[0], {}

    def step(self, action):
        errors, rewards = _advance(self.joints, self.targets, np.asarray(action)[None, :])
        self.left -= 1
        observation = _observations(self.joints, self.targets)[0]
        return observation, float(rewards[0]), False, self.left <= 0, {"error_rad": errors[0]}


class ContinuumJointVectorEnv(VectorEnv):
    """The same for many joints in lockstep, which all end together; the step after that resets them.

    ``num_envs`` joints; the other parameters as of :class:`ContinuumJointEnv`.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(self, num_envs=1, seconds=5.0, parameters=None, spread=0.1):
        self.num_envs = num_envs
        self.randomisation = Randomisation(parameters, spread)
        self.steps = round(seconds / PERIOD_S)
        self.single_action_space, self.single_observation_space = _spaces()
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        drawn = self.randomisation.draw(self.np_random, 4 * self.num_envs)
        self.joints = Joints(self.num_envs, self.randomisation.rig, drawn)
        self.joints.pressures_kpa[:] = START_KPA
        self.targets = self.np_random.uniform(-TARGET_RAD, TARGET_RAD, (self.num_envs, 2))
        self.left = self.steps
        return _observations(self.joints, self.targets), {}

    def step(self, actions):
        ended = np.zeros(self.num_envs, dtype=bool)
        if self.left <= 0:
            observations, info = self.reset()
            return observations, np.zeros(self.num_envs), ended, ended.copy(), info
        errors, rewards = _advance(self.joints, self.targets, actions)
        self.left -= 1
        truncated = np.full(self.num_envs, self.left <= 0)
        return _observations(self.joints, self.targets), rewards, ended, truncated, {"error_rad": errors}


gymnasium.register(
    "pneudrive/ContinuumJoint-v0", entry_point=ContinuumJointEnv, vector_entry_point=ContinuumJointVectorEnv
)
