// The npm package `canopen`, a master that nobody here wrote, commissions a simulated board over socketcand: it reads the
// electronic data sheet, drives NMT, reads and writes objects by every kind of SDO transfer, and takes heartbeats, PDOs and
// emergencies.
//
// Usage: node canopen_test.js PLENUM PLENUM_DICTIONARY NPM_FOLDER
'use strict';

const assert = require('node:assert');
const { execFileSync, spawn } = require('node:child_process');
const { EventEmitter, once } = require('node:events');
const fs = require('node:fs');
const Module = require('node:module');
const net = require('node:net');
const os = require('node:os');
const path = require('node:path');
const test = require('node:test');

const [plenum, plenumDictionary, npmFolder] = process.argv.slice(2);
const DEADLINE_MS = 20000;
const NODE = 1;
const MASTER = 127;

// node-crc is a native module, built by an install script, which we do not run; this is the checksum of CiA 301's block
// transfer (CRC-16, polynomial 1021h, from 0), as CRC-16/XMODEM is published: "123456789" gives 31C3h.
function crc16(data) {
    let crc = 0;
    for (const byte of data) {
        crc ^= byte << 8;
        for (let k = 0; k < 8; ++k) crc = (crc & 0x8000 ? (crc << 1) ^ 0x1021 : crc << 1) & 0xFFFF;
    }
    return crc;
}
const load = Module._load;
Module._load = (name, ...rest) => name !== 'node-crc' ? load(name, ...rest) : {
    crc: (...args) => {
        const result = Buffer.alloc(2);
        result.writeUInt16BE(crc16(args.at(-1)));
        return result;
    },
};
let canopen;
try {
    canopen = Module.createRequire(path.join(path.resolve(npmFolder), 'any.js'))('canopen');
} catch (error) {
    if (error.code !== 'MODULE_NOT_FOUND') throw error;
    console.log('skipped: no npm package canopen in', npmFolder, '(toolchains/dev setup)');
    process.exit(77);
}

/** CAN over socketcand: send({id, data}), and an event 'frame' with the same. */
class SocketcandChannel extends EventEmitter {
    static async open(port, channel) {
        const self = new SocketcandChannel();
        self.socket = net.connect(port, '127.0.0.1').setEncoding('latin1').setNoDelay();
        self.rest = '';
        self.socket.on('data', (text) => self.take(text));
        for (const say of [`< open ${channel} >`, '< rawmode >', null]) {
            await once(self, 'control');  // < hi >, < ok >, < ok >
            if (say) self.socket.write(say);
        }
        return self;
    }

    take(text) {
        const parts = (this.rest + text).split('>');
        this.rest = parts.pop();
        for (const part of parts) {
            const [kind, id, , data = ''] = part.trim().slice(2).split(' ');
            if (kind === 'frame') this.emit('frame', { id: parseInt(id, 16), data: Buffer.from(data, 'hex') });
            else this.emit('control', kind);
        }
    }

    send({ id, data }) {
        const bytes = [...data].map((byte) => byte.toString(16));
        this.socket.write(`< ${['send', id.toString(16), data.length.toString(16), ...bytes].join(' ')} >`);
    }

    close() {
        this.socket.destroy();
    }
}

/** What `emitter` says under `name` for which `wanted` holds; rejects at the deadline. */
function next(emitter, name, wanted = () => true) {
    return new Promise((resolve, reject) => {
        const timer = setTimeout(() => reject(new Error(`no ${name} as wanted within ${DEADLINE_MS} ms`)), DEADLINE_MS);
        const listener = (value) => {
            if (!wanted(value)) return;
            clearTimeout(timer);
            emitter.removeListener(name, listener);
            resolve(value);
        };
        emitter.on(name, listener);
    });
}

let folder, rig, channel, master, boardEds;

const sdo = (index, subIndex = 0, more = {}) => ({ deviceId: NODE, index, subIndex, timeout: DEADLINE_MS, ...more });
const read = (index, subIndex, dataType, more) => master.sdo.upload(sdo(index, subIndex, { dataType, ...more }));
const write = (index, subIndex, data, dataType, more) => master.sdo.download(sdo(index, subIndex, { data, dataType, ...more }));

test.before(async () => {
    folder = fs.mkdtempSync(path.join(os.tmpdir(), 'plenum-'));
    const edsFile = path.join(folder, 'plenum.eds');
    execFileSync(plenumDictionary, ['--eds', edsFile]);
    boardEds = canopen.Eds.fromFile(edsFile);

    rig = spawn(plenum, ['sim', '--bus', 'socketcand:127.0.0.1:0/can0', '--chambers', '2', '--seconds', '120'],
        { stdio: ['ignore', 'pipe', 'inherit'] });
    const ready = await next(rig.stdout.setEncoding('utf8'), 'data', (text) => text.startsWith('serving'));
    channel = await SocketcandChannel.open(Number(ready.match(/:(\d+)\/can0/)[1]), 'can0');

    const eds = new canopen.Eds();
    eds.addEmcyConsumer(0x80 + NODE);
    eds.addHeartbeatConsumer(NODE, 5000);
    eds.addSdoClientParameter(NODE, 0x600 + NODE, 0x580 + NODE);
    eds.setSyncCobId(0x80);
    eds.setSyncGenerationEnable(true);
    master = new canopen.Device({ eds, id: MASTER });
    master.on('message', (frame) => channel.send({ id: frame.id, data: frame.data }));
    channel.on('frame', (frame) => master.receive({ id: frame.id, data: frame.data, len: frame.data.length }));
    master.start();
});

test.after(async () => {
    if (master) master.stop();
    if (channel) channel.close();
    if (rig) {
        const ended = once(rig, 'exit');
        rig.kill('SIGINT');
        assert.deepStrictEqual(await ended, [0, null]);
    }
    fs.rmSync(folder, { recursive: true });
});

test('it reads the data sheet, whose defaults are what the board answers', async () => {
    for (const [index, subIndex, dataType] of [
        [0x1000, 0, canopen.DataType.UNSIGNED32], [0x1018, 0, canopen.DataType.UNSIGNED8],
        [0x1800, 2, canopen.DataType.UNSIGNED8], [0x1A00, 1, canopen.DataType.UNSIGNED32],
        [0x6381, 2, canopen.DataType.UNSIGNED8]]) {
        const parent = boardEds.getEntry(index);
        const entry = subIndex || parent.subNumber ? boardEds.getSubEntry(index, subIndex) : parent;
        assert.strictEqual(await read(index, subIndex, dataType), entry.value, index.toString(16));
    }
});

test('it reads by expedited and segmented transfer', async () => {
    assert.strictEqual(await read(0x1000, 0, canopen.DataType.UNSIGNED32), 0xFFFF0198);
    const name = await read(0x1008, 0, canopen.DataType.VISIBLE_STRING);
    assert.ok(name.length > 4, `the device name, ${name}, takes segments`);
});

test('it reads by block transfer the same bytes', async () => {
    const segmented = await read(0x1008, 0);
    assert.deepStrictEqual(await read(0x1008, 0, undefined, { blockTransfer: true }), segmented);
});

test('it writes by expedited transfer what it then reads', async () => {
    await write(0x6394, 1, 2500, canopen.DataType.INTEGER16);
    assert.strictEqual(await read(0x6394, 1, canopen.DataType.INTEGER16), 2500);
});

test('a model that is none is refused after a segmented and after a block download', async () => {
    const image = Buffer.alloc(100, 0xA5);
    for (const blockTransfer of [false, true]) {
        await assert.rejects(write(0x2110, 0, image, undefined, { blockTransfer }), canopen.SdoError);
        assert.strictEqual(await read(0x6394, 1, canopen.DataType.INTEGER16), 2500, 'the server serves on');
    }
});

test('an object that is none, and one that is read only, are aborted with the codes of CiA 301', async () => {
    await assert.rejects(read(0x5FFF, 0, canopen.DataType.UNSIGNED8), { code: 0x06020000 });
    await assert.rejects(write(0x1000, 0, 1, canopen.DataType.UNSIGNED32), { code: 0x06010002 });
});

test('it commands NMT, and heartbeats say so', async () => {
    await write(0x1017, 0, 20, canopen.DataType.UNSIGNED16);
    const beat = (state) => next(master.nmt, 'heartbeat', (one) => one.deviceId === NODE && one.state === state);
    for (const [command, state] of [
        ['startNode', canopen.NmtState.OPERATIONAL], ['stopNode', canopen.NmtState.STOPPED],
        ['enterPreOperational', canopen.NmtState.PRE_OPERATIONAL], ['startNode', canopen.NmtState.OPERATIONAL]]) {
        const beaten = beat(state);
        master.nmt[command](NODE);
        await beaten;
    }
});

test('a SYNC of it is answered by the PDO of actual pressures, in mbar', async () => {
    master.nmt.startNode(NODE);
    const answer = next(channel, 'frame', (frame) => frame.id === 0x180 + NODE);
    master.sync.write();
    const { data } = await answer;
    const actual = await read(0x6381, 1, canopen.DataType.INTEGER16);
    assert.strictEqual(data.length, 8);
    assert.ok(actual > 500 && Math.abs(data.readInt16LE(0) - actual) < 20, `${data.readInt16LE(0)} by PDO, ${actual} by SDO`);
});

test('a fault is an emergency of its code and chamber, and a reset of it one of code 0', async () => {
    await write(0x1017, 0, 20, canopen.DataType.UNSIGNED16);
    master.nmt.startNode(NODE);
    const emergency = (code) => next(master.emcy, 'emergency', ({ em }) => em.code === code);
    const raised = emergency(0x6300);
    for (const word of [1, 3]) await write(0x6040, 0, word, canopen.DataType.UNSIGNED16);  // HOLD, without a model
    const { cobId, em } = await raised;
    assert.strictEqual(cobId, 0x80 + NODE);
    assert.strictEqual(em.info[0], 1, 'chamber');
    assert.strictEqual(await read(0x604E, 0, canopen.DataType.UNSIGNED16), 0x6300);
    assert.strictEqual(await read(0x1001, 0, canopen.DataType.UNSIGNED8), em.register);

    const gone = emergency(0);
    await write(0x6040, 0, 1, canopen.DataType.UNSIGNED16);
    for (let beat = 0; beat < 2; ++beat) await next(channel, 'frame', (frame) => frame.id === 0x700 + NODE);  // a tick sees the bit low
    await write(0x6040, 0, 9, canopen.DataType.UNSIGNED16);
    await gone;
    assert.strictEqual(await read(0x604E, 0, canopen.DataType.UNSIGNED16), 0);
});
