"""Parameters of services are kept, revised in the answer, or refused with the status of OPC 10000-4."""

import asyncio
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from asyncua import Client, Node, ua
from in_loop import in_loop
from opcua_bench import ServerBench, server_bench

from fieldrig_bus.opcua.requests import wrong_member

pytestmark = pytest.mark.system

POSITION = "ns=2;s=belt.Position"
LONG_AGO = datetime(2020, 1, 1, tzinfo=UTC)


class Heard:
    """Data changes of a subscription, in their order."""

    def __init__(self) -> None:
        self.values: asyncio.Queue[Any] = asyncio.Queue()
        self.data: list[Any] = []

    def datachange_notification(self, _node: Any, value: Any, data: Any) -> None:
        self.data.append(data.monitored_item.Value)
        self.values.put_nowait(value)


def deadband(kind: int, value: float, trigger: int = ua.DataChangeTrigger.StatusValue) -> ua.DataChangeFilter:
    return ua.DataChangeFilter(Trigger=trigger, DeadbandType=kind, DeadbandValue=value)


async def status_of(request: Any) -> str:
    with pytest.raises(ua.UaStatusCodeError) as refused:
        await request
    return type(refused.value).__name__


async def watch(client: Client, heard: Heard, found: ua.DataChangeFilter | None = None, **options: Any) -> Any:
    subscription = await client.create_subscription(20, heard)
    node = client.get_node(options.pop("node", POSITION))
    attribute = options.pop("attribute", ua.AttributeIds.Value)
    await subscription._subscribe(node, attribute, found, sampling_interval=10, **options)
    return subscription


async def goes_to(bench: ServerBench, *values: float) -> None:
    """Let the belt be at each position for more than one sample."""
    for value in values:
        bench.plc.values["belt.Position"] = value
        bench.reads()
        samples = 0
        while samples < 3:
            await asyncio.sleep(0.005)
            samples += bench.reads()


# ---- DataChangeFilter


@in_loop
async def test_an_absolute_deadband_counts_from_the_last_report(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        heard = Heard()
        await watch(client, heard, deadband(1, 2.0), queuesize=10)
        assert await heard.values.get() == 1.5
        await goes_to(bench, 2.5, 3.5, 4.0, 5.0, 3.0)  # 3.5 is no more than 2 above 1.5, and 3.0 than 2 below 4.0
        assert await heard.values.get() == 4.0
        await goes_to(bench, 1.9)
        assert await heard.values.get() == 1.9
        assert heard.values.empty()


@in_loop
@pytest.mark.parametrize(
    ("found", "options", "status"),
    [
        (deadband(2, 10.0), {}, "BadDeadbandFilterInvalid"),  # OPC 10000-8, table 28: there is no EURange
        (deadband(1, -1.0), {}, "BadDeadbandFilterInvalid"),
        (deadband(1, float("nan")), {}, "BadDeadbandFilterInvalid"),
        (deadband(1, 1.0), {"node": "ns=2;s=belt.On"}, "BadFilterNotAllowed"),
        (deadband(0, 0.0), {"attribute": ua.AttributeIds.DisplayName}, "BadFilterNotAllowed"),
        (ua.EventFilter(), {}, "BadFilterNotAllowed"),
        (ua.AggregateFilter(), {}, "BadMonitoredItemFilterUnsupported"),
    ],
)
async def test_a_filter_that_cannot_be_kept_is_refused(
    tmp_path: Path, found: Any, options: dict[str, Any], status: str
) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        assert await status_of(watch(client, Heard(), found, **options)) == status


@in_loop
async def test_a_trigger_by_status_reports_no_values_and_one_by_time_stamps_all(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        still, timed = Heard(), Heard()
        await watch(client, still, deadband(0, 0.0, ua.DataChangeTrigger.Status))
        await watch(client, timed, deadband(0, 0.0, ua.DataChangeTrigger.StatusValueTimestamp))
        assert [await timed.values.get() for _ in range(3)] == [1.5] * 3
        await goes_to(bench, 2.5)
        assert still.values.qsize() == 1


@in_loop
async def test_a_changed_item_has_its_new_filter_and_an_unknown_one_is_refused(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        heard = Heard()
        subscription = await client.create_subscription(20, heard)
        item = await subscription.subscribe_data_change(client.get_node(POSITION), sampling_interval=10, queuesize=5)
        assert await heard.values.get() == 1.5
        asked = ua.MonitoringParameters(
            ClientHandle=item, SamplingInterval=10, QueueSize=7, Filter=deadband(1, 5.0), DiscardOldest=True
        )
        request = ua.MonitoredItemModifyRequest(MonitoredItemId=item, RequestedParameters=asked)
        unknown = ua.MonitoredItemModifyRequest(MonitoredItemId=item + 1_000, RequestedParameters=asked)
        params = ua.ModifyMonitoredItemsParameters(
            SubscriptionId=subscription.subscription_id, ItemsToModify=[request, unknown]
        )
        changed, refused = await client.uaclient.modify_monitored_items(params)
        assert (changed.StatusCode.is_good(), changed.RevisedQueueSize) == (True, 7)
        assert refused.StatusCode.name == "BadMonitoredItemIdInvalid"


# ---- queues and modes


@in_loop
async def test_an_item_that_samples_reports_when_it_may(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        heard = Heard()
        subscription = await watch(client, heard, monitoring=ua.MonitoringMode.Sampling, queuesize=2)
        await goes_to(bench, 2.0, 3.0, 4.0)
        assert heard.values.empty()
        await subscription.set_monitoring_mode(ua.MonitoringMode.Reporting)
        assert [await heard.values.get() for _ in range(2)] == [3.0, 4.0]


@in_loop
async def test_a_queue_that_keeps_its_oldest_value_has_one_place(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        subscription = await client.create_subscription(1000, Heard())
        request = ua.MonitoredItemCreateRequest(
            ItemToMonitor=ua.ReadValueId(NodeId=ua.NodeId.from_string(POSITION), AttributeId=ua.AttributeIds.Value),
            MonitoringMode=ua.MonitoringMode.Reporting,
            RequestedParameters=ua.MonitoringParameters(QueueSize=10, SamplingInterval=10, DiscardOldest=False),
        )
        params = ua.CreateMonitoredItemsParameters(
            SubscriptionId=subscription.subscription_id,
            TimestampsToReturn=ua.TimestampsToReturn.Both,
            ItemsToCreate=[request],
        )
        [result] = await client.uaclient.create_monitored_items(params)
        assert result.RevisedQueueSize == 1


@in_loop
async def test_each_item_is_sampled_at_its_own_interval(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        fast, slow = Heard(), Heard()
        subscription = await client.create_subscription(10, slow)
        await subscription.subscribe_data_change(client.get_node(POSITION), sampling_interval=3_600_000)
        assert await slow.values.get() == 1.5
        await watch(client, fast)
        assert await fast.values.get() == 1.5
        await goes_to(bench, 2.0)
        assert await fast.values.get() == 2.0
        assert slow.values.empty()


@in_loop
async def test_a_message_has_at_most_the_notifications_that_its_client_takes(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        bench.plc.values |= {f"belt.N{number}": float(number) for number in range(7)}
        messages: asyncio.Queue[Any] = asyncio.Queue()
        result = await client.uaclient.create_subscription(
            ua.CreateSubscriptionParameters(
                RequestedPublishingInterval=50,
                RequestedLifetimeCount=3000,
                RequestedMaxKeepAliveCount=1000,
                MaxNotificationsPerPublish=3,
                PublishingEnabled=True,
            ),
            callback=messages.put_nowait,
        )
        items = [
            ua.MonitoredItemCreateRequest(
                ItemToMonitor=ua.ReadValueId(NodeId=ua.NodeId(f"belt.N{number}", 2), AttributeId=ua.AttributeIds.Value),
                MonitoringMode=ua.MonitoringMode.Reporting,
                RequestedParameters=ua.MonitoringParameters(ClientHandle=number, SamplingInterval=1000, QueueSize=1),
            )
            for number in range(7)
        ]
        await client.uaclient.create_monitored_items(
            ua.CreateMonitoredItemsParameters(
                SubscriptionId=result.SubscriptionId,
                TimestampsToReturn=ua.TimestampsToReturn.Both,
                ItemsToCreate=items,
            )
        )
        seen: list[int] = []
        while len(seen) < 7:
            message = (await messages.get()).NotificationMessage
            handles = [item.ClientHandle for data in message.NotificationData for item in data.MonitoredItems]
            assert len(handles) <= 3
            seen += handles
        assert sorted(seen) == list(range(7))


@in_loop
async def test_a_changed_subscription_publishes_at_its_new_interval(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        heard = Heard()
        subscription = await client.create_subscription(3_000_000, heard)
        await subscription.subscribe_data_change(client.get_node(POSITION), sampling_interval=10)
        changed = await client.uaclient.modify_subscription(
            ua.ModifySubscriptionParameters(
                SubscriptionId=subscription.subscription_id,
                RequestedPublishingInterval=float("nan"),
                RequestedLifetimeCount=3000,
                RequestedMaxKeepAliveCount=1000,
            )
        )
        assert changed.RevisedPublishingInterval == 10.0
        await goes_to(bench, 2.0)
        while await heard.values.get() != 2.0:
            pass


# ---- Read and Write


@in_loop
async def test_a_written_source_time_is_that_of_the_value_while_it_lasts(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        node = client.get_node(POSITION)
        await node.write_value(ua.DataValue(ua.Variant(7.0), SourceTimestamp=LONG_AGO))
        assert (await node.read_data_value()).SourceTimestamp == LONG_AGO
        for value in (8.0, 7.0):  # the program writes other values in the meantime
            bench.plc.values["belt.Position"] = value
            assert (await node.read_data_value()).SourceTimestamp > LONG_AGO


@in_loop
@pytest.mark.parametrize(
    "written",
    [
        ua.DataValue(ua.Variant(7.0), StatusCode=ua.StatusCode(ua.StatusCodes.BadSensorFailure)),
        ua.DataValue(ua.Variant(7.0), ServerTimestamp=LONG_AGO),
    ],
    ids=["status", "server time"],
)
async def test_a_status_or_server_time_of_a_client_is_refused(tmp_path: Path, written: ua.DataValue) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        assert await status_of(client.get_node(POSITION).write_value(written)) == "BadWriteNotSupported"
        assert bench.plc.values["belt.Position"] == 1.5


async def read(client: Client, node: str, **options: Any) -> ua.DataValue:
    params = ua.ReadParameters(TimestampsToReturn=options.pop("timestamps", ua.TimestampsToReturn.Source))
    params.MaxAge = options.pop("max_age", 0)
    wanted = ua.ReadValueId(NodeId=ua.NodeId.from_string(node), AttributeId=ua.AttributeIds.Value, **options)
    params.NodesToRead = [wanted]
    [value] = await client.uaclient.read(params)
    return value


@in_loop
async def test_an_index_range_is_a_part_of_the_value_or_refused(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        bench.plc.values["belt.Text"] = "conveyor"
        text = "ns=2;s=belt.Text"
        assert (await read(client, text, IndexRange="0:3")).Value.Value == "conv"
        assert (await read(client, text, IndexRange="4:99")).Value.Value == "eyor"
        namespaces = await read(client, "i=2255", IndexRange="0")
        assert namespaces.Value.Value == ["http://opcfoundation.org/UA/"]
        for node, wanted, status in (
            (text, "99", "BadIndexRangeNoData"),
            (text, "0:1,0:1", "BadIndexRangeNoData"),
            (POSITION, "0", "BadIndexRangeNoData"),
            (text, "3:3", "BadIndexRangeInvalid"),
            (text, "-1", "BadIndexRangeInvalid"),
            (text, "a", "BadIndexRangeInvalid"),
        ):
            assert (await read(client, node, IndexRange=wanted)).StatusCode.name == status, wanted


@in_loop
async def test_a_read_has_the_time_stamps_that_it_asks_for(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        wants = ua.TimestampsToReturn
        seen = {}
        for timestamps in (wants.Source, wants.Server, wants.Both, wants.Neither):
            value = await read(client, POSITION, timestamps=timestamps)
            seen[timestamps] = (value.SourceTimestamp is not None, value.ServerTimestamp is not None)
        assert list(seen.values()) == [(True, False), (False, True), (True, True), (False, False)]
        assert await status_of(read(client, POSITION, timestamps=wants.Invalid)) == "BadTimestampsToReturnInvalid"
        assert await status_of(read(client, POSITION, max_age=-1)) == "BadMaxAgeInvalid"
        encoding = ua.QualifiedName("Default XML", 0)
        assert (await read(client, POSITION, DataEncoding=encoding)).StatusCode.name == "BadDataEncodingInvalid"


# ---- Browse


async def browse(client: Client, node: Node, most: int, mask: int = 63) -> ua.BrowseResult:
    params = ua.BrowseParameters(RequestedMaxReferencesPerNode=most)
    params.NodesToBrowse = [
        ua.BrowseDescription(
            NodeId=node.nodeid,
            BrowseDirection=ua.BrowseDirection.Forward,
            ReferenceTypeId=ua.NodeId(ua.ObjectIds.HierarchicalReferences),
            IncludeSubtypes=True,
            ResultMask=mask,
        )
    ]
    [result] = await client.uaclient.browse(params)
    return result


@in_loop
async def test_references_that_do_not_fit_follow_by_browse_next(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        plc = client.get_node("ns=2;i=1")
        whole = [reference.BrowseName.Name for reference in (await browse(client, plc, 0)).References]
        result = await browse(client, plc, 2)
        names = []
        while True:
            names += [reference.BrowseName.Name for reference in result.References]
            assert len(result.References) <= 2
            if not result.ContinuationPoint:
                break
            point = result.ContinuationPoint
            [result] = await client.uaclient.browse_next(ua.BrowseNextParameters(False, [point]))
        assert names == whole
        [late] = await client.uaclient.browse_next(ua.BrowseNextParameters(False, [point]))
        assert late.StatusCode.name == "BadContinuationPointInvalid"


@in_loop
async def test_references_have_the_fields_that_are_asked_for(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        [first, *_] = (await browse(client, client.get_node("ns=2;i=1"), 0, mask=1 << 3)).References
        assert (first.BrowseName.Name, first.DisplayName.Text) == ("belt", None)
        assert first.NodeClass == ua.NodeClass.Unspecified


@in_loop
async def test_released_continuation_points_have_no_results(tmp_path: Path) -> None:
    """OPC 10000-4, 5.9.3.2."""
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        point = (await browse(client, client.get_node("ns=2;i=1"), 1)).ContinuationPoint
        assert await client.uaclient.browse_next(ua.BrowseNextParameters(True, [point])) == []
        [late] = await client.uaclient.browse_next(ua.BrowseNextParameters(False, [point]))
        assert late.StatusCode.name == "BadContinuationPointInvalid"


# ---- numbers that are none, and attributes that are not there


@in_loop
async def test_a_number_that_an_enumeration_lacks_has_the_status_of_its_parameter(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        subscription = await client.create_subscription(20, Heard())
        item: Any = ua.MonitoredItemCreateRequest(ItemToMonitor=ua.ReadValueId(client.get_node(POSITION).nodeid))
        item.MonitoringMode = 3
        create: Any = ua.CreateMonitoredItemsParameters(subscription.subscription_id, 2, [item])
        assert await status_of(client.uaclient.create_monitored_items(create)) == "BadMonitoringModeInvalid"
        mode: Any = ua.SetMonitoringModeParameters(subscription.subscription_id, 7, [1])
        assert await status_of(client.uaclient.set_monitoring_mode(mode)) == "BadMonitoringModeInvalid"
        read: Any = ua.ReadParameters(TimestampsToReturn=9, NodesToRead=[item.ItemToMonitor])
        assert await status_of(client.uaclient.read(read)) == "BadTimestampsToReturnInvalid"
        asked: Any = ua.BrowseDescription(client.get_node("ns=2;i=1").nodeid, 9)
        browsed = ua.BrowseParameters(NodesToBrowse=[asked])
        assert await status_of(client.uaclient.browse(browsed)) == "BadBrowseDirectionInvalid"


def condition(operator: Any) -> ua.EventFilter:
    return ua.EventFilter(WhereClause=ua.ContentFilter([ua.ContentFilterElement(operator, [])]))


@in_loop
@pytest.mark.parametrize("found", [deadband(0, 0.0, 9), deadband(1, 1.0, -1), condition(99)])
async def test_a_filter_with_a_number_that_is_none_has_the_status_of_a_filter(tmp_path: Path, found: Any) -> None:
    """It was BadInternalError, which says that the server is wrong."""
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        subscription = await client.create_subscription(20, Heard())
        item = ua.MonitoredItemCreateRequest(ItemToMonitor=ua.ReadValueId(client.get_node(POSITION).nodeid))
        item.RequestedParameters.Filter = found
        create: Any = ua.CreateMonitoredItemsParameters(subscription.subscription_id, 2, [item])
        assert await status_of(client.uaclient.create_monitored_items(create)) == "BadMonitoredItemFilterInvalid"
        change: Any = ua.ModifyMonitoredItemsParameters(
            subscription.subscription_id, 2, [ua.MonitoredItemModifyRequest(1, item.RequestedParameters)]
        )
        assert await status_of(client.uaclient.modify_monitored_items(change)) == "BadMonitoredItemFilterInvalid"


@pytest.mark.parametrize("words", ["999 is not a valid NodeClass", "-1 is not a valid MessageSecurityMode"])
def test_any_other_number_that_is_none_cannot_be_decoded(words: str) -> None:
    assert wrong_member(ValueError(words)) == ua.StatusCodes.BadDecodingError


@pytest.mark.parametrize("words", ["9 is not a valid Colour", "9 is not a valid NodeId", "no number"])
def test_a_mistake_that_is_no_number_of_the_request_stays_one(words: str) -> None:
    assert wrong_member(ValueError(words)) == 0


@in_loop
async def test_an_attribute_that_a_node_lacks_is_neither_written_nor_watched(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        node = client.get_node(POSITION)
        written = [
            ua.WriteValue(node_id, attribute, Value=ua.DataValue(ua.Variant(1.0, ua.VariantType.Double)))
            for node_id, attribute in (
                (node.nodeid, 99),
                (node.nodeid, 12),
                (ua.NodeId(2253), 13),
                (ua.NodeId(1, 9), 13),
            )
        ]
        results = await client.uaclient.write(ua.WriteParameters(written))
        assert [result.name for result in results] == ["BadAttributeIdInvalid"] * 3 + ["BadNodeIdUnknown"]
        subscription = await client.create_subscription(20, Heard())
        read = ua.ReadValueId(node.nodeid, ua.AttributeIds.EventNotifier)
        create = ua.CreateMonitoredItemsParameters(
            subscription.subscription_id, ua.TimestampsToReturn.Both, [ua.MonitoredItemCreateRequest(read)]
        )
        [result] = await client.uaclient.create_monitored_items(create)
        assert result.StatusCode.name == "BadAttributeIdInvalid"


@in_loop
async def test_a_sampling_interval_that_is_no_number_is_the_fastest(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        subscription = await client.create_subscription(20, Heard())
        item = ua.MonitoredItemCreateRequest(ua.ReadValueId(client.get_node(POSITION).nodeid, ua.AttributeIds.Value))
        item.RequestedParameters.SamplingInterval = float("nan")
        create = ua.CreateMonitoredItemsParameters(subscription.subscription_id, ua.TimestampsToReturn.Both, [item])
        [result] = await client.uaclient.create_monitored_items(create)
        assert result.StatusCode.is_good()
        assert 0 < result.RevisedSamplingInterval <= 100
