"""PAM applications with ports to a PLC: the listings of the manual, and the PAM's side of tests."""

from collections.abc import Sequence
from functools import cache
from typing import Any, TypeVar

from pam_programs import HEADER

from fieldrig.clock import MS
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.items import Program
from fieldrig_devices.pam.language.ports import PortVariable, ports_of
from fieldrig_devices.pam.language.words import PREDECLARED
from fieldrig_devices.pam.ports import Ports
from fieldrig_devices.pam.ports.masters.rs422 import Rs422Master
from fieldrig_devices.pam.ports.masters.s5 import S5Master
from fieldrig_devices.pam.ports.masters.script import Script, carry_out
from fieldrig_devices.pam.ports.masters.vme import VmeMaster
from fieldrig_devices.pam.ports.memory import Memory
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.runtime.item import Item, RoutineRef

T = TypeVar("T")

GROUP = "NODES_GROUP NGR_PrintHeads; NUMBER = 4; END\n"

VME = """
VME DUALPORT
  SPECS
    DEFAULT_PERIOD = 20 ;
    MASTER_READY_TIMEOUT = 500 ;
    MASTER_CONFIGURATION_TIMEOUT = NONE ;
    MASTER_INACTIVITY_TIMEOUT = 500 ;
  END_SPECS

  INPUT FLAG_VAR  DFI_MachRunning ; // single variable

  INPUT FLAG_VAR  DFI_MachAlarm ; // single variable with period spec.
    PERIOD = 10 ;
  END

  INPUT FLAG_VAR  DFI_MachHeadReady ; // multiple variable with dynamic
    NODES_GROUP = NGR_PrintHeads ; // configuration
  END

  INPUT FLAG_VAR  DFI_MachHeadStopped ; // multiple variable with
    NUMBER = 6 ; // static configuration
  END

  INPUT WORD_VAR  DWI_MachPressure ;
    PERIOD = 5 ;
  END

  INPUT LONG_VAR  DLI_MachHeadSpeed ;
    NUMBER = 6 ;
  END

  INPUT REAL_VAR  DRI_MachHeadFactor ;
    NUMBER = 6 ;
  END

  OUTPUT FLAG_VAR  DFO_MachStopped ;

  OUTPUT WORD_VAR  DWO_MachCurrentPressure ;
    PERIOD = 50 ;
  END

  OUTPUT LONG_VAR  DLO_MachHeadPosition ;
    NODES_GROUP = NGR_PrintHeads ;
  END

  OUTPUT REAL_VAR  DRO_MachHeadLevel ;
    NODES_GROUP = NGR_PrintHeads ;
  END

END_DUALPORT
"""
"""The listing of manual lines 10207 to 10259; its wrapped comments are joined, and one name of the group corrected."""

SIMATIC = """
#define MaxHead 48
DUAL_PORT
  START_ADDRESS      = 0 ;
  LENGTH             = 4096 ;
  FIFO_IN_START      = 0 ;
  FIFO_IN_HEAD       = #0100 ;
  FIFO_IN_TAIL       = #0102 ;
  FIFO_OUT_START     = #0800 ;
  FIFO_OUT_HEAD      = #0900 ;
  FIFO_OUT_TAIL      = #0902 ;
  WATCH_DOG         = #0FFE ;

/* Fatal error panel is located at watch_dog location - #0E */
/* so last output can be located at watch_dog - #10 = #0FEE */

  PAM_READY          = #0FEE BIT 3 ;
  DUALPORT_READY     = #0FEE BIT 4 ;
  HOST_READY         = #0104 BIT 4 ;
  PERIOD              = 10 ;
  MASTER_READY_TIMEOUT = 20000; /* [ms] */
  MASTER_CONFIGURATION_TIMEOUT = NONE; /* infinite */
  MASTER_INACTIVITY_TIMEOUT = 500; /* [ms] */
END
DUALPORT_IN FLAG_VAR DFI_MachRunning ; ADDRESS = #104 BIT 0 ; END
DUALPORT_IN FLAG_VAR DFI_MachEmergency ; ADDRESS = #105 BIT 3 ; END    // cell #104 bit 11
DUALPORT_IN FLAG_VAR DFI_MachHeadReady ;
    NODES_GROUP = NGR_PrintHeads ;
    RESERVED = MaxHead ;
    ADDRESS = #106 ;    // size is 48 / 8 = 6 bytes
END
DUALPORT_IN FLAG_VAR DFI_MachHeadStopped ;
    NODES_GROUP = NGR_PrintHeads ; RESERVED = MaxHead ; ADDRESS = #10C ;
END
DUALPORT_IN WORD_VAR DWI_MachPressure ; ADDRESS = #120 ; END
DUALPORT_IN WORD_VAR DWI_MachHeadSpeed ;
    NODES_GROUP = NGR_PrintHeads ; RESERVED = MaxHead ; ADDRESS = #122 ;    // size is 48 * 2 = 96 bytes
END
DUALPORT_IN FLAG_VAR DFI_MachHeadTorque ;
    NODES_GROUP = NGR_PrintHeads ; RESERVED = MaxHead ; ADDRESS = #182 ;
END
DUALPORT_OUT FLAG_VAR DFO_MachStopped ; ADDRESS = #904 BIT 5 ; END
DUALPORT_OUT FLAG_VAR DFO_MachOk ; ADDRESS = #905 BIT 5; END    // cell #904 bit 13
DUALPORT_OUT FLAG_VAR DFO_MachHeadBusy ;
    NODES_GROUP = NGR_PrintHeads ; RESERVED = MaxHead ; ADDRESS = #906 ;
END
DUALPORT_OUT FLAG_VAR DFO_MachHeadFastSpeed ;
    NODES_GROUP = NGR_PrintHeads ; RESERVED = MaxHead ; ADDRESS = #90C ;
END
DUALPORT_OUT WORD_VAR DWO_MachCurrentPressure ; ADDRESS = #920 ; END
DUALPORT_OUT WORD_VAR DWO_MachHeadPosition ;
    NODES_GROUP = NGR_PrintHeads ; RESERVED = MaxHead ; ADDRESS = #922 ;
END
DUALPORT_OUT FLAG_VAR DFO_MachHeadLevel ;
    NODES_GROUP = NGR_PrintHeads ; RESERVED = MaxHead ; ADDRESS = #982 ;
END
"""
"""The listings of manual lines 10608 to 10631 and 10811 to 10887."""

RS422 = """
RS422 PORT
  SPECS
    PERIOD = 20 ;
    MASTER_READY_TIMEOUT = 20000 ;
    MASTER_CONFIGURATION_TIMEOUT = 5000 ;
    MASTER_INACTIVITY_TIMEOUT = 2000 ;
    PAM_WATCHDOG_MESSAGE_PERIOD = 500 ;

  END_SPECS

  INPUT FLAG_VAR RFI_MachRunning ; // single variable
  INPUT FLAG_VAR RFI_MachHeadReady ; // multiple variable with dynamic
    NODES_GROUP = NGR_PrintHeads ; // configuration
  END

  INPUT FLAG_VAR RFI_MachHeadStopped ; // multiple variable with
    NUMBER = 6 ; // static configuration
  END

  INPUT WORD_VAR RWI_MachPressure ;
  INPUT LONG_VAR RLI_MachHeadSpeed ;
    NUMBER = 6 ;
  END

  INPUT REAL_VAR RRI_MachHeadFactor ;
    NUMBER = 6 ;
  END

  OUTPUT FLAG_VAR RFO_MachStopped ;
  OUTPUT WORD_VAR RWO_MachCurrentPressure ;
  END

  OUTPUT LONG_VAR RLO_MachHeadPosition ;
    NODES_GROUP = NGR_PrintHeads ;
  END

  OUTPUT REAL_VAR RRO_MachHeadLevel ;
    NODES_GROUP = NGR_PrintHeads ;
  END

END_PORT
"""
"""The listing of manual lines 11284 to 11328."""


class FakeKernel:
    """The run time as ports see it."""

    def __init__(self) -> None:
        self.thirds = 3
        self.cycle_number = 0
        self.events: list[str] = []
        self.reports: list[tuple[str, Sequence[int]]] = []

    def touched(self, name: str) -> None:
        self.events.append(name)

    def start_routine(self, routine: RoutineRef) -> None:
        raise AssertionError(routine)

    def report(self, code: str, details: Sequence[int] = ()) -> None:
        self.reports.append((code, details))

    @property
    def codes(self) -> list[str]:
        return [code for code, _ in self.reports]


@cache
def compiled(text: str) -> Program:
    """The program of an application; it is never changed."""
    program, mistakes = checked(HEADER + text, "ports.pam")
    assert not mistakes
    return program


class PortBench:
    """The ports of an application in a PAM with a basic cycle of 1 ms."""

    def __init__(
        self, text: str = GROUP + VME, options: PortOptions | None = None, memory: Memory | None = None
    ) -> None:
        program = compiled(text)
        self.plans = ports_of(program)
        self.kernel, self.memory = FakeKernel(), memory or Memory()
        self.inactive: set[int] = set()
        self.options = options
        self.ports = Ports(
            program,
            self.memory,
            self.kernel,
            options,
            lambda _group, component: component not in self.inactive,
            self._on_sent,
        )
        self.line: list[bytes] = []
        """Bytes that the PAM has sent on the RS422 line."""
        self.master: Rs422Master | None = None
        """The master at the line."""
        self.now_ns = 0
        self.power_on_ns = 0
        """The PAM does nothing before this instant, when it begins by itself if it is not 0."""

    def begin(self) -> None:
        self.ports.begin(self.now_ns)

    def cycles(self, number: int = 1) -> None:
        for _ in range(number):
            self.now_ns += MS
            if self.now_ns == self.power_on_ns:
                self.begin()
            if self.now_ns >= self.power_on_ns:
                self.ports.poll(self.now_ns)
                if self.ports.may_run:
                    self.ports.take()
                    self.ports.give()
                self.kernel.cycle_number += 1
            if self.master is not None:
                self.master.poll(self.now_ns)

    def connect(self, **options: Any) -> Rs422Master:
        """Put a master at the line, and let it ask for a session."""
        self.master = Rs422Master(self.variables, self.ports.receive, **options)
        self.master.begin(self.now_ns)
        return self.master

    def _on_sent(self, data: bytes) -> None:
        self.line.append(data)
        if self.master is not None:
            self.master.receive(data)

    def play(self, script: Script[T]) -> T:
        """Run a script of a master; the PAM goes on during its pauses."""
        return carry_out(script, self.memory, lambda seconds: self.cycles(round(seconds * 1000)))

    def item(self, name: str, index: int = 0) -> Item:
        return self.ports.items[PREDECLARED.get(name, name)][index]

    def value(self, name: str, index: int = 0) -> object:
        return self.item(name, index).value()

    @property
    def variables(self) -> Sequence[PortVariable]:
        return [variable for plan in self.plans for variable in plan.variables]


def started_vme(text: str = GROUP + VME, options: PortOptions | None = None) -> tuple[PortBench, VmeMaster]:
    """A bench whose master has started the application."""
    bench = PortBench(text, options)
    bench.begin()
    master = VmeMaster(bench.variables, options)
    bench.play(master.start_up())
    return bench, master


def started_simatic(options: PortOptions | None = None) -> tuple[PortBench, S5Master]:
    """A bench with the listing of Simatic whose host has started the application."""
    bench = PortBench(GROUP + SIMATIC, options)
    bench.begin()
    master = S5Master(bench.plans[0], options)
    bench.play(master.start_up())
    return bench, master


def started_rs422() -> tuple[PortBench, Rs422Master]:
    """A bench with the listing of RS422 whose master runs."""
    bench = PortBench(GROUP + RS422)
    bench.begin()
    master = bench.connect()
    bench.cycles(300)
    assert master.is_running
    return bench, master
