"""Fits the gain of a valve with diffrax: an adaptive solver over `pneudrive_py.jax.dp`, and gradients through it.

    python fit_with_diffrax.py

Prints the gain from step to step; it ends at the 1.5 mm^2 of the valve that made the data.
"""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from pneudrive_py import jax as chambers

INTERVAL_S, ROWS = 0.01, 200
CONSTANTS = chambers.Constants()
TRUTH = np.array([0.004, 0.003, 1.5, 0.05, -0.04, 0.03, 1.0])


def pressures(theta, drives):
    """Pressures at the rows, from a drive that is held from row to row."""
    times = INTERVAL_S * jnp.arange(ROWS)

    def rate(t, p, _):
        row = jnp.clip(jnp.floor(t / INTERVAL_S + 1e-6).astype(int), 0, ROWS - 1)
        return chambers.dp(p, drives[row], CONSTANTS.volume_m3, 0.0, theta, CONSTANTS)

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(rate),
        diffrax.Tsit5(),
        t0=times[0],
        t1=times[-1],
        dt0=INTERVAL_S / 4,
        y0=jnp.asarray(20.0),
        saveat=diffrax.SaveAt(ts=times),
        stepsize_controller=diffrax.ClipStepSizeController(
            diffrax.PIDController(rtol=1e-6, atol=1e-6), jump_ts=times
        ),
        max_steps=20_000,
        adjoint=diffrax.ForwardMode(),
    )
    return solution.ys


def fit(measured, drives, start_mm2, steps=6):
    """The gain, by Gauss-Newton steps with exact derivatives."""

    def of(log_gain):
        return pressures(jnp.asarray(TRUTH).at[2].set(jnp.exp(log_gain)), drives)

    both = jax.jit(lambda log_gain: (of(log_gain), jax.jvp(of, (log_gain,), (1.0,))[1]))
    log_gain = jnp.log(start_mm2)
    for _ in range(steps):
        found, slope = both(log_gain)
        log_gain = log_gain + jnp.clip((slope @ (measured - found)) / (slope @ slope), -0.5, 0.5)
        print(f"gain {float(jnp.exp(log_gain)):.4f} mm^2")
    return float(jnp.exp(log_gain))


def main():
    jax.config.update("jax_enable_x64", True)
    rng = np.random.default_rng(1)
    drives = jnp.asarray(np.repeat(rng.uniform(-0.4, 0.6, ROWS // 20), 20))
    measured = chambers.rollout(20.0, drives, INTERVAL_S, TRUTH, CONSTANTS, substeps=8)
    return fit(measured + rng.normal(0, 0.1, ROWS), drives, 0.8)


if __name__ == "__main__":
    main()
