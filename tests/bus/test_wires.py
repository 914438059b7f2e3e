import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.signals.codec import LONGEST_NAME, decode, encode, show
from fieldrig_bus.wires import MOST_OF_A_MEMBER, MOST_WIRES, Alarm, Motion, Signal, WiresModel


def test_a_signal_reaches_the_listeners_of_its_name() -> None:
    model = WiresModel()
    for member in ("pump", "tank", "panel"):
        model.join(member)
    model.listen(0, "tank", ["pump.run"])
    model.listen(0, "panel", None)
    model.submit(5, "pump", Signal("pump.run", True))
    model.submit(5, "pump", Signal("pump.speed", 50, "%"))
    first, second = model.collect(5)
    assert (first.time_ns, first.sender, list(first.receivers)) == (5, "pump", ["tank", "panel"])
    assert list(second.receivers) == ["panel"]
    assert model.next_ns() is None


def test_a_late_listener_gets_the_present_value() -> None:
    model = WiresModel()
    model.join("tank")
    model.submit(1, "tank", Signal("tank.level", 1.0, "m"))
    model.submit(2, "tank", Signal("tank.level", 2.0, "m"))
    model.collect(2)
    model.join("panel")
    model.listen(9, "panel", ["tank.level"])
    assert model.next_ns() == 9
    (delivery,) = model.collect(9)
    assert (delivery.message.value, list(delivery.receivers)) == (2.0, ["panel"])


def test_a_driver_does_not_hear_itself() -> None:
    model = WiresModel()
    model.join("tank")
    model.listen(0, "tank", None)
    model.submit(1, "tank", Signal("tank.level", 1.0, "m"))
    (delivery,) = model.collect(1)
    assert list(delivery.receivers) == []


def test_a_signal_crosses_processes_as_json() -> None:
    assert encode(Signal("tank.level", 1.5, "m")) == b'["tank.level",1.5,"m"]'
    assert decode(b'["pump.run",true,""]') == Signal("pump.run", True)


SIGNALS = st.builds(
    Signal,
    name=st.text(max_size=256),
    value=st.booleans() | st.integers(-(1 << 63), (1 << 64) - 1) | st.floats(allow_nan=False, allow_infinity=False),
    unit=st.text(max_size=8),
)


@given(SIGNALS)
def test_every_signal_comes_back(signal: Signal) -> None:
    back = decode(encode(signal))
    assert back == signal
    assert type(back.value) is type(signal.value)


@pytest.mark.parametrize(
    "data",
    [
        b"", b"null", b"[]", b'["a",NaN,""]', b'["a",1e999,""]', b'[1,2,"m"]', b"\xff",
        b'["a",1%s,""]' % (b"0" * 400), b'["a",1,"",1%s,0,0]' % (b"0" * 400), b"[" * 100_000,
    ],
)  # fmt: skip
def test_anything_else_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match=r"."):
        decode(data)


@given(st.binary())
def test_garbage_is_refused_with_a_value_error(data: bytes) -> None:
    try:
        signal = decode(data)
    except ValueError:
        return
    assert math.isfinite(signal.value)


def test_a_motion_goes_on_by_itself() -> None:
    motion = Motion("axis1.encoder", 100, "count", 2_000_000_000, 1_000.0, -500.0)
    assert motion.at(2_000_000_000) == 100
    assert motion.at(3_000_000_000) == 850  # 100 + 1000 * 1 - 500 / 2
    assert motion.speed_at(3_000_000_000) == 500
    assert show(motion) == "axis1.encoder = 100 count, 1000 count/s"


def test_a_motion_crosses_processes_as_json() -> None:
    motion = Motion("axis1.encoder", 7, "count", 12, 1.5, 0.0)
    assert encode(motion) == b'["axis1.encoder",7,"count",12,1.5,0.0]'
    assert decode(encode(motion)) == motion


@pytest.mark.parametrize("course", ["12,1.5", '12,1.5,"a"', "1.5,1.5,0", "12,1e999,0", "12,0,null", "12,0,0,0"])
def test_what_is_no_motion_is_refused(course: str) -> None:
    with pytest.raises(ValueError, match=r"not a signal|beyond all that a float can hold"):
        decode(f'["axis1.encoder",7,"count",{course}]'.encode())


def flood(model: WiresModel, member: str, names: int) -> None:
    for number in range(names):
        model.submit(0, member, Signal(f"{member}.{number}", number))
    model.collect(0)


def kept(model: WiresModel) -> int:
    return int(model.statistics(0)["wires"])


def test_a_member_drives_a_bounded_number_of_wires_and_the_others_go_on() -> None:
    model = WiresModel()
    for member in ("flood", "tank"):
        model.join(member)
    flood(model, "flood", 2 * MOST_OF_A_MEMBER)
    assert kept(model) == MOST_OF_A_MEMBER
    model.submit(1, "tank", Signal("tank.level", 1.0))
    model.submit(1, "flood", Signal("flood.0", 7))  # a wire that it drives already
    assert [delivery.message.value for delivery in model.collect(1)] == [1.0, 7]


@pytest.mark.long
def test_wires_of_members_that_are_gone_make_room_the_oldest_first() -> None:
    model = WiresModel()
    model.join("tank")
    model.submit(0, "tank", Signal("tank.level", 1.0))
    members = 2 * MOST_WIRES // MOST_OF_A_MEMBER
    for number in range(members):
        model.join(f"flood{number}")
        flood(model, f"flood{number}", MOST_OF_A_MEMBER)
        model.leave(f"flood{number}")
    assert kept(model) == MOST_WIRES
    model.join("panel")
    model.listen(9, "panel", ["tank.level", "flood0.0", f"flood{members - 1}.0"])
    assert [delivery.message.name for delivery in model.collect(9)] == ["tank.level", f"flood{members - 1}.0"]


@pytest.mark.long
def test_without_room_a_new_wire_is_dropped_while_all_drivers_are_there() -> None:
    model = WiresModel()
    for number in range(MOST_WIRES // MOST_OF_A_MEMBER + 1):
        model.join(f"flood{number}")
        flood(model, f"flood{number}", MOST_OF_A_MEMBER)
    assert kept(model) == MOST_WIRES


@pytest.mark.long
def test_a_driver_that_comes_back_has_its_wires_again() -> None:
    model = WiresModel()
    for _ in range(3):
        model.join("tank")
        flood(model, "tank", MOST_OF_A_MEMBER)
        model.leave("tank")
    model.join("valve")
    model.submit(1, "valve", Signal("tank.0", 5))
    model.join("tank")
    model.submit(2, "tank", Signal("tank.0", 6))
    assert [(delivery.sender, delivery.message.value) for delivery in model.collect(2)] == [("valve", 5), ("tank", 6)]
    assert kept(model) == MOST_OF_A_MEMBER


def test_a_name_that_is_too_long_is_no_wire() -> None:
    model = WiresModel()
    model.join("flood")
    model.submit(0, "flood", Signal((LONGEST_NAME + 1) * "x", True))
    assert (kept(model), model.next_ns()) == (0, None)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_value_is_shown_with_all_its_digits(value: float) -> None:
    assert float(show(Signal("level", value, "m")).split()[2]) == value


def test_an_alarm_is_reported_while_its_wire_has_the_value() -> None:
    model = WiresModel(
        {"cell.enable": Alarm(when=False, text="emergency stop"), "tank.level": Alarm(when=2.0, text="full")}
    )
    assert model.conditions(0) == {}  # nothing drives the wires
    model.join("panel")
    model.submit(1, "panel", Signal("cell.enable", True))
    assert model.conditions(1) == {}
    model.submit(2, "panel", Signal("cell.enable", False))
    model.submit(2, "panel", Signal("tank.level", 2.0, "m"))
    assert model.conditions(2) == {"cell.enable": "emergency stop", "tank.level": "full"}
    model.submit(3, "panel", Signal("cell.enable", True))
    assert model.conditions(3) == {"tank.level": "full"}


def test_an_alarm_of_a_moving_wire_is_that_of_its_present_value() -> None:
    model = WiresModel({"door.angle": Alarm(when=3.0, text="open")})
    model.submit(0, "door", Motion("door.angle", 2.0, "rad", 0, 1.0))
    assert [model.conditions(at_ns) for at_ns in (0, 1_000_000_000)] == [{}, {"door.angle": "open"}]
