"""Small OpenEXR images: FLOAT, of one part, in lines; written without compression, read with ZIP too."""

import struct
import zlib

FLOAT = 2


def write(path, width, height, channels):
    """`channels` is a name each, with its width × height numbers, row by row from the top."""
    names = sorted(channels)

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    listed = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3xii", FLOAT, 0, 1, 1) for name in names
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = b"".join(
        [
            struct.pack("<ii", 20000630, 2),
            attribute("channels", "chlist", listed + b"\0"),
            attribute("compression", "compression", b"\0"),
            attribute("dataWindow", "box2i", window),
            attribute("displayWindow", "box2i", window),
            attribute("lineOrder", "lineOrder", b"\0"),
            attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
            attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
            attribute("screenWindowWidth", "float", struct.pack("<f", 1)),
            b"\0",
        ]
    )
    size = 4 * width * len(names)
    first = len(header) + 8 * height
    offsets = [first + y * (8 + size) for y in range(height)]
    blocks = []
    for y in range(height):
        row = slice(y * width, (y + 1) * width)
        numbers = [number for name in names for number in channels[name][row]]
        blocks.append(struct.pack("<ii", y, size) + struct.pack(f"<{len(numbers)}f", *numbers))
    with open(path, "wb") as file:
        file.write(header + struct.pack(f"<{height}Q", *offsets) + b"".join(blocks))


def text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def read(path):
    """Width, height, and the numbers of each channel."""
    with open(path, "rb") as file:
        data = file.read()
    magic, version = struct.unpack_from("<ii", data)
    if magic != 20000630 or version & ~0x400 != 2:
        raise ValueError(f"{path} is not an OpenEXR image of one part in lines")
    at, attributes = 8, {}
    while data[at] != 0:
        name, at = text(data, at)
        _, at = text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    names, listed, place = [], attributes["channels"], 0
    while listed[place] != 0:
        name, place = text(listed, place)
        (kind,) = struct.unpack_from("<i", listed, place)
        if kind != FLOAT:
            raise ValueError(f"channel {name} of {path} is not FLOAT")
        names.append(name)
        place += 16
    compression = attributes["compression"][0]
    rows = {0: 1, 2: 1, 3: 16}.get(compression)
    if rows is None:
        raise ValueError(f"{path} is compressed by something other than ZIP")
    blocks = -(-height // rows)
    channels = {name: [0.0] * (width * height) for name in names}
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        block = data[offset + 8 : offset + 8 + size]
        count = min(rows, bottom + 1 - y)
        whole = 4 * width * len(names) * count
        if compression and size < whole:
            block = unpacked(zlib.decompress(block))
        numbers = iter(struct.unpack(f"<{whole // 4}f", block))
        for row in range(y - top, y - top + count):
            for name in names:
                for x in range(width):
                    channels[name][row * width + x] = next(numbers)
    return width, height, channels


def unpacked(block):
    """Undoes what comes before zlib: differences, and even bytes before odd ones."""
    bytes_ = bytearray(block)
    for i in range(1, len(bytes_)):
        bytes_[i] = (bytes_[i - 1] + bytes_[i] - 128) & 255
    half = (len(bytes_) + 1) // 2
    result = bytearray(len(bytes_))
    result[0::2] = bytes_[:half]
    result[1::2] = bytes_[half:]
    return bytes(result)
