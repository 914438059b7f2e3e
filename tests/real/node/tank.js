// A CANopen master of npm's `canopen` that drains the lab's tank by some millimetres: it opens the outlet at the I/O
// node with a PDO, and closes it again when PDOs of the level sensor say so.  The levels go out as one line of JSON.
//
//     node tank.js vcan0 5

const { Device, DataType } = require('canopen');
const can = require('socketcan');

const IO = 5, SENSOR = 6;
const OUTLET_OPEN = 10000; // 100 %
const EMERGENCY_MS = 30000;

function addObjects(eds) {
    const valve = eds.addEntry(0x2000, { parameterName: 'outlet', dataType: DataType.INTEGER16 });
    const others = [1, 2, 3].map((n) => eds.addEntry(0x2000 + n, {
        parameterName: `analog output ${n}`, dataType: DataType.INTEGER16,
    }));
    const level = eds.addEntry(0x2010, { parameterName: 'level in mm', dataType: DataType.INTEGER32 });
    const status = eds.addEntry(0x2011, { parameterName: 'status', dataType: DataType.UNSIGNED8 });
    eds.addTransmitPdo({ cobId: 0x300 + IO, transmissionType: 254, dataObjects: [valve, ...others] });
    eds.addReceivePdo({ cobId: 0x180 + SENSOR, transmissionType: 254, dataObjects: [level, status] });
    return { valve, level };
}

function drain(master, { valve, level }, millimetres) {
    const levels = [];
    const turn = (opening) => {
        valve.value = opening;
        master.pdo.write(0x300 + IO);
    };
    return new Promise((resolve, reject) => {
        const late = setTimeout(() => reject(new Error(`levels: ${levels}`)), EMERGENCY_MS);
        master.pdo.on('pdo', () => {
            levels.push(level.value);
            if (levels.length === 1)
                turn(OUTLET_OPEN);
            if (level.value <= levels[0] - millimetres) {
                turn(0);
                clearTimeout(late);
                resolve(levels);
            }
        });
        master.nmt.startNode(0);
    });
}

async function main(channelName, millimetres) {
    const master = new Device({ id: 0x7F });
    const channel = can.createRawChannel(channelName);
    const objects = addObjects(master.eds);
    master.addListener('message', (message) => channel.send(message));
    channel.addListener('onMessage', (message) => master.receive(message));
    channel.start();
    master.start();
    try {
        console.log(JSON.stringify(await drain(master, objects, millimetres)));
    } finally {
        master.stop();
        channel.stop();
    }
}

main(process.argv[2], Number(process.argv[3])).catch((error) => {
    console.error(error);
    process.exitCode = 1;
});
