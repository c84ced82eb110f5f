"""Whatever is passed in, the answer is one of our exceptions: no panic, no Rust backtrace, nothing sent."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from pneudrive_py import CommandError, PressureController

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
