"""PNG files made small without loss: opaque pixels need no alpha, and more patience saves half of the rest."""

from __future__ import annotations

import struct
import zlib

import numpy as np

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_RGB, _RGBA = 2, 6


def smaller(png: bytes) -> bytes:
    """The same picture in fewer bytes; `png` itself unless it is opaque RGBA of 8 bits, filtered as vl-convert does.

    Rows as they are, or each pixel as its difference from the one at its left (filters 0 and 1 of the PNG standard).
    Drawings have long runs of one colour, which deflate best unfiltered.
    """
    chunks = dict.fromkeys((b"IHDR", b"IDAT"), b"")
    place = len(_SIGNATURE)
    while place < len(png):
        (length,) = struct.unpack(">I", png[place : place + 4])
        kind = png[place + 4 : place + 8]
        chunks[kind] = chunks.get(kind, b"") + png[place + 8 : place + 8 + length]
        place += length + 12
    width, height, depth, colour, *_ = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    if (depth, colour) != (8, _RGBA):
        return png
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), dtype=np.uint8).reshape(height, 1 + 4 * width)
    pixels = rows[:, 1:].reshape(height, width, 4)
    if (rows[:, 0] > 1).any():
        return png
    pixels = np.where(rows[:, :1, np.newaxis] == 1, np.cumsum(pixels, axis=1, dtype=np.uint8), pixels)
    if (pixels[:, :, 3] != 255).any():
        return png
    plain = np.zeros((height, 1 + 3 * width), dtype=np.uint8)
    plain[:, 1:] = pixels[:, :, :3].reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, _RGB, 0, 0, 0)
    body = zlib.compress(plain.tobytes(), 9)
    return _SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", body) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
