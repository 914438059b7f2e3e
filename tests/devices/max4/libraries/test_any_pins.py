"""Whatever a program writes to the pins, the libraries answer with a result, and the axis has a set position."""

from typing import Any

from cam_bench import PINS, CamBench
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.max4.libraries.results import Result

anything = (
    st.floats(allow_nan=True, allow_infinity=True) | st.floats(-1000, 1000) | st.sampled_from([0.0, 1.0, 1e-9, 1e12])
)
numbers = st.integers(-(2**31), 2**31 - 1) | st.integers(0, 3)
FREE = [name for name in PINS if name not in ("lAxisId", "lEncId", "lProfilId")]
STRATEGIES: dict[str, st.SearchStrategy[Any]] = {"b": st.booleans(), "i": numbers, "l": numbers}
pins = st.fixed_dictionaries(
    {}, optional={name: anything if name.startswith("lr") else STRATEGIES[name[0]] for name in FREE}
)  # fmt: skip
calls = st.tuples(st.sampled_from(["CAM", "SLAVECAM", "TORQUECAM"]), st.integers(1, 3), pins, anything)


@given(st.lists(calls, max_size=8))
def test_any_cam_has_a_result_and_a_set_position(given_calls: list[tuple[str, int, dict[str, Any], float]]) -> None:
    bench = CamBench()
    profiles = [bench.call("ProfilLoad", name) for name in ("modisin", "straight", "poly5")]
    for kind, number, given_pins, master in given_calls:
        result, is_active, is_done = bench.cam(profiles[number - 1], kind=kind, instance=number, **given_pins)
        assert result in set(Result)
        assert not (is_active and is_done)
        bench.master.position = master
        bench.run(2)
        value = bench.axes["belt"].set_value
        assert value == int(value)


@given(anything, anything, anything, numbers)
def test_any_number_is_an_answer_for_every_function(x: float, y: float, z: float, number: int) -> None:
    bench = CamBench()
    address = bench.axes["belt"].log_adr
    bench.call("ProfilLoad", "modisin")
    assert isinstance(bench.call("ScalFollPos", x, y, z), float)
    assert isinstance(bench.call("ProfilSetLambda", number, x), bool)
    assert isinstance(bench.call("ProfilSetSlopes", number, x, y), bool)
    assert isinstance(bench.call("CSplinePoint", number, x, y), bool)
    assert isinstance(bench.call("CSplineProfil", number), int)
    for axis in (address, number):
        for function in ("PosAbsolute", "PosRelative"):
            assert bench.call(function, axis, x, y, z, z) in set(Result)
            bench.run(2)
        assert bench.call("PosVelocity", axis, x, y, z) in set(Result)
        bench.run(2)
        assert bench.call("PosStop", axis, x) in set(Result)
        assert isinstance(bench.call("PosDone", axis), bool)
    bench.cam(1)
    bench.run(2)
