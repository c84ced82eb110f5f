"""Whatever is passed in, the answer is one of our exceptions: no panic, no Rust backtrace, nothing sent."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import pneudrive_py as pneu
from pneudrive_py import CommandError, PneuDriveError, PressureController

ANYTHING = st.one_of(
    st.none(),
    st.text(),
    st.binary(),
    st.integers(),
    st.lists(st.one_of(st.floats(), st.text(max_size=3), st.none()), max_size=6),
    st.dictionaries(st.integers(), st.floats(), max_size=3),
    arrays.arrays(
        dtype=st.one_of(arrays.floating_dtypes(), arrays.integer_dtypes(), arrays.complex_number_dtypes()),
        shape=arrays.array_shapes(max_dims=3, max_side=5),
    ),
)


@pytest.mark.parametrize("function", [pneu.fit, pneu.compare, lambda file: pneu.simulate(file, None)])
def test_a_files_name_is_no_recording_and_the_answer_says_what_is(function):
    with pytest.raises(TypeError, match=r'expected a Recording, such as pneudrive_py.load\("run.csv"\), got str'):
        function("run.csv.zst")


def test_a_rate_that_nobody_polls_at_is_answered_with_what_to_do():
    with PressureController("sim", 1, timing="instant") as controller:
        with pytest.raises(CommandError, match="at most 100000 Hz; without it boards are polled as fast as the wire"):
            controller.poll(rate_hz=1e6)


@pytest.fixture(scope="module")
def controller():
    with PressureController("sim", 1, timing="instant", timeout=2.0) as controller:
        controller.ping_devices()
        yield controller


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(device=st.integers(), pressures=ANYTHING)
def test_commands(controller, device, pressures):
    try:
        controller.set_pressure_commands(device, pressures)
    except (CommandError, OverflowError) as error:
        assert "panicked" not in str(error)
    else:
        assert device == 0
        assert controller.get_pressure_data(0).shape == (4,)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rate=st.floats(), history=st.floats())
def test_polling(controller, rate, history):
    if 0 < rate <= 100_000 and 0 <= history <= 3600:
        return
    with pytest.raises(CommandError):
        controller.poll(rate, history_s=history)


FIRST_ARGUMENT = [
    lambda value: pneu.load(value),
    lambda value: pneu.Rig.load(value),
    lambda value: pneu.Rig.parse(value),
    lambda value: pneu.Rig(supply=value),
    lambda value: pneu.Rig(**{str(value): {}}),
    lambda value: pneu.Parameters.load(value),
    lambda value: pneu.Recording.from_columns(value),
    lambda value: pneu.Recording.from_columns({"t_s": [0.0, 1.0], "b0_p0_kpa": value}),
    lambda value: pneu.Recording.from_history(value),
    lambda value: pneu.Recording.from_history({"t_s": value, "commands_kpa": value, "pressures_kpa": value}),
    lambda value: pneu.fit(value),
    lambda value: pneu.simulate(value, value),
    lambda value: pneu.compare(value),
    lambda value: pneu.diagnose(value),
    lambda value: pneu.model_parameters(value),
]


@settings(max_examples=40, deadline=None)
@pytest.mark.parametrize("call", FIRST_ARGUMENT)
@given(value=ANYTHING)
def test_the_toolkit(call, value):
    try:
        call(value)
    except (PneuDriveError, TypeError, ValueError, OSError) as error:
        assert "panicked" not in str(error) and "internal error" not in str(error)


FEW = st.one_of(
    ANYTHING,
    st.floats(-2.0, 2.0),
    arrays.arrays(np.float64, arrays.array_shapes(max_dims=2, max_side=4), elements=st.floats(-2.0, 2.0)),
)


@settings(max_examples=300, deadline=None)
@given(
    parameters=st.one_of(FEW, st.just(np.ones(7)), st.just(np.ones((2, 7)))),
    interval=st.one_of(st.floats(), st.just(0.01)),
    inputs=st.dictionaries(
        st.sampled_from(["drive", "fill", "vent", "command_kpa", "supply_kpa", "volume_m3", "start_kpa"]), FEW
    ),
    controller=st.booleans(),
    sensitivities=st.booleans(),
)
def test_a_batch(rig, parameters, interval, inputs, controller, sensitivities):
    try:
        pneu.simulate_batch(
            "nonlinear",
            parameters,
            interval,
            rig=rig,
            controller=controller,
            sensitivities=sensitivities,
            **inputs,
        )
    except (PneuDriveError, TypeError) as error:
        assert "panicked" not in str(error) and "internal error" not in str(error)
