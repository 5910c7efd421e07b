#!/usr/bin/env python3
"""Renders layers with candela and has other people's readers judge them; a line for each fact, exit code 1 at the first
that does not hold:

    target/clients/bin/python reference/clients/readable.py target/release/candela

Readers: OpenImageIO (PyPI OpenImageIO, whose `oiiotool` composes), the OpenEXR project's package (PyPI OpenEXR), and a
reader of Cryptomattes that is written here from Psyop's specification, with a MurmurHash3 of its own.
"""

import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
import OpenImageIO as oiio

OIIOTOOL = Path(sys.executable).parent / "oiiotool"

# Names of objects and materials in several scripts, with dots and spaces; lights of which two are a group.
TEXT = """
[image]
resolution = [96, 64]
background = [0.02, 0.03, 0.05]
[camera.perspective]
eye = [0, 1.2, 5]
look_at = [0, 0.5, 0]
vertical_fov = 34
[materials."Material.001".phong]
diffuse = [0.25, 0.1, 0.06]
specular = 0.3
shininess = 40
[materials."grün matt".phong]
diffuse = [0.1, 0.25, 0.12]
[objects."球.left".sphere]
material = "Material.001"
center = [-0.6, 0.5, 0]
radius = 0.5
[objects."right ball".sphere]
material = "grün matt"
center = [0.6, 0.5, 0.2]
radius = 0.5
[objects.floor.plane]
material = "grün matt"
point = [0, 0, 0]
normal = [0, 1, 0]
[lights.key.point]
position = [2, 3, 3]
intensity = [30, 26, 20]
[lights.pane1.point]
position = [-3, 2, 1]
intensity = 6
group = "window"
[lights.pane2.point]
position = [-3, 3, 1]
intensity = [4, 5, 8]
group = "window"
"""

LAYERS = "lights,diffuse,specular,albedo,irradiance,depth,position,normal,shadow,cryptomatte"


def say(fact, holds, detail=""):
    print(("ok  " if holds else "NOT ") + fact + (f": {detail}" if detail else ""))
    if not holds:
        sys.exit(1)


def murmur3(data):
    """MurmurHash3_x86_32 with seed 0."""
    mask, hashed = 0xFFFFFFFF, 0

    def scramble(k):
        k = k * 0xCC9E2D51 & mask
        k = (k << 15 | k >> 17) & mask
        return k * 0x1B873593 & mask

    whole = len(data) // 4 * 4
    for (k,) in struct.iter_unpack("<I", data[:whole]):
        hashed ^= scramble(k)
        hashed = (hashed << 13 | hashed >> 19) & mask
        hashed = (hashed * 5 + 0xE6546B64) & mask
    hashed ^= scramble(int.from_bytes(data[whole:], "little"))
    hashed ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35), (16, 1)):
        hashed ^= hashed >> shift
        hashed = hashed * factor & mask
    return hashed


def float_id(name):
    """The f32 that stands for a name."""
    hashed = murmur3(name.encode())
    if hashed >> 23 & 255 in (0, 255):
        hashed ^= 1 << 23
    return struct.unpack("<f", struct.pack("<I", hashed))[0]


def cryptomattes(image):
    """Of each Cryptomatte of a file the mattes by name, from header and channels alone."""
    spec = image.spec()
    attributes = {attribute.name: attribute.value for attribute in spec.extra_attribs}
    keys = {name.split("/")[1] for name in attributes if name.startswith("cryptomatte/")}
    pixels = image.get_pixels(oiio.FLOAT)
    found = {}
    for key in keys:
        of = lambda what: attributes[f"cryptomatte/{key}/{what}"]
        layer = of("name")
        assert key == f"{murmur3(layer.encode()):08x}"[:7], key
        assert of("hash") == "MurmurHash3_32" and of("conversion") == "uint32_to_float32"
        manifest = json.loads(of("manifest"))
        ranks = []
        number = 0
        while f"{layer}{number:02}.R" in spec.channelnames:
            for id_channel, coverage_channel in ("RG", "BA"):
                at = lambda c: pixels[..., spec.channelnames.index(f"{layer}{number:02}.{c}")]
                ranks.append((at(id_channel), at(coverage_channel)))
            number += 1
        mattes = {}
        for name, hexadecimal in manifest.items():
            value = np.float32(float_id(name))
            assert struct.unpack("<I", struct.pack("<f", value))[0] == int(hexadecimal, 16), name
            mattes[name] = sum(np.where(ids == value, coverage, 0) for ids, coverage in ranks)
        found[layer] = mattes
    return found


def main():
    candela = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "scene.toml").write_text(TEXT)
        run = lambda *arguments: subprocess.run(
            [str(argument) for argument in arguments], cwd=folder, check=True, capture_output=True, text=True
        ).stdout
        run(candela, "render", "scene.toml", "-o", "a.exr", "--layers", LAYERS, "-q")

        info = run(OIIOTOOL, "--info", "-v", "a.exr")
        for part in (
            'colorInteropID: "lin_rec709_scene"',
            "candela:samples: 16",
            "candela:residual: ",
            "pinholeFocalLength: ",
            'cryptomatte/3ae39a5/name: "CryptoObject"',
            'candela:transport: "rgb"',
        ):
            say(f"oiiotool --info -v has {part}", part in info)

        layers = ["light_key", "light_window", "light_background"]
        arguments = []
        for number, layer in enumerate(layers):
            channels = ",".join(f"{c}={layer}.{c}" for c in "RGB")
            arguments += ["a.exr", "--ch", channels] + (["--add"] if number else [])
        run(OIIOTOOL, *arguments, "-o", "sum.exr")
        read = lambda name: oiio.ImageBuf(str(folder / name))
        image = read("a.exr")
        whole = image.get_pixels(oiio.FLOAT)
        names = image.spec().channelnames
        plane = lambda name: whole[..., names.index(name)].astype(np.float64)
        rgb = np.stack([plane(c) for c in "RGB"], -1)
        off = np.abs(read("sum.exr").get_pixels(oiio.FLOAT)[..., :3] - rgb).max()
        # oiiotool adds up in f32: half a unit for each addend, and for each sum.
        bound = 6 * 2.0**-24 * rgb.max()
        say("oiiotool adds the lights up to R, G, B", off <= bound, f"off by {off:.2e}")
        lobes = sum(np.stack([plane(f"{layer}.{c}") for c in "RGB"], -1) for layer in ("diffuse", "specular", "background"))
        off = np.abs(lobes - rgb).max()
        say("diffuse + specular + background are R, G, B", off <= bound, f"off by {off:.2e}")
        residual = float(image.spec().getattribute("candela:residual"))
        lights = sum(np.stack([plane(f"{layer}.{c}") for c in "RGB"], -1) for layer in layers)
        found = max(np.abs(lobes - rgb).max(), np.abs(lights - rgb).max())
        say("candela:residual is the largest of both", abs(residual - found) <= 1e-7 * found + 1e-30, f"{residual:.3e}")

        with OpenEXR.File(str(folder / "a.exr")) as file:
            channels = file.channels()
            shapes = {name: channel.pixels.shape for name, channel in channels.items()}
            for layer, shape in {
                "RGBA": (64, 96, 4),
                "light_key": (64, 96, 3),
                "light_window": (64, 96, 3),
                "irradiance": (64, 96),
                "Z": (64, 96),
                "CryptoObject00": (64, 96, 4),
            }.items():
                say(f"the OpenEXR package groups {layer}", shapes.get(layer) == shape, str(shapes.get(layer)))
            kinds = {channels[name].pixels.dtype for name in ("RGBA", "Z", "irradiance", "CryptoObject00")}
            say("they are FLOAT", kinds == {np.dtype("float32")})
            say("its samples are a number", file.header()["candela:samples"] == 16)

        alpha = plane("A")
        for layer, mattes in cryptomattes(image).items():
            off = np.abs(sum(mattes.values()) - alpha).max()
            say(f"the mattes of {layer} add up to A", off == 0, f"of {', '.join(mattes)}")
        objects = cryptomattes(image)["CryptoObject"]
        materials = cryptomattes(image)["CryptoMaterial"]
        same = np.array_equal(materials["Material.001"], objects["球.left"])
        say("a material of one object is its matte", same)

        run(candela, "render", "scene.toml", "-o", "half.exr", "--layers", LAYERS, "--half", "-q")
        with OpenEXR.File(str(folder / "half.exr")) as file:
            channels = file.channels()
            floats = ["Z", "irradiance", "CryptoObject00", "CryptoMaterial00", "P"]
            kinds = {name: channels[name].pixels.dtype for name in floats if name in channels}
            say("with --half they stay FLOAT", set(kinds.values()) == {np.dtype("float32")}, ", ".join(kinds))
            say("and light is HALF", channels["light_key"].pixels.dtype == np.dtype("float16"))

        run(candela, "relight", "a.exr", "-o", "relit.exr", "--light", "key=off", "--light", "window=2")
        relit = read("relit.exr").get_pixels(oiio.FLOAT)[..., :3]
        expected = lights - np.stack([plane(f"light_key.{c}") for c in "RGB"], -1)
        expected += np.stack([plane(f"light_window.{c}") for c in "RGB"], -1)
        off = np.abs(relit - expected).max()
        say("a relit picture is the sum of its layers", off <= bound, f"off by {off:.2e}")


if __name__ == "__main__":
    main()
