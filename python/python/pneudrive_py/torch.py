"""Simulated chambers as a function of PyTorch: gradients by parameters, drives, set points, supply, volume and start.

Needs ``torch`` (``pip install 'pneudrive_py[torch]'``), which nothing else of this package imports::

    import torch
    from pneudrive_py import torch as chambers

    gain = torch.tensor(2.0, dtype=torch.float64, requires_grad=True)
    theta = torch.stack([leak_in, leak_out, gain, ...])
    pressures = chambers.simulate_batch("nonlinear", theta, 0.01, drive=drive, rig="rig.toml")
    ((pressures - measured) ** 2).mean().backward()

Forwards it is :func:`pneudrive_py.simulate_batch`, backwards :func:`pneudrive_py.batch_gradient`: exact for the discretised model, on all cores,
and without a graph of every Runge-Kutta step.
"""

import torch as _torch

from . import batch_gradient as _batch_gradient
from . import simulate_batch as _simulate_batch

__all__ = ["simulate_batch"]

#: What a gradient flows to, in the order of the function's inputs.
_DIFFERENTIABLE = ("parameters", "drive", "fill", "vent", "command_kpa", "supply_kpa", "volume_m3", "start_kpa")


class _SimulateBatch(_torch.autograd.Function):
    @staticmethod
    def forward(ctx, model, interval_s, fixed, *given):
        ctx.save_for_backward(*(tensor for tensor in given if tensor is not None))
        ctx.there = [tensor is not None for tensor in given]
        ctx.call = (model, interval_s, fixed)
        arrays = _arrays(given)
        pressures = _simulate_batch(model, arrays.pop("parameters", None), interval_s, **arrays, **fixed)
        result = _torch.from_numpy(pressures)
        return result.to(next(tensor for tensor in given if tensor is not None).device)

    @staticmethod
    @_torch.autograd.function.once_differentiable
    def backward(ctx, weights):
        saved = iter(ctx.saved_tensors)
        given = [next(saved) if there else None for there in ctx.there]
        model, interval_s, fixed = ctx.call
        arrays = _arrays(given)
        parameters = arrays.pop("parameters", None)
        weights = weights.detach().cpu().to(_torch.float64).numpy()
        fixed = {name: value for name, value in fixed.items() if name != "dtype"}
        slopes = _batch_gradient(model, parameters, interval_s, weights, **arrays, **fixed)
        found = []
        for name, tensor, needed in zip(_DIFFERENTIABLE, given, ctx.needs_input_grad[3:], strict=True):
            there = tensor is not None and needed
            found.append(_torch.as_tensor(slopes[name]).to(tensor) if there else None)
        return (None, None, None, *found)


def _arrays(tensors):
    """The tensors that are there by name, as arrays."""
    named = zip(_DIFFERENTIABLE, tensors, strict=True)
    return {name: tensor.detach().cpu().numpy() for name, tensor in named if tensor is not None}


def simulate_batch(
    model,
    parameters,
    interval_s,
    *,
    drive=None,
    fill=None,
    vent=None,
    command_kpa=None,
    supply_kpa=None,
    volume_m3=None,
    start_kpa=None,
    rig=None,
    controller=None,
    substeps=None,
    dtype=None,
    channel=None,
):
    """Simulates many chambers at once, differentiably.

    Parameters
    ----------
    model : {"nonlinear", "parametric", "linear"}, Parameters or ExtendedModel
    parameters : torch.Tensor, shape (parameters,) or (chambers, parameters), or None
        In the order and units of ``pneudrive_py.model_parameters``; ``None`` for those of a calibrated model.
    interval_s : float
        Time between two rows, s.
    drive, fill, vent, command_kpa, supply_kpa, volume_m3, start_kpa : torch.Tensor or array_like, optional
        Shapes, units and ranges as of :func:`pneudrive_py.simulate_batch`.
    rig, controller, substeps, channel
        As of :func:`pneudrive_py.simulate_batch`.
    dtype : {torch.float64, torch.float32}, default torch.float64
        Of the pressures. The gradient is computed in float64, and is of the type of what it is by.

    Returns
    -------
    torch.Tensor of ``dtype``, shape (chambers, rows)
        kPa gauge, on the device of ``parameters``; computed on the CPU.

    Raises
    ------
    DataError
        As :func:`pneudrive_py.simulate_batch`; backwards, of a model with a smooth correction.

    Notes
    -----
    Gradients can be taken once, not of each other.
    """
    given = {
        "parameters": parameters,
        "drive": drive,
        "fill": fill,
        "vent": vent,
        "command_kpa": command_kpa,
        "supply_kpa": supply_kpa,
        "volume_m3": volume_m3,
        "start_kpa": start_kpa,
    }
    tensors = [None if given[name] is None else _torch.as_tensor(given[name]) for name in _DIFFERENTIABLE]
    fixed = {
        "rig": rig,
        "controller": controller,
        "substeps": substeps,
        "dtype": _numpy_name(dtype),
        "channel": channel,
    }
    return _SimulateBatch.apply(model, interval_s, fixed, *tensors)


def _numpy_name(dtype):
    """A type of PyTorch's as NumPy calls it; what is none is refused there."""
    return str(dtype).removeprefix("torch.") if isinstance(dtype, _torch.dtype) else dtype
