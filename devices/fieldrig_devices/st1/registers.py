"""The registers of an ST1 behind the addresses of table 2-2 (PAML-140 to PAML-149).

Positions of resolvers are counts of 16 bits a turn, which a register of 32 bits adds up (E-24); the set-point has the
same unit.  A register of 16 bits has the lowest 16 bits of its value.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_devices.pamring.registers import Parameter, Primary, Variable, register_at, rolled
from fieldrig_devices.st1.settings import ParameterSettings

COUNT: Final = 1 << 16
"""RU to a count, and counts to a turn."""

Source = Callable[[], int]


class Registers:
    def __init__(
        self,
        primary: Mapping[Primary, Source],
        variables: Mapping[int, Source],
        parameters: Mapping[int, Source],
    ) -> None:
        self._sources: Mapping[type, Mapping[int, Source]] = {
            Primary: {int(key): source for key, source in primary.items()},
            Variable: variables,
            Parameter: parameters,
        }

    def read(self, address: int) -> int | None:
        """Return the register's bits with their sign; None if there is no such register."""
        register = register_at(address)
        if register is None:
            return None
        source = self._sources[register.kind].get(register.code)
        return None if source is None else rolled(source(), register.bits)


def parameter_sources(own: ParameterSettings) -> dict[int, Source]:
    """Return the parameters by their codes; lengths are counts."""

    def counts(turns: float | None) -> int:
        return 0 if turns is None else round(turns * COUNT)

    values = {
        Parameter.CKV: counts(own.ckv),
        Parameter.CKA: counts(own.cka),
        Parameter.CKR: own.ckr,
        Parameter.CKH: own.ckh,
        Parameter.ASTOP: counts(own.astop),
        Parameter.PHIL1: counts(own.phil1),
        Parameter.PHIL2: counts(own.phil2),
        Parameter.EQUIP: own.equip,
        Parameter.CMASKS: own.cmasks,
        Parameter.CMASKU: own.cmasku,
        Parameter.CACTIN: own.cactin,
        Parameter.CVALIN: own.cvalin,
        Parameter.CACOUT: own.cacout,
    }
    return {int(code): _constant(value) for code, value in values.items()}


def _constant(value: int) -> Source:
    return lambda: value
