"""The values of the server's own nodes: what it is, and its limits, as strict clients read them while they connect.

Source: OPC 10000-5, 6.3.1 to 6.3.4.  asyncua leaves them empty, and a client that checks their types then refuses to
connect.  A limit of 0 is none.
"""

from collections.abc import Iterator
from importlib.metadata import version

from asyncua import Server, ua

from fieldrig_bus.opcua.browsing import MOST_POINTS
from fieldrig_bus.opcua.items import LONGEST_QUEUE
from fieldrig_bus.opcua.message import MOST_ELEMENTS
from fieldrig_bus.opcua.subscriptions import MOST_SUBSCRIPTIONS

PRODUCT = "fieldrig"


def _values(fastest_sampling_ms: float) -> Iterator[tuple[int, ua.VariantType, object]]:
    kind, ids = ua.VariantType, ua.ObjectIds
    yield ids.Server_Auditing, kind.Boolean, False
    yield ids.Server_ServerStatus_SecondsTillShutdown, kind.UInt32, 0
    yield ids.Server_ServerStatus_ShutdownReason, kind.LocalizedText, ua.LocalizedText()
    yield ids.Server_ServerRedundancy_RedundancySupport, kind.Int32, 0
    yield ids.Server_ServerDiagnostics_EnabledFlag, kind.Boolean, False
    yield ids.Server_ServerCapabilities_ServerProfileArray, kind.String, []
    yield ids.Server_ServerCapabilities_LocaleIdArray, kind.String, ["en"]
    yield ids.Server_ServerCapabilities_MinSupportedSampleRate, kind.Double, fastest_sampling_ms
    yield ids.Server_ServerCapabilities_MaxBrowseContinuationPoints, kind.UInt16, MOST_POINTS
    yield ids.Server_ServerCapabilities_MaxQueryContinuationPoints, kind.UInt16, 0
    yield ids.Server_ServerCapabilities_MaxHistoryContinuationPoints, kind.UInt16, 0
    yield ids.Server_ServerCapabilities_SoftwareCertificates, kind.ExtensionObject, []
    yield ids.Server_ServerCapabilities_MaxArrayLength, kind.UInt32, MOST_ELEMENTS
    yield ids.Server_ServerCapabilities_MaxStringLength, kind.UInt32, 0
    yield ids.Server_ServerCapabilities_MaxByteStringLength, kind.UInt32, 0
    yield ids.Server_ServerCapabilities_MaxSessions, kind.UInt32, 0
    yield ids.Server_ServerCapabilities_MaxSubscriptions, kind.UInt32, MOST_SUBSCRIPTIONS
    yield ids.Server_ServerCapabilities_MaxSubscriptionsPerSession, kind.UInt32, MOST_SUBSCRIPTIONS
    yield ids.Server_ServerCapabilities_MaxMonitoredItems, kind.UInt32, 0
    yield ids.Server_ServerCapabilities_MaxMonitoredItemsPerSubscription, kind.UInt32, 0
    yield ids.Server_ServerCapabilities_MaxMonitoredItemsQueueSize, kind.UInt32, LONGEST_QUEUE
    yield ids.Server_ServerCapabilities_MaxSelectClauseParameters, kind.UInt32, 0
    yield ids.Server_ServerCapabilities_MaxWhereClauseParameters, kind.UInt32, 0
    yield ids.Server_ServerCapabilities_ConformanceUnits, kind.QualifiedName, []


async def fill(server: Server, fastest_sampling_ms: float) -> None:
    """Give the server's own nodes their values."""
    built = await server.get_node(ua.ObjectIds.Server_ServerStatus_BuildInfo_BuildDate).read_value()
    number = version(PRODUCT)
    await server.set_build_info(f"urn:{PRODUCT}", PRODUCT, PRODUCT, number, number, built)
    for node, kind, value in _values(fastest_sampling_ms):
        variant = ua.Variant(value, kind, is_array=isinstance(value, list))
        await server.get_node(node).write_value(ua.DataValue(variant))
