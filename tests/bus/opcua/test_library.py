"""The parts of asyncua that are not public and that `fieldrig_bus.opcua` uses: changes to them fail here.

pyproject.toml allows one minor version, because these classes may change with the next.
"""

import inspect
from collections.abc import Callable
from importlib.metadata import version

import pytest
from asyncua import Server
from asyncua.server.address_space import AddressSpace
from asyncua.server.internal_server import InternalServer
from asyncua.server.internal_session import InternalSession
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.monitored_item_service import MonitoredItemService
from asyncua.server.subscription_service import SubscriptionService
from asyncua.server.uaprocessor import UaProcessor

from fieldrig_bus.opcua.items import Items
from fieldrig_bus.opcua.listener import Processor
from fieldrig_bus.opcua.session import Backend, Session
from fieldrig_bus.opcua.subscriptions import Subscription, Subscriptions

BASES = (
    (InternalServer, Backend),
    (InternalSession, Session),
    (InternalSubscription, Subscription),
    (MonitoredItemService, Items),
    (SubscriptionService, Subscriptions),
    (UaProcessor, Processor),
)
OVERRIDDEN = [
    (base, own, name)
    for base, own in BASES
    for name, member in vars(own).items()
    if inspect.isfunction(member) and not name.startswith("__") and name in dir(base)
]
ATTRIBUTES: dict[type, tuple[str, ...]] = {
    SubscriptionService: ("subscriptions", "_sub_id_counter", "_clamp_keep_alive_count", "_clamp_lifetime_count"),
    InternalSubscription: (
        *("monitored_item_srv", "data", "_task", "_publishing_enabled", "_triggered_datachanges"),
        *("_not_acknowledged_results", "_pop_publish_result", "_pop_triggered_datachanges"),
    ),
    MonitoredItemService: ("_monitored_item_counter", "aspace"),
    UaProcessor: ("session", "session_last_activity", "send_response"),
}
CALLED: dict[Callable[..., object], tuple[str, ...]] = {
    InternalServer.__init__: ("user_manager",),
    InternalSession.__init__: ("internal_server", "aspace", "submgr", "name", "user", "external"),
    AddressSpace.write_attribute_value: ("nodeid", "attr", "value"),
    AddressSpace.get: ("nodeid",),
    UaProcessor.__init__: ("internal_server", "transport", "limits"),
    UaProcessor.set_policies: ("policies",),
    UaProcessor.process: ("header", "body"),
    UaProcessor.close: (),
    Server._setup_server_nodes: (),
}


def test_sessions_override_what_they_are_meant_to() -> None:
    names = {name for _, own, name in OVERRIDDEN if own is Session}
    assert names == {
        "browse",
        "browse_next",
        "translate_browsepaths_to_nodeids",
        "read",
        "history_read",
        "write",
        "call",
        "create_monitored_items",
        "modify_monitored_items",
        "delete_monitored_items",
        "set_monitoring_mode",
        "set_publishing_mode",
        "republish",
        "delete_subscriptions",
        "transfer_subscriptions",
        "close_session",
    }
    assert [name for _, own, name in OVERRIDDEN if own is Backend] == ["create_session"]


@pytest.mark.parametrize(
    ("base", "own", "name"), OVERRIDDEN, ids=[f"{own.__name__}.{name}" for _, own, name in OVERRIDDEN]
)
def test_an_overridden_method_has_the_parameters_of_the_library(base: type, own: type, name: str) -> None:
    theirs, ours = (inspect.signature(getattr(one, name)) for one in (base, own))
    assert list(ours.parameters) == list(theirs.parameters)
    assert inspect.iscoroutinefunction(getattr(own, name)) == inspect.iscoroutinefunction(getattr(base, name))


@pytest.mark.parametrize("function", CALLED, ids=lambda function: function.__qualname__)
def test_a_called_method_has_the_parameters_that_are_passed(function: Callable[..., object]) -> None:
    assert set(CALLED[function]) <= set(inspect.signature(function).parameters)


@pytest.mark.parametrize(("owner", "names"), ATTRIBUTES.items())
def test_attributes_that_are_used_are_those_of_the_library(owner: type, names: tuple[str, ...]) -> None:
    text = inspect.getsource(owner)
    assert [name for name in names if f"self.{name}" not in text and f"def {name}" not in text] == []


def test_the_version_is_the_one_that_was_read() -> None:
    assert version("asyncua").startswith("2.1.")
