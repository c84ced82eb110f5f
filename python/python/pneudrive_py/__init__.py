"""Pressure control and modelling for large pneumatic soft robots.

The bus, with four chambers a board::

    import numpy as np
    from pneudrive_py import PressureController

    with PressureController("/dev/ttyUSB0", 3) as controller:   # or "sim": three virtual boards
        controller.ping_devices()
        controller.set_pressure_commands(0, np.array([100.0, 120.0, 0.0, 0.0]))
        print(controller.get_pressure_data(0))                  # kPa gauge, shape (4,)

The modelling toolkit::

    import pneudrive_py as pneu

    recording = pneu.load("run.csv", rig="rig.toml")
    fit = pneu.fit(recording, "rig.toml", model="nonlinear", fit_fraction=0.8)
    predicted = pneu.simulate(recording, fit.parameters)
    print(pneu.compare(recording, "rig.toml"))                  # three models on one recording
    diagnosis = pneu.diagnose(recording, "rig.toml")            # what the model lacks
    better = pneu.simulate(recording, diagnosis.extended_model)

    pressures, sensitivities = pneu.simulate_batch(             # thousands of chambers at once
        "nonlinear", fit.parameters.array("b0c0"), 0.01, drive=drives, rig="rig.toml", sensitivities=True
    )

Pressures are in kPa gauge, times in s. Everything that goes wrong is an exception of :mod:`pneudrive_py.exceptions`.
"""

from . import _pneudrive, exceptions, live, plots, sim, tables
from ._pneudrive import *  # noqa: F403
from .exceptions import (
    BoardError,
    CommandError,
    DataError,
    FileError,
    FitError,
    GarbledAnswerError,
    NoAnswerError,
    PneuDriveError,
    PortError,
    StaleDataError,
    VentWarning,
)

__version__ = _pneudrive.__version__
__all__ = [
    *_pneudrive.__all__,
    "BoardError",
    "CommandError",
    "DataError",
    "FileError",
    "FitError",
    "GarbledAnswerError",
    "NoAnswerError",
    "PneuDriveError",
    "PortError",
    "StaleDataError",
    "VentWarning",
    "exceptions",
    "live",
    "plots",
    "sim",
    "tables",
]
