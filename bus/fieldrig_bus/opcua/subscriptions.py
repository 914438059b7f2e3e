"""Subscriptions whose parameters are kept as their clients have asked for them, or revised in the answer.

Source: OPC 10000-4, 5.14 (Subscription Service Set).  The library publishes; it takes the most notifications of a
message, changed parameters, and acknowledgements of messages that are not there, without looking at them.
Left out: the priority (5.14.2 leaves its use to the server), and the transfer to another session.
"""

from collections.abc import Callable, Iterable
from typing import Any, Final

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.subscription_service import SubscriptionService

from fieldrig_bus.opcua.items import LONGEST_QUEUE, Items

FASTEST_MS: Final = 10.0
SLOWEST_MS: Final = 3_600_000.0
MOST_UNACKNOWLEDGED: Final = 100
"""Messages that a subscription keeps for Republish."""
MOST_SUBSCRIPTIONS: Final = 100
"""Subscriptions of all clients together."""


def revised_ms(requested_ms: float) -> float:
    """Return the publishing interval; 0, a negative one and NaN ask for the fastest (5.14.2.2)."""
    return min(max(FASTEST_MS, requested_ms), SLOWEST_MS)  # in this order NaN becomes the fastest


class Subscription(InternalSubscription):  # type: ignore[misc]
    """A subscription with monitored items of ours, which keeps the most notifications of a message."""

    def __init__(self, data: ua.CreateSubscriptionResult, *arguments: Any, most: int, **options: Any) -> None:
        super().__init__(data, *arguments, **options)
        self.items = Items(self, arguments[0])
        self.monitored_item_srv = self.items
        self.most = most
        """The most notifications of a message; 0: any number."""
        self._triggered_datachanges: dict[int, list[Any]] = {}
        self._waiting: list[Any] = []
        """Notifications that did not fit into the last message."""

    def has_published_results(self) -> bool:
        return bool(self._publishing_enabled and self._waiting) or bool(super().has_published_results())

    async def publish_results(self, requestdata: Any = None) -> bool:
        """Send a message, and further ones while there are notifications and requests for them (5.14.1.2)."""
        is_sent: bool = await super().publish_results(requestdata)
        has_more = is_sent and bool(self._waiting)
        while has_more:
            has_more = await super().publish_results() and bool(self._waiting)
        return is_sent

    def _pop_publish_result(self) -> ua.PublishResult:
        result = super()._pop_publish_result()
        result.MoreNotifications = bool(self._waiting)
        return result

    def _pop_triggered_datachanges(self, result: ua.PublishResult) -> None:
        changes = [item for queue in self._triggered_datachanges.values() for item in queue]
        self._triggered_datachanges = {}
        waiting = [*self._waiting, *changes]
        count = self.most or len(waiting)
        now, self._waiting = waiting[:count], waiting[count:]
        if now:
            result.NotificationMessage.NotificationData.append(ua.DataChangeNotification(MonitoredItems=now))

    async def change(self, interval_ms: float, lifetime: int, keep_alive: int, most: int) -> None:
        """Take changed parameters, which hold from the next publishing on."""
        self.most = most
        self.data.RevisedLifetimeCount, self.data.RevisedMaxKeepAliveCount = lifetime, keep_alive
        if interval_ms != self.data.RevisedPublishingInterval:
            self.data.RevisedPublishingInterval = interval_ms
            if self._task is not None:
                self._task.cancel()
                await self.start()

    def acknowledge(self, number: int) -> ua.StatusCode:
        is_known = self._not_acknowledged_results.pop(number, None) is not None
        return ua.StatusCode(ua.StatusCodes.Good if is_known else ua.StatusCodes.BadSequenceNumberUnknown)

    def message(self, number: int) -> ua.NotificationMessage:
        """Return a message that is not acknowledged yet; it stays until it is."""
        result = self._not_acknowledged_results.get(number)
        if result is None:
            raise ServiceError(ua.StatusCodes.BadMessageNotAvailable)
        return result.NotificationMessage


class Subscriptions(SubscriptionService):  # type: ignore[misc]
    """The subscriptions of all sessions."""

    async def create_subscription(
        self,
        params: ua.CreateSubscriptionParameters,
        callback: Callable[..., Any],
        session_id: ua.NodeId,
        request_callback: Callable[..., Any] | None = None,
    ) -> ua.CreateSubscriptionResult:
        if len(self.subscriptions) >= MOST_SUBSCRIPTIONS:
            self.iserver.note_limit("subscriptions over the limit", f"{MOST_SUBSCRIPTIONS} subscriptions are open")
            raise ServiceError(ua.StatusCodes.BadTooManySubscriptions)
        self._sub_id_counter += 1
        result = ua.CreateSubscriptionResult()
        number = result.SubscriptionId = self._sub_id_counter
        result.RevisedPublishingInterval = revised_ms(params.RequestedPublishingInterval)
        result.RevisedLifetimeCount, result.RevisedMaxKeepAliveCount = self._counts(params)
        subscription = Subscription(
            result,
            self.aspace,
            callback,
            session_id,
            most=params.MaxNotificationsPerPublish,
            request_callback=request_callback,
            delete_callback=lambda: self.subscriptions.pop(number, None),
            no_acks_limit=MOST_UNACKNOWLEDGED,
            max_queue_size=LONGEST_QUEUE,
            publishing_enabled=params.PublishingEnabled,
        )
        self.subscriptions[number] = subscription
        await subscription.start()
        return result

    def _counts(self, params: Any) -> tuple[int, int]:
        """Return lifetime and keep-alive count; the lifetime is at least three times the other (5.14.2.2)."""
        keep_alive = self._clamp_keep_alive_count(params.RequestedMaxKeepAliveCount)
        return max(self._clamp_lifetime_count(params.RequestedLifetimeCount), 3 * keep_alive), keep_alive

    def of(self, number: int) -> Subscription:
        subscription = self.subscriptions.get(number)
        if not isinstance(subscription, Subscription):
            raise ServiceError(ua.StatusCodes.BadSubscriptionIdInvalid)
        return subscription

    async def change(self, params: ua.ModifySubscriptionParameters) -> ua.ModifySubscriptionResult:
        subscription = self.of(params.SubscriptionId)
        interval_ms = revised_ms(params.RequestedPublishingInterval)
        lifetime, keep_alive = self._counts(params)
        await subscription.change(interval_ms, lifetime, keep_alive, params.MaxNotificationsPerPublish)
        return ua.ModifySubscriptionResult(
            RevisedPublishingInterval=interval_ms, RevisedLifetimeCount=lifetime, RevisedMaxKeepAliveCount=keep_alive
        )

    def publish(self, acks: Iterable[ua.SubscriptionAcknowledgement]) -> tuple[int, list[ua.StatusCode]]:
        if not self.subscriptions:
            raise ServiceError(ua.StatusCodes.BadNoSubscription)
        return len(self.subscriptions), [self._acknowledge(ack) for ack in acks]

    def _acknowledge(self, ack: ua.SubscriptionAcknowledgement) -> ua.StatusCode:
        subscription = self.subscriptions.get(ack.SubscriptionId)
        if not isinstance(subscription, Subscription):
            return ua.StatusCode(ua.StatusCodes.BadSubscriptionIdInvalid)
        return subscription.acknowledge(ack.SequenceNumber)

    def republish(self, params: ua.RepublishParameters) -> ua.NotificationMessage:
        return self.of(params.SubscriptionId).message(params.RetransmitSequenceNumber)
