"""The texts of system messages, by origin and number, in our own words (appendix B, section 14 of the digest)."""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.pam.panel.codes import Code, Kind

_BOOT: Final = {
    0x022: "the application in RAM is corrupted: download it again",
    0x023: "checksum error in the application in RAM",
    0x024: "the download failed: try again",
    0x025: "the application has the wrong link address",
    0x027: "the application was compiled with the wrong version",
    0x028: "this PAM has the wrong firmware version",
}
_KERNEL: Final = {
    0x001: "not enough heap for a mailbox",
    0x00F: "not enough heap for a task",
    0x011: "not enough heap for a process",
    0x013: "not enough heap for a signal",
    0x018: "not enough heap for the library",
    0x060: "the basic cycle takes too long",
    0xFF1: "operation fault",
    0xFF2: "arithmetic fault: integer overflow or division by zero",
    0xFF3: "floating-point fault: overflow, invalid operation or division by zero",
}
_REAL_TIME_KERNEL: Final = {
    0x003: "not enough heap for a process",
    0x02C: "a sequence has exceeded its workspace",
    0x02D: "stopped by an earlier error",
    0x031: "EXCEPTION with a negative time-out",
    0x032: "CONDITION with a negative time-out",
    0x033: "XEQ_TASK for a task that is running",
    0x050: "not enough heap for the processes of a multiple task",
}
_SMART_IO: Final = {
    0x00C: "fault of a SMART_IO",
    0x00E: "fault of an output",
    0x010: "DC motor",
    0x01A: "a SMART_IO refuses the declaration of an I/O variable",
}
_RING: Final = {
    0x001: "the hardware of the ring cannot be initialized",
    0x002: "a peripheral is on the ring and not declared",
    0x003: "a declared peripheral is not on the ring",
    0x004: "a peripheral is of another type than declared",
    0x005: "a peripheral does not report that it is ready",
    0x006: "the number of peripherals differs from the declarations",
    0x009: "the reception FIFO is full",
    0x00C: "the optical link is interrupted",
    0x00E: "a frame with a CRC error",
    0x010: "the optical link is interrupted",
    0x016: "too many peripherals for the basic cycle",
}
_AUTOMATE: Final = {
    0x001: "memory cannot be allocated",
    0x006: "too many changes of outputs: the FIFO to the ring is full",
    0x008: "DualPort overflow",
    0x00B: "a SMART_IO acknowledges a wrong command",
    0x011: "unknown address in the input FIFO of the DualPort",
    0x013: "the ring has stopped",
    0x014: "error in the configuration of a SMART_IO",
    0x015: "a SMART_IO refuses its initialization",
    0x016: "a SMART_IO does not acknowledge its configuration",
    0x017: "a SMART_IO does not acknowledge the order to run",
    0x01D: "unknown variable ID",
    0x01E: "DualPort watchdog",
    0x01F: "an axis refuses its declaration",
    0x020: "host not ready",
    0x021: "time-out while an I/O is read over the ring",
    0x023: "the event FIFO is full",
    0x025: "node initialization: no peripheral of a NODE is present",
    0x028: "unknown CRC of a VME output",
    0x029: "unknown key of a VME input",
    0x02A: "wrong item index of a VME variable",
    0x02B: "the buffer of VME events is full",
    0x02D: "wrong address of an ST1 I/O",
    0x035: "RS422: no user activity",
    0x036: "RS422: command refused in this phase",
    0x037: "RS422: unknown command",
    0x038: "RS422: no room in the send queue",
    0x039: "RS422: communication disconnected",
    0x03A: "RS422: communication error",
    0x03B: "RS422: unknown CRC of an output",
    0x03C: "RS422: unknown key of an input",
    0x03D: "RS422: wrong configuration",
    0x03E: "RS422: wrong class of an input",
}
_MESSAGES: Final = {
    0x001: "debugger attached",
    0x002: "waiting for a debugger command",
    0x003: "configuration of an empty ring checked",
    0x004: "configuration of the ring checked",
    0x005: "no DualPort declared",
    0x006: "Simatic DualPort initialized",
    0x007: "VME DualPort initialized",
    0x008: "no axis declared",
    0x009: "no interpolation group declared",
    0x00A: "axes initialized",
    0x00B: "peripherals of the ring ready",
    0x00C: "ring ready without peripherals",
    0x00D: "all SMART_IO configured",
    0x00E: "first values of all inputs received",
    0x00F: "axes running",
    0x010: "no axes to start",
    0x011: "inputs of the DualPort initialized",
    0x012: "variables of the VME DualPort configured",
    0x013: "all SMART_IO running",
    0x014: "all I/O of ST1 configured",
    0x015: "linked outputs installed",
    0x016: "power-on actions started",
    0x017: "working",
    0x018: "power-on actions completed",
    0x019: "evaluator started",
    0x01A: "watch started",
    0x01B: "waiting for synchronization with the PLC",
    0x01C: "waiting for synchronization with the VME master",
    0x01D: "waiting for the PLC",
    0x01E: "working without PLC",
    0x01F: "working without VME master",
    0x020: "RS422 port declared",
    0x021: "RS422 on line",
    0x022: "RS422 configured",
    0x023: "RS422 started",
    0x024: "RS422 waiting for a connection",
}
_ORIGINS: Final[Mapping[int, Mapping[int, str]]] = {
    1: _BOOT,
    2: _KERNEL,
    3: _REAL_TIME_KERNEL,
    4: _SMART_IO,
    6: _RING,
    7: _AUTOMATE,
}
_NAMES: Final[Mapping[int, str]] = {
    0: "application",
    1: "boot",
    2: "kernel",
    3: "rt_kernel",
    4: "smart_io",
    6: "ring",
    7: "automate",
}


def origin_name(code: Code) -> str:
    """Return the name of what a message comes from, as the debugger shows it."""
    return _NAMES.get(code.origin, "system")


def text_of(code: Code) -> str:
    """Return the text of a system message; empty for a message of the application, which brings its own."""
    if code.origin == 7 and code.kind is Kind.MESSAGE:
        return _MESSAGES.get(code.number, "")
    return _ORIGINS.get(code.origin, {}).get(code.number, "")
