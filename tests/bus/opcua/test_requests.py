"""Requests that ask for nothing, for what is not there, or for what belongs to another session.

Expected status codes are those of OPC 10000-4; each request comes from the client of asyncua.
"""

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from asyncua import Client, ua
from in_loop import in_loop
from opcua_bench import server_bench

pytestmark = pytest.mark.long

POSITION = ua.NodeId("belt.Position", 2)
PLC = ua.NodeId(1, 2)
HIERARCHICAL = ua.NodeId(ua.ObjectIds.HierarchicalReferences)


async def status_of(request: Awaitable[Any]) -> str:
    with pytest.raises(ua.UaStatusCodeError) as refused:
        await request
    return type(refused.value).__name__


EMPTY: dict[str, Callable[[Any, int], Awaitable[Any]]] = {
    "read": lambda peer, _: peer.read(ua.ReadParameters()),
    "write": lambda peer, _: peer.write(ua.WriteParameters()),
    "call": lambda peer, _: peer.call([]),
    "browse": lambda peer, _: peer.browse(ua.BrowseParameters()),
    "browse next": lambda peer, _: peer.browse_next(ua.BrowseNextParameters()),
    "translate": lambda peer, _: peer.translate_browsepaths_to_nodeids([]),
    "register": lambda peer, _: peer.register_nodes([]),
    "unregister": lambda peer, _: peer.unregister_nodes([]),
    "history read": lambda peer, _: peer.history_read(history([])),
    "create items": lambda peer, number: peer.create_monitored_items(
        ua.CreateMonitoredItemsParameters(SubscriptionId=number)
    ),
    "modify items": lambda peer, number: peer.modify_monitored_items(
        ua.ModifyMonitoredItemsParameters(SubscriptionId=number)
    ),
    "delete items": lambda peer, number: peer.delete_monitored_items(
        ua.DeleteMonitoredItemsParameters(SubscriptionId=number)
    ),
    "monitoring mode": lambda peer, number: peer.set_monitoring_mode(
        ua.SetMonitoringModeParameters(SubscriptionId=number)
    ),
    "publishing mode": lambda peer, _: peer.set_publishing_mode(ua.SetPublishingModeParameters()),
    "delete subscriptions": lambda peer, _: peer.delete_subscriptions([]),
}


def history(nodes: list[ua.NodeId]) -> ua.HistoryReadParameters:
    asked = ua.HistoryReadParameters(HistoryReadDetails=ua.ReadRawModifiedDetails())
    asked.NodesToRead = [ua.HistoryReadValueId(NodeId=node) for node in nodes]
    return asked


class Nothing:
    """A handler that wants no values."""

    def datachange_notification(self, *_: Any) -> None: ...


@in_loop
async def test_a_request_for_nothing_is_refused_by_each_service(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        subscription = await client.create_subscription(100, Nothing())
        found = {
            name: await status_of(ask(client.uaclient, subscription.subscription_id)) for name, ask in EMPTY.items()
        }
        assert found == dict.fromkeys(EMPTY, "BadNothingToDo")


def path(start: ua.NodeId, *names: str | None) -> ua.BrowsePath:
    elements = [
        ua.RelativePathElement(HIERARCHICAL, False, True, ua.QualifiedName(name, 2) if name else ua.QualifiedName())
        for name in names
    ]
    return ua.BrowsePath(start, ua.RelativePath(elements))


@in_loop
async def test_each_path_has_its_own_status(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        paths = {
            "Good": path(PLC, "belt", "Position"),
            "BadNothingToDo": path(PLC),
            "BadNodeIdUnknown": path(ua.NodeId(4711, 0), "belt"),
            "BadBrowseNameInvalid": path(PLC, None, "Position"),
            "BadNoMatch": path(PLC, "belt", "Nothing"),
        }
        results = await client.uaclient.translate_browsepaths_to_nodeids([*paths.values()])
        assert [one.StatusCode.name for one in results] == list(paths)
        assert [target.TargetId for target in results[0].Targets] == [POSITION]


@in_loop
async def test_a_browse_with_a_wrong_direction_or_type_of_reference_is_refused(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:

        def asked(direction: int = 0, kind: ua.NodeId = HIERARCHICAL, node: ua.NodeId = PLC) -> ua.BrowseDescription:
            made = ua.BrowseDescription(NodeId=node, ReferenceTypeId=kind, IncludeSubtypes=True, ResultMask=63)
            made.BrowseDirection = ua.BrowseDirection(direction)
            return made

        given = [
            asked(),
            asked(3),
            asked(kind=ua.NodeId(85, 0)),
            asked(kind=ua.NodeId(99_999, 0)),
            asked(kind=ua.NodeId()),
            asked(node=ua.NodeId("none", 2)),
        ]
        results = await client.uaclient.browse(ua.BrowseParameters(NodesToBrowse=given))
        assert [(one.StatusCode.name, bool(one.References)) for one in results] == [
            ("Good", True),
            ("BadBrowseDirectionInvalid", False),
            ("BadReferenceTypeIdInvalid", False),
            ("BadReferenceTypeIdInvalid", False),
            ("Good", True),
            ("BadNodeIdUnknown", False),
        ]


@in_loop
async def test_a_call_of_what_is_no_method_and_of_no_object_is_refused(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        start = ua.NodeId("start()", 2)
        given = [(PLC, start), (PLC, POSITION), (PLC, ua.NodeId(77, 0)), (ua.NodeId(1234, 7), start)]
        results = await client.uaclient.call([ua.CallMethodRequest(*one, []) for one in given])
        assert [one.StatusCode.name for one in results] == [
            "Good",
            "BadMethodInvalid",
            "BadMethodInvalid",
            "BadNodeIdUnknown",
        ]
        assert bench.plc.called == ["start"]


@in_loop
async def test_there_is_no_history_and_no_age_that_is_no_number(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        [result] = await client.uaclient.history_read(history([POSITION]))
        assert result.StatusCode.name == "BadHistoryOperationUnsupported"
        value = ua.ReadValueId(NodeId=POSITION, AttributeId=ua.AttributeIds.Value)
        aged = ua.ReadParameters(MaxAge=float("nan"), NodesToRead=[value])
        assert await status_of(client.uaclient.read(aged)) == "BadMaxAgeInvalid"


@in_loop
async def test_the_subscription_of_another_session_is_unknown(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as owner, Client(bench.url) as other:
        subscription = await owner.create_subscription(100, Nothing())
        item = await subscription.subscribe_data_change(owner.get_node(POSITION))
        number, peer = subscription.subscription_id, other.uaclient
        create = ua.CreateMonitoredItemsParameters(
            SubscriptionId=number, ItemsToCreate=[ua.MonitoredItemCreateRequest()]
        )
        modify = ua.ModifyMonitoredItemsParameters(
            SubscriptionId=number, ItemsToModify=[ua.MonitoredItemModifyRequest()]
        )
        delete = ua.DeleteMonitoredItemsParameters(SubscriptionId=number, MonitoredItemIds=[item])
        mode = ua.SetMonitoringModeParameters(SubscriptionId=number, MonitoredItemIds=[item])
        for request in (
            peer.create_monitored_items(create),
            peer.modify_monitored_items(modify),
            peer.delete_monitored_items(delete),
            peer.set_monitoring_mode(mode),
            peer.update_subscription(ua.ModifySubscriptionParameters(SubscriptionId=number)),
        ):
            assert await status_of(request) == "BadSubscriptionIdInvalid"
        publishing = ua.SetPublishingModeParameters(SubscriptionIds=[number])
        for statuses in (await peer.set_publishing_mode(publishing), await peer.delete_subscriptions([number])):
            assert [one.name for one in statuses] == ["BadSubscriptionIdInvalid"]
        await subscription.unsubscribe(item)
        await subscription.delete()
