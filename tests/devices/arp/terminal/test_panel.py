"""Keys and LEDs of both models: points, bits on the bus, flags of the card.  The table is the manual's, 4.5."""

import pytest
from arp_terminal import CellBench, TerminalBench

from fieldrig.errors import ControlError
from fieldrig_devices.arp.terminal.panel import Model

pytestmark = pytest.mark.manual("ARP-064")

LEDS: dict[Model, dict[int, str]] = {
    "TR4": {219: "F12", 220: "F11", 221: "F10", 222: "F9", 223: "F8", 224: "F7"},
    "TR5": {218: "F1", 219: "F2", 220: "F3", 221: "F4", 222: "FA", 223: "FB", 224: "AUTO"},
}
BOTH = {224 + digit: str(digit) for digit in range(1, 10)} | {
    234: "0", 235: "POINT", 236: "MINUS", 237: "CR", 238: "ESC", 240: "DEL", 243: "DOWN", 244: "UP",
    245: "F1", 246: "F2", 247: "F3", 248: "F4",
}  # fmt: skip
KEYS: dict[Model, dict[int, str]] = {
    "TR4": BOTH
    | {239: "END", 241: "LEFT", 242: "RIGHT", 249: "F5", 250: "F6", 251: "F7"}
    | {252: "F8", 253: "F9", 254: "F10", 255: "F11", 256: "F12"},
    "TR5": BOTH | {239: "SHIFT", 249: "FA", 250: "FB", 251: "AUTO"},
}
MODELS: list[Model] = ["TR4", "TR5"]


@pytest.mark.long
@pytest.mark.parametrize("model", MODELS)
def test_model_has_its_keys_and_leds_and_no_others(model: Model) -> None:
    points = TerminalBench(model=model).terminal.points()
    assert {key.removeprefix("key.") for key in points if key.startswith("key.")} == set(KEYS[model].values())
    assert {key.removeprefix("led.") for key in points if key.startswith("led.")} == set(LEDS[model].values())


@pytest.mark.parametrize("model", MODELS)
def test_every_key_has_its_bit_in_tpdo_1(model: Model) -> None:
    bench = TerminalBench(model=model)
    for flag, name in KEYS[model].items():
        bits = (1 << flag - 225).to_bytes(4, "little")
        bench.set(f"key.{name}", True)
        assert bench.after(0) == [f"194#{bits.hex(' ')}"]
        assert bench.get(f"key.{name}") is True
        bench.set(f"key.{name}", False)
        assert bench.after(0) == ["194#00 00 00 00"]


@pytest.mark.manual("ARP-119")
def test_keys_held_together() -> None:
    bench = TerminalBench()
    bench.set("key.1", True)
    assert bench.after(0) == ["194#01 00 00 00"]
    bench.set("key.F12", True)
    assert bench.after(0) == ["194#01 00 00 80"]


@pytest.mark.parametrize("model", MODELS)
def test_every_led_follows_its_bit_of_rpdo_1(model: Model) -> None:
    bench = TerminalBench(model=model)
    for flag, name in LEDS[model].items():
        assert bench.send(f"214#{1 << flag - 218:02x}") == []
        assert {led for led in LEDS[model].values() if bench.get(f"led.{led}")} == {name}


@pytest.mark.parametrize("model", MODELS)
def test_every_key_is_a_flag_of_the_card(model: Model) -> None:
    with CellBench(model=model) as cell:
        cell.after(100)
        for flag, name in KEYS[model].items():
            cell.rig.set("tr", f"key.{name}", True)
            cell.after(40)
            assert [number for number in range(218, 257) if cell.card.F[number]] == [flag]
            cell.rig.set("tr", f"key.{name}", False)
            cell.after(40)
        assert not any(cell.card.F[218:257])


@pytest.mark.parametrize("model", MODELS)
def test_every_led_flag_lights_its_led(model: Model) -> None:
    with CellBench(model=model) as cell:
        cell.after(100)
        for flag in range(218, 225):
            cell.card.F[218:225] = [int(number == flag) for number in range(218, 225)]
            cell.after(40)
            lit = [name for name in LEDS[model].values() if cell.rig.get("tr", f"led.{name}")]
            assert lit == [name for number, name in LEDS[model].items() if number == flag]


def test_program_cannot_press_keys() -> None:
    with CellBench() as cell:
        cell.after(100)
        cell.program("SET F230\n@FLAG8 == H1", ms=40)
        assert cell.card.F[225:257] == [0] * 32


def test_key_that_is_only_touched_is_seen_by_one_pass() -> None:
    with CellBench() as cell:
        cell.after(100)
        cell.rig.set("tr", "key.5", True)
        cell.after(2)
        cell.rig.set("tr", "key.5", False)
        seen = [cell.after(10).card.F[229] for _ in range(8)]
        assert sum(seen) == 2  # read twice in the pass that saw it
        assert seen[-1] == 0


def test_press_holds_keys_for_100_ms_one_after_the_other() -> None:
    bench = TerminalBench()
    bench.set("press", "1 cr")
    assert bench.after(99) == ["194#01 00 00 00"]
    assert bench.after(1) == ["194#00 00 00 00"]
    assert bench.after(49) == []
    assert bench.after(1) == ["194#00 10 00 00"]
    assert bench.after(100) == ["194#00 00 00 00"]
    assert bench.get("press") == "CR"


@pytest.mark.long
@pytest.mark.parametrize(("model", "name"), [("TR5", "F5"), ("TR4", "AUTO"), ("TR4", "ENTER")])
def test_press_of_a_key_that_is_not_there_says_which_are(model: Model, name: str) -> None:
    bench = TerminalBench(model=model)
    with pytest.raises(ControlError, match=f"{name!r} is not a key of this terminal; expected one of 0, 1, .* UP"):
        bench.set("press", f"1 {name}")
    assert bench.after(200) == []


@pytest.mark.long
def test_key_takes_true_or_false() -> None:
    bench = TerminalBench()
    with pytest.raises(ControlError, match="true or false"):
        bench.set("key.1", 7)
