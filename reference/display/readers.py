#!/usr/bin/env python3
"""Shows candela's PNGs and TIFFs in other programs, and compares the code values that these read:

    tests/setup.sh
    target/opencolorio/bin/pip install pillow
    target/opencolorio/bin/python reference/display/readers.py target/release/candela [chromium]

Each PNG is of grays and saturated colors. OpenImageIO and Pillow have to read the very codes that the PNG holds, by a
decoder of a few lines here, and the same ones in a TIFF, whose tags they have to understand. Chromium, where it is named, shows each PNG on a page of its own, headless, and its screenshot, in
sRGB, has to have the codes of the same colors made for sRGB: to the code where the PNG is for sRGB, within a few codes where
it converts. A picture in PQ says by cLLI that nothing in it is brighter than diffuse white, so that it is shown as the one for
sRGB. HDR that does not say so is darkened for such a screen, by a curve of Chromium's own: the picture in HLG has to look like that in PQ
without its cLLI, and grays have to be gray. The exit code is 1 where one differs by more.
"""

import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from PIL import Image

SIZE = 16


def colors():
    """Linear Rec.709 up to 1: grays, and what no screen here clips."""
    ramp = np.linspace(0, 1, SIZE * SIZE // 2)
    grays = np.repeat(ramp[:, None], 3, axis=1)
    random = np.random.default_rng(1)
    return np.concatenate([grays, random.random((SIZE * SIZE // 2, 3))]).astype(np.float32).reshape(SIZE, SIZE, 3)


def written(pixels, path):
    spec = oiio.ImageSpec(SIZE, SIZE, pixels.shape[2], oiio.FLOAT)
    image = oiio.ImageBuf(spec)
    image.set_pixels(spec.roi, pixels)
    if not image.write(str(path)):
        sys.exit(image.geterror())


def tonemapped(program, source, name, *options):
    picture = source.with_name(name)
    command = [program, "tonemap", source, "-o", picture, "--dither", "none", *options]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return picture


def decoded(path):
    """The codes of a PNG without interlace, and its chunks."""
    data = path.read_bytes()[8:]
    chunks = []
    while data:
        (length,) = struct.unpack(">I", data[:4])
        chunks.append((data[4:8].decode(), data[8 : 8 + length]))
        data = data[12 + length :]
    header = dict(chunks)["IHDR"]
    width, height, depth, kind = struct.unpack(">IIBB", header[:10])
    channels, size = {2: 3, 6: 4}[kind], depth // 8
    raw = zlib.decompress(b"".join(body for name, body in chunks if name == "IDAT"))
    step = channels * size
    rows = np.zeros((height, width * step), np.uint8)
    for y in range(height):
        line = raw[y * (width * step + 1) :][: width * step + 1]
        above = rows[y - 1] if y else np.zeros(width * step, np.uint8)
        for x in range(width * step):
            left = int(rows[y, x - step]) if x >= step else 0
            corner = int(above[x - step]) if x >= step else 0
            up = int(above[x])
            guess = left + up - corner
            paeth = min((abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner))[2]
            rows[y, x] = (line[1 + x] + [0, left, up, (left + up) // 2, paeth][line[0]]) & 255
    codes = rows.reshape(height, width, channels, size).astype(np.uint32)
    return (codes[..., 0] if size == 1 else codes[..., 0] << 8 | codes[..., 1]), chunks


def of_tiff(path, kind):
    """The samples of a TIFF as OpenImageIO reads them, not multiplied by alpha, and what it says of them."""
    as_stored = oiio.ImageSpec()
    as_stored["oiio:UnassociatedAlpha"] = 1
    file = oiio.ImageInput.open(str(path), as_stored)
    if file is None:
        sys.exit(oiio.geterror())
    return file.read_image(kind), file.spec()


def judge_tiff(judge, name, tiff, codes, depth):
    """A TIFF beside the codes of the PNG that was made of the same picture in the same way; floats are what 16 bits are
    rounded from."""
    kind = {8: oiio.UINT8, 16: oiio.UINT16, 32: oiio.FLOAT}[depth]
    pixels, spec = of_tiff(tiff, kind)
    pixels = np.clip(pixels, 0, 1) * 65535 if depth == 32 else pixels
    difference = np.abs(pixels.astype(float) - codes).max()
    judge(f"{name}, OpenImageIO", round(float(difference), 3), 0.502 if depth == 32 else 0)
    has_alpha = codes.shape[2] == 4
    judge(f"{name}, not told to have alpha", int((spec.alpha_channel == 3) != has_alpha), 0)
    judge(f"{name}, not told to be unassociated", int(bool(spec.get("oiio:UnassociatedAlpha")) != has_alpha), 0)
    judge(f"{name}, no origin", int("candela:command: candela tonemap" not in spec.get("ImageDescription", "")), 0)
    judge(f"{name}, no program", int(not spec.get("Software", "").startswith("candela ")), 0)
    if depth == 32:
        # Pillow has no colors of floats.
        return
    image = Image.open(tiff)
    judge(f"{name}, primaries in Pillow", int(len(image.tag_v2[319]) != 6 or len(image.tag_v2[318]) != 2), 0)
    if depth == 8:
        difference = np.abs(np.array(image).astype(int) - codes.astype(int)).max()
        judge(f"{name} {image.mode}, Pillow", int(difference), 0)


def without(picture, name):
    """A PNG without one of its chunks."""
    data = picture.read_bytes()
    start = data.index(name) - 4
    (length,) = struct.unpack(">I", data[start : start + 4])
    rest = picture.with_stem(picture.stem + "-rest")
    rest.write_bytes(data[:start] + data[start + length + 12 :])
    return rest


def of_chromium(chromium, picture, folder):
    """The codes of a screenshot of the PNG, one pixel for one."""
    page = folder / "page.html"
    page.write_text(
        f'<body style="margin:0;background:#000"><img src="{picture.name}" '
        'style="display:block;image-rendering:pixelated">'
    )
    shot = folder / "shot.png"
    subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--force-device-scale-factor=1",
         "--force-color-profile=srgb", f"--window-size={max(SIZE, 500)},{max(SIZE, 200)}", f"--screenshot={shot}", page.as_uri()],
        capture_output=True,
        check=True,
    )
    return np.array(Image.open(shot).convert("RGB"))[:SIZE, :SIZE].astype(int)


def luminance_of_pq(codes):
    """In cd/m², of codes from 0 to 1 (SMPTE ST 2084)."""
    power = codes ** (32 / 2523)
    return 1e4 * (np.maximum(power - 3424 / 4096, 0) / (2413 / 128 - 2392 / 128 * power)) ** (16384 / 2610)


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: readers.py path/to/candela [chromium]")
    program, chromium = sys.argv[1], sys.argv[2] if len(sys.argv) == 3 else None
    is_right = True

    def judge(what, difference, limit):
        nonlocal is_right
        is_right &= difference <= limit
        print(f"{what}: {difference} of {limit} codes{'' if difference <= limit else ': FAILED'}")

    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        source = folder / "colors.exr"
        written(colors(), source)
        covered = folder / "covered.exr"
        alpha = np.linspace(0.1, 1, SIZE * SIZE, dtype=np.float32).reshape(SIZE, SIZE, 1)
        written(np.concatenate([colors() * alpha, alpha], axis=2), covered)
        for bits in ["8", "16"]:
            codes, _ = decoded(tonemapped(program, covered, f"covered-{bits}.png", "--bits", bits))
            tiff = tonemapped(program, covered, f"covered-{bits}.tif", "--bits", bits)
            judge_tiff(judge, f"TIFF with alpha, {bits} bits", tiff, codes, int(bits))
        shown = tonemapped(program, source, "shown.png")
        expected, _ = decoded(shown)
        expected = expected.astype(int)
        darkened = None
        for display in ["srgb", "p3", "rec2020-pq", "rec2020-hlg", "rec1886", "linear"]:
            for bits in ["8", "16"]:
                picture = tonemapped(program, source, f"{display}-{bits}.png", "--display", display, "--bits", bits)
                codes, chunks = decoded(picture)
                name = f"{display}, {bits} bits"
                kind = oiio.UINT8 if bits == "8" else oiio.UINT16
                pixels = oiio.ImageBuf(str(picture)).get_pixels(kind).astype(int)
                judge(f"{name}, OpenImageIO", np.abs(pixels[..., :3] - codes[..., :3]).max(), 0)
                if bits == "8":
                    pixels = np.array(Image.open(picture).convert("RGB")).astype(int)
                    judge(f"{name}, Pillow", np.abs(pixels - codes[..., :3]).max(), 0)
                tiff = tonemapped(program, source, f"{display}-{bits}.tif", "--display", display, "--bits", bits)
                judge_tiff(judge, f"{display}, TIFF of {bits} bits", tiff, codes, int(bits))
                if bits == "16":
                    tiff = tonemapped(program, source, f"{display}-32.tif", "--display", display, "--bits", "32")
                    judge_tiff(judge, f"{display}, TIFF of floats", tiff, codes, 32)
                if display == "rec2020-pq":
                    told = np.array(struct.unpack(">II", dict(chunks)["cLLI"])) / 1e4
                    light = luminance_of_pq(codes.max(axis=2) / (2 ** int(bits) - 1))
                    expected_light = np.array([light.max(), light.mean()])
                    judge(f"{name}, cLLI {told} cd/m²", round(float(np.abs(told - expected_light).max()), 5), 1e-4)
                if chromium:
                    found = of_chromium(chromium, picture, folder)
                    points = list(dict(chunks).get("cICP", b""))
                    name = f"{name}, Chromium by cICP {points}"
                    if display == "rec2020-pq":
                        # In 8 bits the darkest codes are coarse.
                        judge(name, np.abs(found - expected[..., :3]).max(), 18 if bits == "8" else 2)
                        darkened = of_chromium(chromium, without(picture, b"cLLI"), folder)
                        continue
                    if display == "rec2020-hlg":
                        judge(f"{name}, beside PQ without cLLI", np.abs(found - darkened).max(), 4)
                        grays = found[: SIZE // 2]
                        judge(f"{name}, grays", (grays.max(axis=2) - grays.min(axis=2)).max(), 1)
                        continue
                    # Light in 8 bits has few codes for shadows, and Chromium decodes it with little precision.
                    limit = 10 if display == "linear" else 0 if (display, bits) == ("srgb", "8") else 2
                    judge(name, np.abs(found - expected[..., :3]).max(), limit)
    sys.exit(0 if is_right else 1)


if __name__ == "__main__":
    main()
