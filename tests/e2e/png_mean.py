# SPDX-License-Identifier: MIT
"""Prints width, height and the mean linear light, in thousandths, of a PNG of 8-bit RGB: png_mean.py FILE."""
import struct
import sys
import zlib


def predict(kind, left, up, corner):
    """The prediction of a byte by the filter of its row (PNG specification, section 9)."""
    if kind == 4:
        guess = left + up - corner
        return min((left, up, corner), key=lambda value: abs(guess - value))
    return (0, left, up, (left + up) // 2)[kind]


with open(sys.argv[1], "rb") as file:
    data = file.read()
at, packed = 8, b""
while at < len(data):
    length, name = struct.unpack(">I4s", data[at:at + 8])
    if name == b"IHDR":
        width, height, bits, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
        assert (bits, colour) == (8, 2)
    if name == b"IDAT":
        packed += data[at + 8:at + 8 + length]
    at += length + 12
rows, stride = zlib.decompress(packed), 3 * width + 1
light = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (i / 255 for i in range(256))]
total, above = 0.0, [0] * (stride - 1)
for y in range(height):
    row = list(rows[y * stride + 1:(y + 1) * stride])
    for i, value in enumerate(row):
        left, corner = (row[i - 3], above[i - 3]) if i >= 3 else (0, 0)
        row[i] = (value + predict(rows[y * stride], left, above[i], corner)) % 256
        total += light[row[i]]
    above = row
print(width, height, round(1000 * total / (3 * width * height)))
