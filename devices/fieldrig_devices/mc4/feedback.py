"""The feedback values of an AT as bytes: values that change in every cycle first, then the steady ones."""

import struct
from collections.abc import Callable, Sequence

from fieldrig_devices.drives.axis import Axis
from fieldrig_devices.drives.fold import FollowingCycle
from fieldrig_devices.mc4.machine import Machine
from fieldrig_devices.mc4.values import MOVING, STANDING, Number, following_numbers, moving_numbers
from fieldrig_devices.sercos.datum import IdnTable
from fieldrig_devices.sercos.telegram import code_of


class Feedback:
    __slots__ = (
        "_codes", "_idns", "_machine", "_moving", "_moving_record", "_numbers", "_standing_record", "size", "standing",
    )  # fmt: skip

    def __init__(
        self, machine: Machine, table: IdnTable, idns: Sequence[int], number_of: Callable[[int], Number]
    ) -> None:
        """`idns` are in the order of the AT; `number_of` returns a function that gives the present value of an IDN."""
        self._machine = machine
        numbers = [number_of(idn) for idn in idns]
        codes = [code_of(table, idn) for idn in idns]
        first = len(idns)
        while first and idns[first - 1] in STANDING:
            first -= 1
        self._idns, self._codes = tuple(idns[:first]), "".join(codes[:first])
        self._moving_record = struct.Struct("<" + self._codes)
        self._moving: Callable[[], tuple[int, ...]] = lambda: tuple(number() for number in numbers[:first])
        if self.is_of_the_axis:
            self._moving = moving_numbers(machine, self._idns)
        self._numbers = numbers[first:]
        self._standing_record = struct.Struct("<" + "".join(codes[first:]))
        self.size = self._moving_record.size + self._standing_record.size
        """Size in bytes."""
        self.standing = b""
        """The trailing values, packed; they change only with `Machine.look`."""
        self.refresh()

    @property
    def moving(self) -> tuple[tuple[int, ...], str]:
        """The IDNs of the leading values, and their codes for `struct`."""
        return self._idns, self._codes

    @property
    def is_of_the_axis(self) -> bool:
        """True if all leading values are of the axis."""
        return all(idn in MOVING for idn in self._idns)

    def refresh(self) -> None:
        """Pack the trailing values again, after `Machine.look`."""
        self.standing = self._standing_record.pack(*[number() for number in self._numbers])

    def encode(self) -> bytes:
        return self._moving_record.pack(*self._moving()) + self.standing

    def following(self, axis: Axis, *, is_published: bool) -> FollowingCycle | None:
        """Return the folded cycle that packs the leading values, or None if it cannot compute all of them."""
        if not self.is_of_the_axis:
            return None
        return axis.following(following_numbers(self._machine, self._idns, self._codes), is_published=is_published)
