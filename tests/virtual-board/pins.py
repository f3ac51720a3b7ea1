"""What the board does at its pins, as guest/plantd.cpp writes it down in the guest."""

PINS = "/run/virtual-board/pins"
RESTING = [round(65536 * volts / 10) for volts in (5, 3)]  # codes of null_V and vent_V of a chamber: the valve is shut, or vents


class Pins:
    """What plantd has written: a row a change, of the time [us], the valves' power, the emergency stop, and the outputs' codes."""

    def __init__(self, text):
        self.rows = [[int(word) for word in line.split()] for line in text.splitlines()]

    @staticmethod
    def safe(row):
        return row[1] == 0 or all(code in RESTING for code in row[3:])

    def until(self, time_us):
        return [row for row in self.rows if row[0] <= time_us]

    def stop_pressed_us(self):
        return next(row[0] for row in self.rows if row[2] == 1)

    def safe_for_good_us(self):
        """Since when they are safe; None: they are not."""
        since = None
        for row in self.rows:
            since = (since or row[0]) if self.safe(row) else None
        return since
