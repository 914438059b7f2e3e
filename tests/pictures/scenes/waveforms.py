"""Wires of the lab while its pump fills the tank."""

from collections.abc import Callable, Mapping
from typing import Final

from tests.pictures.recording import block_named, recorded

from fieldrig.clock import MS, S
from fieldrig.rig import Rig
from fieldrig.trace import TraceEntry
from fieldrig.yaml_source import read
from fieldrig_bus.traces.timing_diagram import Window, timing_diagram
from fieldrig_bus.traces.waves import waves_of
from fieldrig_bus.wires import encode

SHOWN: Final = ("pump.run", "pump.speed", "tank.inflow", "tank.level")
END_NS: Final = 60 * S
PULSES_END_NS: Final = 70 * MS


def tank() -> str:
    """The wires as `fieldrig draw` draws them."""

    def play(rig: Rig) -> None:
        rig.run_until(2 * S)
        rig.set("drive", "speed_set", 100)
        rig.set("drive", "run", True)
        rig.run_until(40 * S)
        rig.set("drive", "run", False)
        rig.run_until(END_NS)

    sent = [message for message in recorded("lab-virtual.yaml", play) if message.bus == "wires"]
    found = waves_of(TraceEntry(one.time_ns, one.bus, "wires", one.sender, encode(one.message)) for one in sent)
    waves = {wave.name: wave for wave in found.waves}
    about = "The pump runs from 2 s to 40 s; water flows into the tank, and its level rises."
    return timing_diagram([waves[name] for name in SHOWN], Window(0, END_NS), "Wires of the lab", about)


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

    sent = [message for message in recorded(source, play) if message.bus == "wires"]
    found = waves_of(TraceEntry(one.time_ns, one.bus, "wires", one.sender, encode(one.message)) for one in sent)
    waves = {wave.name: wave for wave in found.waves}
    about = "Pulses that speed up, an output that a counter switches at the 20th, and PWM that changes from 75 to 25 %."
    shown = [waves[name] for name in ("source.pulse", "counter.reached", "pwm.pwm")]
    return timing_diagram(shown, Window(0, PULSES_END_NS), "Pulses and PWM", about)


PICTURES: Final[Mapping[str, Callable[[], str]]] = {"wires-tank": tank, "wires-pulses": pulses}
