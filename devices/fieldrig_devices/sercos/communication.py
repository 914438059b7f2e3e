"""The operation data that every drive on a ring has, and what they say together: where its records lie.

Source: IEC 61491 by its public facts; digest 3.1.  Times are in microseconds, as on the ring.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, NamedTuple

from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import READ_ONLY, Attribute, Format, Length
from fieldrig_devices.sercos.telegram import CONFIGURED, HEAD_BYTES, STANDARD, Telegrams, code_of, size

CYCLES_US: Final = (1_000, 2_000, 4_000)
"""Manual 6042-6044."""
MOST_DATA_BYTES: Final = 32
"""Of configurable data in one record; our choice."""
MOST_IDNS_BYTES: Final = 4_096

_WORD: Final = Attribute(Length.TWO)
_PROTECTED_LATE: Final = (3, 4)

_TIMES: Final = {
    1: "NC cycle time (tNcyc)",
    2: "SERCOS cycle time (tScyc)",
    6: "AT transmission starting time (t1)",
    7: "feedback acquisition starting time (t4)",
    8: "command valid time (t3)",
    89: "MDT transmission starting time (t2)",
}
_OWN_TIMES: Final = {
    3: ("shortest AT transmission starting time (t1min)", 10),
    4: ("transmit/receive transition time (tATMT)", 10),
    5: ("minimum feedback processing time (t4min)", 100),
    87: ("transmit/transmit recovery time (tATAT)", 10),
    88: ("receive/receive recovery time (tMTSY)", 20),
    90: ("command value transmit time (tMTSG)", 30),
}
"""What the drive needs; our choice, as a SERCON and a servo of the time would."""
_LISTS: Final = {
    17: "IDN-list of all operation data",
    18: "IDN-list of operation data for CP2",
    19: "IDN-list of operation data for CP3",
    21: "IDN-list of invalid operation data for CP2",
    22: "IDN-list of invalid operation data for CP3",
    25: "IDN-list of all procedure commands",
    187: "IDN-list of configurable data in the AT",
    188: "IDN-list of configurable data in the MDT",
}
_CP2: Final = (1, 2, 6, 7, 8, 9, 10, 15, 16, 24, 89)
"""What the master has to give before CP3."""


class Layout(NamedTuple):
    position: int
    """Of the drive's record in the MDT; its address is byte 0."""
    mdt_length: int
    """Of the MDT's data, without the address."""
    mdt: tuple[str, ...]
    """Codes of the values in a record of it."""


class Communication:
    def __init__(
        self,
        table: IdnTable,
        interface_status: Callable[[], int],
        check: Callable[[int, Command], None],
        on_command_end: Callable[[bool], None],
    ) -> None:
        self._table = table
        for number, name in _TIMES.items():
            start = 4_000 if number in (1, 2) else 0
            attribute = Attribute(Length.TWO, protected=_PROTECTED_LATE)
            table.add(Datum(number, name, attribute, start, unit="us", minimum=0, maximum=65_000))
        for number, (name, value) in _OWN_TIMES.items():
            table.add(Datum(number, name, Attribute(Length.TWO, protected=READ_ONLY), value, unit="us"))
        self._add_records()
        self._add_lists()
        status = table.add(Datum(14, "interface status", Attribute(Length.TWO, Format.BINARY, protected=READ_ONLY)))
        status.reader = lambda: interface_status().to_bytes(2, "little")
        self._mst_failures = table.add(Datum(28, "error counter MST", _WORD))
        self._mdt_failures = table.add(Datum(29, "error counter MDT", _WORD))
        table.add(Datum(96, "slave arrangement", Attribute(Length.TWO, Format.HEX, protected=READ_ONLY)))
        self.commands: list[Command] = []
        for number, phase in ((127, 3), (128, 4)):
            attribute = Attribute(Length.TWO, Format.BINARY, is_command=True)
            datum = table.add(Datum(number, f"CP{phase} transition check", attribute))
            self.commands.append(Command(datum, partial(check, phase), on_command_end))

    def _add_records(self) -> None:
        late = Attribute(Length.TWO, protected=_PROTECTED_LATE)
        add = self._table.add
        add(Datum(9, "position of data record in the MDT", late, 1, unit="byte", minimum=1, maximum=65_531))
        add(Datum(10, "length of the MDT", late, HEAD_BYTES, unit="byte", minimum=HEAD_BYTES, maximum=65_534))
        add(Datum(15, "telegram type", Attribute(Length.TWO, Format.BINARY, protected=_PROTECTED_LATE), 4))
        configured = Attribute(Length.LIST_OF_WORDS, Format.IDN, protected=_PROTECTED_LATE)
        add(Datum(16, "configuration list of the AT", configured, ()))
        add(Datum(24, "configuration list of the MDT", configured, ()))
        fixed = Attribute(Length.TWO, protected=READ_ONLY)
        add(Datum(185, "length of the configurable data record in the AT", fixed, MOST_DATA_BYTES, unit="byte"))
        add(Datum(186, "length of the configurable data record in the MDT", fixed, MOST_DATA_BYTES, unit="byte"))

    def _add_lists(self) -> None:
        attribute = Attribute(Length.LIST_OF_WORDS, Format.IDN, protected=READ_ONLY)
        for number, name in _LISTS.items():
            self._table.add(Datum(number, name, attribute, (), largest=MOST_IDNS_BYTES))
        self._compute(17, lambda: sorted(one.idn for one in self._table))
        self._compute(18, lambda: list(_CP2))
        self._compute(187, lambda: sorted(one.idn for one in self._table if code_of(self._table, one.idn)))
        self._compute(188, lambda: sorted(one.idn for one in self._table if self._may_be_sent(one.idn)))
        self._compute(25, lambda: sorted(one.idn for one in self._table if one.attribute.is_command))

    def _may_be_sent(self, idn: int) -> bool:
        """Whether the drive takes it in the MDT, by what its attribute says; an application may know better."""
        return bool(code_of(self._table, idn)) and 4 not in self._table[idn].attribute.protected

    def _compute(self, number: int, numbers: Callable[[], Sequence[int]]) -> None:
        datum = self._table[number]
        datum.reader = lambda: datum.encoded(numbers())

    @property
    def cycle_us(self) -> int:
        return self._table[2].number

    def clear_counters(self) -> None:
        """S-0-0028 and S-0-0029 count from CP3 on."""
        self._mst_failures.set(0)
        self._mdt_failures.set(0)

    def count_mst_failure(self) -> None:
        self._mst_failures.set(min(self._mst_failures.number + 1, 0xFFFF))

    def count_mdt_failure(self) -> None:
        self._mdt_failures.set(min(self._mdt_failures.number + 1, 0xFFFF))

    @property
    def telegrams(self) -> Telegrams:
        """As S-0-0015 picks them, once that is right."""
        return self._telegrams() or STANDARD[0]

    def _telegrams(self) -> Telegrams | None:
        """None if there is no such type."""
        kind = self._table[15].number & 7
        if kind == CONFIGURED:
            return Telegrams(tuple(self._table[24].numbers), tuple(self._table[16].numbers))
        return STANDARD.get(kind)

    def layout(self) -> Layout:
        """Of what `invalid` has found right."""
        mdt = tuple(code_of(self._table, idn) for idn in self.telegrams.mdt)
        return Layout(self._table[9].number, self._table[10].number, mdt)

    def invalid(self) -> list[int]:
        """The IDNs of CP2 whose values can't be."""
        table = self._table
        value = {number: table[number].number for number in (1, 2, 6, 7, 8, 9, 10, 89)}
        invalid = [number for number in (1, 2) if value[number] not in CYCLES_US]
        cycle_us = value[2]
        if value[1] % (cycle_us or 1):
            invalid.append(1)
        invalid += [number for number in (6, 7) if value[number] >= cycle_us]
        if value[6] < table[3].number:
            invalid.append(6)
        if not value[6] + table[4].number <= value[89] <= cycle_us - table[88].number:
            invalid.append(89)
        if not value[89] + table[90].number <= value[8] <= cycle_us:
            invalid.append(8)
        if value[7] > cycle_us - table[5].number:
            invalid.append(7)
        return sorted({*invalid, *self._invalid_records(value[9], value[10])})

    def _invalid_records(self, position: int, mdt_length: int) -> list[int]:
        telegrams = self._telegrams()
        if telegrams is None:
            return [15]
        mdt, at = ([code_of(self._table, idn) for idn in idns] for idns in telegrams)
        is_configured = self._table[15].number & 7 == CONFIGURED
        invalid = []
        if "" in mdt or size(mdt) > MOST_DATA_BYTES or not {*telegrams.mdt} <= {*self._table[188].numbers}:
            invalid.append(24 if is_configured else 15)
        if "" in at or size(at) > MOST_DATA_BYTES:
            invalid.append(16 if is_configured else 15)
        if not invalid and position + HEAD_BYTES + size(mdt) > 1 + mdt_length:
            invalid += [9, 10]
        return invalid

    def show_invalid(self, phase: int, invalid: Sequence[int]) -> None:
        self._table[21 if phase == 3 else 22].set(invalid)
