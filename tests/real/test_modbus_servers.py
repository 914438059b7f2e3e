"""Servers that are not ours, pymodbus and libmodbus, asked by the Modbus client of a MAx-4 in a running rig."""

import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import pytest
from foreign_modbus import ForeignServer
from running_rig import RunningRig, until

from fieldrig.testing import free_port

pytestmark = pytest.mark.real

LOST, BACK = "\tMB_UNIT\tpump\t6570\tModbus 7\t", "\tMB_UNIT\tpump\t8571\tModbus 7\t"

RIG = """
time: real
buses:
  field: BUS
devices:
  max4:
    kind: max4
    links: {modbus: [field]}
    drives: {belt: {ring_address: 1, simulated: true}}
    modbus_client:
      pause_ms: 200
      units:
        pump:
          unit: 7
          reads:
            - {what: input_registers, address: 16, values: [{name: level}, {name: flow, type: f32}]}
            - {address: 32, values: [{name: speed_there}, {name: place_there, type: s32}]}
            - {what: coils, address: 9, values: [{name: run_there, type: bool}, {name: fill_there, type: bool}]}
            - {what: discrete_inputs, address: 2, values: [{name: low, type: bool}, {name: high, type: bool}]}
          writes:
            - {address: 32, values: [{name: speed}, {name: place, type: s32}]}
            - {what: coils, address: 9, values: [{name: run, type: bool}, {name: fill, type: bool}]}
"""


class Way(NamedTuple):
    library: str
    framer: str
    bus: str
    place: str


SOCAT = "{kind: modbus.rtu, port: OURS, parity: N, servers: [7]}"
WAYS = {
    "pymodbus tcp": Way(
        "pymodbus", "tcp", '{kind: modbus.tcp, listen: "127.0.0.1:OWN", servers: {7: 127.0.0.1:PORT}}', "PORT"
    ),
    "libmodbus tcp": Way(
        "libmodbus", "tcp", '{kind: modbus.tcp, listen: "127.0.0.1:OWN", servers: {7: localhost:PORT}}', "PORT"
    ),
    "pymodbus rtu by pty": Way("pymodbus", "rtu", "{kind: modbus.rtu, pty: field, servers: [7]}", "PTY"),
    "libmodbus rtu by pty": Way("libmodbus", "rtu", "{kind: modbus.rtu, pty: field, servers: [7]}", "PTY"),
    "pymodbus ascii by pty": Way("pymodbus", "ascii", "{kind: modbus.ascii, pty: field, servers: [7]}", "PTY"),
    "pymodbus rtu by socat": Way("pymodbus", "rtu", SOCAT, "THEIRS"),
    "libmodbus rtu by socat": Way("libmodbus", "rtu", SOCAT, "THEIRS"),
    "pymodbus rtu dialled": Way("pymodbus", "rtu", "{kind: modbus.rtu, dial: 127.0.0.1:PORT, servers: [7]}", "PORT"),
}


class Field(NamedTuple):
    rig: RunningRig
    server: ForeignServer

    def value(self, name: str) -> object:
        return self.rig.value(f"max4/pump.{name}")

    def until(self, name: str, value: object) -> None:
        until(lambda: self.value(name) == value)

    def until_logged(self, entry: str, times: int = 1) -> None:
        until(lambda: self.rig.value("max4/log").count(entry) >= times)

    def set(self, **values: object) -> None:
        self.rig.ask("device/max4/set", {"values": {f"pump.{name}": value for name, value in values.items()}})


@pytest.fixture(params=WAYS)
def field(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Field]:
    way, port = WAYS[request.param], str(free_port())
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    with ExitStack() as ending:
        if way.place == "THEIRS":
            ending.enter_context(Cable(ours, theirs))
        bus = way.bus.replace("PORT", port).replace("OWN", str(free_port())).replace("OURS", str(ours))
        rig = ending.enter_context(RunningRig(RIG.replace("BUS", bus), None))
        places = {"PORT": port, "PTY": str(rig.run / "field"), "THEIRS": str(theirs)}
        server = ending.enter_context(ForeignServer(way.library, way.framer, places[way.place]))
        rig.until_ready()
        yield Field(rig, server)
        assert rig.end(signal.SIGINT) == 0, rig.output()


class Cable:
    """Two ptys, each what is written to the other."""

    def __init__(self, first: Path, second: Path) -> None:
        self._ends = first, second

    def __enter__(self) -> None:
        socat = shutil.which("socat")
        assert socat, "socat is not installed (Debian: socat)"
        self._process = subprocess.Popen([socat, *(f"pty,rawer,link={end}" for end in self._ends)])
        until(lambda: all(end.exists() for end in self._ends))

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait()


@pytest.mark.manual("PD-209", "PD-306")
def test_a_foreign_server_is_read_written_lost_and_found_again(field: Field) -> None:
    field.until_logged(LOST)  # it is not there yet
    field.server.start()
    field.until_logged(BACK)
    assert field.value("IsRunning") is True
    field.until("level", 1234)
    field.until("high", True)
    assert (field.value("low"), field.value("flow")) == (False, 2.5)
    field.set(speed=500, place=-70_000, run=True, fill=True)
    field.until("speed_there", 500)
    field.until("place_there", -70_000)
    field.until("fill_there", True)
    field.until("run_there", True)

    field.server.kill()
    field.until_logged(LOST, 2)
    assert field.value("IsRunning") is False
    field.until("level", 0)
    field.server.start()
    field.until_logged(BACK, 2)
    field.until("level", 1234)
    field.until("speed_there", 500)  # it was written again
    field.until("run_there", True)
