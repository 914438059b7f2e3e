"""A PAM from power-on to power-off: its ring comes up, its ports find their masters, and then its programs run.

The order is that of sections 11.5 and 12.3: objects and ring first, then the ports to a PLC, then linked outputs,
power-on actions and tasks.  The manual does not give the order of ring and ports; here the ring is first, so that its
nodes do not wait for a PLC that is absent.  A fatal error ends everything: programs, the watchdog of the ports, and the
cycles of the ring, so that the nodes stop as they do after a break (F 2, "PAM system error").
"""

from collections.abc import Callable, Mapping, Sequence
from enum import Enum

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.ring.pam.message import RingMessage
from fieldrig_devices.pam.declared_nodes import declared_nodes
from fieldrig_devices.pam.objects.application import ApplicationObjects, Shapes
from fieldrig_devices.pam.objects.outputs import Volts
from fieldrig_devices.pam.panel.codes import code_of
from fieldrig_devices.pam.ports import Ports
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.runtime.compiler import Compiled
from fieldrig_devices.pam.runtime.item import Item, Part
from fieldrig_devices.pam.runtime.runtime import OnMessage, Runtime
from fieldrig_devices.pam.settings import PamSettings
from fieldrig_devices.pamring.frames import NodeType, Report
from fieldrig_devices.pamring.master import RingMaster
from fieldrig_devices.pamring.start_up import Phase

NO_AXES = "07..M008"
NO_INTERPOLATION_GROUP = "07..M009"
AXES_INITIALIZED = "07..M00A"
AXES_RUNNING = "07..M00F"
NO_AXES_STARTED = "07..M010"


class PowerState(Enum):
    """The state of a PAM that has power."""

    RING = "ring"
    """The ring comes up."""
    PORTS = "ports"
    """The ports wait for their masters."""
    RUNNING = "running"
    FATAL = "fatal"


class PanelPart:
    """The object PamDisplay as a part of the application."""

    def __init__(self, items: Mapping[str, Sequence[Item]]) -> None:
        self.items = items

    def take(self) -> None:
        """Do nothing: the panel has no inputs."""

    def give(self) -> None:
        """Do nothing: the display shows at once what it is given."""


class PowerCycle:
    """Everything that begins again at power-on and at a reset."""

    def __init__(
        self,
        clock: Clock,
        ring: Link[RingMessage],
        compiled: Compiled,
        settings: PamSettings,
        memory: Memory,
        panel: Part,
        *,
        shapes: Shapes,
        volts: Volts,
        rs422: Callable[[bytes], None],
        on_message: OnMessage,
    ) -> None:
        """`rs422` sends on the line to the RS422 master, and `on_message` takes all messages."""
        self._clock, self._say = clock, on_message
        self._panel, self._on_message = panel, on_message
        self.state = PowerState.RING
        self._has_begun = False
        self.runtime = Runtime(compiled, self._on_kernel_message, settings.limits(), settings.programs)
        self.ring = RingMaster(
            clock,
            ring,
            settings.ring_settings(compiled.thirds),
            declared_nodes(compiled.program),
            self,
            self._on_kernel_message,
        )
        self.objects = ApplicationObjects(
            compiled.program, self.runtime, self.ring, readings=settings.objects, shapes=shapes, volts=volts
        )
        self.ports = Ports(compiled.program, memory, self.runtime, settings.ports, self.objects.is_active, rs422)
        for node in self.objects.nodes:
            self.ring.configure(node.address, node.items)
        self._axes = [node for node in self.objects.nodes if node.node_type is NodeType.ST1]

    @property
    def application(self) -> Runtime | None:
        """The programs, from the moment at which they begin."""
        return self.runtime if self._has_begun else None

    def start(self) -> None:
        """Power on."""
        self._say_all(*([AXES_INITIALIZED] if self._axes else [NO_AXES]), NO_INTERPOLATION_GROUP)
        self.ring.start()

    def cycle(self) -> None:
        """Run a basic cycle."""
        self.ring.take()
        step = _STEPS.get(self.state)
        if step is not None:
            step(self)
        if self.state is not PowerState.FATAL:
            self.ring.give()

    def on_report(self, address: int, report: Report) -> None:
        """Hand a report of a node to the objects (`ReportHandler`)."""
        self.objects.on_report(address, report)

    # ---- steps

    def _bring_up_ring(self) -> None:
        if self.ring.phase is not Phase.RUNNING:
            return
        missing = [node.address for node in self.objects.nodes if node.address not in self.ring.active]
        self.objects.leave_out(missing)
        self._say_all(AXES_RUNNING if self._axes else NO_AXES_STARTED)
        self.state = PowerState.PORTS
        self.ports.begin(self._clock.now_ns())
        self._wait_for_masters()

    def _wait_for_masters(self) -> None:
        self.ports.poll(self._clock.now_ns())
        if self.state is PowerState.PORTS and self.ports.may_run:
            self.state, self._has_begun = PowerState.RUNNING, True
            self.runtime.start(self.objects, [self.ports, self._panel])
            self.runtime.cycle()

    def _run(self) -> None:
        self.ports.poll(self._clock.now_ns())
        if self.state is PowerState.RUNNING:
            self.runtime.cycle()

    # ---- messages

    def _say_all(self, *codes: str) -> None:
        for code in codes:
            self._say(code, (), "")

    def _on_kernel_message(self, code: str, details: Sequence[int], text: str) -> None:
        if code_of(code).is_fatal:
            self.state = PowerState.FATAL
        self._on_message(code, details, text)


_STEPS: Mapping[PowerState, Callable[[PowerCycle], None]] = {
    PowerState.RING: PowerCycle._bring_up_ring,
    PowerState.PORTS: PowerCycle._wait_for_masters,
    PowerState.RUNNING: PowerCycle._run,
}
