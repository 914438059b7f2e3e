"""Wires of rigs: the lab while its pump fills the tank, pulses, and a DC motor."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from tests.pictures.recording import block_named, recorded

from fieldrig.clock import MS, S
from fieldrig.config.yaml_source import read
from fieldrig.traces.trace import TraceEntry
from fieldrig.virtual.rig import Rig
from fieldrig_bus.signals.codec import encode
from fieldrig_bus.traces.timing_diagram import Window, timing_diagram
from fieldrig_bus.traces.waves import waves_of

SHOWN: Final = ("pump.run", "pump.speed", "tank.inflow", "tank.level")
END_NS: Final = 60 * S
PULSES_END_NS: Final = 70 * MS
SMART_IO_END_NS: Final = 1_200 * MS


def tank() -> str:
    """The wires as `fieldrig draw` draws them."""

    def play(rig: Rig) -> None:
        rig.run_until(2 * S)
        rig.set("drive", "speed_set", 100)
        rig.set("drive", "run", True)
        rig.run_until(40 * S)
        rig.set("drive", "run", False)
        rig.run_until(END_NS)

    about = "The pump runs from 2 s to 40 s; water flows into the tank, and its level rises."
    return drawn("lab.yaml", play, SHOWN, Window(0, END_NS), "Wires of the lab", about)


def pulses() -> str:
    """The rig of the page on pulses: a train from a standstill, a compare output, and PWM."""
    source = read(block_named("pulses.md", "pulses.yaml").text, "pulses.yaml").data

    def play(rig: Rig) -> None:
        for key, value in {"frequency": 100, "rate": 20_000, "count": 40, "run": True}.items():
            rig.set("source", key, value)
        rig.set("counter", "value", 480)
        rig.set("pwm", "duty", 75)
        rig.set("pwm", "run", True)
        rig.run_until(35 * MS)
        rig.set("pwm", "duty", 25)
        rig.run_until(PULSES_END_NS)

    about = "Pulses that speed up, an output that a counter switches at the 20th, and PWM that changes from 75 to 25 %."
    shown = ("source.pulse", "counter.reached", "pwm.pwm")
    return drawn(source, play, shown, Window(0, PULSES_END_NS), "Pulses and PWM", about)


def smart_io() -> str:
    """A DC motor of a Smart-IO node: it moves from 0 to 12, and back to its zero switch."""

    def play(rig: Rig) -> None:
        rig.set("io", "motor1.value", 12)
        rig.set("io", "motor1.order", 1)
        rig.run_until(600 * MS)
        for key, value in {"value": -1, "second": 1, "order": 6}.items():
            rig.set("io", f"motor1.{key}", value)
        rig.run_until(SMART_IO_END_NS)

    about = "The output INC is off two pulses before the target.  Then DEC is on until the zero switch is closed."
    shown = ("rail.increase", "rail.decrease", "rail.pulse", "rail.zero")
    return drawn("smart-io.yaml", play, shown, Window(0, SMART_IO_END_NS), "A DC motor of a Smart-IO", about)


def drawn(
    source: Any, play: Callable[[Rig], None], shown: Sequence[str], window: Window, title: str, about: str
) -> str:
    """Wires of a rig while something is played on it."""
    sent = [message for message in recorded(source, play) if message.bus == "wires"]
    found = waves_of(TraceEntry(one.time_ns, one.bus, "wires", one.sender, encode(one.message)) for one in sent)
    waves = {wave.name: wave for wave in found.waves}
    return timing_diagram([waves[name] for name in shown], window, title, about)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {
    "wires-tank": tank,
    "wires-pulses": pulses,
    "wires-smart-io": smart_io,
}
