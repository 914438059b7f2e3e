"""Correctors in programs: events with their instants (section 2.23 of the language's digest)."""

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.inputs import BinaryInput
from fieldrig_devices.pam.objects.parameters import AboveZero, OfBlock
from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.objects.transformer_item import TransformerItem
from fieldrig_devices.pam.pipes.corrector import Corrector, Settings


class CorrectorItem(TransformerItem):
    block: Corrector
    correction_slope = AboveZero()
    correction_level = AboveZero()
    delay_compensation = OfBlock("delay_s")

    def __init__(self, declared: Declared, site: Site, trigger: BinaryInput) -> None:
        super().__init__(declared, site)
        settings = Settings(
            is_immediate=declared.word("CORRECTION_MODE") == "IMMEDIATE",
            is_output=declared.word("CORRECTION_REFERENCE") == "OUTPUT",
            is_repetitive=declared.word("TRIGGER_MODE") == "REPETITIVE",
            value_period=declared.number("VALUE_PERIOD") or None,
            is_input_sign_reversed=site.readings.corrector_input_sign_reversed,
            is_ended_by_trigger_off=site.readings.trigger_off_ends_correction,
        )
        self.block = Corrector(settings, 1.0, 1.0, 0.0)
        self.flowed_in = 0
        """The basic cycle of the last value of the flow."""
        self.declare(declared)
        trigger.watchers.append(self._on_event if site.readings.corrector_takes_both_edges else self._on_trigger)

    def declare(self, declared: Declared) -> None:
        self.correction_slope, self.correction_level = (
            declared.number("CORRECTION_SLOPE"),
            declared.number("CORRECTION_LEVEL"),
        )
        self.delay_compensation = declared.number("DELAY_COMPENSATION")

    def _on_trigger(self, is_true: bool, age_us: int) -> None:
        if is_true:
            self._on_event(is_true, age_us)

    def _on_event(self, _is_true: bool, age_us: int) -> None:
        """Take the event at its instant: the age of the input, and the ways over the ring (PAML-513, G-47).

        A value of the flow works in the axis a delay after it has been computed, so an event belongs to an earlier one.
        """
        if not self.block.is_active:
            return
        site, readings = self.site, self.site.readings
        self.block.slope, self.block.level = self.correction_slope, self.correction_level
        cycles = readings.report_delay_cycles - (site.cycle - self.flowed_in)
        delay_s = readings.set_point_delay_periods * self.block.period_s
        self.block.event(age_us / 1e6 + cycles * site.cycle_s + delay_s)
        site.changes += 1
        site.kernel.touched(self.name)

    def do_trigger(self, must_be: float) -> None:
        self.block.trigger(float(must_be))

    def do_trigger_off(self) -> None:
        self.block.trigger_off()

    def do_start_correction(self, value: float | None = None) -> None:
        self.block.slope, self.block.level = self.correction_slope, self.correction_level
        self.block.start_correction(value)

    def ask_triggered(self) -> bool:
        return self.block.triggered

    def ask_correction(self) -> float:
        return self.block.correction

    def ask_latched_value(self) -> float:
        return self.block.latched[0]

    def ask_latched_d_value(self) -> float:
        return self.block.latched[1]

    def ask_latched_dd_value(self) -> float:
        return self.block.latched[2]
