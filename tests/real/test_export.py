"""Files of `fieldrig export`, read by others: `cantools decode`, asammdf with a recording of the lab, canmatrix."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import can
import canmatrix.formats
import pytest
from asammdf import MDF
from virtual_lab import LAB, play

from fieldrig.bus import Bus, Delivery
from fieldrig.config.rig_file import load
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import write
from fieldrig.virtual.rig import Rig
from fieldrig_devices.export.can_networks import networks
from fieldrig_devices.export.dbc import text_of

pytestmark = [pytest.mark.real, pytest.mark.timeout(400)]

DAY_NS = 1_700_000_000_000_000_000
"""An instant of 2023: tools take small numbers for a relative time."""


class Recorded(NamedTuple):
    log: Path
    dbc: Path


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """Fifteen seconds of the lab with three masters at work, and its network."""
    folder = tmp_path_factory.mktemp("export")
    entries: list[TraceEntry] = []

    def hear(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if bus.family == "can":
            instant, data = DAY_NS + delivery.time_ns, bus.encode(delivery.message)
            entries.append(TraceEntry(instant, bus.name, bus.family, delivery.sender, data))

    with Rig(load(LAB, ["time=virtual"]), hear) as rig:
        play(rig)
    write(entries, folder / "lab.log")
    [network] = networks(load(LAB))
    (folder / "lab.dbc").write_bytes(text_of(network))
    return Recorded(folder / "lab.log", folder / "lab.dbc")


def test_cantools_decodes_every_frame_by_name(lab: Recorded) -> None:
    command = [sys.executable, "-m", "cantools", "decode", "--single-line", str(lab.dbc)]
    with lab.log.open(encoding="utf-8") as log:
        done = subprocess.run(command, stdin=log, capture_output=True, text=True, check=True)
    lines, names = done.stdout.splitlines(), re.findall(r":: (\w+)\(", done.stdout)
    assert len(names) == len(lines) == len(lab.log.read_text(encoding="utf-8").splitlines())
    assert {*names} == {
        *("NMT", "SYNC", "io_heartbeat", "sensor_heartbeat", "io_TPDO1", "io_TPDO2", "io_RPDO2", "sensor_TPDO1"),
        *("io_SDO_request", "io_SDO_answer", "sensor_SDO_request", "sensor_SDO_answer"),
    }
    assert "sensor_TPDO1(tank_level: 0.5 m, AI_status_1: 0)" in done.stdout
    assert "io_TPDO1(tank_high: 0, tank_low: 0," in done.stdout


def test_asammdf_makes_curves_of_a_recording(lab: Recorded) -> None:
    """The level rises from 0.5 m; io and sensor measure it with different resolutions."""
    recording = lab.log.with_suffix(".mf4")
    with can.LogReader(str(lab.log)) as reader, can.Logger(str(recording)) as writer:
        for message in reader:
            writer(message)
    with MDF(str(recording)) as measured:
        found = measured.extract_bus_logging({"CAN": [(str(lab.dbc), 0)]})
        level = found.get("sensor_TPDO1.tank_level")
        outlet = found.get("tank_outlet")
        found.close()
    assert (level.unit, level.samples[0], max(level.samples) > 0.52) == ("m", 0.5, True)
    assert (outlet.unit, list(outlet.samples)) == ("%", [75.0])


def test_canmatrix_has_the_same_messages(lab: Recorded) -> None:
    frames = {frame.name: frame for frame in canmatrix.formats.loadp_flat(str(lab.dbc)).frames}
    outputs = frames["io_RPDO2"].signal_by_name("tank_outlet")
    assert (frames["io_RPDO2"].arbitration_id.id, float(outputs.factor), outputs.unit) == (0x305, 0.01, "%")
    assert frames["io_SDO_request"].is_multiplexed
    assert frames["io_heartbeat"].signal_by_name("state").values[5] == "operational"
