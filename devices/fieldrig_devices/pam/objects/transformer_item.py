"""The base of the transformers of pipes in programs."""

from typing import Any

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.pipes.block import Block


class TransformerItem(ObjectItem):
    block: Block

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared.name)
        self.site = site

    def begin(self, period_s: float) -> None:
        """The first pipe with this block is activated."""
        self.block.start(period_s)

    def end(self) -> None:
        self.block.stop()

    def declare(self, declared: Declared) -> None:
        """Give the parameters the values of the declaration."""

    def ask_ready(self) -> bool:
        return self.block.ready

    def ask_value(self) -> float:
        return self.block.value

    def do(self, function: str, arguments: Any = ()) -> None:
        super().do(function, arguments)
        self.site.changes += 1
        self.site.kernel.touched(self.name)

    def set_parameter(self, name: str, value: Any) -> None:
        super().set_parameter(name, value)
        self.site.changes += 1
        self.site.kernel.touched(self.name)
