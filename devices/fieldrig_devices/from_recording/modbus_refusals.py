"""The exceptions of a unit: those that its register table gives by itself, and faults for others.

What was refused at times, and done at others, is refused again in the order of the recording.
"""

from collections.abc import Iterator, Mapping
from typing import Any, Final

from fieldrig.points.values import counted
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_VALUE
from fieldrig_bus.modbus.identification import Identification, ServerId
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_devices.from_recording.modbus_log import EXCEPTION, UnitLog
from fieldrig_devices.from_recording.register_log import (
    MASK_WRITE,
    READ_WRITE,
    WRITE_COIL,
    WRITE_COILS,
    WRITE_REGISTER,
    WRITE_REGISTERS,
    Group,
    GroupLog,
)
from fieldrig_devices.from_recording.silences import FUNCTION_CODES
from fieldrig_devices.from_recording.unit_words import exception_words, group_words
from fieldrig_devices.modbus.answer_times import Kind, kind_of
from fieldrig_devices.modbus.unit import ModbusUnit
from fieldrig_devices.registers.table import Table

CODES: Final = range(1, 256)
"""Exception codes; a response that ends before its code has none."""
WRITERS: Final = frozenset({WRITE_COIL, WRITE_REGISTER, WRITE_COILS, WRITE_REGISTERS, MASK_WRITE, READ_WRITE})
MOST_FAULTS: Final = 100
ANY_UNIT: Final = 1
"""The unit id of the requests that are tried, on which no answer depends."""
Entries = Mapping[str, list[dict[str, Any]]]


class ModbusRefusals:
    """The faults for what a unit has refused, and the kinds of requests that it has refused at times."""

    def __init__(self, log: UnitLog, entries: Entries, more: Mapping[str, Any]) -> None:
        """`entries` are those of the register table, `more` are the further keys of the device."""
        self._log, self._server = log, _server(entries, more)
        self.remarks: list[str] = []
        self.at_times: set[Kind] = set()
        self.faults: list[dict[str, Any]] = []
        for group, of_group in sorted(log.groups.items()):
            for code, times in of_group.refused.items():
                self._take(group, of_group, code, times)
        for request, code in log.refused_functions.items():
            function = request[0]
            if code not in CODES or self._answer(request) == bytes((function | EXCEPTION, code)):
                continue
            is_certain = function in FUNCTION_CODES and function not in log.done_functions
            if not is_certain or not self._add({"function": function, "code": code}):
                self._at_times(request, f"function {function} with {request[1:].hex(' ')}", code, 1)

    def _at_times(self, request: bytes, what: str, code: int, times: int) -> None:
        """Repeat a refusal in turn, as nothing in the request tells when it comes."""
        kind = kind_of(None, request)
        has_value = code == ILLEGAL_DATA_VALUE and request[0] in WRITERS  # what was written decides
        if code in CODES and kind in self._log.answers_of and not has_value:
            self.at_times.add(kind)
            how = "which comes again in turn"
        else:
            how = "which is not repeated here"
        self.remarks.append(f"why {what} ended in {exception_words(code)} {counted(times, 'time')}, {how}")

    def _take(self, group: Group, log: GroupLog, code: int, times: int) -> None:
        if self._answer(log.refused_request) == bytes((group.function | EXCEPTION, code)):
            return
        address = self._refusing_address(group)
        is_certain = code in CODES and len(log.refused) == 1 and log.sample is None
        if (
            address is None
            or not is_certain
            or not self._add({"function": group.function, "address": address, "code": code})
        ):
            self._at_times(log.refused_request, group_words(group), code, times)

    def _add(self, keys: dict[str, Any]) -> bool:
        has_room = len(self.faults) < MOST_FAULTS
        if has_room:
            self.faults.append({"what": "exception", **keys})
        return has_room

    def _answer(self, request: bytes) -> bytes | None:
        return self._server.answer(ModbusRequest(ANY_UNIT, request))

    def _refusing_address(self, refused: Group) -> int | None:
        """Return an address that only refused requests of the function name; None if there is none."""
        done = {
            address
            for group, log in self._log.groups.items()
            if group.function == refused.function and log.sample is not None
            for address in group.addresses
        }
        return next((address for address in refused.addresses if address not in done), None)


def _server(entries: Entries, more: Mapping[str, Any]) -> ModbusServer:
    plain = {space: list(_without_sources(of_space)) for space, of_space in entries.items()}
    unit = ModbusUnit(Table.model_validate(plain), "server_failure", 0, lambda signal: None, lambda: None)
    identification = Identification.model_validate(more.get("identification", {}))
    return ModbusServer(unit, identification, ServerId.model_validate(more.get("server_id", {})))


def _without_sources(entries: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield entries that refuse what those with a source refuse, without its file."""
    for entry in entries:
        plain = {key: value for key, value in entry.items() if key != "source"}
        yield plain | ({"access": "ro"} if "source" in entry else {})
