"""The documentation of kinds, settings, commands, exit codes and the lab agrees with the code.

A table whose first column is called `key` lists settings; the heading above it names the kinds that have them.  Where a
section describes several, the column `applies to` names those of a row, and `default` holds the default.
"""

import json
import re
from collections.abc import Iterator, Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, NamedTuple, get_args
from xml.etree import ElementTree

import pytest
import typer
from doc_pages import (
    INDEX,
    PAGES,
    ROOT,
    Row,
    anchor,
    code_in,
    headings,
    links,
    links_in,
    page_named,
    place_of,
    prose,
    rows,
)

from fieldrig.cli.app import app
from fieldrig.config import kinds
from fieldrig.config.keys import SECTIONS, BusKeys, DeviceKeys, PageKeys, RigKeys
from fieldrig.config.rig_file import RigConfig, load
from fieldrig.device import Device
from fieldrig.faults import faults
from fieldrig.settings import Settings
from fieldrig.system.exits import ABOUT, Exit
from fieldrig_bus.can.faults import CanFault
from fieldrig_bus.can.member import Controller
from fieldrig_bus.dualport import faults as dualport_faults
from fieldrig_bus.ip import faults as ip_faults
from fieldrig_bus.modbus import faults as modbus_faults
from fieldrig_bus.modbus.identification import Identification, ServerId
from fieldrig_bus.opcua import faults as opcua_faults
from fieldrig_bus.ring.pam.faults import RingFault as PamRingFault
from fieldrig_bus.ring.sercos.faults import RingFault
from fieldrig_bus.serial import faults as serial_faults
from fieldrig_bus.signals import faults as wire_faults
from fieldrig_bus.tcp import faults as tcp_faults
from fieldrig_bus.telephone.exchange import IncomingSettings, OutgoingSettings
from fieldrig_bus.telephone.faults import TelephoneFault
from fieldrig_devices.arp.can.exchange import ExchangeSettings, Received, Sent
from fieldrig_devices.arp.card import faults as card_faults
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.slices import Costs
from fieldrig_devices.arp.terminal import faults as terminal_faults
from fieldrig_devices.canopen import node_faults
from fieldrig_devices.canopen.master_settings import CanMasterSettings, CanNodeSettings
from fieldrig_devices.canopen.node import CanopenSettings
from fieldrig_devices.canopen.point_slave import PointSlaveSettings
from fieldrig_devices.canopen.signals import SignalSettings
from fieldrig_devices.cia402.single import faults as single_drive_faults
from fieldrig_devices.cia402.single import settings as single_drive
from fieldrig_devices.cia402.single.personality import PersonalitySettings
from fieldrig_devices.drives.load import LoadSettings
from fieldrig_devices.hiperface.faults import EncoderFault
from fieldrig_devices.hiperface.plate import NamePlate
from fieldrig_devices.hmiscu.faces.modbus import ModbusFaceSettings as ScuModbus
from fieldrig_devices.hmiscu.pto.settings import PtoSettings
from fieldrig_devices.hmiscu.pwm.settings import PwmSettings
from fieldrig_devices.max4.can.settings import AxisTerminals, CanFaceSettings
from fieldrig_devices.max4.configuration.files import DriveSettings
from fieldrig_devices.max4.faults import Max4Fault
from fieldrig_devices.max4.modbus.settings import AxisLimits, ModbusFaceSettings
from fieldrig_devices.max4.settings import BootTimes, Com1Settings, FtpSettings, ProcessTimes
from fieldrig_devices.mc4.faults import DriveFault
from fieldrig_devices.mc4.settings import (
    AmplifierSettings,
    MotorSettings,
    ParameterSettings,
    VersionSettings,
)
from fieldrig_devices.modbus import faults as modbus_device_faults
from fieldrig_devices.modbus.client_settings import (
    ClientUnitSettings,
    ModbusClientSettings,
    ReadSettings,
    WriteSettings,
)
from fieldrig_devices.modbus.device import ModbusDeviceSettings, UnitSettings
from fieldrig_devices.modem.faults import ModemFault
from fieldrig_devices.pam import faults as pam_faults
from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pam.ports.access.faces import AccessSettings
from fieldrig_devices.pam.ports.masters import device as vme_master
from fieldrig_devices.pam.ports.options import ClassCodes, PortOptions
from fieldrig_devices.pam.settings import ProgramReadings, RingReadings
from fieldrig_devices.plants import dc_motor, heater, pulse_servo, servo_settings, tank_faults, winder_settings
from fieldrig_devices.plants.cam_switches import CamSettings
from fieldrig_devices.plants.conveyor_settings import ConveyorFault, SensorSettings
from fieldrig_devices.plants.stepper_settings import StepperFault
from fieldrig_devices.plants.winder_settings import Dancer, LoadCell
from fieldrig_devices.registers.entries import Bit, BitField, Fifo, RecordFile, Register
from fieldrig_devices.registers.packed import Element
from fieldrig_devices.registers.table import Table, load_table
from fieldrig_devices.smart_io.faults import SmartIoFault
from fieldrig_devices.smart_io.settings import ModuleSettings as SmartIoModule
from fieldrig_devices.smart_io.settings import MotorSettings as SmartIoMotor
from fieldrig_devices.smart_io.settings import NodeReadings
from fieldrig_devices.sources.settings import SourceSettings
from fieldrig_devices.sources.signals import WireSettings
from fieldrig_devices.st1.faults import St1Fault
from fieldrig_devices.st1.readings import St1Readings
from fieldrig_devices.st1.settings import MotorSettings as St1Motor
from fieldrig_devices.st1.settings import ParameterSettings as St1Parameters
from fieldrig_devices.st1.settings import PlantSettings, RegisterSettings, SupplySettings

REQUIRED = "required"
Models = Mapping[str, type[Settings]]

OTHER_SECTIONS: Mapping[str, Models] = {
    "Keys of a rig": {"rig": RigKeys},
    "Keys of the page": {"page": PageKeys},
    "Keys of every bus": {"bus": BusKeys},
    "Keys of every device": {"device": DeviceKeys},
    "Keys of a controller": {"controller": Controller},
    "Keys of a fault": faults.models_of(CanFault),
    "Keys of a node fault": node_faults.MODELS,
    "Keys of a Modbus device fault": modbus_device_faults.MODELS,
    "Keys of an OPC UA fault": opcua_faults.MODELS,
    "Keys of a TCP service fault": tcp_faults.MODELS,
    "Keys of a relay fault": ip_faults.MODELS,
    "Keys of a Modbus fault": modbus_faults.MODELS,
    "Keys of a serial fault": serial_faults.TCP_MODELS,
    "Keys of a fault of wires": wire_faults.MODELS,
    "Keys of a DualPort fault": dualport_faults.MODELS,
    "Keys of a ring fault": faults.models_of(RingFault),
    "Keys of a PAM ring fault": faults.models_of(PamRingFault),
    "Keys of a telephone fault": faults.models_of(TelephoneFault),
    "Keys of a modem fault": faults.models_of(ModemFault),
    "Keys of calls over TCP": {"incoming": IncomingSettings, "outgoing": OutgoingSettings},
    "Keys of an encoder fault": faults.models_of(EncoderFault),
    "Keys of a drive's behaviour": {"behaviour": PersonalitySettings},
    "Keys of a name plate": {"plate": NamePlate},
    "Keys of a controller fault": faults.models_of(Max4Fault),
    "Keys of drives, boot and load": {"drives": DriveSettings, "boot": BootTimes, "load": ProcessTimes},
    "Keys of COM1 and of FTP": {"com1": Com1Settings, "ftp": FtpSettings},
    "Keys of the Modbus server": {"modbus": ModbusFaceSettings, "limits": AxisLimits},
    "Keys of a value": {"value": Element},
    "Keys of the Modbus client": {
        "modbus_client": ModbusClientSettings,
        "unit": ClientUnitSettings,
        "read": ReadSettings,
        "write": WriteSettings,
    },
    "Keys of the CAN axes": {"can_axes": CanFaceSettings, "terminals": AxisTerminals},
    "Keys of the CANopen master": {"can_master": CanMasterSettings, "node": CanNodeSettings},
    "Keys of a servo drive fault": single_drive_faults.MODELS,
    "Keys of motor, load, loops and switches": {
        "motor": single_drive.MotorSettings,
        "loops": single_drive.LoopSettings,
        "switch": single_drive.CamSettings,
    },
    "Keys of a drive fault": faults.models_of(DriveFault),
    "Keys of motor, load, amplifier, parameters, versions": {
        "motor": MotorSettings,
        "load": LoadSettings,
        "amplifier": AmplifierSettings,
        "parameters": ParameterSettings,
        "versions": VersionSettings,
    },
    "Keys of an ST1 fault": faults.models_of(St1Fault),
    "Keys of parameters, motor, plant, supply and registers of an ST1": {
        "parameters": St1Parameters,
        "motor": St1Motor,
        "plant": PlantSettings,
        "supply": SupplySettings,
        "registers": RegisterSettings,
    },
    "Signals": {"signal": SignalSettings},
    "Keys of one unit, of its identification, of its server id": {
        "units": UnitSettings,
        "identification": Identification,
        "server_id": ServerId,
    },
    "Keys of a stepper fault": faults.models_of(StepperFault),
    "Keys of a pulse servo fault": pulse_servo.MODELS,
    "Keys of a heater fault": heater.MODELS,
    "Keys of a tank fault": tank_faults.MODELS,
    "Keys of a servo axis fault": servo_settings.MODELS,
    "Keys of a card fault": card_faults.MODELS,
    "Keys of a VME master fault": vme_master.MODELS,
    "Keys of a terminal fault": terminal_faults.OWN,
    "Keys of a winder fault": winder_settings.MODELS,
    "Keys of a DC motor fault": dc_motor.MODELS,
    "Keys of modules and motors": {"modules": SmartIoModule, "motors": SmartIoMotor},
    "Readings of a Smart-IO": {"readings": NodeReadings},
    "Readings of an ST1": {"readings": St1Readings},
    "Keys of a Smart-IO fault": faults.models_of(SmartIoFault),
    "Light barriers of a conveyor": {"sensor": SensorSettings},
    "Keys of a conveyor fault": faults.models_of(ConveyorFault),
    "Load cell and dancer": {"load_cell": LoadCell, "dancer": Dancer},
    "Cams": {"cam": CamSettings},
    "Keys of a PAM fault": pam_faults.MODELS,
    "Readings of a PAM": {
        "ring": RingReadings,
        "objects": ObjectReadings,
        "programs": ProgramReadings,
        "access": AccessSettings,
    },
    "Settings of the ports": {"ports": PortOptions, "class_codes": ClassCodes},
    "Exchange settings": {"exchange": ExchangeSettings, "send": Sent, "receive": Received},
    "Readings": {"readings": Readings},
    "Costs of the processor": {"costs": Costs},
    "Keys of channels": {"pto": PtoSettings, "pwm": PwmSettings},
    "Keys of the server and the slave of an HMISCU": {"modbus": ScuModbus, "can_slave": PointSlaveSettings},
    "Register tables": {
        "table": Table,
        "bit": Bit,
        "register": Register,
        "field": BitField,
        "fifo": Fifo,
        "file": RecordFile,
    },
    "Kinds of sources": {
        get_args(model.model_fields["kind"].annotation)[0]: model for model in get_args(get_args(SourceSettings)[0])
    },
    "Keys of a living wire": {"wire": WireSettings},
}
"""Settings that are not of a kind, by the heading of their section and their word in the column `of`."""


class Said(NamedTuple):
    """A key as a table has it."""

    place: str
    without: str


def names_in(group: str) -> list[str]:
    return [point.name for point in entry_points(group=group)]


def model_of(kind: str) -> type[Settings]:
    is_bus = kind in names_in("fieldrig.buses")
    return kinds.settings_model(kinds.find_bus(kind)) if is_bus else kinds.settings_model(kinds.find_device(kind))


def models_of(heading: str) -> Models:
    if heading in OTHER_SECTIONS:
        return OTHER_SECTIONS[heading]
    return {kind: model_of(kind) for kind in code_in(heading)}


def key_rows() -> Iterator[Row]:
    for page in PAGES:
        yield from (row for row in rows(page) if row.columns[0] == "key")


def said_by_tables(heading: str) -> dict[str, dict[str, Said]]:
    """The keys of a section by their owner."""
    said: dict[str, dict[str, Said]] = {name: {} for name in models_of(heading)}
    for row in key_rows():
        if row.heading != heading:
            continue
        cells = dict(zip(row.columns, row.cells, strict=True))
        for name in code_in(cells.get("applies to", "")) or said:
            for key in code_in(cells["key"]):
                assert key not in said[name], f"{row.page.name}: {heading}: {key} of {name} appears twice"
                said[name][key] = Said(f"{row.page.name}: {heading}: {key}", cells["default"])
    return said


SECTIONS_WITH_KEYS = sorted({row.heading for row in key_rows()})


@pytest.mark.long
@pytest.mark.parametrize("heading", SECTIONS_WITH_KEYS)
def test_tables_have_every_key_and_no_other(heading: str) -> None:
    said = said_by_tables(heading)
    for name, model in models_of(heading).items():
        sections = SECTIONS if model is RigKeys else ()
        assert said[name].keys() == {*model.model_fields, *sections}, f"{heading}: {name}"


@pytest.mark.long
@pytest.mark.parametrize("heading", SECTIONS_WITH_KEYS)
def test_tables_have_the_right_defaults(heading: str) -> None:
    for name, keys in said_by_tables(heading).items():
        fields = models_of(heading)[name].model_fields
        for key, (place, without) in keys.items():
            if key not in fields:
                continue
            default: Any = fields[key].default
            if fields[key].is_required():
                assert without.startswith(REQUIRED), place
            elif isinstance(default, bool | int | float | str) and default != "":
                text = default if isinstance(default, str) else json.dumps(default)
                assert code_in(without)[:1] == [text], place
            else:
                assert code_in(without) == [] or "NAME" in without or REQUIRED in without, place


def test_every_kind_of_bus_has_its_section() -> None:
    said = {kind for title in headings(page_named("buses.md")) for kind in code_in(title)}
    assert said == set(names_in("fieldrig.buses"))


def test_every_kind_of_device_is_in_the_overview_and_has_its_section() -> None:
    page = page_named("devices.md")
    overview = [row.cells[0] for row in rows(page) if row.columns[0] == "kind"]
    assert sorted(kind for cell in overview for kind in code_in(cell)) == sorted(names_in("fieldrig.devices"))
    for cell in overview:
        name, _, part = links_in(cell)[0].partition("#")
        assert part in map(anchor, headings(page.parent / (name or page.name)))
        assert [anchor(kind) for kind in code_in(cell)] == [part]


def test_the_overview_of_devices_says_which_take_faults() -> None:
    overview = [row for row in rows(page_named("devices.md")) if row.columns[0] == "kind"]
    said = {kind for row in overview for kind in code_in(row.cells[0]) if links_in(row.cells[3])}
    assert said == {kind for kind in names_in("fieldrig.devices") if kinds.find_device(kind).fault_models}


def test_every_kind_of_bus_is_in_the_overview_with_its_time() -> None:
    overview = [row for row in rows(page_named("buses.md")) if row.columns[0] == "kind"]
    said = {kind: row.cells[1] for row in overview for kind in code_in(row.cells[0])}
    assert said.keys() == set(names_in("fieldrig.buses"))
    for kind, times in said.items():
        assert kinds.find_bus(kind).times <= set(times.split(", ")), kind


def test_every_fault_is_explained() -> None:
    said = {code_in(row.cells[0])[0] for row in rows(page_named("can-faults.md")) if row.heading == "What can go wrong"}
    assert said == OTHER_SECTIONS["Keys of a fault"].keys()


def test_the_page_of_faults_has_all_faults_of_all_kinds() -> None:
    said = {
        kind: code_in(row.cells[1])
        for row in rows(page_named("faults.md"))
        if row.columns[0] == "kind"
        for kind in code_in(row.cells[0])
    }
    own = {kind: kinds.find_bus(kind).fault_models for kind in names_in("fieldrig.buses")}
    own |= {kind: kinds.find_device(kind).fault_models for kind in names_in("fieldrig.devices")}
    assert said == {kind: list(models) for kind, models in own.items() if models}


def test_the_readme_counts_the_kinds_that_take_faults() -> None:
    [cell] = [row.cells[1] for row in rows(ROOT / "README.md") if row.cells[0] == "faults at run time"]
    assert cell.startswith(f"[{len(list(kinds_on_the_page_of_faults()))} kinds")


def kinds_on_the_page_of_faults() -> Iterator[str]:
    for row in rows(page_named("faults.md")):
        if row.columns[0] != "kind":
            continue
        yield from code_in(row.cells[0])


@pytest.mark.parametrize("kind", names_in("fieldrig.devices"))
def test_faults_of_every_device_go_the_one_way_of_the_kernel(kind: str) -> None:
    device = kinds.find_device(kind)
    for method in ("add_fault", "clear_fault", "faults"):
        assert getattr(device, method) is getattr(Device, method)


@pytest.mark.parametrize("kind", names_in("fieldrig.buses"))
def test_faults_of_a_bus_from_the_start_are_those_at_run_time(kind: str) -> None:
    bus = kinds.find_bus(kind)
    assert ("faults" in kinds.settings_model(bus).model_fields) == bool(bus.fault_models)


def test_exit_codes_are_those_of_the_program() -> None:
    said = {
        int(row.cells[0]): row.cells[1] for row in rows(page_named("command-line.md")) if row.heading == "Exit codes"
    }
    assert said.keys() == {code.value for code in Exit}
    for code, about in ABOUT.items():
        assert said[code].startswith(about)


def test_commands_are_those_of_the_program() -> None:
    lines = [code_in(row.cells[0])[0] for row in rows(page_named("command-line.md")) if row.columns[0] == "command"]
    said = {" ".join(word for word in line.split()[1:] if word.islower()) for line in lines}
    own = {name for name, _ in commands()}
    assert own <= said
    assert {line.split()[0] for line in said - own} == set(names_in("fieldrig.commands"))


def test_options_are_those_of_the_program() -> None:
    text = prose(page_named("command-line.md"))
    known = {
        option
        for _, command in commands()
        for parameter in command.params
        for option in parameter.opts
        if option[:2] == "--"
    }
    known |= {"--help", "--version", "--install-completion", "--show-completion"}
    assert set(re.findall(r"(?<!\w)--[a-z][a-z-]*", text)) == known


@pytest.mark.parametrize("page", PAGES, ids=place_of)
def test_links_lead_somewhere(page: Path) -> None:
    for link in links(page):
        if link.startswith("http"):
            continue
        name, _, part = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert not part or part in map(anchor, headings(target)), link


def test_every_page_is_reached_by_links_from_the_readme() -> None:
    reached: set[Path] = set()
    found = {ROOT / "README.md"}
    while found:
        reached |= found
        found = ({target for page in found for target in targets_of(page)} & set(PAGES)) - reached
    assert reached == set(PAGES)


def targets_of(page: Path) -> set[Path]:
    """Return the files that a page has links to."""
    return {(page.parent / link.partition("#")[0]).resolve() for link in links(page)}


def test_the_name_of_a_page_is_that_of_no_other() -> None:
    names = [page.name for page in PAGES if page.name != INDEX]
    assert sorted(names) == sorted({*names})


def test_every_folder_has_an_index_of_its_pages() -> None:
    pages = [page for page in PAGES if page.parent != ROOT and page.name != INDEX]
    unlisted = [page for page in pages if page not in targets_of(page.with_name(INDEX))]
    assert unlisted == []


def test_every_index_is_in_the_index_above() -> None:
    below = [page for page in PAGES if page.name == INDEX and page.parent.parent != ROOT and page.parent != ROOT]
    assert [page for page in below if page not in targets_of(page.parent.parent / INDEX)] == []


@pytest.mark.parametrize(
    "message", [text for title in headings(page_named("troubleshooting.md")) for text in code_in(title)]
)
def test_messages_are_what_the_program_says(message: str) -> None:
    sources = [path for folder in ("emulator", "bus", "devices", "page") for path in (ROOT / folder).rglob("*.py")]
    assert any(message in path.read_text(encoding="utf-8") for path in sources)


@pytest.fixture(scope="module")
def lab() -> RigConfig:
    return load(ROOT / "configs" / "lab.yaml")


@pytest.mark.parametrize("page", PAGES, ids=place_of)
def test_pages_are_short(page: Path) -> None:
    lines = page.read_text(encoding="utf-8").splitlines()
    # Tables are looked up, not read, and so is what is below one of them: when it was measured.
    assert sum(line != "" and not line.startswith(("|", "Measured ")) for line in lines) <= 120


def test_parts_of_the_lab_are_in_its_page_and_picture(lab: RigConfig) -> None:
    parts = {code_in(row.cells[0])[0] for row in rows(page_named("lab.md")) if row.heading == "Parts"}
    assert parts == {*lab.buses, *lab.devices}
    picture = {node.text for node in ElementTree.parse(page_named("lab.md").with_name("lab.svg")).iter() if node.text}
    assert parts <= picture


def test_signals_of_the_lab_are_in_its_page(lab: RigConfig) -> None:
    text = prose(page_named("lab.md"))
    for device in lab.devices.values():
        if isinstance(device.settings, CanopenSettings):
            for key, signal in device.settings.signals.items():
                assert key.partition(".")[0] in text
                assert f"`{signal if isinstance(signal, str) else signal.wire}`" in text


def test_registers_of_the_lab_are_in_its_page(lab: RigConfig) -> None:
    settings = lab.devices["drive"].settings
    assert isinstance(settings, ModbusDeviceSettings)
    assert settings.table is not None
    table = load_table(settings.table)
    names = [entry.name for space in Table.model_fields.values() for entry in spaces(table)]
    said = {code_in(row.cells[2])[0] for row in rows(page_named("lab.md")) if row.heading == "Modbus registers"}
    assert said == set(names)


def spaces(table: Table) -> list[Bit | Register | Fifo]:
    return [
        *table.coils,
        *table.discrete_inputs,
        *table.holding_registers,
        *table.input_registers,
        *table.fifos,
    ]


def commands() -> Iterator[tuple[str, Any]]:
    """The kernel's own commands and all of its groups, with their whole names."""
    root: Any = typer.main.get_command(app)
    for name, command in root.commands.items():
        if getattr(command, "commands", None) is None:
            yield name, command
        else:
            yield from ((f"{name} {part}", command.get_command(None, part)) for part in command.list_commands(None))
