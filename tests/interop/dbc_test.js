// The npm package `candied`, a reader of DBC files that nobody here wrote, decodes recorded frames of a simulated board by the
// DBC file that `plenum describe` wrote of it, to the values that `plenum decode` has by another way.
//
// Usage: node dbc_test.js PLENUM NPM_FOLDER
'use strict';

const assert = require('node:assert');
const fs = require('node:fs');
const test = require('node:test');

const { ServedRig, foreign, next } = require('./served_rig.js');

const [plenum, npmFolder] = process.argv.slice(2);
const { Can, Dbc } = foreign(npmFolder, 'candied');
const NODE = 3;

const bytes = (hex) => Buffer.from(hex.replaceAll(' ', ''), 'hex');

let rig, database, decoded;

/** Sends a frame; resolves with the next one of identifier `answer`. */
async function exchange(id, data, answer) {
    const answered = next(rig.channel, 'frame', (frame) => frame.id === answer);
    rig.channel.send({ id, data });
    return (await answered).data;
}

test.before(async () => {
    rig = new ServedRig(plenum);
    await rig.serve('--boards', '3', '--chambers', '2');
    await exchange(0x600 + NODE, bytes('23 04 18 01 80 06 00 00'), 0x580 + NODE);  // 1804h:1 = 680h: the stream of chamber 1
    await rig.run('describe', '--bus', rig.bus, '--node', String(NODE), '-o', '.');

    const recorder = await rig.start('record', '--bus', rig.bus, '-o', 'bus.log');
    await exchange(0, bytes('01 03'), 0x380 + NODE);  // NMT start is answered by the status word
    for (const mbar of [1000, 2345, 32767]) {
        const setPoints = Buffer.alloc(8);
        for (let c = 0; c < 4; ++c) setPoints.writeInt16LE(mbar - c, 2 * c);
        rig.channel.send({ id: 0x200 + NODE, data: setPoints });
        rig.channel.send({ id: 0x400 + NODE, data: bytes('01 00') });
        await exchange(0x80, Buffer.alloc(0), 0x680);
    }
    // The recorder has all that came before this frame, once it has written it.
    rig.channel.send({ id: 0x7FF, data: Buffer.alloc(0) });
    while (!fs.readFileSync(rig.file('bus.log'), 'latin1').includes(' 7FF#')) await next(rig.channel, 'frame');
    await ServedRig.end(recorder);

    database = new Dbc().load(fs.readFileSync(rig.file(`node-${NODE}.dbc`), 'utf8'));
    decoded = JSON.parse(await rig.run('decode', 'bus.log', '--json', '-')).frames;
});

test.after(() => rig.close());

test('it finds the messages of the PDOs that are switched on, and who sends them', () => {
    const found = [...database.messages.values()].map(({ id, dlc, sendingNode }) => [id, dlc, sendingNode]);
    const board = `Board${NODE}`;
    assert.deepStrictEqual(found.sort(([a], [b]) => a - b), [
        [0x183, 8, board], [0x203, 8, 'Master'], [0x283, 8, board], [0x303, 8, 'Master'], [0x383, 2, board], [0x403, 2, 'Master'], [0x483, 4, board],
        [0x680, 8, board]]);
});

test('it decodes the recorded frames to the values of plenum decode', () => {
    const can = new Can();
    can.database = database;
    const lines = fs.readFileSync(rig.file('bus.log'), 'utf8').trim().split('\n');
    assert.strictEqual(lines.length, decoded.length);
    const si = { mbar: [100, 'Pa'], Pa: [1, 'Pa'], V: [1, 'V'], '': [1, ''] };
    const compared = new Map();
    lines.forEach((line, k) => {
        const [id, payload] = line.split(' ').at(-1).split('#');
        if (!payload) return;
        const frame = can.createFrame(parseInt(id, 16), [...bytes(payload)]);
        const message = can.decode(frame);
        if (!message) return;
        const signals = [...message.boundSignals.values()];
        assert.strictEqual(signals.length, decoded[k].values.length, line);
        signals.forEach(({ rawValue, value, boundData: { signal } }, at) => {
            const ours = decoded[k].values[at];
            // The package knows of REAL32 (SIG_VALTYPE_) and yet decodes it as a whole number.
            const number = signal.dataType === 'float' ? Buffer.from(Int32Array.of(rawValue).buffer).readFloatLE() : value;
            if (signal.unit === 'm3') {
                assert.ok(Math.abs(number - 1e-7 * ours.value) < 1e-12, `${line}: ${number} m3, code ${ours.value}`);
            } else {
                const [factor, unit] = si[signal.unit];
                assert.strictEqual(unit, ours.unit, signal.name);
                // 2228h:1, the LSB of a command, is a REAL32
                assert.ok(Math.abs(factor * number - ours.value) <= 2 ** -24 * Math.abs(ours.value), `${line}: ${signal.name} ${number}, ${ours.value}`);
            }
            const name = ours.name.toLowerCase().replace(/^command,/, 'command code,');
            assert.strictEqual(signal.name.toLowerCase(), name.replace(/[^a-z0-9]+/g, '_'));
            compared.set(frame.id, (compared.get(frame.id) ?? 0) + 1);
        });
    });
    for (const [id, values] of [[0x183, 12], [0x203, 12], [0x383, 1], [0x403, 3], [0x680, 9]])
        assert.ok(compared.get(id) >= values, `${id.toString(16)}: ${compared.get(id)} values`);
});
