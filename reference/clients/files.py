"""The files that programs are tried on, made by candela."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenEXR

HERE = Path(__file__).resolve().parent

# One byte more than Blender 4.5 reads, and as many as it reads: "light_" and the name.
LONG = "a name of many words that is longer than some programs like"
SHORT = LONG[: 57 - len("light_")]

ALL_LAYERS = "lights,light-diffuse,light-specular,diffuse,specular,albedo,irradiance,shadow,depth,position,normal"


@dataclass
class File:
    """A file: what is asked of its reader (a key of verdicts.VERDICTS), options of `candela render`, what the scene has
    in another way (old text, new text), and attributes that are taken out of the header afterwards."""

    name: str
    question: str
    options: str = ""
    replaced: tuple = ()
    without: tuple = ()


ACESCG = (('"rec709"', '"acescg"'),)
MIXED = "--half --layers depth,normal"

FILES = [
    File("rec709", "picture"),
    File("half", "picture", "--half"),
    *(File(f"compression-{name}", "picture", f"--compression {name}") for name in ("none", "rle", "zips", "piz", "pxr24", "dwaa", "dwab")),
    File("id", "space", "", ACESCG, without=("chromaticities",)),
    File("chromaticities", "space", "--chromaticities", ACESCG, without=("colorInteropID",)),
    File("id-and-chromaticities", "space", "--chromaticities", ACESCG),
    File("crop", "place", "--crop 10,20,42,44"),
    File("crop-full-window", "place", "--crop 10,20,42,44 --full-window"),
    File("layers", "layers", f"--layers {ALL_LAYERS}"),
    File("layers-half", "layers", f"--half --layers {ALL_LAYERS}"),
    File("name-57-bytes", "layers", "--layers lights", (("lights.key.", f'lights."{SHORT}".'),)),
    File("name-65-bytes", "layers", "--layers lights", (("lights.key.", f'lights."{LONG}".'),)),
    File("name-200-bytes", "layers", "--layers lights", (("lights.key.", f'lights."{"n" * 200}".'),)),
    File("name-unicode", "layers", "--layers lights", (("lights.key.", 'lights."Schlüssel 主光".'),)),
    File("mixed-zip", "layers", f"{MIXED} --compression zip"),
    File("mixed-zips", "layers", f"{MIXED} --compression zips"),
    File("mixed-rle", "layers", f"{MIXED} --compression rle"),
    File("mixed-none", "layers", f"{MIXED} --compression none"),
    File("mixed-piz", "layers", f"{MIXED} --compression piz"),
    File("mixed-pxr24", "layers", f"{MIXED} --compression pxr24"),
    File("mixed-dwaa", "layers", f"{MIXED} --compression dwaa"),
    File("bands-23", "layers", "--layers spectral --wavelengths 400:620:10"),
    File("bands-24", "layers", "--layers spectral --wavelengths 400:630:10"),
    File("bands-41", "layers", "--layers spectral"),
    File("beside-bands", "picture", "--layers spectral --spectral-output bands.exr"),
    File("cryptomatte", "layers", "--layers cryptomatte"),
    File("cryptomatte-half", "layers", "--half --layers cryptomatte"),
]


@dataclass
class Image:
    """A file as it is stored, by the OpenEXR project's own library."""

    planes: dict
    header: dict
    place: tuple
    whole: tuple

    @property
    def layers(self):
        """What stands before the last dot of a channel's name, or the name itself, but for the picture's own."""
        names = {name.rpartition(".")[0] or name for name in self.planes if name not in "RGBA"}
        return sorted(names)


def stored(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        header = dict(file.header())
        planes = {name: np.array(channel.pixels, np.float32) for name, channel in file.channels().items()}
    low, _ = header["dataWindow"]
    first, last = header["displayWindow"]
    place = tuple(int(n) for n in np.subtract(low, first))
    return Image(planes, header, place, tuple(int(n) for n in np.subtract(last, first) + 1))


def attributes_removed(path, names):
    """Takes attributes out of the header of an EXR of one part, byte by byte: the rest stays as candela has written
    it. The table of offsets to the chunks moves with it."""
    data = path.read_bytes()
    at, kept, removed = 8, bytearray(data[:8]), 0
    while data[at]:
        name_end = data.index(0, at)
        type_end = data.index(0, name_end + 1)
        size = int.from_bytes(data[type_end + 1 : type_end + 5], "little")
        end = type_end + 5 + size
        if data[at:name_end].decode() in names:
            removed += end - at
        else:
            kept += data[at:end]
        at = end
    kept.append(0)
    table = at + 1
    first_chunk = int.from_bytes(data[table : table + 8], "little")
    for entry in range(table, first_chunk, 8):
        offset = int.from_bytes(data[entry : entry + 8], "little")
        kept += (offset - removed).to_bytes(8, "little")
    path.write_bytes(kept + data[first_chunk:])


def make(file, renderer, folder):
    """Renders a file; what went wrong, if anything did."""
    scene = (HERE / "scene.toml").read_text()
    for old, new in file.replaced:
        scene = scene.replace(old, new)
    (folder / f"{file.name}.toml").write_text(scene)
    output = folder / f"{file.name}.exr"
    command = [renderer, "render", f"{file.name}.toml", "-q", "--samples", "4", "-o", output.name, *file.options.split()]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if run.returncode:
        return run.stderr.strip().splitlines()[0]
    if file.without:
        attributes_removed(output, file.without)
    return ""
