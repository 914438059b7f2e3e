"""The library HMISCU_PTOPWM: its types and blocks as IEC text, and its blocks as native blocks.

Source: manual 640, 760, 990, 2184-2225 (SCU-010, SCU-092, SCU-097, SCU-098).  The text follows from the tables of pins
and enumerations.  The instances of the channels are global variables of the library; an instance that the program
declares of their types has no channel.
"""

from collections.abc import Callable, Iterator, Mapping

from fieldrig.clock import Clock
from fieldrig_devices.hmiscu.blocks.pins import Block, BlockType, Pin
from fieldrig_devices.hmiscu.blocks.tables import BLOCK_TYPES
from fieldrig_devices.hmiscu.enumerations import ALIASES, ENUMERATIONS
from fieldrig_devices.iec.host import Library, NativeBlock, Results
from fieldrig_devices.iec.types import Value

NAME = "HMISCU_PTOPWM"

MakeBlock = Callable[[BlockType, str], Block]
"""Returns a new block of a type; the text is the name of a global variable, or empty for any other instance."""


def text_of(instances: Mapping[str, str]) -> str:
    """Return the text of the library; `instances` are the types of the global variables by their names."""
    return "\n".join(_lines(instances))


def _lines(instances: Mapping[str, str]) -> Iterator[str]:
    yield "TYPE"
    yield "  PTO_REF : BYTE;"
    for name, members in ENUMERATIONS.items():
        yield f"  {name} : ({', '.join(f'{member} := {number}' for member, number in members.items())});"
    for alias, name in ALIASES.items():
        if name == "PTO_REF" or name in ENUMERATIONS:
            yield f"  {alias} : {name};"
    yield "END_TYPE"
    yield "VAR_GLOBAL CONSTANT"
    kinds = {member: name for name, members in ENUMERATIONS.items() for member in members}
    for alias, member in ALIASES.items():
        if member in kinds:
            yield f"  {alias} : {kinds[member]} := {member};"
    yield "END_VAR"
    for block in BLOCK_TYPES.values():
        yield from _declared(block)
    if instances:
        yield "VAR_GLOBAL"
        for name, type_name in instances.items():
            yield f"  {name} : {type_name};"
        yield "END_VAR"


def _declared(block: BlockType) -> Iterator[str]:
    yield f"FUNCTION_BLOCK {block.name}"
    for section, pins in (("VAR_INPUT", block.inputs), ("VAR_OUTPUT", block.outputs)):
        yield section
        yield from (f"  {_pin(pin)}" for pin in pins)
        yield "END_VAR"
    yield "{native}"
    yield "END_FUNCTION_BLOCK"


def _pin(pin: Pin) -> str:
    initial = f" := {pin.default}" if pin.default and pin.type in ("BYTE", "DWORD") else ""
    return f"{pin.name} : {pin.type}{initial}; (* {pin.about} *)"


class Instances:
    """The blocks of one loaded program, by the addresses of their instances."""

    def __init__(self, clock: Clock, make: MakeBlock) -> None:
        self._clock, self._make = clock, make
        self._blocks: dict[int, Block] = {}
        self.names: Mapping[int, str] = {}
        """Names of the global variables by their addresses."""

    def library(self, instances: Mapping[str, str]) -> Library:
        blocks = {block.name.lower(): self._native(block) for block in BLOCK_TYPES.values()}
        return Library(NAME, text_of(instances), {}, blocks, frozenset({"PTO_REF_IN"}))

    def _native(self, type_: BlockType) -> NativeBlock:
        def run(address: int, *inputs: Value) -> Results:
            block = self._blocks.get(address)
            if block is None:
                block = self._blocks[address] = self._make(type_, self.names.get(address, ""))
            return block.run(self._clock.now_ns(), *(int(value) for value in inputs))

        return NativeBlock(run, forget=self._blocks.clear)
