"""The hardware's watchdog: where nobody in the board watches any more, the whole board starts anew, at rest.

What it does then is asked of the guest: after a reset qemu's CAN controllers hand each frame over with the next one only, and the PC's
tools would hear every answer too late.
"""

import sys
import unittest

from board import NODE, Board
from pins import PINS, Pins

TIMEOUT_s = 5  # HardwareWatchdog::kTimeout_s
CARD_RESET = 0x20  # WDIOF_CARDRESET: a watchdog has reset the machine
PRE_OPERATIONAL = "7F"
WATCHDOG = "/sys/class/watchdog/watchdog0"


class HardwareWatchdog(unittest.TestCase):
    def test_a_board_that_ticks_is_left_alone_and_one_that_stands_still_is_reset(self):
        with Board() as board:
            boot = board.run("cat /proc/sys/kernel/random/boot_id")
            self.assertEqual(board.run(f"cat {WATCHDOG}/state {WATCHDOG}/timeout {WATCHDOG}/bootstatus").split(), ["active", str(TIMEOUT_s), "0"])
            board.run("systemctl service-watchdogs no")
            loop, guard = board.processes()
            board.run(f"sleep {3 * TIMEOUT_s}; kill -0 {loop}")
            self.assertEqual(board.run("cat /proc/sys/kernel/random/boot_id"), boot)

            bite_s = board.bitten(lambda: board.run(f"kill -STOP {loop} {guard}"))
            print(f"{'bite, by the clock of the PC':40}{bite_s:8.1f} s", file=sys.stderr)
            board.run("systemctl is-system-running --wait", board.BOOT_s)
            self.assertNotEqual(board.run("cat /proc/sys/kernel/random/boot_id"), boot)
            self.assertEqual(board.run(f"cat {WATCHDOG}/bootstatus"), str(CARD_RESET))
            heartbeats = board.run(f"candump -L -n 3 can1,{0x700 + NODE:X}:7FF").splitlines()
            self.assertEqual(heartbeats[-1].split("#")[1], PRE_OPERATIONAL)
            rows = Pins(board.run(f"cat {PINS}")).rows
            self.assertTrue(rows)
            self.assertEqual([row for row in rows if not Pins.safe(row)], [])


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
