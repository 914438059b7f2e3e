"""The two modems in virtual time: one dials, the other answers, and a poor line slows them."""

from pathlib import Path

from fieldrig import RigMaker, S

RIG = Path(__file__).with_name("modems.yaml")


def test_the_office_calls_the_machine(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    terminals = rig.attach("terminals")
    office, machine = terminals.link("office_com"), terminals.link("machine_com")
    heard: dict[str, bytes] = {"office": b"", "machine": b""}
    office.on_receive(lambda data: heard.update(office=heard["office"] + data))
    machine.on_receive(lambda data: heard.update(machine=heard["machine"] + data))
    machine.send(b"ATE0S0=1\r")
    office.send(b"ATE0DT200\r")
    rig.run_until(12 * S)
    assert heard["office"].endswith(b"\r\nCONNECT 33600\r\n")
    machine.send(b"Hello")
    rig.run_until(13 * S)
    assert heard["office"].endswith(b"Hello")
    assert rig.get("office/dcd") is True


def test_a_poor_line_slows_the_call(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG, "buses.telephone.faults=[{what: slow, highest_bps: 9600}]")
    terminals = rig.attach("terminals")
    office, machine = terminals.link("office_com"), terminals.link("machine_com")
    machine.send(b"ATS0=1\r")
    office.send(b"ATDT200\r")
    rig.run_until(12 * S)
    assert rig.get("office/rate") == rig.get("machine/rate") == 9600
