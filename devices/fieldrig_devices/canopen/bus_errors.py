"""What the node makes of its CAN controller's state: errors that it reports, and bus-off as a communication error.

Source: CiA 301 table 26 (8120h, 8140h), 7.5.2.32 (1029h: bus-off).  A node that is the first on its bus gets no
acknowledgement and turns error passive; that is no error to report before anybody else was heard.  A bus that says
nothing of the state, as one on UDP, never leaves 'error active'.
"""

from collections.abc import Callable

from fieldrig_bus.can.notices import BusState, CanState
from fieldrig_devices.canopen import emcy
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import Reset, Service


class BusErrors(Service):
    """Tells `on_bus_off` when the controller has left the bus, and when it is back."""

    def __init__(self, port: Port, errors: "emcy.Emcy", on_bus_off: Callable[[bool], None]) -> None:
        self._port, self._errors, self._on_bus_off = port, errors, on_bus_off
        self._state = CanState.ACTIVE
        self.times_off = 0
        """How often the controller has left the bus."""
        port.on_bus_state(self._on_state)

    def reset(self, scope: Reset) -> None:
        """The controller is reset with the node only as far as its errors are concerned: its state is the bus's."""
        self._report(self._state)

    def _on_state(self, notice: BusState) -> None:
        before, self._state = self._state, notice.state
        self._report(notice.state)
        if notice.state is CanState.BUS_OFF:
            self.times_off += 1
            self._on_bus_off(True)
        elif before is CanState.BUS_OFF:
            self._on_bus_off(False)
            self._errors.raise_error(emcy.Error.RECOVERED_FROM_BUS_OFF, emcy.COMMUNICATION)
            self._errors.clear_error(emcy.Error.RECOVERED_FROM_BUS_OFF)

    def _report(self, state: CanState) -> None:
        if state is CanState.PASSIVE and not self._port.has_heard:
            return
        if state is CanState.PASSIVE:
            self._errors.raise_error(emcy.Error.ERROR_PASSIVE, emcy.COMMUNICATION)
        elif state is not CanState.BUS_OFF:
            self._errors.clear_error(emcy.Error.ERROR_PASSIVE)
