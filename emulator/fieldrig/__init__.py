"""The public names of fieldrig: rigs, time, and what a device, a bus or a test of your own needs.

The package is the kernel: it knows no bus and no device, and finds both by their `kind`.  Messages are in the package
of their family (`fieldrig_bus.can`), tools in that of their device (`fieldrig_devices.conformance`).  Everything that
docs/reference/reference.md does not list is private and may move.
"""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "MS",
    "US",
    "ArgumentError",
    "Background",
    "Branch",
    "BranchMaker",
    "Bus",
    "BusError",
    "BusModel",
    "Claim",
    "Clock",
    "ConfigError",
    "ConfigFile",
    "ControlError",
    "Covered",
    "Delivery",
    "Device",
    "DirectBus",
    "EventNode",
    "Front",
    "Link",
    "LiveRig",
    "LiveRigMaker",
    "MasterRigMaker",
    "MemoryStore",
    "Mistake",
    "ModelBus",
    "Point",
    "ProgramBench",
    "ProgramMaker",
    "Recording",
    "Rig",
    "RigConfig",
    "RigError",
    "RigMaker",
    "S",
    "Settings",
    "Store",
    "StoreError",
    "T",
    "Timer",
    "UnmetError",
    "Value",
    "VirtualClock",
    "VirtualTimeError",
    "WrongKey",
    "covered",
    "from_dict",
    "load",
    "program",
    "read_trace",
    "restore",
    "virtual_time",
]

if TYPE_CHECKING:
    from fieldrig.bus import Bus, BusModel, Delivery, DirectBus, ModelBus
    from fieldrig.clock import MS, US, Clock, S, Timer, VirtualClock
    from fieldrig.config.rig_file import RigConfig, from_dict, load
    from fieldrig.coverage.covered import Covered, covered
    from fieldrig.device import Device, Point, Value
    from fieldrig.errors import ArgumentError, BusError, ConfigError, ControlError, Mistake, RigError, UnmetError
    from fieldrig.front import Front
    from fieldrig.link import Link
    from fieldrig.loop.background import Background
    from fieldrig.master_time.block import virtual_time
    from fieldrig.master_time.errors import VirtualTimeError
    from fieldrig.programs import ProgramBench, T, program
    from fieldrig.pytest_plugin import BranchMaker, LiveRigMaker, MasterRigMaker, ProgramMaker, RigMaker
    from fieldrig.real.live_rig import LiveRig
    from fieldrig.recording.recording import Recording
    from fieldrig.settings import Claim, ConfigFile, Settings, WrongKey
    from fieldrig.storage.store import MemoryStore, Store, StoreError, restore
    from fieldrig.traces.trace_files import read_trace
    from fieldrig.virtual.branch import Branch
    from fieldrig.virtual.node import EventNode
    from fieldrig.virtual.rig import Rig
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig.loop.background": "Background",
            "fieldrig.bus": "Bus BusModel Delivery DirectBus ModelBus",
            "fieldrig.clock": "MS S US Clock Timer VirtualClock",
            "fieldrig.config.rig_file": "RigConfig from_dict load",
            "fieldrig.coverage.covered": "Covered covered",
            "fieldrig.device": "Device Point Value",
            "fieldrig.errors": "ArgumentError BusError ConfigError ControlError Mistake RigError UnmetError",
            "fieldrig.front": "Front",
            "fieldrig.link": "Link",
            "fieldrig.master_time.block": "virtual_time",
            "fieldrig.master_time.errors": "VirtualTimeError",
            "fieldrig.real.live_rig": "LiveRig",
            "fieldrig.recording.recording": "Recording",
            "fieldrig.traces.trace_files": "read_trace",
            "fieldrig.virtual.branch": "Branch",
            "fieldrig.virtual.node": "EventNode",
            "fieldrig.programs": "ProgramBench T program",
            "fieldrig.pytest_plugin": "BranchMaker LiveRigMaker MasterRigMaker ProgramMaker RigMaker",
            "fieldrig.virtual.rig": "Rig",
            "fieldrig.settings": "Claim ConfigFile Settings WrongKey",
            "fieldrig.storage.store": "MemoryStore Store StoreError restore",
        },
    )
