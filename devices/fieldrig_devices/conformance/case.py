"""Cases: the requirement of each, its clause in the standard, and the steps of the test."""

import re
from collections.abc import Callable
from typing import NamedTuple

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.line import Steps

Try = Callable[[Bench], Steps[None]]


class Case(NamedTuple):
    number: str
    """Number such as `2.7`, as in the public log of a test with CiA's tool."""
    name: str
    """Name such as `SDO 07`."""
    requirement: str
    clause: str
    steps: Try

    @property
    def family(self) -> str:
        return re.sub(r" ?\d+$", "", self.name)

    @property
    def order(self) -> tuple[int, int]:
        chapter, _, place = self.number.partition(".")
        return int(chapter), int(place)


CASES: dict[str, Case] = {}


def case(number: str, name: str, requirement: str, clause: str) -> Callable[[Try], Try]:
    def keep(steps: Try) -> Try:
        assert number not in CASES, number
        CASES[number] = Case(number, name, requirement, clause, steps)
        return steps

    return keep
