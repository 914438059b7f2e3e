// A CANopen master of npm's `canopen` at a socketcand: it moves one CiA 402 drive, and what it saw goes out as JSON.
//
//     node drive.js 29569 can0 3

const net = require('net');
const { Device, DataType } = require('canopen');

const TIMEOUT_MS = 5000;
const POLL_MS = 20;
const TURNS = 2_000_000;
const SYNC = 0x80;
const TARGET_REACHED = 0x0400;

const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// The raw mode of socketcand: `< send 123 2 aa bb >` out, `< frame 123 23.424242 aabb >` in.
function connect(port, bus, onFrame) {
    return new Promise((resolve, reject) => {
        const socket = net.connect(port, '127.0.0.1');
        const answers = [`< open ${bus} >`, '< rawmode >'];
        let text = '';
        socket.on('error', reject);
        socket.on('data', (data) => {
            text += data;
            for (let end = text.indexOf('>'); end >= 0; end = text.indexOf('>')) {
                const words = text.slice(text.indexOf('<') + 1, end).trim().split(/\s+/);
                text = text.slice(end + 1);
                if (words[0] === 'frame')
                    onFrame({ id: parseInt(words[1], 16), data: Buffer.from(words.slice(3).join(''), 'hex') });
                else if (answers.length > 0)
                    socket.write(answers.shift());
                else
                    resolve(socket);
            }
        });
    });
}

async function move(master, send, nodeId) {
    const at = (index, subIndex, dataType) => ({ serverId: nodeId, index, subIndex, dataType, timeout: TIMEOUT_MS });
    const read = (index, type) => master.sdo.upload(at(index, 0, type));
    const write = (index, type, data) => master.sdo.download({ ...at(index, 0, type), data });
    const seen = { deviceType: await read(0x1000, DataType.UNSIGNED32), states: [], positions: 0 };
    master.addListener('position', () => { seen.positions += 1; });
    master.nmt.startNode(nodeId);
    await write(0x6060, DataType.INTEGER8, 1);
    for (const [word, state] of [[0x06, 0x21], [0x07, 0x23], [0x0F, 0x27]]) {
        await write(0x6040, DataType.UNSIGNED16, word);
        while ((await read(0x6041, DataType.UNSIGNED16) & 0x6F) !== state)
            await wait(POLL_MS);
        seen.states.push(state);
    }
    const begin = await read(0x6064, DataType.INTEGER32);
    await write(0x6081, DataType.UNSIGNED32, 5_000_000);
    await write(0x607A, DataType.INTEGER32, begin + TURNS);
    await write(0x6040, DataType.UNSIGNED16, 0x1F);
    for (let status = 0; !(status & TARGET_REACHED);) {
        send({ id: SYNC, data: Buffer.alloc(0) });
        status = await read(0x6041, DataType.UNSIGNED16);
        await wait(1);
    }
    await wait(200);
    seen.moved = await read(0x6064, DataType.INTEGER32) - begin;
    await write(0x6040, DataType.UNSIGNED16, 0x00);
    return seen;
}

async function main(port, bus, nodeId) {
    const master = new Device({ id: 0x7F });
    const socket = await connect(port, bus, (message) => {
        if (message.id === 0x380 + nodeId)
            master.emit('position');
        master.receive(message);
    });
    const send = ({ id, data }) => {
        const bytes = [...data].map((byte) => byte.toString(16).padStart(2, '0'));
        socket.write(`< send ${id.toString(16)} ${bytes.length} ${bytes.join(' ')} >`);
    };
    master.eds.addSdoClientParameter(nodeId, 0x600 + nodeId, 0x580 + nodeId);
    master.addListener('message', send);
    master.start();
    try {
        console.log(JSON.stringify(await move(master, send, nodeId)));
    } finally {
        master.stop();
        socket.destroy();
    }
}

main(Number(process.argv[2]), process.argv[3], Number(process.argv[4])).catch((error) => {
    console.error(error);
    process.exitCode = 1;
});
