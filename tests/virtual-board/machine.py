"""The virtual board as a Python object: qemu, its monitor, and a way to run commands in the guest.

    with Machine(arguments) as machine:
        machine.run("cat /proc/version")
        machine.power_key()

Every wait is on an event (a line, an answer, an end) and has a limit. A limit that is passed raises Timeout with the end of
the guest's console, never a guess.
"""

import base64
import json
import re
import shutil
import socket
import subprocess
import tempfile
import time
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
IMAGE = TOP / "build/image"
GUEST = TOP / "build/virtual-board"


class Timeout(Exception):
    """An event did not come within its limit."""


class CommandFailed(Exception):
    """A command in the guest ended with another status than 0."""


class Channel:
    """A stream from a Unix socket, read in lines and counted bytes within a limit."""

    def __init__(self, path, limit_s):
        end = time.monotonic() + limit_s
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(limit_s)
        try:
            self.socket.connect(str(path))
        except OSError:
            self.socket.close()
            raise
        self.socket.settimeout(max(0.001, end - time.monotonic()))
        self.buffer = b""

    def send(self, text):
        self.socket.sendall(text.encode())

    def fill(self, end, what):
        """More bytes, before `end`."""
        left = end - time.monotonic()
        if left <= 0:
            raise Timeout(what)
        self.socket.settimeout(left)
        try:
            more = self.socket.recv(65536)
        except socket.timeout:
            raise Timeout(what) from None
        if not more:
            raise Timeout(f"{what}: qemu has ended")
        self.buffer += more

    def line(self, limit_s, what):
        end = time.monotonic() + limit_s
        while b"\n" not in self.buffer:
            self.fill(end, what)
        line, self.buffer = self.buffer.split(b"\n", 1)
        return line.decode(errors="replace").rstrip("\r")

    def bytes(self, count, limit_s, what):
        end = time.monotonic() + limit_s
        while len(self.buffer) < count:
            self.fill(end, what)
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def close(self):
        self.socket.close()


class Machine:
    """qemu's machine `virt` with two CAN controllers on one bus. `disk`: a disk image, whose changes are thrown away; none:
    the guest lives in its initramfs. `firmware`: it boots the disk by UEFI, as a board does, and has no agent. `plenumd`: it is
    started at boot; else it leaves the devices to the tests. Seconds are of this machine's clock."""

    FIRMWARE = "/usr/share/qemu-efi-aarch64/QEMU_EFI.fd"

    START_s = 10.0  # qemu's own start
    BOOT_s = 600.0
    COMMAND_s = 120.0

    def __init__(self, disk=None, firmware=False, plenumd=False, boot_s=BOOT_s):
        self.folder = Path(tempfile.mkdtemp(prefix="plenum-virtual-board-"))
        release = (IMAGE / "kernel/release").read_text().strip()
        self.console = self.folder / "console"
        command = [
            "qemu-system-aarch64", "-nodefaults", "-display", "none", "-M", "virt,gic-version=3", "-cpu", "cortex-a53", "-smp", "1", "-m", "512",
            # Time goes by instructions, 4 ns each, and waits for a PC that is slower: README.md.
            "-icount", "shift=2,sleep=on",
            "-no-reboot", "-serial", "chardev:serial", "-device", "i6300esb", "-action", "watchdog=reset",
            "-qmp", f"unix:{self.folder}/qmp,server=on,wait=off",
            "-device", "virtio-serial-pci", "-chardev", f"socket,id=agent,path={self.folder}/agent,server=on,wait=off",
            "-device", "virtserialport,chardev=agent,name=plenum.agent",
            "-object", "can-bus,id=can", "-device", "kvaser_pci,canbus=can", "-device", "kvaser_pci,canbus=can",
        ]
        if firmware:
            # A guest whose console nobody reads stands still: expect() is to read it.
            command += ["-chardev", f"socket,id=serial,path={self.folder}/serial,server=on,wait=off,logfile={self.console}", "-bios", self.FIRMWARE]
        else:
            # gpio_keys would take the line of the power key, which here is the board's emergency stop.
            words = "console=ttyAMA0 panic=-1 modprobe.blacklist=gpio_keys" + (" root=LABEL=plenum net.ifnames=0" if disk else "")
            words += "" if plenumd else " systemd.mask=plenumd.service"
            command += ["-chardev", f"file,id=serial,path={self.console}"]
            command += ["-kernel", str(IMAGE / f"kernel/tree/boot/vmlinuz-{release}"), "-initrd", str(GUEST / "initramfs.cpio.gz"), "-append", words]
        if disk:
            command += ["-drive", f"file={disk},format=raw,if=none,id=disk,snapshot=on", "-device", "virtio-blk-pci,drive=disk"]
            command += ["-netdev", "user,id=door,restrict=on,hostfwd=tcp:127.0.0.1:0-:29536", "-device", "virtio-net-pci,netdev=door,romfile="]
        self.lost = False
        self.started = time.monotonic()
        with open(self.folder / "qemu.log", "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT)
        try:
            self.monitor = self._connect("qmp")
            self.monitor.line(self.START_s, "qemu's monitor")
            self.qmp("qmp_capabilities")
            if firmware:
                self.serial = self._connect("serial")
            else:
                self.agent = self._connect("agent")
                self._expect_agent(boot_s)
        except BaseException:
            self.close()
            raise

    def _connect(self, name):
        """qemu makes its sockets when it starts; there is no event of that but their being there."""
        end = time.monotonic() + self.START_s
        while True:
            if self.process.poll() is not None:
                raise Timeout("qemu has ended: " + (self.folder / "qemu.log").read_text())
            try:
                return Channel(self.folder / name, self.START_s)
            except (FileNotFoundError, ConnectionRefusedError):
                if time.monotonic() > end:
                    raise
                try:
                    self.process.wait(0.02)
                except subprocess.TimeoutExpired:
                    pass

    def _expect_agent(self, boot_s):
        if self._within(lambda: self.agent.line(boot_s, f"the agent of the guest, after {boot_s} s")) != "ready":
            raise Timeout("the agent of the guest did not say 'ready'")
        self.booted_s = time.monotonic() - self.started

    def _within(self, wait):
        """The wait's answer; a limit that was passed tells what the console said last, and ends the use of the guest: an answer
        that comes later would be taken for that of another command."""
        if self.lost:
            raise Timeout("an earlier wait was in vain")
        try:
            return wait()
        except Timeout as passed:
            self.lost = True
            said = self.console.read_text(errors="replace").splitlines()[-25:] if self.console.exists() else []
            raise Timeout("\n".join([f"waited in vain for {passed}; the console's last lines:", *said])) from None

    def expect(self, text, limit_s):
        """Reads the serial console up to where `text` stands."""
        end = time.monotonic() + limit_s
        while text.encode() not in self.serial.buffer:
            self._within(lambda: self.serial.fill(end, f"'{text}' on the console, after {limit_s} s"))
        self.serial.buffer = self.serial.buffer.split(text.encode(), 1)[1]

    def qmp(self, name, **arguments):
        """One command of qemu's monitor, and what it returns."""
        self.monitor.send(json.dumps({"execute": name, "arguments": arguments}) + "\n")
        while True:
            answer = json.loads(self.monitor.line(self.START_s, f"qemu's answer to {name}"))
            if "error" in answer:
                raise CommandFailed(f"{name}: {answer['error']['desc']}")
            if "return" in answer:
                return answer["return"]

    def status(self, command, limit_s=COMMAND_s):
        """The exit status of one line of shell in the guest, and what it wrote, errors included."""
        def ask():
            self.agent.send(command + "\n")
            status, size = self.agent.line(limit_s, f"the end of '{command}'").split()
            return int(status), self.agent.bytes(int(size), limit_s, f"what '{command}' wrote")
        return self._within(ask)

    def run_bytes(self, command, limit_s=COMMAND_s):
        status, output = self.status(command, limit_s)
        if status:
            raise CommandFailed(f"'{command}' ended with status {status}: {output.decode(errors='replace')}")
        return output

    def run(self, command, limit_s=COMMAND_s):
        """What a line of shell writes that must end well."""
        return self.run_bytes(command, limit_s).decode().strip()

    def write(self, path, text):
        """A file of the guest."""
        self.run(f"echo {base64.b64encode(text.encode()).decode()} | base64 -d >{path}")

    def bitten(self, strike, boot_s=BOOT_s):
        """Does what makes the hardware's watchdog bite, and waits until the guest has booted anew: seconds until the bite."""
        self.qmp("set-action", reboot="reset")
        struck = time.monotonic()
        strike()
        self._within(lambda: self._expect_event("WATCHDOG"))
        bitten = self.started = time.monotonic()
        self._expect_agent(boot_s)
        return bitten - struck

    def _expect_event(self, name):
        while json.loads(self.monitor.line(self.COMMAND_s, f"qemu's event {name}, after {self.COMMAND_s} s")).get("event") != name:
            pass

    def power_key(self):
        """Presses the power key: a pulse of 100 ms on line 3 of the gpiochip, which the board takes for its emergency stop."""
        self.qmp("system_powerdown")

    def door_port(self):
        """The port of this machine that leads to the guest's can_door."""
        told = self.qmp("human-monitor-command", **{"command-line": "info usernet"})
        return int(re.search(r"TCP\[HOST_FORWARD\]\s+\d+\s+127\.0\.0\.1\s+(\d+)", told).group(1))

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        for channel in (getattr(self, name, None) for name in ("monitor", "serial", "agent")):
            if channel:
                channel.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
