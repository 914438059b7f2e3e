// A CANopen master of npm's `canopen` on a SocketCAN bus: what it saw of one CiA 401 node goes out as one line of JSON.
//
//     node master.js vcan0 5

const { Device, DataType, NmtState } = require('canopen');
const can = require('socketcan');

const OUTPUTS = [0xA5, 0x5A, 0x00, 0xFF];
const TIMEOUT_MS = 5000;
const HEARTBEAT_MS = 100;

function mapOutputs(master, nodeId) {
    const entries = OUTPUTS.map((value, i) => master.eds.addEntry(0x2000 + i, {
        parameterName: `outputs ${i}`, dataType: DataType.UNSIGNED8, defaultValue: value,
    }));
    master.eds.addTransmitPdo({ cobId: 0x200 + nodeId, transmissionType: 254, dataObjects: entries });
}

function heartbeatIn(master, nodeId, state) {
    return new Promise((resolve, reject) => {
        const late = setTimeout(() => reject(new Error(`no heartbeat in state ${state}`)), TIMEOUT_MS);
        master.nmt.on('heartbeat', (beat) => {
            if (beat.deviceId === nodeId && beat.state === state) {
                clearTimeout(late);
                resolve(state);
            }
        });
    });
}

async function look(master, nodeId) {
    const at = (index, subIndex, dataType) => ({ serverId: nodeId, index, subIndex, dataType, timeout: TIMEOUT_MS });
    const seen = {
        deviceType: await master.sdo.upload(at(0x1000, 0, DataType.UNSIGNED32)),
        name: await master.sdo.upload(at(0x1008, 0, DataType.VISIBLE_STRING)),
    };
    await master.sdo.download({ ...at(0x1017, 0, DataType.UNSIGNED16), data: HEARTBEAT_MS });
    const isOperational = heartbeatIn(master, nodeId, NmtState.OPERATIONAL);
    master.nmt.startNode(0); // everybody: the master itself sends PDOs only when it is operational, too
    seen.state = await isOperational;
    master.pdo.write(0x200 + nodeId);
    seen.outputs = [];
    for (let subIndex = 1; subIndex <= OUTPUTS.length; subIndex++)
        seen.outputs.push(await master.sdo.upload(at(0x6200, subIndex, DataType.UNSIGNED8)));
    seen.abort = await master.sdo.upload(at(0x5FFF, 0)).catch((error) => error.code);
    return seen;
}

async function main(channelName, nodeId) {
    const master = new Device({ id: 0x7F });
    const channel = can.createRawChannel(channelName);
    master.eds.addSdoClientParameter(nodeId, 0x600 + nodeId, 0x580 + nodeId);
    master.eds.addHeartbeatConsumer(nodeId, 10 * HEARTBEAT_MS);
    mapOutputs(master, nodeId);
    master.addListener('message', (message) => channel.send(message));
    channel.addListener('onMessage', (message) => master.receive(message));
    channel.start();
    master.start();
    try {
        console.log(JSON.stringify(await look(master, nodeId)));
    } finally {
        master.stop();
        channel.stop();
    }
}

main(process.argv[2], Number(process.argv[3])).catch((error) => {
    console.error(error);
    process.exitCode = 1;
});
