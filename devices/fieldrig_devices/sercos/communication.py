"""The operation data that every drive on a ring has, their checks, and the layout of the records they define.

Source: IEC 61491 by its public facts; digest 3.1.  Times are in microseconds, as on the ring.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, NamedTuple

from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import READ_ONLY, Attribute, Format, Length
from fieldrig_devices.sercos.telegram import CONFIGURED, HEAD_BYTES, STANDARD, Telegrams, code_of, size

CYCLES_US: Final = (1_000, 2_000, 4_000)
"""Cycle times of the ring (manual 6042-6044)."""
MOST_DATA_BYTES: Final = 32
"""Largest size of the configurable data in a record; our choice."""
MOST_IDNS_BYTES: Final = 4_096

_WORD: Final = Attribute(Length.TWO)
_PROTECTED_LATE: Final = (3, 4)

_TIMES: Final = {
    std.NC_CYCLE_TIME: "NC cycle time (tNcyc)",
    std.SERCOS_CYCLE_TIME: "SERCOS cycle time (tScyc)",
    std.AT_START: "AT transmission starting time (t1)",
    std.FEEDBACK_TIME: "feedback acquisition starting time (t4)",
    std.COMMAND_VALID_TIME: "command valid time (t3)",
    std.MDT_START: "MDT transmission starting time (t2)",
}
_OWN_TIMES: Final = {
    std.SHORTEST_AT_START: ("shortest AT transmission starting time (t1min)", 10),
    std.TRANSMIT_RECEIVE_TIME: ("transmit/receive transition time (tATMT)", 10),
    std.SHORTEST_FEEDBACK_TIME: ("minimum feedback processing time (t4min)", 100),
    std.TRANSMIT_TRANSMIT_TIME: ("transmit/transmit recovery time (tATAT)", 10),
    std.RECEIVE_RECEIVE_TIME: ("receive/receive recovery time (tMTSY)", 20),
    std.COMMAND_TRANSMIT_TIME: ("command value transmit time (tMTSG)", 30),
}
"""Times that the drive needs; our choice, typical of a SERCON and a servo of that time."""
_LISTS: Final = {
    std.ALL_IDNS: "IDN-list of all operation data",
    std.CP2_IDNS: "IDN-list of operation data for CP2",
    std.CP3_IDNS: "IDN-list of operation data for CP3",
    std.INVALID_CP2_IDNS: "IDN-list of invalid operation data for CP2",
    std.INVALID_CP3_IDNS: "IDN-list of invalid operation data for CP3",
    std.COMMAND_IDNS: "IDN-list of all procedure commands",
    std.AT_IDNS: "IDN-list of configurable data in the AT",
    std.MDT_IDNS: "IDN-list of configurable data in the MDT",
}
_CP2: Final = (
    std.NC_CYCLE_TIME,
    std.SERCOS_CYCLE_TIME,
    std.AT_START,
    std.FEEDBACK_TIME,
    std.COMMAND_VALID_TIME,
    std.RECORD_POSITION,
    std.MDT_LENGTH,
    std.TELEGRAM_TYPE,
    std.AT_CONFIGURATION,
    std.MDT_CONFIGURATION,
    std.MDT_START,
)
"""Data that the master has to write before CP3."""
_CONTENTS: Final = (std.TELEGRAM_TYPE, std.AT_CONFIGURATION, std.MDT_CONFIGURATION)
"""Data of CP2 that say what the telegrams contain."""


class Layout(NamedTuple):
    """The place of a drive's record in the MDT."""

    position: int
    """First byte of the drive's record; byte 0 of the MDT is its address."""
    mdt_length: int
    """Length of the MDT's data, without the address."""
    mdt: tuple[str, ...]
    """Codes of the values in the record, for `struct`."""


class Communication:
    """The data of the ring interface in a drive's table."""

    def __init__(
        self,
        table: IdnTable,
        interface_status: Callable[[], int],
        check: Callable[[int, Command], None],
        on_command_end: Callable[[bool], None],
    ) -> None:
        self._table = table
        for number, name in _TIMES.items():
            start = 4_000 if number in (std.NC_CYCLE_TIME, std.SERCOS_CYCLE_TIME) else 0
            attribute = Attribute(Length.TWO, protected=_PROTECTED_LATE)
            table.add(Datum(number, name, attribute, start, unit="us", minimum=0, maximum=65_000))
        for number, (name, value) in _OWN_TIMES.items():
            table.add(Datum(number, name, Attribute(Length.TWO, protected=READ_ONLY), value, unit="us"))
        self._add_records()
        self._add_lists()
        status = table.add(
            Datum(std.INTERFACE_STATUS, "interface status", Attribute(Length.TWO, Format.BINARY, protected=READ_ONLY))
        )
        status.reader = lambda: interface_status().to_bytes(2, "little")
        self._mst_failures = table.add(Datum(std.MST_ERRORS, "error counter MST", _WORD))
        self._mdt_failures = table.add(Datum(std.MDT_ERRORS, "error counter MDT", _WORD))
        table.add(
            Datum(std.SLAVE_ARRANGEMENT, "slave arrangement", Attribute(Length.TWO, Format.HEX, protected=READ_ONLY))
        )
        self.commands: list[Command] = []
        for number, phase in ((std.CP3_TRANSITION_CHECK, 3), (std.CP4_TRANSITION_CHECK, 4)):
            attribute = Attribute(Length.TWO, Format.BINARY, is_command=True)
            datum = table.add(Datum(number, f"CP{phase} transition check", attribute))
            self.commands.append(Command(datum, partial(check, phase), on_command_end))

    def _add_records(self) -> None:
        late = Attribute(Length.TWO, protected=_PROTECTED_LATE)
        kind = Attribute(Length.TWO, Format.BINARY, protected=_PROTECTED_LATE)
        configured = Attribute(Length.LIST_OF_WORDS, Format.IDN, protected=_PROTECTED_LATE)
        fixed = Attribute(Length.TWO, protected=READ_ONLY)
        place = partial(Datum, unit="byte", minimum=1, maximum=65_531)
        length = partial(Datum, unit="byte", minimum=HEAD_BYTES, maximum=65_534)
        most = partial(Datum, attribute=fixed, value=MOST_DATA_BYTES, unit="byte")
        for datum in (
            place(std.RECORD_POSITION, "position of data record in the MDT", late, 1),
            length(std.MDT_LENGTH, "length of the MDT", late, HEAD_BYTES),
            Datum(std.TELEGRAM_TYPE, "telegram type", kind, 4),
            Datum(std.AT_CONFIGURATION, "configuration list of the AT", configured, ()),
            Datum(std.MDT_CONFIGURATION, "configuration list of the MDT", configured, ()),
            most(std.AT_DATA_LENGTH, "length of the configurable data record in the AT"),
            most(std.MDT_DATA_LENGTH, "length of the configurable data record in the MDT"),
        ):
            self._table.add(datum)

    def _add_lists(self) -> None:
        attribute = Attribute(Length.LIST_OF_WORDS, Format.IDN, protected=READ_ONLY)
        for number, name in _LISTS.items():
            self._table.add(Datum(number, name, attribute, (), largest=MOST_IDNS_BYTES))
        self._compute(std.ALL_IDNS, lambda: sorted(datum.idn for datum in self._table))
        self._compute(std.CP2_IDNS, lambda: list(_CP2))
        self._compute(
            std.AT_IDNS, lambda: sorted(datum.idn for datum in self._table if code_of(self._table, datum.idn))
        )
        self._compute(std.MDT_IDNS, lambda: sorted(datum.idn for datum in self._table if self._may_be_sent(datum.idn)))
        self._compute(
            std.COMMAND_IDNS, lambda: sorted(datum.idn for datum in self._table if datum.attribute.is_command)
        )

    def _may_be_sent(self, idn: int) -> bool:
        """True if the attribute allows the datum in the MDT; an application may restrict this further."""
        return bool(code_of(self._table, idn)) and 4 not in self._table[idn].attribute.protected

    def _compute(self, number: int, numbers: Callable[[], Sequence[int]]) -> None:
        datum = self._table[number]
        datum.reader = lambda: datum.encoded(numbers())

    @property
    def cycle_us(self) -> int:
        return self._table[std.SERCOS_CYCLE_TIME].number

    def clear_counters(self) -> None:
        """Clear S-0-0028 and S-0-0029, which count from CP3 on."""
        self._mst_failures.set(0)
        self._mdt_failures.set(0)

    def count_mst_failure(self) -> None:
        self._mst_failures.set(min(self._mst_failures.number + 1, 0xFFFF))

    def count_mdt_failure(self) -> None:
        self._mdt_failures.set(min(self._mdt_failures.number + 1, 0xFFFF))

    @property
    def telegrams(self) -> Telegrams:
        """The telegrams that S-0-0015 selects, or the first standard telegram while it is invalid."""
        return self._telegrams() or STANDARD[0]

    def _telegrams(self) -> Telegrams | None:
        """Return the selected telegrams, or None if the type does not exist."""
        telegram_type = self._table[std.TELEGRAM_TYPE].number & 7
        if telegram_type == CONFIGURED:
            return Telegrams(
                tuple(self._table[std.MDT_CONFIGURATION].numbers), tuple(self._table[std.AT_CONFIGURATION].numbers)
            )
        return STANDARD.get(telegram_type)

    def layout(self) -> Layout:
        """Return the layout; the data must be valid."""
        mdt = tuple(code_of(self._table, idn) for idn in self.telegrams.mdt)
        return Layout(self._table[std.RECORD_POSITION].number, self._table[std.MDT_LENGTH].number, mdt)

    def invalid(self) -> list[int]:
        """Return the IDNs of CP2 whose values are invalid."""
        table = self._table
        value = {number: table[number].number for number in _CP2 if number not in _CONTENTS}
        invalid = [number for number in (std.NC_CYCLE_TIME, std.SERCOS_CYCLE_TIME) if value[number] not in CYCLES_US]
        cycle_us = value[std.SERCOS_CYCLE_TIME]
        if value[std.NC_CYCLE_TIME] % (cycle_us or 1):
            invalid.append(std.NC_CYCLE_TIME)
        invalid += [number for number in (std.AT_START, std.FEEDBACK_TIME) if value[number] >= cycle_us]
        if value[std.AT_START] < table[std.SHORTEST_AT_START].number:
            invalid.append(std.AT_START)
        if (
            not value[std.AT_START] + table[std.TRANSMIT_RECEIVE_TIME].number
            <= value[std.MDT_START]
            <= cycle_us - table[std.RECEIVE_RECEIVE_TIME].number
        ):
            invalid.append(std.MDT_START)
        if (
            not value[std.MDT_START] + table[std.COMMAND_TRANSMIT_TIME].number
            <= value[std.COMMAND_VALID_TIME]
            <= cycle_us
        ):
            invalid.append(std.COMMAND_VALID_TIME)
        if value[std.FEEDBACK_TIME] > cycle_us - table[std.SHORTEST_FEEDBACK_TIME].number:
            invalid.append(std.FEEDBACK_TIME)
        return sorted({*invalid, *self._invalid_records(value[std.RECORD_POSITION], value[std.MDT_LENGTH])})

    def _invalid_records(self, position: int, mdt_length: int) -> list[int]:
        telegrams = self._telegrams()
        if telegrams is None:
            return [std.TELEGRAM_TYPE]
        mdt, at = ([code_of(self._table, idn) for idn in idns] for idns in telegrams)
        is_configured = self._table[std.TELEGRAM_TYPE].number & 7 == CONFIGURED
        invalid = []
        if "" in mdt or size(mdt) > MOST_DATA_BYTES or not {*telegrams.mdt} <= {*self._table[std.MDT_IDNS].numbers}:
            invalid.append(std.MDT_CONFIGURATION if is_configured else std.TELEGRAM_TYPE)
        if "" in at or size(at) > MOST_DATA_BYTES:
            invalid.append(std.AT_CONFIGURATION if is_configured else std.TELEGRAM_TYPE)
        if not invalid and position + HEAD_BYTES + size(mdt) > 1 + mdt_length:
            invalid += [std.RECORD_POSITION, std.MDT_LENGTH]
        return invalid

    def show_invalid(self, phase: int, invalid: Sequence[int]) -> None:
        self._table[std.INVALID_CP2_IDNS if phase == 3 else std.INVALID_CP3_IDNS].set(invalid)
