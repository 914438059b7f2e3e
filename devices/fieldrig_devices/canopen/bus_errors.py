"""The node's reaction to the state of its CAN controller: EMCY messages, and bus-off as a communication error.

Source: CiA 301 table 26 (8120h, 8140h), 7.5.2.32 (1029h: bus-off).  The first node on a bus gets no acknowledgement and
becomes error passive; it doesn't report that as an error before it has received a frame.  The error is over below the
warning limit of interface chips: on a disturbed bus a counter goes around 128 with each frame, and a message for each
of its passes would fill the bus.  On a bus that doesn't report the state, such as one on UDP, the node stays 'error
active'.
"""

from collections.abc import Callable

from fieldrig_bus.can.notices import BusState, CanState
from fieldrig_devices.canopen import emcy
from fieldrig_devices.canopen.port import Port
from fieldrig_devices.canopen.service import Reset, Service


class BusErrors(Service):
    """Reports errors of the controller, and calls `on_bus_off` with True at bus-off and with False after recovery."""

    def __init__(self, port: Port, errors: "emcy.Emcy", on_bus_off: Callable[[bool], None]) -> None:
        self._port, self._errors, self._on_bus_off = port, errors, on_bus_off
        self._state = CanState.ACTIVE
        self.times_off = 0
        """Number of times that the controller has gone bus-off."""
        port.on_bus_state(self._on_state)

    def reset(self, scope: Reset) -> None:
        """Report the controller's errors again; its state belongs to the bus and survives a reset of the node."""
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
        elif state is CanState.ACTIVE:
            self._errors.clear_error(emcy.Error.ERROR_PASSIVE)
