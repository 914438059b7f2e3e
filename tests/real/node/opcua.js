// Drives the OPC UA server of a MAx-4 with node-opcua and prints what it saw as JSON.
// node opcua.js URL FOLDER [USER PASSWORD]
"use strict";
const {
    AttributeIds, ClientMonitoredItem, DataType, MessageSecurityMode, OPCUAClient, SecurityPolicy, TimestampsToReturn,
    UserTokenType, makeBrowsePath, resolveNodeId,
} = require("node-opcua-client");
const { OPCUACertificateManager } = require("node-opcua-certificate-manager");

const [url, folder, userName, password] = process.argv.slice(2);
const COUNT = "ns=2;s=PLC_PRG.count";

async function browsed(session, nodeId) {
    const result = await session.browse(nodeId);
    return result.references.map((one) => one.browseName.name);
}

async function write(session, nodeId, dataType, value, arrayType) {
    const status = await session.write({
        nodeId, attributeId: AttributeIds.Value, value: { value: { dataType, value, arrayType } },
    });
    return status.name;
}

async function changes(session, nodeId, count, act) {
    // The first values of a subscription; `act` is called after the first one.
    const subscription = await session.createSubscription2({
        requestedPublishingInterval: 50, requestedLifetimeCount: 1000, requestedMaxKeepAliveCount: 10,
        publishingEnabled: true, maxNotificationsPerPublish: 0, priority: 0,
    });
    const item = ClientMonitoredItem.create(
        subscription, { nodeId, attributeId: AttributeIds.Value },
        { samplingInterval: 20, discardOldest: true, queueSize: 10 }, TimestampsToReturn.Both,
    );
    const seen = [];
    await new Promise((resolve) => {
        item.on("changed", async (value) => {
            seen.push(value.value.value);
            if (seen.length === 1) await act();
            if (seen.length >= count) resolve();
        });
    });
    await subscription.terminate();
    return seen;
}

async function call(session, method, ...inputArguments) {
    return session.call({ objectId: "ns=2;i=1", methodId: `ns=2;s=${method}()`, inputArguments });
}

async function forcing(session) {
    // Hold the counter of the program at 1000, see it stand, and release it.
    const found = {};
    const signature = await session.getArgumentDefinition("ns=2;s=force()");
    found.arguments = signature.inputArguments.map((one) => [one.name, DataType[one.dataType.value] ?? "", one.description.text !== ""]);
    const variable = { dataType: DataType.NodeId, value: resolveNodeId(COUNT) };
    const wrong = await call(session, "force", variable, { dataType: DataType.String, value: "x" });
    found.refused = [wrong.statusCode, ...wrong.inputArgumentResults].map((one) => one.name);
    found.force = (await call(session, "force", variable, { dataType: DataType.Int32, value: 1000 })).statusCode.name;
    found.forced = (await call(session, "forced")).outputArguments[0].value.map(String);
    await write(session, COUNT, DataType.Int32, 5);
    found.held = [];
    while (found.held.length < 3) {
        const value = (await session.read({ nodeId: COUNT, attributeId: AttributeIds.Value })).value.value;
        if (value === 1000) found.held.push(value); // the written 5 stays until the cycle ends
    }
    found.release = (await call(session, "release", variable)).statusCode.name;
    found.left = (await call(session, "forced")).outputArguments[0].value.map(String);
    const counted = await changes(session, COUNT, 3, async () => {});
    found.counts = counted[0] >= 1000 && counted[2] > counted[0];
    return found;
}

async function visit(session) {
    const found = {};
    found.device = await browsed(session, "ns=2;i=1");
    found.program = await browsed(session, "ns=2;s=PLC_PRG");
    found.path = (await session.translateBrowsePath(
        makeBrowsePath("RootFolder", "/Objects/2:max4/2:PLC_PRG/2:count"))).targets[0].targetId.toString();
    const count = await session.read({ nodeId: COUNT, attributeId: AttributeIds.Value });
    found.type = DataType[count.value.dataType];
    found.timestamp = count.sourceTimestamp instanceof Date;
    found.written = await write(session, "ns=2;s=PLC_PRG.setpoint", DataType.Float, 2.5);
    found.read = (await session.read({ nodeId: "ns=2;s=PLC_PRG.setpoint", attributeId: AttributeIds.Value })).value.value;
    found.array = [...(await session.read({ nodeId: "ns=2;s=PLC_PRG.table", attributeId: AttributeIds.Value })).value.value];
    found.wrongType = await write(session, "ns=2;s=PLC_PRG.setpoint", DataType.Int32, 2);
    found.outOfRange = await write(session, "ns=2;s=PLC_PRG.small", DataType.Int16, 11);
    found.readOnly = await write(session, "ns=2;s=PacDriveM.DiagCode", DataType.Int32, 1);
    found.unknown = (await session.read({ nodeId: "ns=2;s=PLC_PRG.none", attributeId: AttributeIds.Value })).statusCode.name;
    found.stop = (await session.call({ objectId: "ns=2;i=1", methodId: "ns=2;s=stop()" })).statusCode.name;
    found.values = await changes(session, "ns=2;s=PLC_PRG.setpoint", 2, () =>
        write(session, "ns=2;s=PLC_PRG.setpoint", DataType.Float, 3.5));
    found.start = (await session.call({ objectId: "ns=2;i=1", methodId: "ns=2;s=start()" })).statusCode.name;
    const counted = await changes(session, COUNT, 3, async () => {});
    found.counts = counted.every((value, place) => place === 0 || value > counted[place - 1]);
    found.forcing = await forcing(session);
    return found;
}

async function main() {
    const isSecure = userName !== undefined;
    const client = OPCUAClient.create({
        endpointMustExist: false,
        securityMode: isSecure ? MessageSecurityMode.SignAndEncrypt : MessageSecurityMode.None,
        securityPolicy: isSecure ? SecurityPolicy.Basic256Sha256 : SecurityPolicy.None,
        clientCertificateManager: new OPCUACertificateManager({
            rootFolder: `${folder}/pki`, automaticallyAcceptUnknownCertificate: true,
        }),
        connectionStrategy: { maxRetry: 1, initialDelay: 100 },
    });
    await client.connect(url);
    const found = { user: userName ?? "", policy: client.securityPolicy };
    try {
        const session = await client.createSession(
            isSecure ? { type: UserTokenType.UserName, userName, password } : { type: UserTokenType.Anonymous });
        if (isSecure) {
            found.written = await write(session, "ns=2;s=PLC_PRG.setpoint", DataType.Float, 1.25);
            found.forced = (await call(session, "force",
                { dataType: DataType.NodeId, value: resolveNodeId("ns=2;s=PLC_PRG.setpoint") },
                { dataType: DataType.Float, value: 1.25 })).statusCode.name;
        } else {
            Object.assign(found, await visit(session));
        }
        await session.close();
    } catch (error) {
        found.refused = (/Bad\w+/.exec(error.message) ?? [error.message])[0];
    }
    await client.disconnect();
    console.log(JSON.stringify(found));
}

main().then(() => process.exit(0), (error) => { console.error(error); process.exit(1); });
