"""The exceptions of a unit: those that its register table gives by itself, and faults for all others."""

from collections.abc import Iterator, Mapping
from typing import Any, Final

from fieldrig.points.values import counted
from fieldrig_bus.modbus.identification import Identification, ServerId
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_devices.from_recording.modbus_log import EXCEPTION, UnitLog
from fieldrig_devices.from_recording.register_log import Group, GroupLog
from fieldrig_devices.from_recording.silences import FUNCTION_CODES
from fieldrig_devices.from_recording.unit_words import exception_words, group_words
from fieldrig_devices.modbus.unit import ModbusUnit
from fieldrig_devices.registers.table import Table

CODES: Final = range(1, 256)
"""Exception codes; a response that ends before its code has none."""
MOST_FAULTS: Final = 100
ANY_UNIT: Final = 1
"""The unit id of the requests that are tried, on which no answer depends."""
Entries = Mapping[str, list[dict[str, Any]]]


class ModbusRefusals:
    """The faults for what a unit has refused, and words about refusals that are not repeated."""

    def __init__(self, log: UnitLog, entries: Entries, more: Mapping[str, Any]) -> None:
        """`entries` are those of the register table, `more` are the further keys of the device."""
        self._log, self._server = log, _server(entries, more)
        self.remarks: list[str] = []
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
                words = f"function {function} with {request[1:].hex(' ')} ended in {exception_words(code)}"
                self.remarks.append(f"{words}, which is not repeated here")

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
            ended = f"{group_words(group)} ended in {exception_words(code)} {counted(times, 'time')}"
            self.remarks.append(f"{ended}, which is not repeated here")

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
