"""A master in virtual time: what a switch of threads and a frame cost, and a homing of a minute by python canopen.

Times are processor seconds of this process, because the host may have other work.  The homing is that of the tests,
`can_homing`.
"""

import threading
import time
from collections.abc import Callable
from typing import Any

from report import COMPARED, Report, progress

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.master_time.active import any_scheduler
from fieldrig.master_time.block import virtual_time
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame

SWITCHES, FRAMES = 20_000, 5_000
CAN: dict[str, Any] = {"kind": "can.virtual", "bitrate": None, "socketcand": "127.0.0.1:29536"}
HEARING: dict[str, Any] = {"time": "virtual", "buses": {"can0": CAN}, "devices": {}}


def cpu_s(work: Callable[[], object]) -> float:
    start_s = time.process_time()
    work()
    return time.process_time() - start_s


def switch_s() -> float:
    """Return the processor time of one switch, between two threads that give way to each other."""

    def give_way() -> None:
        scheduler = any_scheduler()
        assert scheduler is not None
        for _ in range(SWITCHES // 2):
            scheduler.give_way()

    with Rig(from_dict({"time": "virtual", "buses": {}, "devices": {}})) as rig, virtual_time(rig):
        other = threading.Thread(target=give_way)
        other.start()
        taken_s = cpu_s(give_way)
        other.join()
    return taken_s / SWITCHES


def plain_frame_s() -> float:
    """Return the processor time of a frame between two members that the test moves by hand."""
    with Rig(from_dict(HEARING)) as rig:
        heard: list[Any] = []
        rig.attach("hearer").link("can0").on_receive(heard.append)
        sender = rig.attach("sender").link("can0")

        def send() -> None:
            for _ in range(FRAMES):
                sender.send(CanFrame(0x123, b"12345678"))
                rig.run_until(rig.now_ns + MS)

        taken_s = cpu_s(send)
        assert len(heard) == FRAMES
    return taken_s / FRAMES


def frame_s(**where: Any) -> float:
    """Return the same between two ends of python-can in virtual time."""
    import can

    with Rig(from_dict(HEARING)) as rig, virtual_time(rig), can.Bus(**where) as hearer, can.Bus(**where) as sender:
        message = can.Message(arbitration_id=0x123, data=b"12345678", is_extended_id=False)

        def send() -> None:
            for _ in range(FRAMES):
                sender.send(message)
                assert hearer.recv(1) is not None
                time.sleep(0.001)

        taken_s = cpu_s(send)
    return taken_s / FRAMES


def run() -> Report:
    from can_homing import FIELDRIG, SOCKETCAND, homed

    report = Report(
        "A master in virtual time", "This table shows what an unchanged master in virtual time costs.", COMPARED
    )
    progress("a master in virtual time: switches and frames")
    switch, plain = switch_s(), plain_frame_s()
    report.add("a switch between two threads", f"{switch * 1e6:.1f} us", "20 us", 20e-6 / switch)
    report.add("a frame between two members, moved by hand", f"{plain * 1e6:.0f} us", "itself", 1.0)
    for name, where in (("fieldrig", FIELDRIG), ("socketcand", SOCKETCAND)):
        cost = frame_s(**where)
        report.add(f"a frame by python-can, {name}", f"{cost * 1e6:.0f} us", "moved by hand", plain / cost)
    homed(FIELDRIG)
    for name, sync_s, goal_s in (("a homing of a minute", None, 1.0), ("the same with a SYNC each 10 ms", 0.01, 1.5)):
        progress(f"a master in virtual time: {name}")
        start_s, start_cpu_s = time.perf_counter(), time.process_time()
        _, ended_ns, _, _ = homed(FIELDRIG, sync_s)
        wall_s, taken_s = time.perf_counter() - start_s, time.process_time() - start_cpu_s
        assert ended_ns > 60 * S
        report.add(name, f"{wall_s:.2f} s, {taken_s:.2f} s of processor", f"{goal_s:g} s", goal_s / taken_s)
    return report


if __name__ == "__main__":
    print(run().markdown())
