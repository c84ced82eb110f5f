"""Chambers in PyTorch are those of the toolkit, and their gradients those of differences. Run by ``python/optional/run``."""

import numpy as np
import pneudrive_py as pneu
import pytest

torch = pytest.importorskip("torch")
from pneudrive_py import torch as chambers  # noqa: E402

RIG = pneu.Rig(
    supply={"pressure_kpa": 550.0}, chamber={"radius_m": 0.024, "length_m": 0.2, "offset_m": 0.045}
)
THETA = np.array([0.02, 0.02, 2.0, 0.05, 0.03, 0.1, 1.0])
CHAMBERS, ROWS = 3, 12


def given(seed=1):
    random = np.random.default_rng(seed)
    arrays = {
        "parameters": THETA * random.uniform(0.9, 1.1, (CHAMBERS, 7)),
        "drive": random.uniform(-0.5, 0.5, (CHAMBERS, ROWS)),
        "supply_kpa": random.uniform(500.0, 560.0, ROWS),
        "start_kpa": random.uniform(80.0, 160.0, CHAMBERS),
    }
    return {name: torch.tensor(values, requires_grad=True) for name, values in arrays.items()}


def simulate(parameters, **more):
    return chambers.simulate_batch("nonlinear", parameters, 0.01, rig=RIG, **more)


def test_pressures_are_those_of_simulate_batch():
    tensors = given()
    found = simulate(**tensors)
    arrays = {name: tensor.detach().numpy() for name, tensor in tensors.items()}
    expected = pneu.simulate_batch("nonlinear", arrays.pop("parameters"), 0.01, rig=RIG, **arrays)
    assert found.dtype == torch.float64
    np.testing.assert_array_equal(found.detach().numpy(), expected)


def test_gradcheck_finds_nothing():
    tensors = given()
    names = list(tensors)
    function = lambda *values: simulate(**dict(zip(names, values, strict=True)))  # noqa: E731
    # Differences of 1e-6 in kPa lose digits against pressures of 100 kPa.
    assert torch.autograd.gradcheck(function, tuple(tensors.values()), eps=1e-6, atol=1e-5, rtol=1e-4)


def test_gradcheck_by_volume():
    """In litres: a step of 1e-6 is small beside them, and not beside cubic metres."""
    litres = torch.tensor(0.36 + 0.05 * np.sin(np.arange(ROWS)), requires_grad=True)
    drive = given()["drive"].detach()
    function = lambda litres: simulate(torch.tensor(THETA), drive=drive, volume_m3=1e-3 * litres)  # noqa: E731
    assert torch.autograd.gradcheck(function, (litres,), eps=1e-6, atol=1e-4, rtol=1e-4)


def test_gradcheck_by_set_points_of_the_linear_model():
    command = torch.tensor(np.linspace(20.0, 80.0, ROWS), requires_grad=True)
    rates = torch.tensor([5.0, 4.0], dtype=torch.float64, requires_grad=True)
    function = lambda rates, command: chambers.simulate_batch("linear", rates, 0.01, command_kpa=command)  # noqa: E731
    assert torch.autograd.gradcheck(function, (rates, command), eps=1e-6, atol=1e-5, rtol=1e-4)


def test_an_optimiser_finds_the_gain_that_made_the_data():
    drive = np.repeat(np.random.default_rng(2).uniform(-0.5, 0.5, 20), 10)
    measured = simulate(torch.tensor(THETA), drive=drive)
    gain = torch.tensor(1.5, dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.Adam([gain], lr=0.05)
    for _ in range(150):
        optimiser.zero_grad()
        theta = torch.cat([torch.tensor(THETA[:2]), gain[None], torch.tensor(THETA[3:])])
        ((simulate(theta, drive=drive) - measured) ** 2).mean().backward()
        optimiser.step()
    assert abs(gain.item() - THETA[2]) < 0.01


def test_single_precision_comes_and_goes():
    tensors = {name: tensor.detach().float().requires_grad_() for name, tensor in given().items()}
    pressures = simulate(**tensors, dtype=torch.float32)
    assert pressures.dtype == torch.float32
    pressures.sum().backward()
    assert all(tensor.grad.dtype == torch.float32 and tensor.grad.abs().max() > 0 for tensor in tensors.values())
    with pytest.raises(pneu.DataError, match="dtype is"):
        simulate(**tensors, dtype=torch.float16)


def test_what_needs_no_gradient_has_none():
    tensors = given()
    tensors["drive"].requires_grad_(False)
    simulate(**tensors).sum().backward()
    assert tensors["drive"].grad is None and tensors["parameters"].grad is not None
