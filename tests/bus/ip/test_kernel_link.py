"""The link of a device to the kernel of the host: the model, and the end of it in the device."""

from ipaddress import IPv4Address
from typing import Any

import pytest
from relay_deliveries import deliveries

from fieldrig_bus.ip.message import (
    Closed,
    IpPacket,
    KernelOffered,
    LinkDown,
    LinkUp,
    Opened,
    Portion,
    RelayMessage,
)
from fieldrig_bus.ip.model import LEFT, NO_KERNEL, REFUSED, RELAY, TAKEN, RelayModel

HERE, THERE = IPv4Address("190.200.100.100"), IPv4Address("190.200.100.101")
UP = LinkUp("plc", HERE, THERE, 1500, (80,))


def relay(*sent: tuple[str, RelayMessage]) -> RelayModel:
    model = RelayModel()
    for member in ("plc", "kernel", "other"):
        model.join(member)
    for member, message in sent:
        model.submit(0, member, message)
    deliveries(model)
    return model


def linked() -> RelayModel:
    return relay(("kernel", KernelOffered()), ("plc", UP))


def test_a_kernel_is_offered_to_those_that_are_there_and_those_that_come() -> None:
    model = relay()
    model.submit(0, "kernel", KernelOffered())
    assert deliveries(model) == [("kernel", KernelOffered(), ("plc", "other"))]
    model.join("late")
    model.listen(5, "late", None)
    assert deliveries(model) == [("kernel", KernelOffered(), ("late",))]


def test_packets_go_between_the_kernel_and_the_device() -> None:
    model = linked()
    there, back = IpPacket("plc", False, b"\x45ping"), IpPacket("plc", True, b"\x45pong")
    model.submit(1, "plc", there)
    model.submit(1, "kernel", back)
    assert deliveries(model) == [("plc", there, ("kernel",)), ("kernel", back, ("plc",))]
    assert model.statistics(1)["packets"] == 2


def test_the_kernel_opens_channels_to_the_ports_of_the_link() -> None:
    model = linked()
    model.submit(1, "kernel", Opened("kernel", 1, 80))
    model.submit(1, "plc", Portion("kernel", 1, True, b"page"))
    model.submit(1, "kernel", Opened("kernel", 2, 81))
    assert deliveries(model) == [
        ("kernel", Opened("kernel", 1, 80), ("plc",)),
        ("plc", Portion("kernel", 1, True, b"page"), ("kernel",)),
        ("kernel", Opened("kernel", 2, 81), ()),
        (RELAY, Closed("kernel", 2, True, REFUSED), ("kernel",)),
    ]


@pytest.mark.parametrize(
    ("member", "message"),
    [
        ("other", IpPacket("plc", False, b"\x45")),
        ("other", IpPacket("plc", True, b"\x45")),
        ("other", IpPacket("other", False, b"\x45")),
        ("plc", IpPacket("plc", True, b"\x45")),
        ("kernel", IpPacket("other", True, b"\x45")),
        ("other", LinkUp("plc", HERE, THERE, 1500, ())),
        ("other", LinkDown("plc", False, "")),
    ],
)
def test_no_member_speaks_for_another_one(member: str, message: RelayMessage) -> None:
    model = linked()
    model.submit(1, member, message)
    assert deliveries(model) == [(member, message, ())]
    model.submit(1, "plc", IpPacket("plc", False, b"\x45"))
    assert deliveries(model)[0][2] == ("kernel",)


@pytest.mark.parametrize(
    ("model", "member", "why"), [(relay(), "plc", NO_KERNEL), (linked(), "other", TAKEN)], ids=["none", "taken"]
)
def test_a_link_without_a_free_kernel_is_refused(model: RelayModel, member: str, why: str) -> None:
    link = LinkUp(member, HERE, THERE, 1500, ())
    model.submit(1, member, link)
    assert deliveries(model) == [(member, link, ()), (RELAY, LinkDown(member, True, why), (member,))]


@pytest.mark.parametrize(("leaver", "other", "is_answer"), [("plc", "kernel", False), ("kernel", "plc", True)])
def test_a_member_that_leaves_loses_the_link(leaver: str, other: str, is_answer: bool) -> None:
    model = linked()
    model.leave(leaver)
    assert deliveries(model) == [(RELAY, LinkDown("plc", is_answer, LEFT), (other,))]


def test_a_link_that_is_down_leaves_the_kernel_to_another_device() -> None:
    model = linked()
    model.submit(1, "plc", LinkDown("plc", False, "the line was lost"))
    link: Any = LinkUp("other", HERE, THERE, 1500, ())
    model.submit(2, "other", link)
    assert [receivers for _, _, receivers in deliveries(model)] == [("kernel",), ("kernel",)]
