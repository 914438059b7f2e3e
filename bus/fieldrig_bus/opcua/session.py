"""A client's session: what concerns nodes of devices is answered by the devices, everything else by the library."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import Coroutine, Hashable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from typing import Any, Final

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.internal_server import InternalServer
from asyncua.server.internal_session import InternalSession, SessionState

from fieldrig.outside.limits import Reached
from fieldrig_bus.opcua import calls
from fieldrig_bus.opcua.address_space import AddressSpace
from fieldrig_bus.opcua.browsing import Continuations, check_view, with_fields
from fieldrig_bus.opcua.devices import Devices
from fieldrig_bus.opcua.mapping import STATUS_CODES, WrongValueError, from_variant, to_variant
from fieldrig_bus.opcua.message import Kind, Node, Outcome, Status
from fieldrig_bus.opcua.requests import check_some, with_status, wrong_browse, wrong_call, wrong_path
from fieldrig_bus.opcua.sampler import Sampler, revised_ms
from fieldrig_bus.opcua.subscriptions import Subscription, Subscriptions
from fieldrig_bus.opcua.users import Users
from fieldrig_bus.opcua.values import SourceTimes, part_of, stamped, wrong_read

MOST_SESSIONS: Final = 16
"""Sessions of one connection; a client has one."""
_VALUE: Final = ua.AttributeIds.Value
BAD_NOT_WRITABLE: Final[int] = ua.StatusCodes.BadNotWritable
BAD_NODE_ID_UNKNOWN: Final[int] = ua.StatusCodes.BadNodeIdUnknown
BAD_USER_ACCESS_DENIED: Final[int] = ua.StatusCodes.BadUserAccessDenied
BAD_WRITE_NOT_SUPPORTED: Final[int] = ua.StatusCodes.BadWriteNotSupported
BAD_TYPE_MISMATCH: Final[int] = ua.StatusCodes.BadTypeMismatch


class Backend(InternalServer):  # type: ignore[misc]
    """The library's server, with sessions of ours, and with what they have in common."""

    def __init__(self, users: Users, fastest_ms: float) -> None:
        self.space: AddressSpace | None = None
        self.devices: Devices | None = None
        self.sampler = Sampler(self.values)
        self.source_times = SourceTimes()
        self.fastest_ms, self.users = fastest_ms, users
        self._sessions: Counter[Hashable] = Counter()
        self._closing: set[asyncio.Task[None]] = set()
        self.reached: Reached | None = None
        """The limits of the service that were reached; None before it listens."""
        super().__init__(user_manager=users)
        # The server's own session, which passes events on, has the library's service as well.
        own = Subscriptions(self.aspace, self)
        own.standard_events = self.isession.subscription_service.standard_events
        self.subscription_service: Subscriptions = own
        self.isession.subscription_service = own

    def create_session(
        self,
        name: str,
        user: User = User(role=UserRole.Anonymous),  # noqa: B008  as in the base class
        external: bool = False,
    ) -> InternalSession:
        if external:
            if self._sessions[name] >= MOST_SESSIONS:
                self.note_limit("sessions over the limit", f"{MOST_SESSIONS} sessions of a connection are open")
                raise ServiceError(ua.StatusCodes.BadTooManySessions)
            self._sessions[name] += 1
        return Session(self, self.aspace, self.subscription_service, name, user=user, external=external)

    def note_limit(self, limit: str, what: str) -> None:
        """Count and log that a client has reached a limit, and that its request is refused."""
        if self.reached is not None:
            self.reached.note(limit, f"{what}; another one is refused")

    def forget(self, name: Hashable) -> None:
        """Count the sessions of a connection no longer, because it is closed."""
        self._sessions.pop(name, None)

    def close_later(self, closing: Coroutine[Any, Any, None]) -> None:
        """Close what a lost connection has left behind."""
        task = asyncio.get_running_loop().create_task(closing)
        self._closing.add(task)
        task.add_done_callback(self._closing.discard)

    async def close_all(self) -> None:
        """Wait until everything that lost connections have left is closed."""
        await asyncio.gather(*self._closing, return_exceptions=True)

    async def values(self, node_ids: Sequence[ua.NodeId]) -> list[ua.DataValue]:
        """Return the present values of variables."""
        assert self.space is not None
        assert self.devices is not None
        by_node: dict[ua.NodeId, ua.DataValue] = {}
        by_device: dict[str, list[tuple[ua.NodeId, Node]]] = {}
        for node_id in dict.fromkeys(node_ids):
            node = self.space.node(node_id)
            if node is None:
                by_node[node_id] = _data_value(ua.StatusCodes.BadNodeIdUnknown)
            else:
                by_device.setdefault(self.space.device(node_id), []).append((node_id, node))
        reads = (self.devices.read(device, [node.path for _, node in asked]) for device, asked in by_device.items())
        answers = await asyncio.gather(*reads)  # all at once, as each of them may be late
        for asked, outcomes in zip(by_device.values(), answers, strict=True):
            for (node_id, node), outcome in zip(asked, outcomes, strict=True):
                by_node[node_id] = self.source_times.applied(node_id, _shown(node, outcome))
        return [by_node[node_id] for node_id in node_ids]


class Session(InternalSession):  # type: ignore[misc]
    iserver: Backend
    subscription_service: Subscriptions

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._continuations = Continuations()

    @property
    def may_write(self) -> bool:
        return self.iserver.users.may_write(self.user)

    async def browse(self, params: ua.BrowseParameters) -> list[ua.BrowseResult]:
        check_some(params.NodesToBrowse)
        check_view(params)
        for asked in params.NodesToBrowse:
            await self._space.browse(asked.NodeId)
        results: list[ua.BrowseResult] = await super().browse(params)
        for index, (asked, result) in enumerate(zip(params.NodesToBrowse, results, strict=True)):
            wrong = wrong_browse(asked, self.aspace)
            if wrong:
                results[index] = with_status(ua.BrowseResult(), wrong)
                continue
            result.References = with_fields(result.References, asked.ResultMask)
            self._continuations.first(result, params.RequestedMaxReferencesPerNode)
        return results

    async def browse_next(self, parameters: ua.BrowseNextParameters) -> list[ua.BrowseResult]:
        check_some(parameters.ContinuationPoints)
        return self._continuations.next(parameters)

    async def translate_browsepaths_to_nodeids(self, params: list[ua.BrowsePath]) -> list[ua.BrowsePathResult]:
        check_some(params)
        results = []
        for path in params:
            await self._space.ensure(path.StartingNode)
            wrong = wrong_path(path, self.aspace)
            if wrong:
                results.append(with_status(ua.BrowsePathResult(), wrong))
                continue
            await self._walk(path)
            results += await super().translate_browsepaths_to_nodeids([path])
        return results

    async def read(self, params: ua.ReadParameters) -> list[ua.DataValue]:
        check_some(params.NodesToRead)
        if not params.MaxAge >= 0:  # or NaN
            raise ServiceError(ua.StatusCodes.BadMaxAgeInvalid)
        check_timestamps(params.TimestampsToReturn)
        for asked in params.NodesToRead:
            await self._space.ensure(asked.NodeId)
        results: list[ua.DataValue] = await super().read(params)
        ours = [
            index
            for index, asked in enumerate(params.NodesToRead)
            if asked.AttributeId == _VALUE and self._is_variable(asked.NodeId)
        ]
        values = await self.iserver.values([params.NodesToRead[index].NodeId for index in ours])
        for index, value in zip(ours, values, strict=True):
            results[index] = value
        if not self.may_write:
            self._hide_rights(params, results)
        for index, asked in enumerate(params.NodesToRead):
            wrong = wrong_read(asked)
            value = _data_value(wrong) if wrong else part_of(asked, results[index])
            results[index] = stamped(value, params.TimestampsToReturn)
        return results

    async def history_read(self, params: ua.HistoryReadParameters) -> list[ua.HistoryReadResult]:
        check_some(params.NodesToRead)
        wrong = ua.StatusCodes.BadHistoryOperationUnsupported  # the recording of signals has the history
        return [with_status(ua.HistoryReadResult(HistoryData=ua.HistoryData()), wrong) for _ in params.NodesToRead]

    async def write(self, params: ua.WriteParameters) -> list[ua.StatusCode]:
        check_some(params.NodesToWrite)
        results = []
        for asked in params.NodesToWrite:
            await self._space.ensure(asked.NodeId)
            results.append(ua.StatusCode(await self._write(asked)))
        return results

    async def call(self, params: list[ua.CallMethodRequest]) -> list[ua.CallMethodResult]:
        check_some(params)
        results = []
        for asked in params:
            await self._space.ensure(asked.MethodId)
            await self._space.ensure(asked.ObjectId)
            wrong = wrong_call(asked, self.aspace)
            if wrong:
                results.append(calls.refused(wrong))
                continue
            node = self._space.node(asked.MethodId)
            if node is None or node.kind is not Kind.METHOD:
                results += await super().call([asked])
                continue
            results.append(await self._call(asked, node))
        return results

    async def create_monitored_items(
        self, params: ua.CreateMonitoredItemsParameters
    ) -> list[ua.MonitoredItemCreateResult]:
        check_some(params.ItemsToCreate)
        check_timestamps(params.TimestampsToReturn)
        subscription = self._own(params.SubscriptionId)
        results = []
        for asked in params.ItemsToCreate:
            await self._space.ensure(asked.ItemToMonitor.NodeId)
            if asked.ItemToMonitor.AttributeId == ua.AttributeIds.EventNotifier:
                if wrong := self._wrong_attribute(asked.ItemToMonitor.NodeId, asked.ItemToMonitor.AttributeId):
                    results.append(ua.MonitoredItemCreateResult(StatusCode=ua.StatusCode(wrong)))
                    continue
                results += await super().create_monitored_items(replace(params, ItemsToCreate=[asked]))
            else:
                results.append(await self._create_item(subscription, asked, params.TimestampsToReturn))
        return results

    def _wrong_attribute(self, node_id: ua.NodeId, attribute: int) -> int:
        """Return the status of an attribute that is not there, or of a node; 0 for one that is there."""
        status = self.aspace.read_attribute_value(node_id, attribute).StatusCode
        wrong = status.value in (BAD_NODE_ID_UNKNOWN, ua.StatusCodes.BadAttributeIdInvalid)
        return status.value if wrong else 0

    async def _create_item(
        self,
        subscription: Subscription,
        asked: ua.MonitoredItemCreateRequest,
        timestamps: ua.TimestampsToReturn,
    ) -> ua.MonitoredItemCreateResult:
        read = asked.ItemToMonitor
        is_sampled = read.AttributeId == _VALUE and self._is_variable(read.NodeId)
        result = await subscription.items.create(asked, timestamps, is_sampled=is_sampled)
        if is_sampled and result.StatusCode.is_good():
            number, interval_ms = result.MonitoredItemId, self._revised_ms(subscription, asked.RequestedParameters)
            result.RevisedSamplingInterval = interval_ms
            item = subscription.data.SubscriptionId, number
            await self.iserver.sampler.add(item, read.NodeId, interval_ms, partial(subscription.items.take, number))
        return result

    async def modify_monitored_items(
        self, params: ua.ModifyMonitoredItemsParameters
    ) -> list[ua.MonitoredItemModifyResult]:
        check_some(params.ItemsToModify)
        check_timestamps(params.TimestampsToReturn)
        subscription = self._own(params.SubscriptionId)
        results = []
        for asked in params.ItemsToModify:
            result = subscription.items.modify(asked, params.TimestampsToReturn)
            if result.StatusCode.is_good() and self._is_sampled(subscription, asked.MonitoredItemId):
                interval_ms = self._revised_ms(subscription, asked.RequestedParameters)
                result.RevisedSamplingInterval = interval_ms
                self.iserver.sampler.change((params.SubscriptionId, asked.MonitoredItemId), interval_ms)
            results.append(result)
        return results

    def _is_sampled(self, subscription: Subscription, number: int) -> bool:
        return (subscription.data.SubscriptionId, number) in self.iserver.sampler

    async def delete_monitored_items(self, params: ua.DeleteMonitoredItemsParameters) -> list[ua.StatusCode]:
        check_some(params.MonitoredItemIds)
        self._own(params.SubscriptionId)
        self.iserver.sampler.remove((params.SubscriptionId, number) for number in params.MonitoredItemIds)
        results: list[ua.StatusCode] = await super().delete_monitored_items(params)
        return results

    async def set_monitoring_mode(self, params: ua.SetMonitoringModeParameters) -> list[ua.StatusCode]:
        check_some(params.MonitoredItemIds)
        self._own(params.SubscriptionId)
        results: list[ua.StatusCode] = await super().set_monitoring_mode(params)
        return results

    async def set_publishing_mode(self, params: ua.SetPublishingModeParameters) -> list[ua.StatusCode]:
        check_some(params.SubscriptionIds)
        results = []
        for number in params.SubscriptionIds:
            if self._is_own(number):
                results += await super().set_publishing_mode(replace(params, SubscriptionIds=[number]))
            else:
                results.append(ua.StatusCode(ua.StatusCodes.BadSubscriptionIdInvalid))
        return results

    def republish(self, params: ua.RepublishParameters) -> ua.NotificationMessage:
        self._own(params.SubscriptionId)
        return super().republish(params)

    async def delete_subscriptions(self, ids: Sequence[int]) -> list[ua.StatusCode]:
        if self.state is not SessionState.Closed:  # a session that closes may have none
            check_some(ids)
        results = []
        for number in ids:
            if self._is_own(number):
                self.iserver.sampler.remove_subscription(number)
                results += await super().delete_subscriptions([number])
            else:
                results.append(ua.StatusCode(ua.StatusCodes.BadSubscriptionIdInvalid))
        return results

    def _is_own(self, number: int) -> bool:
        """True for a subscription of this session: another session neither sees nor changes it."""
        subscription = self.subscription_service.subscriptions.get(number)
        return subscription is not None and subscription.session_id == self.session_id

    def _own(self, number: int) -> Subscription:
        if not self._is_own(number):
            raise ServiceError(ua.StatusCodes.BadSubscriptionIdInvalid)
        return self.subscription_service.of(number)

    async def change_subscription(self, params: ua.ModifySubscriptionParameters) -> ua.ModifySubscriptionResult:
        self._own(params.SubscriptionId)
        return await self.subscription_service.change(params)

    async def transfer_subscriptions(self, params: Any, callback: Any) -> list[ua.TransferResult]:
        raise ServiceError(ua.StatusCodes.BadServiceUnsupported)

    # ---- nodes of devices

    @property
    def _space(self) -> AddressSpace:
        assert self.iserver.space is not None
        return self.iserver.space

    def _is_variable(self, node_id: ua.NodeId) -> bool:
        node = self._space.node(node_id)
        return node is not None and node.kind is Kind.VARIABLE

    def _revised_ms(self, subscription: Subscription, asked: ua.MonitoringParameters) -> float:
        publishing_ms = subscription.data.RevisedPublishingInterval
        return revised_ms(asked.SamplingInterval, publishing_ms, self.iserver.fastest_ms)

    def _hide_rights(self, params: ua.ReadParameters, results: list[ua.DataValue]) -> None:
        """Show users without write access that they have none."""
        for index, asked in enumerate(params.NodesToRead):
            node = self._space.node(asked.NodeId)
            if node is None:
                continue
            if asked.AttributeId == ua.AttributeIds.UserAccessLevel and node.kind is Kind.VARIABLE:
                results[index] = ua.DataValue(ua.Variant(1 << ua.AccessLevel.CurrentRead, ua.VariantType.Byte))
            if asked.AttributeId == ua.AttributeIds.UserExecutable and node.kind is Kind.METHOD and node.is_writable:
                results[index] = ua.DataValue(ua.Variant(False, ua.VariantType.Boolean))

    async def _walk(self, path: ua.BrowsePath) -> None:
        """Add the nodes along a path of names."""
        current = {path.StartingNode}
        for element in path.RelativePath.Elements:
            reached = set()
            for node_id in current:
                await self._space.browse(node_id)
                data = self.aspace.get(node_id)
                references = data.references if data is not None else []
                reached |= {reference.NodeId for reference in references if reference.BrowseName == element.TargetName}
            current = reached

    async def _write(self, asked: ua.WriteValue) -> int:
        node = self._space.node(asked.NodeId)
        if wrong := self._wrong_attribute(asked.NodeId, asked.AttributeId):
            return wrong
        if node is None:
            return BAD_NOT_WRITABLE
        if asked.AttributeId != _VALUE or node.kind is not Kind.VARIABLE or not node.is_writable:
            return BAD_NOT_WRITABLE
        if not self.may_write:
            return BAD_USER_ACCESS_DENIED
        if asked.IndexRange:
            return BAD_WRITE_NOT_SUPPORTED  # elements have nodes of their own
        if asked.Value is None or asked.Value.Value is None:
            return BAD_TYPE_MISMATCH
        if _has_status_or_server_time(asked.Value):
            return BAD_WRITE_NOT_SUPPORTED  # 5.11.4.1: they are those of the device and of this server
        try:
            value = from_variant(node, asked.Value.Value)
        except WrongValueError as cause:
            return STATUS_CODES[cause.status]
        assert self.iserver.devices is not None
        outcome = await self.iserver.devices.write(self._space.device(asked.NodeId), node.path, value)
        if outcome.status is Status.GOOD:
            self.iserver.source_times.note(asked.NodeId, asked.Value)
        return STATUS_CODES[outcome.status]

    async def _call(self, asked: ua.CallMethodRequest, node: Node) -> ua.CallMethodResult:
        if node.is_writable and not self.may_write:
            return calls.refused(BAD_USER_ACCESS_DENIED)
        assert self.iserver.devices is not None
        return await calls.call(self._space, self.iserver.devices, asked, node)

    async def close_session(self, delete_subs: bool = True) -> None:
        with contextlib.suppress(ua.UaError):
            await super().close_session(delete_subs)


def _has_status_or_server_time(written: ua.DataValue) -> bool:
    has_status = written.StatusCode is not None and written.StatusCode.value != ua.StatusCodes.Good
    return has_status or written.ServerTimestamp is not None or written.ServerPicoseconds is not None


def check_timestamps(timestamps: ua.TimestampsToReturn) -> None:
    """Raise ServiceError for a value that OPC 10000-4, 7.40, does not define."""
    if timestamps == ua.TimestampsToReturn.Invalid:
        raise ServiceError(ua.StatusCodes.BadTimestampsToReturnInvalid)


def _shown(node: Node, outcome: Outcome) -> ua.DataValue:
    if outcome.status is not Status.GOOD or outcome.value is None:
        return _data_value(STATUS_CODES[outcome.status])
    now = datetime.now(UTC)
    return ua.DataValue(to_variant(node, outcome.value), SourceTimestamp=now, ServerTimestamp=now)


def _data_value(status: int) -> ua.DataValue:
    now = datetime.now(UTC)
    return ua.DataValue(ua.Variant(None), ua.StatusCode(status), SourceTimestamp=now, ServerTimestamp=now)
