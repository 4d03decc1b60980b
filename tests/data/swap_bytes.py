#!/usr/bin/env python3
"""Turns a little-endian binary MSH file (2.2 or 4.1) into a big-endian one: swap_bytes.py IN OUT."""
import struct
import sys

NODES = {15: 1, 1: 2, 2: 3, 4: 4}


class Swapper:
    def __init__(self, data):
        self.data, self.pos, self.out = data, 0, bytearray()

    def copy_line(self):
        end = self.data.index(b"\n", self.pos) + 1
        line, self.pos = self.data[self.pos:end], end
        self.out += line
        return line.strip()

    def take(self, code):
        values = struct.unpack_from("<" + code, self.data, self.pos)
        self.pos += struct.calcsize("<" + code)
        self.out += struct.pack(">" + code, *values)
        return values


def entities(s):
    counts = s.take("4q")
    for dim, n in enumerate(counts):
        for _ in range(n):
            s.take("i3d" if dim == 0 else "i6d")
            for _ in range(1 if dim == 0 else 2):
                s.take("%di" % s.take("q")[0])


def nodes4(s):
    blocks = s.take("4q")[0]
    for _ in range(blocks):
        n = s.take("3iq")[3]
        s.take("%dq" % n)
        s.take("%dd" % (3 * n))


def elements4(s):
    blocks = s.take("4q")[0]
    for _ in range(blocks):
        _, _, kind, n = s.take("3iq")
        s.take("%dq" % (n * (1 + NODES[kind])))


def nodes2(s):
    for _ in range(int(s.copy_line())):
        s.take("i3d")


def elements2(s):
    left = int(s.copy_line())
    while left > 0:
        kind, n, tags = s.take("3i")
        s.take("%di" % (n * (1 + tags + NODES[kind])))
        left -= n


def main(source, target):
    s = Swapper(open(source, "rb").read())
    version = None
    while s.pos < len(s.data):
        line = s.copy_line()
        if line == b"$MeshFormat":
            version = s.copy_line().split()[0]
            s.take("i")
        elif line == b"$Entities":
            entities(s)
        elif line == b"$Nodes":
            (nodes4 if version == b"4.1" else nodes2)(s)
        elif line == b"$Elements":
            (elements4 if version == b"4.1" else elements2)(s)
    open(target, "wb").write(s.out)


main(sys.argv[1], sys.argv[2])
