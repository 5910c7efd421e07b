"""What a client hands back: the image as its program has read it."""

import json
import sys
from pathlib import Path

import numpy as np

# The exit code of a client whose program is not installed; run.py then says "not here".
NOT_HERE = 69


def arguments():
    """The file to read, the folder for what was read, and the layers that the file has."""
    return Path(sys.argv[1]), Path(sys.argv[2]), json.loads(sys.argv[3])


def not_here(why):
    print(why, file=sys.stderr)
    sys.exit(NOT_HERE)


def hand_back(folder, program, planes, *, color="stored", place=None, whole=None, tags=None, note=""):
    """Writes read.json and read.f32.

    `program` is its name and version, `planes` its channels by name, each an array of rows. `color` is "stored" where
    the numbers are as the program has read them, "rec709" where it was asked for linear Rec.709. `place` is the column
    and the row of the first pixel in the whole image, and `whole` the size of that, where the program tells them.
    `tags` are the attributes that it makes known."""
    arrays = {name: np.ascontiguousarray(plane, "<f4") for name, plane in planes.items()}
    shapes = {array.shape for array in arrays.values()}
    if len(shapes) > 1:
        raise ValueError(f"channels of several sizes: {shapes}")
    height, width = shapes.pop() if shapes else (0, 0)
    said = {
        "program": program,
        "channels": list(arrays),
        "size": [width, height],
        "color": color,
        "place": place,
        "whole": whole,
        "tags": tags or {},
        "note": note,
    }
    (folder / "read.json").write_text(json.dumps(said))
    (folder / "read.f32").write_bytes(b"".join(array.tobytes() for array in arrays.values()))
