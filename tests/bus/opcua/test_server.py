"""The server with a client of the same library; `tests/real` has a foreign one."""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from asyncua import Client, ua
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from cryptography.x509.oid import ExtendedKeyUsageOID
from in_loop import in_loop
from opcua_bench import ServerBench, server_bench

from fieldrig.errors import BusError
from fieldrig_bus.opcua.sampler import revised_ms
from fieldrig_bus.opcua.server import OpcUaSettings
from fieldrig_bus.opcua.session import MOST_SESSIONS
from fieldrig_bus.opcua.subscriptions import MOST_SUBSCRIPTIONS

pytestmark = pytest.mark.system

POSITION = "ns=2;s=belt.Position"


class Heard:
    """Notifications of a subscription."""

    def __init__(self) -> None:
        self.values: asyncio.Queue[Any] = asyncio.Queue()
        self.changes: asyncio.Queue[Any] = asyncio.Queue()

    def datachange_notification(self, _node: Any, value: Any, data: Any) -> None:
        self.values.put_nowait(value)

    def event_notification(self, event: Any) -> None:
        self.changes.put_nowait(event.Changes)


async def code_of(request: Any) -> str:
    """The name of the status code that a request is refused with."""
    with pytest.raises(ua.UaStatusCodeError) as refused:
        await request
    return type(refused.value).__name__


@in_loop
async def test_a_client_browses_the_nodes_with_their_types_units_and_texts(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        plc = await client.nodes.objects.get_child("2:plc")
        names = [(await node.read_browse_name()).Name for node in await plc.get_children()]
        assert names == ["belt", "start", "stop", "hold", "held"]
        position = await plc.get_child(["2:belt", "2:Position"])
        assert position.nodeid.to_string() == POSITION
        assert (await position.read_data_type()).Identifier == ua.ObjectIds.Double
        assert (await position.read_description()).Text == "position of the belt"
        unit = await (await position.get_child("0:EngineeringUnits")).read_value()
        assert (unit.UnitId, unit.DisplayName.Text) == (5066068, "mm")
        assert await position.get_user_access_level() == {ua.AccessLevel.CurrentRead, ua.AccessLevel.CurrentWrite}
        on = client.get_node("ns=2;s=belt.On")
        assert await on.get_access_level() == {ua.AccessLevel.CurrentRead}


OWN = [
    (ua.ObjectIds.Server_ServerCapabilities_MaxBrowseContinuationPoints, "UInt16", 16),
    (ua.ObjectIds.Server_ServerCapabilities_MaxQueryContinuationPoints, "UInt16", 0),
    (ua.ObjectIds.Server_ServerCapabilities_MaxHistoryContinuationPoints, "UInt16", 0),
    (ua.ObjectIds.Server_ServerCapabilities_MinSupportedSampleRate, "Double", 10.0),
    (ua.ObjectIds.Server_ServerCapabilities_LocaleIdArray, "String", ["en"]),
    (ua.ObjectIds.Server_ServerCapabilities_ServerProfileArray, "String", []),
    (ua.ObjectIds.Server_ServerCapabilities_SoftwareCertificates, "ExtensionObject", []),
    (ua.ObjectIds.Server_ServerCapabilities_MaxArrayLength, "UInt32", 10_000),
    (ua.ObjectIds.Server_ServerCapabilities_MaxSubscriptions, "UInt32", MOST_SUBSCRIPTIONS),
    (ua.ObjectIds.Server_ServerStatus_SecondsTillShutdown, "UInt32", 0),
    (ua.ObjectIds.Server_ServerRedundancy_RedundancySupport, "Int32", 0),
    (ua.ObjectIds.Server_ServerDiagnostics_EnabledFlag, "Boolean", False),
    (ua.ObjectIds.Server_Auditing, "Boolean", False),
    (ua.ObjectIds.Server_ServerStatus_BuildInfo_ProductName, "String", "fieldrig"),
]


@in_loop
async def test_the_nodes_of_the_server_have_values_of_their_types(tmp_path: Path) -> None:
    """OPC 10000-5, 6.3: a client that checks the types while it connects refuses a server that leaves them empty."""
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        found = [await client.get_node(node).read_data_value() for node, _, _ in OWN]
        assert [(one.Value.VariantType.name, one.Value.Value) for one in found] == [
            (kind, value) for _, kind, value in OWN
        ]


@in_loop
async def test_a_value_is_that_of_the_instant_of_reading(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        position = client.get_node(POSITION)
        for value in (1.5, 2.5):
            bench.plc.values["belt.Position"] = value
            assert await position.read_value() == value
        assert await code_of(client.get_node("ns=2;s=belt.Speed").read_value()) == "BadNodeIdUnknown"


@in_loop
async def test_values_that_fit_into_no_message_together_are_read_one_after_the_other(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        bench.plc.values |= {f"belt.Text{number}": str(number) * 300_000 for number in range(8)}
        bench.plc.values["belt.Long"] = "x" * 2_000_000
        texts = [client.get_node(f"ns=2;s=belt.Text{number}") for number in range(8)]
        assert await client.read_values(texts) == [str(number) * 300_000 for number in range(8)]
        assert await code_of(client.get_node("ns=2;s=belt.Long").read_value()) == "BadEncodingLimitsExceeded"
        assert await code_of(texts[0].write_value("y" * 2_000_000)) == "BadNotWritable"
        assert await code_of(client.get_node(f"ns=2;s={'x' * 5_000}").read_value()) == "BadNodeIdUnknown"


@in_loop
async def test_a_write_is_carried_out_or_refused_with_its_status(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        position = client.get_node(POSITION)
        await position.write_value(7.25)
        assert bench.plc.values["belt.Position"] == 7.25
        assert await code_of(position.write_value(ua.Variant(7, ua.VariantType.Int32))) == "BadTypeMismatch"
        assert await code_of(position.write_value(-1.0)) == "BadOutOfRange"
        assert await code_of(client.get_node("ns=2;s=belt.On").write_value(False)) == "BadNotWritable"
        belt = client.get_node("ns=2;s=belt")  # an object, which has no value
        assert await code_of(belt.write_value(False)) == "BadAttributeIdInvalid"
        assert await code_of(client.get_node("ns=2;s=none").write_value(False)) == "BadNodeIdUnknown"
        assert bench.plc.values == {"belt.Position": 7.25, "belt.On": True}


@in_loop
async def test_a_method_is_called_or_refused(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        plc = await client.nodes.objects.get_child("2:plc")
        await plc.call_method("2:start")
        assert bench.plc.called == ["start"]
        assert await code_of(plc.call_method("2:stop")) == "BadInvalidState"
        assert await code_of(plc.call_method(ua.NodeId("start()", 2), 1)) == "BadTooManyArguments"
        belt = client.get_node("ns=2;s=belt")
        assert await code_of(belt.call_method(ua.NodeId("start()", 2))) == "BadMethodInvalid"
        assert bench.plc.called == ["start"]


@in_loop
async def test_arguments_of_a_method_have_names_types_and_texts(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        hold, held = client.get_node("ns=2;s=hold()"), client.get_node("ns=2;s=held()")
        given = await (await hold.get_child("0:InputArguments")).read_value()
        assert [(one.Name, one.DataType.Identifier, one.ValueRank, one.Description.Text) for one in given] == [
            ("Variable", ua.ObjectIds.NodeId, -1, "what to hold"),
            ("Value", ua.ObjectIds.BaseDataType, -2, "where to hold it"),
        ]
        [result] = await (await held.get_child("0:OutputArguments")).read_value()
        assert (result.Name, result.DataType.Identifier, result.ValueRank) == ("Variables", ua.ObjectIds.NodeId, 1)
        assert [await (await node.get_parent()).read_browse_name() for node in (hold, held)] == [
            ua.QualifiedName("plc", 2)
        ] * 2


@in_loop
async def test_arguments_reach_the_device_or_are_refused_one_by_one(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        position, on = ua.NodeId("belt.Position", 2), ua.NodeId("belt.On", 2)
        plc, hold = client.get_node("ns=2;i=1"), ua.NodeId("hold()", 2)
        assert await plc.call_method(hold, position, 7.5) is None
        assert bench.plc.held == {"belt.Position": 7.5}
        assert await plc.call_method("2:held") == [position]

        async def statuses(*arguments: Any) -> list[str]:
            request = ua.CallMethodRequest(plc.nodeid, hold, [ua.Variant(argument) for argument in arguments])
            [result] = await client.uaclient.call([request])
            return [result.StatusCode.name, *(status.name for status in result.InputArgumentResults)]

        assert await statuses(position) == ["BadArgumentsMissing"]
        assert await statuses(position, 1.0, 2.0) == ["BadTooManyArguments"]
        assert await statuses(position, True) == ["BadInvalidArgument", "Good", "BadTypeMismatch"]
        assert await statuses("belt.Position", 1.0) == ["BadInvalidArgument", "BadTypeMismatch", "Good"]
        assert await statuses(on, False) == ["BadInvalidArgument", "BadNotWritable", "Good"]
        for unknown in (ua.NodeId("none", 2), ua.NodeId("belt.Position", 9), ua.NodeId(2253, 0)):
            assert await statuses(unknown, 1.0) == ["BadInvalidArgument", "BadNodeIdUnknown", "Good"]
        assert bench.plc.held == {"belt.Position": 7.5}


@in_loop
async def test_a_subscription_samples_while_it_exists_and_only_then(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        heard, position = Heard(), client.get_node(POSITION)
        subscription = await client.create_subscription(20, heard)
        item = await subscription.subscribe_data_change(position, sampling_interval=10)
        assert await heard.values.get() == 1.5
        bench.plc.values["belt.Position"] = 2.5
        assert await heard.values.get() == 2.5
        assert bench.reads() > 0
        await subscription.unsubscribe(item)
        await position.read_browse_name()
        bench.reads()
        assert _sampler(bench).intervals_ms == []
        await subscription.subscribe_data_change(position, sampling_interval=10)
        assert _sampler(bench).intervals_ms == [10.0]
        await subscription.delete()
        assert _sampler(bench).intervals_ms == []


def _sampler(bench: ServerBench) -> Any:
    [port] = bench.hub._ports
    return port._backend.sampler


@in_loop
async def test_a_session_that_ends_takes_its_sampling_with_it(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench:
        async with Client(bench.url) as client:
            subscription = await client.create_subscription(20, Heard())
            await subscription.subscribe_data_change(client.get_node(POSITION), sampling_interval=10)
            assert _sampler(bench).intervals_ms == [10.0]
        assert _sampler(bench).intervals_ms == []


# OPC 10000-4, 7.21 (MonitoringParameters): -1 is the publishing interval, 0 the fastest practical rate.
@pytest.mark.parametrize(
    ("requested", "revised"), [(-1.0, 500.0), (0.0, 100.0), (25.0, 25.0), (1.0, 10.0), (1e9, 3_600_000.0)]
)
def test_the_sampling_interval_is_the_requested_one_within_limits(requested: float, revised: float) -> None:
    assert revised_ms(requested, 500.0, 10.0) == revised


@in_loop
async def test_nodes_follow_a_change_of_the_device_and_sessions_and_subscriptions_stay(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        heard, belt = Heard(), client.get_node("ns=2;s=belt")
        subscription = await client.create_subscription(20, heard)
        await subscription.subscribe_data_change(client.get_node(POSITION), sampling_interval=10)
        await subscription.subscribe_events(ua.ObjectIds.Server, ua.ObjectIds.GeneralModelChangeEventType)
        assert len(await belt.get_children()) == 2
        await client.get_node("ns=2;s=belt.On").read_value()
        bench.plc.values |= {"belt.On": 3, "belt.Torque": 0.5}
        bench.face.offer()
        changes = {(change.Affected.to_string(), change.Verb) for change in await heard.changes.get()}
        assert changes == {("ns=2;s=belt.On", 16), ("ns=2;s=belt.Torque", 1)}  # DataTypeChanged, NodeAdded
        assert await client.get_node("ns=2;s=belt.On").read_value() == 3
        assert len(await belt.get_children()) == 3
        del bench.plc.values["belt.Torque"]
        bench.face.offer()
        [change] = await heard.changes.get()
        assert (change.Affected.to_string(), change.Verb) == ("ns=2;s=belt.Torque", 2)  # NodeDeleted
        assert await code_of(client.get_node("ns=2;s=belt.Torque").read_value()) == "BadNodeIdUnknown"
        bench.plc.values["belt.Position"] = 9.0
        while await heard.values.get() != 9.0:
            pass


@in_loop
async def test_a_second_device_has_a_namespace_of_its_own(tmp_path: Path) -> None:
    async with server_bench(tmp_path, order=["tank", "plc"]) as bench, Client(bench.url) as client:
        assert (await client.get_namespace_array())[2:] == ["urn:fieldrig:bench:tank", "urn:fieldrig:bench:plc"]
        assert await client.get_node("ns=3;s=belt.Position").read_value() == 1.5


# ---- malformed bytes

HELLO = (
    b"HELF\x38\x00\x00\x00\x00\x00\x00\x00\x00\x00\x01\x00\x00\x00\x01\x00\x00\x00\x00\x00\x00\x00\x00\x00"
    b"\x18\x00\x00\x00opc.tcp://127.0.0.1:4840"
)
"""OPC 10000-6, 7.1.2.3: message type, size, version, two buffer sizes, limits, and the URL with its length."""
HOSTILE = {
    "noise": [b"\x00\xff" * 500],
    "size 0": [b"HELF\x00\x00\x00\x00"],
    "largest size": [b"HELF\xff\xff\xff\xff" + bytes(100)],
    "cut": [HELLO[:20]],
    "message before a channel": [HELLO, b"MSGF\x18\x00\x00\x00" + bytes(16)],
    "channel without a policy": [HELLO, b"OPNF\x20\x00\x00\x00\x00\x00\x00\x00\xff\xff\xff\x7f" + bytes(16)],
    "nothing": [],
}


@in_loop
async def test_malformed_bytes_disturb_no_other_client_and_fill_no_log(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with server_bench(tmp_path) as bench:
        caplog.clear()
        host, port = bench.settings.listen.split(":")
        for parts in HOSTILE.values():
            _, writer = await asyncio.open_connection(host, int(port))
            for part in parts:
                writer.write(part)
            async with Client(bench.url) as client:
                assert await client.get_node(POSITION).read_value() == 1.5
            writer.close()
        assert [record.name for record in caplog.records if record.levelname == "ERROR"] == []


@in_loop
async def test_a_fault_of_ours_is_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        monkeypatch.setattr("fieldrig_bus.opcua.session.from_variant", lambda node, variant: node.nothing)
        assert await code_of(client.get_node(POSITION).write_value(1.0)) == "BadInternalError"
        assert "asyncua.server.uaprocessor" in [record.name for record in caplog.records]


# ---- security


async def _secured(bench: ServerBench, tmp_path: Path, user: str, password: str) -> Client:
    client = Client(bench.url)
    key, certificate = tmp_path / "client.pem", tmp_path / "client.der"
    await setup_self_signed_certificate(
        key, certificate, client.application_uri, "localhost", [ExtendedKeyUsageOID.CLIENT_AUTH], {"commonName": "test"}
    )
    server = bench.run / "opcua/ua/certificate.der"
    await client.set_security(SecurityPolicyBasic256Sha256, certificate, key, server_certificate=server)
    client.set_user(user)
    client.set_password(password)
    return client


@in_loop
async def test_a_secured_server_accepts_its_users_with_the_token(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIELDRIG_TOKEN", "a long secret")
    users = {"engineer": "write", "visitor": "read"}
    async with server_bench(tmp_path, security="sign_and_encrypt", users=users) as bench:
        async with await _secured(bench, tmp_path, "engineer", "a long secret") as client:
            await client.get_node(POSITION).write_value(2.0)
        async with await _secured(bench, tmp_path, "visitor", "a long secret") as client:
            position = client.get_node(POSITION)
            assert await position.read_value() == 2.0
            assert await position.get_user_access_level() == {ua.AccessLevel.CurrentRead}
            assert await code_of(position.write_value(3.0)) == "BadUserAccessDenied"
            plc = await client.nodes.objects.get_child("2:plc")
            assert await code_of(plc.call_method("2:start")) == "BadUserAccessDenied"
            assert await plc.call_method("2:held") == []
            executable = [
                await client.get_node(f"ns=2;s={name}()").read_attribute(ua.AttributeIds.UserExecutable)
                for name in ("start", "hold", "held")
            ]
            assert [value.Value.Value for value in executable] == [False, False, True]
        for user, password in (("engineer", "wrong"), ("nobody", "a long secret"), ("engineer", "")):
            client = await _secured(bench, tmp_path, user, password)
            assert await code_of(client.connect()) in ("BadUserAccessDenied", "BadIdentityTokenInvalid")
        assert (bench.plc.values["belt.Position"], bench.plc.called) == (2.0, [])


@in_loop
async def test_a_secured_server_accepts_nothing_open_and_nobody_without_a_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIELDRIG_TOKEN", "a long secret")
    async with server_bench(tmp_path, security="sign_and_encrypt") as bench:
        with pytest.raises((ua.UaError, ConnectionError, asyncio.TimeoutError)):
            await Client(bench.url, timeout=5).connect()
        key = bench.run / "opcua/ua/key.pem"
        assert key.stat().st_mode & 0o777 == 0o600


@in_loop
async def test_a_secured_server_needs_a_token(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FIELDRIG_TOKEN", raising=False)
    monkeypatch.delenv("FIELDRIG_TOKEN_FILE", raising=False)
    with pytest.raises(BusError, match="FIELDRIG_TOKEN"):
        async with server_bench(tmp_path, security="sign_and_encrypt"):
            pass


@pytest.mark.parametrize(
    ("listen", "is_secure"), [("127.0.0.1:4840", False), ("[::1]:4840", False), ("0.0.0.0:4840", True), ("plc:1", True)]
)
def test_a_server_beyond_loopback_is_secured(listen: str, is_secure: bool) -> None:
    assert OpcUaSettings(listen=listen).is_secure is is_secure


@in_loop
async def test_subscriptions_and_sessions_over_the_limit_are_refused_and_counted(tmp_path: Path) -> None:
    async with server_bench(tmp_path) as bench, Client(bench.url) as client:
        for _ in range(MOST_SUBSCRIPTIONS):
            await client.create_subscription(1000, Heard())
        assert await code_of(client.create_subscription(1000, Heard())) == "BadTooManySubscriptions"
        for _ in range(MOST_SESSIONS - 1):
            await client.create_session()
        assert await code_of(client.create_session()) == "BadTooManySessions"
        figures = bench.hub.statistics()
        assert (figures["subscriptions over the limit"], figures["sessions over the limit"]) == (1.0, 1.0)
