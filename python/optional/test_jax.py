"""The chamber in JAX is that of the toolkit: values, derivatives, both precisions. Run by ``python/optional/run``."""

import time

import jax
import jax.numpy as jnp
import numpy as np
import pneudrive_py as pneu
import pytest
from pneudrive_py import jax as chambers

jax.config.update("jax_enable_x64", True)

RIG = pneu.Rig(
    supply={"pressure_kpa": 550.0},
    chamber={"radius_m": 0.024, "length_m": 0.2, "offset_m": 0.045},
    valve={"critical_ratio": 0.35, "discharge_coefficient": 0.9},
    ambient={"pressure_kpa_abs": 95.0, "temperature_k": 285.0},
)
CONSTANTS = chambers.constants(RIG)
THETA = np.array([0.004, 0.003, 1.5, 0.05, -0.04, 0.03, 1.0])
SEPARATE = np.array([0.004, 0.003, 1.5, 1.2, 0.05, 0.04, 0.03, 1.0])
ROWS = 400


def course(seed=1, low=-0.6, high=0.6):
    rng = np.random.default_rng(seed)
    drive = np.repeat(rng.uniform(low, high, ROWS // 20), 20)
    time_s = 0.01 * np.arange(ROWS)
    return drive, 550 + 15 * np.sin(3 * time_s), 3.6e-4 * (1 + 0.2 * np.sin(5 * time_s))


@pytest.mark.parametrize("substeps", [1, 3])
def test_a_rollout_is_that_of_simulate_batch(substeps):
    drive, supply, volume = course()
    expected = pneu.simulate_batch(
        "nonlinear", THETA, 0.01, drive=drive, supply_kpa=supply, volume_m3=volume, start_kpa=30.0, rig=RIG, substeps=substeps
    )[0]
    found = chambers.rollout(
        30.0, drive, 0.01, THETA, CONSTANTS, supply_kpa=supply, volume_m3=volume, substeps=substeps
    )
    assert np.abs(found - expected).max() < 1e-8
    assert np.ptp(expected) > 100


def test_two_valves_are_those_of_simulate_batch():
    fill, vent = course(2, 0, 0.5)[0], course(3, 0, 0.5)[0]
    expected = pneu.simulate_batch("nonlinear", SEPARATE, 0.01, fill=fill, vent=vent, rig=RIG)[0]
    found = chambers.rollout(0.0, np.stack([fill, vent], axis=1), 0.01, SEPARATE, CONSTANTS)
    assert np.abs(found - expected).max() < 1e-8


def test_derivatives_are_the_toolkits_sensitivities():
    drive, supply, volume = course(4)
    _, expected = pneu.simulate_batch(
        "nonlinear", THETA, 0.01, drive=drive, supply_kpa=supply, volume_m3=volume, rig=RIG, sensitivities=True
    )

    def pressures(theta):
        return chambers.rollout(0.0, drive, 0.01, theta, CONSTANTS, supply_kpa=supply, volume_m3=volume)

    scale = np.abs(expected[0]).max(axis=0)
    for jacobian in (jax.jacfwd, jax.jacrev):
        found = jax.jit(jacobian(pressures))(jnp.asarray(THETA))
        assert np.isfinite(found).all()
        assert (np.abs(found - expected[0]) / scale).max() < 1e-8


def test_a_gradient_is_finite_where_nothing_flows():
    rest = jax.grad(chambers.dp, argnums=(0, 4))(0.0, 0.0, 3.6e-4, 0.0, jnp.asarray(THETA), CONSTANTS)
    at_supply = jax.grad(chambers.dp)(CONSTANTS.supply_kpa, 0.5, 3.6e-4, 0.0, jnp.asarray(THETA), CONSTANTS)
    assert all(np.isfinite(part).all() for part in (*rest, at_supply))
    assert at_supply < 0


def test_many_chambers_at_once_are_those_one_by_one():
    drives = np.stack([course(seed)[0] for seed in range(5)])
    many = jax.vmap(lambda drive: chambers.rollout(0.0, drive, 0.01, THETA, CONSTANTS))(drives)
    one = [chambers.rollout(0.0, drive, 0.01, THETA, CONSTANTS) for drive in drives]
    assert np.abs(many - np.stack(one)).max() < 1e-9


def test_single_precision_stays_within_a_fiftieth_of_a_kpa():
    drive, _, _ = course(6)
    double = chambers.rollout(0.0, drive, 0.01, THETA, CONSTANTS)
    single = chambers.rollout(
        jnp.float32(0.0), jnp.asarray(drive, jnp.float32), 0.01, jnp.asarray(THETA, jnp.float32), CONSTANTS
    )
    assert single.dtype == jnp.float32
    assert np.abs(single - double).max() < 0.02


def test_wrong_numbers_of_parameters_are_refused():
    with pytest.raises(ValueError, match="7 .one spool. or 8 .two valves."):
        chambers.dp(0.0, 0.0, 1e-4, 0.0, THETA[:5], CONSTANTS)
    with pytest.raises(pneu.DataError, match=r"\[supply\]"):
        chambers.constants(pneu.Rig(chamber={"volume_m3": 1e-4}))


def test_diffrax_finds_the_gain_that_made_the_data():
    from fit_with_diffrax import TRUTH, main

    assert abs(main() - TRUTH[2]) < 0.002


def test_throughput_is_printed_beside_simulate_batch(capsys):
    """1000 chambers of 400 rows: no pass or fail on time."""
    drives = np.stack([course(seed)[0] for seed in range(1000)])
    batch = jax.jit(jax.vmap(lambda drive: chambers.rollout(0.0, drive, 0.01, THETA, CONSTANTS)))
    single = jax.jit(
        jax.vmap(lambda d: chambers.rollout(jnp.float32(0), d, 0.01, jnp.asarray(THETA, jnp.float32), CONSTANTS))
    )
    ways = {
        "JAX, double": lambda: batch(drives).block_until_ready(),
        "JAX, single": lambda: single(drives.astype(np.float32)).block_until_ready(),
        "simulate_batch": lambda: pneu.simulate_batch("nonlinear", THETA, 0.01, drive=drives, rig=RIG),
    }
    for name, way in ways.items():
        assert way().shape == drives.shape
        spent = min(_seconds(way) for _ in range(3))
        with capsys.disabled():
            print(f"\n{name}: {1e9 * spent / drives.size:.1f} ns a chamber and row")


def _seconds(way):
    began = time.perf_counter()
    way()
    return time.perf_counter() - began
