"""The frames of docs/joystick-link.md, written from the document: an oracle for the codec in C++."""

import struct

CODES = {"command": 1, "query": 2, "set_calibration": 3, "select_profile": 4, "report": 16, "identity": 17}
REPORT = struct.Struct("<IhhHHiiHhhBHBBBH")
REPORT_FIELDS = [
    "tick",
    "forward",
    "left",
    "adc_forward",
    "adc_left",
    "left_edges",
    "right_edges",
    "lost_edges",
    "given_forward",
    "given_left",
    "state",
    "faults",
    "inputs",
    "profile",
    "age",
    "bad_frames",
]
CALIBRATION = struct.Struct("<14H4B")


def crc16(data: bytes) -> int:
    """MCRF4XX, a bit at a time."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)
    return crc


def stuffed(data: bytes) -> bytes:
    """COBS."""
    return b"".join(bytes([len(part) + 1]) + part for part in data.split(b"\0"))


def unstuffed(data: bytes) -> bytes:
    parts = []
    while data:
        parts.append(data[1 : data[0]])
        data = data[data[0] :]
    return b"\0".join(parts)


def frame(kind: str, payload: bytes = b"", sequence: int = 0) -> bytes:
    body = bytes([1, CODES[kind], sequence]) + payload
    return stuffed(body + struct.pack("<H", crc16(body))) + b"\0"


def command(tick: int, forward: int, left: int = 0) -> bytes:
    return frame("command", struct.pack("<Ihh", tick, forward, left))


def reports(stream: bytes) -> list[dict[str, int]]:
    """Of a stream that ends anywhere, the whole reports."""
    found = []
    for part in stream.split(b"\0")[:-1]:
        body = unstuffed(part)
        if len(body) == 39 and body[1] == CODES["report"] and crc16(body[:-2]) == struct.unpack("<H", body[-2:])[0]:
            found.append(dict(zip(REPORT_FIELDS, REPORT.unpack(body[3:-2]), strict=True)))
    return found
