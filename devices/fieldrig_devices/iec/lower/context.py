"""The common part of the routines of one program while it is lowered: numbers of types, images and native POUs."""

from fieldrig_devices.iec.costs import Costs
from fieldrig_devices.iec.layout import Images
from fieldrig_devices.iec.program import Pou
from fieldrig_devices.iec.types import Type, Value


class Context:
    def __init__(self, costs: Costs) -> None:
        self.costs = costs
        self.images = Images()
        self.forms: list[Type] = []
        """The types that pointers are compared with, by number."""
        self._form_numbers: dict[Type, int] = {}
        self.constants: list[list[Value]] = []
        """The start values of structures and arrays on the stack, by number."""

    def form(self, kind: Type) -> int:
        if kind not in self._form_numbers:
            self._form_numbers[kind] = len(self.forms)
            self.forms.append(kind)
        return self._form_numbers[kind]

    def image(self, cells: list[Value]) -> str:
        self.constants.append(cells)
        return f"image_{len(self.constants) - 1}"

    @staticmethod
    def routine(pou: Pou) -> str:
        """Return the name of the routine of a POU."""
        return pou.name.lower()
