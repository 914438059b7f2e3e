"""Comparators and multi-comparators in programs (sections 2.21 and 2.25 of the language's digest)."""

from typing import Any

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.parameters import PeriodOfBlock, StartedRoutine
from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.objects.transformer_item import TransformerItem
from fieldrig_devices.pam.pipes.comparator import Comparator
from fieldrig_devices.pam.pipes.multi_comparator import MultiComparator, Reference, Trace


class ComparatorItem(TransformerItem):
    block: Comparator
    routine = StartedRoutine("block", "routine")
    reverse_routine = StartedRoutine("block", "reverse_routine")

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared, site)
        self.block = Comparator(0.0)
        self.declare(declared)

    def declare(self, declared: Declared) -> None:
        is_through_zero = "THROUGH_ZERO_REFERENCE" in declared
        reference = declared.number("THROUGH_ZERO_REFERENCE" if is_through_zero else "REFERENCE")
        self.block.set_reference(reference, is_through_zero=is_through_zero)
        self.routine, self.reverse_routine = declared.routine("ROUTINE"), declared.routine("REVERSE_ROUTINE")

    def parameter(self, _name: str) -> float:
        """Return the reference, of either mode."""
        return self.block.reference

    def set_parameter(self, name: str, value: Any) -> None:
        """Set a routine, or a reference, which selects the mode as well (PAML-463)."""
        if name in ("REFERENCE", "THROUGH_ZERO_REFERENCE"):
            self.block.set_reference(float(value), is_through_zero=name != "REFERENCE")
            self.site.changes += 1
            self.site.kernel.touched(self.name)
        else:
            super().set_parameter(name, value)


class MultiComparatorItem(TransformerItem):
    """A changed origin works from the next `learn` or `execute` on."""

    block: MultiComparator
    value_period = PeriodOfBlock("value_period")
    time_origin_routine = StartedRoutine("block", "origin_routine")

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared, site)
        self.block = MultiComparator(Reference("POSITIVE", "IMMEDIATE", 0.0), declared.number("VALUE_PERIOD") or None)
        self.declare(declared)
        self.traces = [TraceItem(part, site, self.block) for part in declared.parts]

    def declare(self, declared: Declared) -> None:
        self.time_origin_slope: Any = declared.word("TIME_ORIGIN_SLOPE")
        self.time_origin_compare_mode: Any = declared.word("TIME_ORIGIN_COMPARE_MODE")
        self.time_origin_reference = declared.number("TIME_ORIGIN_REFERENCE")
        self.time_origin_routine = declared.routine("TIME_ORIGIN_ROUTINE")

    def do_learn(self) -> None:
        self.block.origin = self._origin()
        self.block.learn()

    def do_execute(self) -> None:
        self.block.origin = self._origin()
        self.block.execute()

    def _origin(self) -> Reference:
        return Reference(self.time_origin_slope, self.time_origin_compare_mode, float(self.time_origin_reference))

    def ask_execute(self) -> bool:
        return self.block.is_executing


class TraceItem(ObjectItem):
    """A trace of a multi-comparator."""

    routine = StartedRoutine("trace", "routine")

    def __init__(self, declared: Declared, site: Site, block: MultiComparator) -> None:
        super().__init__(declared.name)
        self.site, self._block = site, block
        self.trace = Trace()
        block.traces.append(self.trace)
        self.routine = declared.routine("ROUTINE")

    def do_install_reference(self, slope: Any, mode: Any, position: float, delay_s: float) -> None:
        self.site.changes += 1
        self.trace.install(Reference(slope, mode, float(position)), float(delay_s), self._block.value_period)
