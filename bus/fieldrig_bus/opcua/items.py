"""Monitored items: which values of a variable a subscription reports, and when.

Source: OPC 10000-4, 5.13 (MonitoredItem Service Set) and 7.22.2 (DataChangeFilter), OPC 10000-8, 7.2.  The library
keeps the items of events.  Its items of data compare a value with the last sample, where the standard says the last
report, and take parameters that they do not use.
Revised instead of kept: a queue whose oldest value must stay (DiscardOldest = False) has one place.
Left out: percent deadbands, because no variable has an EURange, and aggregates.
"""

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from asyncua import ua
from asyncua.server.address_space import AddressSpace
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.monitored_item_service import MonitoredItemService

from fieldrig_bus.opcua.values import GOOD, part_of, stamped, wrong_read

LONGEST_QUEUE: Final = 1_000


class ItemRefusedError(Exception):
    """The status code with which a monitored item is refused."""

    def __init__(self, status: int) -> None:
        super().__init__(status)
        self.status = status


@dataclass(frozen=True, slots=True)
class Filter:
    """A DataChangeFilter that was checked."""

    trigger: int = ua.DataChangeTrigger.StatusValue
    deadband: float = 0.0
    """Least change of a number that is reported; 0 reports every change."""

    def passes(self, last: ua.DataValue | None, value: ua.DataValue) -> bool:
        """Return whether a value is reported, by the one that was reported last."""
        if last is None or last.StatusCode != value.StatusCode:
            return True
        if self.trigger == ua.DataChangeTrigger.Status:
            return False
        if self.deadband:  # then a trigger by time stamps is one by values (7.10)
            return self._exceeds(last.Value, value.Value)
        is_timed = self.trigger == ua.DataChangeTrigger.StatusValueTimestamp
        return bool(last.Value != value.Value or (is_timed and last.SourceTimestamp != value.SourceTimestamp))

    def _exceeds(self, last: ua.Variant, value: ua.Variant) -> bool:
        before, now = ([one.Value] if not isinstance(one.Value, list) else one.Value for one in (last, value))
        if len(before) != len(now) or None in (*before, *now):
            return bool(before != now)
        return any(not abs(new - old) <= self.deadband for old, new in zip(before, now, strict=True))


@dataclass(slots=True)
class Item:
    """A monitored item of an attribute that has a value."""

    number: int
    read: ua.ReadValueId
    client_handle: int
    mode: ua.MonitoringMode
    timestamps: ua.TimestampsToReturn
    filter: Filter = Filter()
    queue_size: int = 1
    reported: ua.DataValue | None = None
    """The value that was reported last, or queued for it."""
    held: deque[ua.DataValue] = field(default_factory=deque)
    """The queue of an item that samples and does not report."""

    def revise(self, asked: ua.MonitoringParameters, filter_: Filter) -> None:
        """Take the parameters of a request (5.13.1.5: a queue has at least one place)."""
        self.client_handle, self.filter = asked.ClientHandle, filter_
        self.queue_size = min(max(int(asked.QueueSize), 1), LONGEST_QUEUE) if asked.DiscardOldest else 1
        self.held = deque(self.held, self.queue_size)

    def notification(self, value: ua.DataValue) -> ua.MonitoredItemNotification:
        return ua.MonitoredItemNotification(ClientHandle=self.client_handle, Value=stamped(value, self.timestamps))


class Items(MonitoredItemService):  # type: ignore[misc]
    """The monitored items of a subscription."""

    def __init__(self, subscription: InternalSubscription, space: AddressSpace) -> None:
        super().__init__(subscription, space)
        self._subscription = subscription
        self._items: dict[int, Item] = {}
        self._by_handle: dict[int, Item] = {}
        """The items of nodes whose changes the address space tells, by the handle of the callback."""

    async def take(self, number: int, value: ua.DataValue) -> None:
        """Take a sample, and report it if the filter lets it pass."""
        item = self._items.get(number)
        if item is None or item.mode == ua.MonitoringMode.Disabled:
            return
        value = part_of(item.read, value)
        if not item.filter.passes(item.reported, value):
            return
        item.reported = value
        if item.mode == ua.MonitoringMode.Sampling:
            item.held.append(value)
        else:
            await self._report(item, value)

    async def _report(self, item: Item, value: ua.DataValue) -> None:
        await self._subscription.enqueue_datachange_event(item.number, item.notification(value), item.queue_size)

    async def create(
        self, asked: ua.MonitoredItemCreateRequest, timestamps: ua.TimestampsToReturn, *, is_sampled: bool
    ) -> ua.MonitoredItemCreateResult:
        """Create an item; its caller passes on the samples of one that `is_sampled`."""
        read = asked.ItemToMonitor
        try:
            item = self._checked(asked, timestamps)
            if not is_sampled:
                status, handle = self.aspace.add_datachange_callback(read.NodeId, read.AttributeId, self._on_change)
                if not status.is_good():
                    raise ItemRefusedError(status.value)
                self._by_handle[handle] = item
        except ItemRefusedError as refused:
            return ua.MonitoredItemCreateResult(StatusCode=ua.StatusCode(refused.status))
        self._items[item.number] = item
        if not is_sampled:
            await self.take(item.number, self.aspace.read_attribute_value(read.NodeId, read.AttributeId))
        interval_ms = self._subscription.data.RevisedPublishingInterval
        return ua.MonitoredItemCreateResult(
            MonitoredItemId=item.number, RevisedSamplingInterval=interval_ms, RevisedQueueSize=item.queue_size
        )

    def _checked(self, asked: ua.MonitoredItemCreateRequest, timestamps: ua.TimestampsToReturn) -> Item:
        """Return the item of a request.  ItemRefusedError for one that the server cannot do as it says."""
        read = asked.ItemToMonitor
        if (status := wrong_read(read)) != GOOD:
            raise ItemRefusedError(status)
        if asked.MonitoringMode not in tuple(ua.MonitoringMode):
            raise ItemRefusedError(ua.StatusCodes.BadMonitoringModeInvalid)
        filter_ = checked_filter(asked.RequestedParameters.Filter, read, self._data_type(read))
        self._monitored_item_counter += 1
        item = Item(self._monitored_item_counter, read, 0, asked.MonitoringMode, timestamps)
        item.revise(asked.RequestedParameters, filter_)
        return item

    def _data_type(self, read: ua.ReadValueId) -> ua.NodeId | None:
        """Return the data type of the variable."""
        value = self.aspace.read_attribute_value(read.NodeId, ua.AttributeIds.DataType)
        return value.Value.Value if value.StatusCode.is_good() and value.Value is not None else None

    async def _on_change(self, handle: int, value: ua.DataValue, error: ua.StatusCode | None = None) -> None:
        item = self._by_handle.get(handle)
        if error is None and item is not None:
            await self.take(item.number, value)

    def modify(
        self, asked: ua.MonitoredItemModifyRequest, timestamps: ua.TimestampsToReturn
    ) -> ua.MonitoredItemModifyResult:
        item = self._items.get(asked.MonitoredItemId)
        if item is None:
            return ua.MonitoredItemModifyResult(StatusCode=ua.StatusCode(ua.StatusCodes.BadMonitoredItemIdInvalid))
        try:
            filter_ = checked_filter(asked.RequestedParameters.Filter, item.read, self._data_type(item.read))
        except ItemRefusedError as refused:
            return ua.MonitoredItemModifyResult(StatusCode=ua.StatusCode(refused.status))
        item.revise(asked.RequestedParameters, filter_)
        item.timestamps = timestamps
        return ua.MonitoredItemModifyResult(
            RevisedSamplingInterval=self._subscription.data.RevisedPublishingInterval, RevisedQueueSize=item.queue_size
        )

    async def set_monitoring_mode(self, mode: ua.MonitoringMode, ids: Sequence[int]) -> list[ua.StatusCode]:
        if mode not in tuple(ua.MonitoringMode):
            raise ua.uaerrors.BadMonitoringModeInvalid
        return [await self._set_mode(mode, number) for number in ids]

    async def _set_mode(self, mode: ua.MonitoringMode, number: int) -> ua.StatusCode:
        item = self._items.get(number)
        if item is None:
            [status] = await super().set_monitoring_mode(mode, [number])
            return status
        item.mode = mode
        if mode == ua.MonitoringMode.Disabled:  # the queue is deleted, and the next sample is a first one (5.13.4)
            item.reported = None
            item.held.clear()
        elif mode == ua.MonitoringMode.Reporting:
            while item.held:
                await self._report(item, item.held.popleft())
        return ua.StatusCode()

    def delete_monitored_items(self, ids: Iterable[int]) -> list[ua.StatusCode]:
        return [self._delete(number) for number in ids]

    def _delete(self, number: int) -> ua.StatusCode:
        item = self._items.pop(number, None)
        if item is None:
            [status] = super().delete_monitored_items([number])
            return status
        for handle in [handle for handle, own in self._by_handle.items() if own is item]:
            del self._by_handle[handle]
            self.aspace.delete_datachange_callback(handle)
        return ua.StatusCode()

    def delete_all_monitored_items(self) -> None:
        self.delete_monitored_items(list(self._items))
        super().delete_all_monitored_items()


def checked_filter(asked: Any, read: ua.ReadValueId, data_type: ua.NodeId | None) -> Filter:
    """Return the filter of a request.  ItemRefusedError with the status of the standard for one that cannot be kept."""
    if asked is None:
        return Filter()
    if isinstance(asked, ua.ExtensionObject):  # of a type that the library does not know, or none
        if asked.TypeId == ua.NodeId():
            return Filter()
        raise ItemRefusedError(ua.StatusCodes.BadMonitoredItemFilterUnsupported)
    filter_type = asked.data_type.Identifier  # the library decodes into other classes of the same names
    if filter_type == ua.ObjectIds.EventFilter:
        raise ItemRefusedError(ua.StatusCodes.BadFilterNotAllowed)
    if filter_type != ua.ObjectIds.DataChangeFilter:
        raise ItemRefusedError(ua.StatusCodes.BadMonitoredItemFilterUnsupported)
    if read.AttributeId != ua.AttributeIds.Value:
        raise ItemRefusedError(ua.StatusCodes.BadFilterNotAllowed)
    if asked.Trigger not in tuple(ua.DataChangeTrigger) or asked.DeadbandType not in tuple(ua.DeadbandType):
        raise ItemRefusedError(ua.StatusCodes.BadMonitoredItemFilterInvalid)
    if asked.DeadbandType == ua.DeadbandType.None_:
        return Filter(asked.Trigger)
    if asked.DeadbandType == ua.DeadbandType.Percent or not 0 <= asked.DeadbandValue < math.inf:
        raise ItemRefusedError(ua.StatusCodes.BadDeadbandFilterInvalid)  # OPC 10000-8, table 28: there is no EURange
    if data_type is None or data_type.NamespaceIndex != 0 or data_type.Identifier not in NUMBERS:
        raise ItemRefusedError(ua.StatusCodes.BadFilterNotAllowed)
    return Filter(asked.Trigger, asked.DeadbandValue)


NUMBERS: Final = frozenset(
    (
        *range(ua.ObjectIds.SByte, ua.ObjectIds.Double + 1),
        *(ua.ObjectIds.Number, ua.ObjectIds.Integer, ua.ObjectIds.UInteger, ua.ObjectIds.Duration),
    )
)
"""Data types whose values have a deadband."""
