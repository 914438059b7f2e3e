"""The address of a bus on the command line.

can.socketcan:vcan0
can.udp:239.74.163.2:43113                 group and port are optional
can.hub:run/lab/can0                       the bus can0 of the running rig with this run folder
can.hub:127.0.0.1:4000/can0                the bus can0 of a hub on another machine
python-can:interface=pcan,channel=PCAN_USBBUS1,bitrate=500000
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from fieldrig.bus import Bus
from fieldrig.config.kinds import find_bus, settings_model
from fieldrig.errors import UsageError

FORMS = (
    "can.socketcan:vcan0, can.udp:GROUP:PORT, can.hub:RUNFOLDER/can0, or python-can:interface=...,channel=...;"
    " --rig FILE --bus can0 names a bus of a rig file"
)


class Address(NamedTuple):
    bus: Bus[Any]
    run: Path
    """The run folder of the bus's rig."""


def parse(text: str) -> Address:
    """Parse an address.  Raises UsageError, with what was expected, if it is wrong."""
    kind, _, rest = text.partition(":")
    maker = _MAKERS.get(kind)
    if maker is None or (not rest and kind != "can.udp"):
        raise UsageError(f"{text!r} is not the address of a bus", f"expected {FORMS}")
    try:
        return maker(rest)
    except ValidationError as wrong:
        first = wrong.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        what = f"{text!r} is not the address of a bus: {where}: {first['msg']}"
        raise UsageError(what, f"expected {FORMS}") from wrong


def _made(kind: str, name: str, settings: dict[str, Any], run: Path = Path()) -> Address:
    cls = find_bus(kind)
    return Address(cls(name, settings_model(cls).model_validate(settings)), run)


def _socketcan(rest: str) -> Address:
    return _made("can.socketcan", rest, {"channel": rest})


def _udp(rest: str) -> Address:
    group, _, port = rest.partition(":")
    settings: dict[str, Any] = {"group": group} if group else {}
    if port:
        settings["port"] = int(port) if port.isdecimal() else port
    return _made("can.udp", "udp", settings)


def _hub(rest: str) -> Address:
    where, _, name = rest.rpartition("/")
    host, _, port = where.rpartition(":")
    if host and port.isdecimal():
        return _made("can.hub", name, {"connect": where.removeprefix("tcp://")})
    return _made("can.hub", name, {}, Path(where or "."))


def _python_can(rest: str) -> Address:
    from fieldrig_bus.can.python_can import PythonCan, PythonCanSettings

    pairs = [part.partition("=") for part in rest.split(",")]
    settings = {key: int(value) if value.isdecimal() else value for key, _, value in pairs}
    return Address(PythonCan("python-can", PythonCanSettings.model_validate(settings)), Path())


_MAKERS: dict[str, Callable[[str], Address]] = {
    "can.socketcan": _socketcan,
    "can.udp": _udp,
    "can.hub": _hub,
    "python-can": _python_can,
}
