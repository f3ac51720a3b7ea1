"""What a browser has painted, from the PNG file that it writes (RFC 2083: eight bits a channel, not interlaced)."""

import struct
import zlib


def paeth(left, up, corner):
    guess = left + up - corner
    a, b, c = abs(guess - left), abs(guess - up), abs(guess - corner)
    return left if a <= b and a <= c else up if b <= c else corner


class Screenshot:
    """width, height [pixels]; rows count downwards, columns to the right, from 0."""

    def __init__(self, data):
        """The bytes of the file."""
        if data[:8] != b"\x89PNG\r\n\x1a\n":
            raise ValueError("no PNG file")
        at, packed = 8, b""
        while at < len(data):
            length, kind = struct.unpack(">I4s", data[at:at + 8])
            body = data[at + 8:at + 8 + length]
            if kind == b"IHDR":
                self.width, self.height, depth, colours, _, _, interlaced = struct.unpack(">IIBBBBB", body)
                if depth != 8 or colours not in (2, 6) or interlaced:
                    raise ValueError(f"depth {depth}, colour type {colours}, interlaced {interlaced}")
                self.channels = 3 if colours == 2 else 4
            elif kind == b"IDAT":
                packed += body
            at += 12 + length
        self.rows = self.unfiltered(zlib.decompress(packed))

    def unfiltered(self, raw):
        size, step = self.width * self.channels, self.channels
        above, rows = bytes(size), []
        for at in range(0, len(raw), size + 1):
            kind, row = raw[at], bytearray(raw[at + 1:at + 1 + size])
            if kind == 2:
                row = bytearray((one + up) & 255 for one, up in zip(row, above))
            elif kind:
                for i in range(size):
                    left, up, corner = (row[i - step] if i >= step else 0), above[i], (above[i - step] if i >= step else 0)
                    row[i] = (row[i] + (left if kind == 1 else (left + up) // 2 if kind == 3 else paeth(left, up, corner))) & 255
            rows.append(bytes(row))
            above = row
        return rows

    def pixel(self, column, row):
        at = column * self.channels
        return tuple(self.rows[row][at:at + 3])

    def painted(self, colour, box, within=48):
        """{column: rows that are painted in `colour`, "#rrggbb", each channel within so much}; box: left, top, right, bottom."""
        red, green, blue = bytes.fromhex(colour.removeprefix("#"))
        left, top, right, bottom = box
        columns = {}
        for row in range(top, bottom + 1):
            cells = self.rows[row][left * self.channels:(right + 1) * self.channels]
            channels = (cells[k::self.channels] for k in range(3))
            for column, (r, g, b) in enumerate(zip(*channels), left):
                if abs(r - red) <= within and abs(g - green) <= within and abs(b - blue) <= within:
                    columns.setdefault(column, []).append(row)
        return columns

    def curve(self, colour, box):
        """{column: the row, a float, at which it is crossed by what is painted in `colour`}."""
        return {column: sum(rows) / len(rows) for column, rows in self.painted(colour, box).items()}
