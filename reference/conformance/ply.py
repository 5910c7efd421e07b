"""Meshes in PLY: ASCII, or binary with the low byte first; a polygon is a fan of triangles."""

import struct

SIZES = {
    "char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
    "int": "i", "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d",
}


def ply(path):
    """Triangles with the normals of their corners, or None."""
    data = path.read_bytes()
    end = data.index(b"end_header") + len(b"end_header")
    end = data.index(b"\n", end) + 1
    elements, kind = [], None
    for line in data[:end].decode("ascii", "replace").splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            kind = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    if kind not in ("ascii", "binary_little_endian"):
        raise ValueError(f"{path}: {kind}")
    words = iter(data[end:].split()) if kind == "ascii" else None
    at = end

    def number(code):
        nonlocal at
        if words is not None:
            return float(next(words)) if code in "fd" else int(next(words))
        (value,) = struct.unpack_from(f"<{code}", data, at)
        at += struct.calcsize(code)
        return value

    vertices, normals, triangles = [], [], []
    for name, count, properties in elements:
        for _ in range(count):
            entry = {}
            for *types, key in properties:
                if types[0] == "list":
                    entry[key] = [number(SIZES[types[2]]) for _ in range(number(SIZES[types[1]]))]
                else:
                    entry[key] = number(SIZES[types[0]])
            if name == "vertex":
                vertices.append([entry["x"], entry["y"], entry["z"]])
                if "nx" in entry:
                    normals.append([entry["nx"], entry["ny"], entry["nz"]])
            elif name == "face":
                corners = next(value for value in entry.values() if isinstance(value, list))
                for b, c in zip(corners[1:], corners[2:]):
                    fan = [corners[0], b, c]
                    smooth = [normals[i] for i in fan] if normals else None
                    triangles.append(([vertices[i] for i in fan], smooth))
    return triangles
