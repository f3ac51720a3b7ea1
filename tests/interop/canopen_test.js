// The npm package `canopen`, a master that nobody here wrote, commissions a simulated board over socketcand: it reads the
// electronic data sheet from the board, maps its PDOs by it, uploads a model, lets the board follow set points, drives NMT
// and LSS, and takes heartbeats and emergencies.
//
// Usage: node canopen_test.js PLENUM NPM_FOLDER
'use strict';

const assert = require('node:assert');
const fs = require('node:fs');
const Module = require('node:module');
const test = require('node:test');

const { DEADLINE_MS, ServedRig, foreign, next } = require('./served_rig.js');

const [plenum, npmFolder] = process.argv.slice(2);
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

/** CRC-32 of IEEE 802.3, as a model image and a commit have it: "123456789" gives CBF43926h. */
function crc32(data) {
    let crc = 0xFFFFFFFF;
    for (const byte of data) {
        crc ^= byte;
        for (let k = 0; k < 8; ++k) crc = crc & 1 ? (crc >>> 1) ^ 0xEDB88320 : crc >>> 1;
    }
    return ~crc >>> 0;
}

const load = Module._load;
Module._load = (name, ...rest) => name !== 'node-crc' ? load(name, ...rest) : {
    crc: (...args) => {
        const result = Buffer.alloc(2);
        result.writeUInt16BE(crc16(args.at(-1)));
        return result;
    },
};
const canopen = foreign(npmFolder, 'canopen');

let rig, channel, master, board;

const sdo = (index, subIndex = 0, more = {}) => ({ deviceId: NODE, index, subIndex, timeout: DEADLINE_MS, ...more });
const read = (index, subIndex, dataType, more) => master.sdo.upload(sdo(index, subIndex, { dataType, ...more }));
const write = (index, subIndex, data, dataType, more) => master.sdo.download(sdo(index, subIndex, { data, dataType, ...more }));
const { UNSIGNED8, UNSIGNED16, UNSIGNED32, INTEGER16, VISIBLE_STRING } = canopen.DataType;

test.before(async () => {
    rig = new ServedRig(plenum);
    await rig.run('capture', '--chambers', '2', '--seconds', '30', '-o', 'logs');
    for (const c of [1, 2]) await rig.run('identify', '--rig', 'logs/rig.toml', `logs/chamber-${c}.csv`, '-o', `model-${c}.json`);
    await rig.run('upload', '--chambers', '2', '--store', 'board', 'model-1.json', 'model-2.json');
    await rig.serve('--chambers', '2', '--store', 'board');
    channel = rig.channel;

    const eds = new canopen.Eds();
    eds.addEmcyConsumer(0x80 + NODE);
    eds.addHeartbeatConsumer(NODE, 5000);
    eds.addSdoClientParameter(NODE, 0x600 + NODE, 0x580 + NODE);
    eds.setSyncCobId(0x80);
    eds.setSyncGenerationEnable(true);
    master = new canopen.Device({ eds, id: MASTER });
    master.on('message', (frame) => {
        channel.send({ id: frame.id, data: frame.data });
        if (frame.id === 0x80) setImmediate(() => master.pdo.receive(frame));  // its own SYNC counts for its own PDOs, too
    });
    channel.on('frame', (frame) => master.receive({ id: frame.id, data: frame.data, len: frame.data.length }));
    master.start();
});

test.after(async () => {
    if (master) master.stop();
    await rig.close();
});

test('it reads the data sheet from the board, and parses it for its node', async () => {
    const sheet = await read(0x1021, 0, undefined, { blockTransfer: true });
    await rig.run('describe', '--bus', rig.bus, '--node', String(NODE), '-o', '.');
    assert.ok(fs.readFileSync(rig.file(`node-${NODE}.eds`)).equals(sheet), 'our client and this one read the same');
    const eds = canopen.Eds.fromFile(rig.file(`node-${NODE}.eds`));
    // The package takes no notice of $NODEID, with which CiA 306 writes identifiers for any node: the DCF has them resolved.
    board = canopen.Eds.fromFile(rig.file(`node-${NODE}.dcf`));
    assert.deepStrictEqual([...board.keys()], [...eds.keys()]);
    assert.strictEqual(board.productName, await read(0x1008, 0, VISIBLE_STRING));
    assert.strictEqual(board.getEmcyCobId(), 0x80 + NODE);
    assert.deepStrictEqual(board.getSdoServerParameters().map(({ cobIdRx, cobIdTx }) => [cobIdRx, cobIdTx]), [[0x600 + NODE, 0x580 + NODE]]);
});

test('each default of the sheet is what the board answers', async () => {
    let compared = 0;
    for (const object of board.values()) {
        // The package's subIndex takes for hexadecimal what it wrote as a decimal number: it is counted here.
        const entries = object.subNumber ? Array.from({ length: 256 }, (_, sub) => [sub, object.at(sub)]) : [[0, object]];
        for (const [sub, entry] of entries) {
            if (entry?.defaultValue === undefined || entry.dataType === VISIBLE_STRING) continue;
            // The package takes the highest sub-index for the value of sub-index 0, where a mapping has the number of its objects.
            const value = sub === 0 && object.subNumber ? Number(entry.defaultValue) : entry.value;
            const answered = await read(object.index, sub, entry.dataType);
            assert.strictEqual(answered, value, `${object.index.toString(16)}h:${sub} ${entry.parameterName}`);
            ++compared;
        }
    }
    assert.ok(compared > 500, `${compared} defaults`);
});

test('it reads by expedited and segmented transfer', async () => {
    assert.strictEqual(await read(0x1000, 0, UNSIGNED32), 0xFFFF0198);
    const name = await read(0x1008, 0, VISIBLE_STRING);
    assert.ok(name.length > 4, `the device name, ${name}, takes segments`);
});

test('it reads by block transfer the same bytes', async () => {
    const segmented = await read(0x1008, 0);
    assert.deepStrictEqual(await read(0x1008, 0, undefined, { blockTransfer: true }), segmented);
});

test('it writes by expedited transfer what it then reads', async () => {
    await write(0x6394, 1, 2500, INTEGER16);
    assert.strictEqual(await read(0x6394, 1, INTEGER16), 2500);
});

test('a model that is none is refused after a segmented and after a block download', async () => {
    const image = Buffer.alloc(100, 0xA5);
    for (const blockTransfer of [false, true]) {
        await assert.rejects(write(0x2110, 0, image, undefined, { blockTransfer }), canopen.SdoError);
        assert.strictEqual(await read(0x6394, 1, INTEGER16), 2500, 'the server serves on');
    }
});

test('an object that is none, and one that is read only, are aborted with the codes of CiA 301', async () => {
    await assert.rejects(read(0x5FFF, 0, UNSIGNED8), { code: 0x06020000 });
    await assert.rejects(write(0x1000, 0, 1, UNSIGNED32), { code: 0x06010002 });
});

test('it commands NMT, and heartbeats say so', async () => {
    await write(0x1017, 0, 20, UNSIGNED16);
    const beat = (state) => next(master.nmt, 'heartbeat', (one) => one.deviceId === NODE && one.state === state);
    for (const [command, state] of [
        ['startNode', canopen.NmtState.OPERATIONAL], ['stopNode', canopen.NmtState.STOPPED],
        ['enterPreOperational', canopen.NmtState.PRE_OPERATIONAL], ['startNode', canopen.NmtState.OPERATIONAL]]) {
        const beaten = beat(state);
        master.nmt[command](NODE);
        await beaten;
    }
});

test('a good model is taken by block and by segmented download, committed, and read back by both', async () => {
    const active = await read(0x2118, 0, undefined, { blockTransfer: true });
    assert.deepStrictEqual(await read(0x2118, 0), active);
    assert.strictEqual(active.toString('latin1', 0, 4), 'PLM2');
    for (const blockTransfer of [true, false]) {
        const image = Buffer.from(active);
        image.writeUInt32LE(blockTransfer ? 1700000000 : 1800000000, 12);  // the date of the fit
        image.writeUInt32LE(crc32(image.subarray(0, -4)), image.length - 4);
        await write(0x2110, 0, image, undefined, { blockTransfer });
        while (await read(0x2128, 1, UNSIGNED8) === 5);  // the board checks it
        assert.strictEqual(await read(0x2128, 1, UNSIGNED8), 2, 'staged');
        assert.deepStrictEqual(await read(0x2118, 0), blockTransfer ? active : await read(0x2118, 0, undefined, { blockTransfer: true }));
        await write(0x2120, 1, 1, UNSIGNED8);
        await write(0x2120, 2, crc32(image.subarray(-4)), UNSIGNED32);
        await write(0x2120, 3, 0x746D6F63, UNSIGNED32);
        while (await read(0x2128, 1, UNSIGNED8) === 3);  // until the edge of a tick
        assert.strictEqual(await read(0x2128, 1, UNSIGNED8), 1, 'active');
        assert.deepStrictEqual(await read(0x2118, 0, undefined, { blockTransfer: true }), image);
        assert.deepStrictEqual(await read(0x2118, 0), image);
    }
});

/** Maps the PDOs of the board in the master, as its sheet has them, both ways. Returns the set points and the control word. */
function mapPdos() {
    master.mapRemoteNode({ id: NODE, eds: board, skipEmcy: true, skipNmt: true, skipSdo: true });
    let index = 0x5000;  // behind the copies of what it receives
    const own = [];
    for (const { cobId, dataObjects } of board.getReceivePdos()) {
        const copies = dataObjects.map(({ parameterName, dataType }) => master.eds.addEntry(index++, { parameterName, dataType }));
        master.eds.addTransmitPdo({ cobId, transmissionType: 1, dataObjects: copies });
        own.push(...copies);
    }
    const of = (name) => own.filter((one) => one.parameterName.startsWith(name));
    return { setPoints: of('Set point'), controlWord: of('Control word')[0] };
}

test('its own PDO objects take what the board sends, and lead the board', async () => {
    const { setPoints, controlWord } = mapPdos();
    assert.strictEqual(setPoints.length, 8);
    const received = (name) => master.eds.getReceivePdos().flatMap((pdo) => pdo.dataObjects).filter((one) => one.parameterName.startsWith(name));
    const [actual] = received('Actual value');
    const [statusWord] = received('Status word');

    for (const index of [0x1400, 0x1401]) await write(index, 5, 2000, UNSIGNED16);  // ms without set points: this machine may be busy
    await write(0x2419, 2, 200, UNSIGNED16);
    await write(0x6043, 0, 4, canopen.DataType.INTEGER8);  // closed loop
    setPoints.forEach((one) => { one.value = 2000; });
    master.nmt.startNode();  // itself: only then it serves PDOs
    master.nmt.startNode(NODE);
    master.eds.setSyncCyclePeriod(20000);  // us; each SYNC takes set points and control word along
    for (const [word, state] of [[1, 9], [3, 11], [7, 15]]) {
        controlWord.value = word;
        await next(master.pdo, 'pdo', () => (statusWord.value & 15) === state);
    }
    for (const mbar of [2500, 3500]) {
        setPoints[0].value = mbar;
        await next(master.pdo, 'pdo', () => Math.abs(actual.value - mbar) < 20);
        const answered = await read(0x6381, 1, INTEGER16);
        assert.ok(Math.abs(answered - mbar) < 60, `${answered} mbar by SDO, ${mbar} asked for`);
        assert.strictEqual(await read(0x6380, 1, INTEGER16), mbar, 'the set point arrived');
    }
    assert.strictEqual(await read(0x604E, 0, UNSIGNED16), 0, 'no fault');
});

test('a fault is an emergency of its code, and a reset of it one of code 0', async () => {
    await write(0x1017, 0, 20, UNSIGNED16);
    const emergency = (code) => next(master.emcy, 'emergency', ({ em }) => em.code === code);
    const raised = emergency(0x8250);
    master.eds.setSyncGenerationEnable(false);  // set points stay away from a board that follows them
    const { cobId, em } = await raised;
    assert.strictEqual(cobId, 0x80 + NODE);
    assert.strictEqual(await read(0x604E, 0, UNSIGNED16), 0x8250);
    assert.strictEqual(await read(0x1001, 0, UNSIGNED8), em.register);
    assert.strictEqual(await read(0x1003, 1, UNSIGNED32) & 0xFFFF, 0x8250);

    const gone = emergency(0);
    await write(0x6040, 0, 0, UNSIGNED16);
    for (let beat = 0; beat < 2; ++beat) await next(channel, 'frame', (frame) => frame.id === 0x700 + NODE);  // a tick sees the bit low
    await write(0x6040, 0, 8, UNSIGNED16);
    await gone;
    assert.strictEqual(await read(0x604E, 0, UNSIGNED16), 0);
    assert.strictEqual(await read(0x6041, 0, UNSIGNED16) & 15, 8, 'INIT');
});

test('as a master of CiA 408 it reads who the board is, and sets ramp, deviation and target window of a chamber', async () => {
    const chamber = 0x800 * 3;
    const quantity = async (index, dataType) => [await read(index, 1, dataType), await read(index, 2, UNSIGNED8),
                                                 await read(index, 3, canopen.DataType.INTEGER8)];
    assert.strictEqual(await read(0x6052, 0, VISIBLE_STRING), String(await read(0x1018, 4, UNSIGNED32)));
    assert.strictEqual(await read(0x6050, 0, VISIBLE_STRING), await read(0x100A, 0, VISIBLE_STRING));
    await assert.rejects(read(0x6055, 0, VISIBLE_STRING), { code: 0x08000024 }, 'no data: no page about this model is stated');
    await write(0x63B1 + chamber, 1, 4000, UNSIGNED16);
    await write(0x63B4 + chamber, 1, 8000, UNSIGNED16);
    await write(0x63B0 + chamber, 0, 2, canopen.DataType.INTEGER8);
    assert.deepStrictEqual(await quantity(0x63B1 + chamber, UNSIGNED16), [4000, 0x03, -3]);
    assert.deepStrictEqual(await quantity(0x63B4 + chamber, UNSIGNED16), [8000, 0x03, -3]);
    await write(0x63D3 + chamber, 1, 150, INTEGER16);
    assert.deepStrictEqual(await quantity(0x63D5 + chamber, INTEGER16), [-150, 0x4E, -3]);
    await write(0x63F1 + chamber, 1, 250, UNSIGNED16);
    assert.deepStrictEqual(await quantity(0x63F1 + chamber, UNSIGNED16), [250, 0x03, -3]);
    await assert.rejects(write(0x63E0 + chamber, 0, 1, canopen.DataType.INTEGER8), { code: 0x06090031 });
    await write(0x63B0 + chamber, 0, 1, canopen.DataType.INTEGER8);
    await write(0x63B1 + chamber, 1, 10, UNSIGNED16);
});

test('by LSS it gives the board another node id, finds a board that has none, and names it', async () => {
    master.nmt.enterPreOperational(NODE);
    const identity = { timeout: DEADLINE_MS };
    for (const [sub, name] of ['vendorId', 'productCode', 'revisionNumber', 'serialNumber'].entries())
        identity[name] = await read(0x1018, sub + 1, UNSIGNED32);
    const { lss } = master;
    const booted = (id) => next(channel, 'frame', (frame) => frame.id === 0x700 + id && frame.data[0] === 0);
    const name = async (id) => {
        await lss.configureNodeId(id, DEADLINE_MS);
        await lss.storeConfiguration(DEADLINE_MS);
        lss.switchModeGlobal(0);
    };

    await lss.switchModeSelective(identity);
    assert.strictEqual(await lss.inquireVendorId(DEADLINE_MS), identity.vendorId);
    assert.strictEqual(await lss.inquireSerialNumber(DEADLINE_MS), identity.serialNumber);
    await assert.rejects(lss.configureNodeId(128, DEADLINE_MS), { code: 1 });
    await name(9);
    let boot = booted(9);
    master.nmt.resetCommunication(NODE);
    await boot;

    await lss.switchModeSelective(identity);
    await name(255);  // none
    assert.strictEqual(await lss.fastscan({ timeout: 200 }), null, 'its old id counts until the reset');
    master.nmt.resetCommunication(9);
    let found = null;
    while (!found) found = await lss.fastscan({ timeout: 2000 });  // until the reset is worked off
    assert.deepStrictEqual(found, { vendorId: identity.vendorId, productCode: identity.productCode,
        revisionNumber: identity.revisionNumber, serialNumber: identity.serialNumber });
    boot = booted(NODE);
    await name(NODE);
    await boot;
    assert.strictEqual(await read(0x1000, 0, UNSIGNED32), 0xFFFF0198);
});
