// A rig that `plenum sim` serves over socketcand, and the way to its bus: what the tests in JavaScript share.
'use strict';

const { execFile, spawn } = require('node:child_process');
const { EventEmitter, once } = require('node:events');
const assert = require('node:assert');
const fs = require('node:fs');
const Module = require('node:module');
const net = require('node:net');
const os = require('node:os');
const path = require('node:path');
const { promisify } = require('node:util');

const DEADLINE_MS = 20000;

/** The npm package `name` in `folder`; without it the test is skipped, and says so. */
function foreign(folder, name) {
    try {
        return Module.createRequire(path.join(path.resolve(folder), 'any.js'))(name);
    } catch (error) {
        if (error.code !== 'MODULE_NOT_FOUND') throw error;
        console.log(`skipped: no npm package ${name} in`, folder, '(toolchains/dev setup)');
        return process.exit(77);
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

class ServedRig {
    constructor(plenum) {
        this.plenum = plenum;
        this.folder = fs.mkdtempSync(path.join(os.tmpdir(), 'plenum-'));
    }

    file(name) {
        return path.join(this.folder, name);
    }

    /** Another plenum, in the rig's folder, to its end: what it printed. What it said on the bus is over then for our channel, too. */
    async run(...args) {
        const { stdout } = await promisify(execFile)(this.plenum, args, { cwd: this.folder, maxBuffer: 1 << 28 });
        if (this.channel) await next(this.channel, 'frame', ({ id }) => id > 0x700);  // a heartbeat, behind all of it
        return stdout;
    }

    /** Another plenum, in the rig's folder, that is ready for its user: the process. */
    async start(...args) {
        const started = spawn(this.plenum, args, { cwd: this.folder, stdio: ['ignore', 'pipe', 'inherit'] });
        started.ready = await next(started.stdout.setEncoding('utf8'), 'data');
        return started;
    }

    /** Ends such a process as its user does. */
    static async end(started) {
        const ended = once(started, 'exit');
        started.kill('SIGINT');
        assert.deepStrictEqual(await ended, [0, null]);
    }

    /** The rig's bus, and a channel of ours to it. The time is a lid on a test that hangs. */
    async serve(...args) {
        this.process = await this.start('sim', '--bus', 'socketcand:127.0.0.1:0/can0', '--seconds', '300', ...args);
        const [, bus, port] = this.process.ready.match(/serving (socketcand:127\.0\.0\.1:(\d+)\/can0)/);
        this.bus = bus;
        this.channel = await SocketcandChannel.open(Number(port), 'can0');
    }

    async close() {
        if (this.channel) this.channel.close();
        if (this.process) await ServedRig.end(this.process);
        fs.rmSync(this.folder, { recursive: true });
    }
}

module.exports = { DEADLINE_MS, ServedRig, foreign, next };
