"""A PAM's run time with its real objects and recorded orders, without a ring: programs that move pipes."""

from collections.abc import Sequence

from pam_objects import Port, St1

from fieldrig_devices.pam.objects.application import ApplicationObjects
from fieldrig_devices.pam.pipes.shapes import shape_of
from fieldrig_devices.pam.runtime.compiler import compile_application
from fieldrig_devices.pam.runtime.runtime import Runtime
from fieldrig_devices.pamring.frames import InputChanged, Report


class WholePam:
    """An application that runs, with an axis at each address; a report arrives in the next cycle."""

    def __init__(self, text: str, addresses: Sequence[int] = ()) -> None:
        program = compile_application(text, "whole.pam")
        self.messages: list[str] = []
        self.volts: list[tuple[int, float]] = []
        self.runtime = Runtime(program, lambda code, _details, _text: self.messages.append(code))
        self.port = Port()
        self.objects = ApplicationObjects(
            program.program,
            self.runtime,
            self.port,
            shapes=lambda _name: shape_of(b"0 0\n1 1\n"),
            volts=lambda *volts: self.volts.append(volts),
        )
        self._reports: list[tuple[int, Report]] = []
        self._delivered = 0
        self.nodes = {
            address: St1(lambda report, to=address: self._reports.append((to, report)), program.thirds / 3000)  # type: ignore[misc]
            for address in addresses
        }
        self.runtime.start(self.objects)

    def __getitem__(self, name: str) -> object:
        return self.runtime.cells[self.runtime.program.layout.cells[name].first]

    def __setitem__(self, name: str, value: bool | float) -> None:
        self.runtime.poke(self.runtime.program.layout.cells[name].first, value)

    def change(self, address: int, item: int, value: int) -> None:
        self.objects.on_report(address, InputChanged(item, value, 0))

    def run(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            reports, self._reports = self._reports, []
            for address, report in reports:
                self.objects.on_report(address, report)
            self.runtime.cycle()
            for address, order in self.port.sent[self._delivered :]:
                if address in self.nodes:
                    self.nodes[address].order(order)
            self._delivered = len(self.port.sent)
            for node in self.nodes.values():
                node.cycle()
