#!/usr/bin/env python3
"""Compares candela's views with OpenColorIO's, color by color:

    tests/setup.sh
    target/opencolorio/bin/python reference/display/ocio.py target/release/candela

`candela tonemap` turns an EXR of FLOAT colors into a PNG of 16 bits, whose code values are compared with those
of OpenColorIO's CPU processor, without optimization, clipped to 0 to 1. One line for each row of the table below says
the largest difference and where it is. The exit code is 1 where one is above its limit.
"""

import math
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import PyOpenColorIO as ocio

STUDIO_ACES_1 = "studio-config-v2.2.0_aces-v1.3_ocio-v2.4"
STUDIO_ACES_2 = "studio-config-v4.0.0_aces-v2.0_ocio-v2.5"

COLORCHECKER = Path(__file__).resolve().parent.parent / "colorchecker.csv"

# XYZ to linear Rec.709 (IEC 61966-2-1, ten decimals).
TO_REC709 = [
    [3.2409699419, -1.5373831776, -0.4986107603],
    [-0.9692436363, 1.8759675015, 0.0415550574],
    [0.0556300797, -0.2039769589, 1.0569715142],
]

SEED = 1
WIDTH = 512


@dataclass
class Row:
    """A view of candela and what it is compared with."""

    # Options of `candela tonemap`.
    options: str
    # A built-in config of OpenColorIO, and a display and a view of that.
    config: str
    display: str
    view: str
    # Of the difference in code value: twice what was measured.
    limit: float
    # Colors of which no channel has a larger magnitude are compared. OpenColorIO computes in f32: beside a
    # channel of 100, one of 0 is 1e-5 or so, which the curve makes 10 times as much.
    largest: float = math.inf
    # Codes below this count as equal: the 1e-7 of its white that OpenColorIO's way over XYZ in f32 leaves in channels
    # that are 0 is up to 2e-3 on a curve that is steep at 0.
    toe: float = 0


# The curve of candela's sRGB is that of the standard, OpenColorIO's has one slope where the pieces meet: 9.8e-6. Half a
# code of 16 bits is 7.6e-6.
ROWS = [
    Row("--view srgb", STUDIO_ACES_1, "sRGB - Display", "Un-tone-mapped", 3.5e-5, largest=4),
    Row("--view raw", STUDIO_ACES_1, "sRGB - Display", "Raw", 1.5e-5),
    Row("--view aces1", STUDIO_ACES_1, "sRGB - Display", "ACES 1.0 - SDR Video", 3.5e-5),
    Row("--view srgb --display p3", STUDIO_ACES_2, "Display P3 - Display", "Un-tone-mapped", 3.5e-5, largest=4),
    Row("--view srgb --display rec1886", STUDIO_ACES_2, "Rec.1886 Rec.709 - Display", "Un-tone-mapped", 1.8e-4, largest=4, toe=0.01),
    Row("--view srgb --display rec2020-pq --white-nits 100", STUDIO_ACES_2, "Rec.2100-PQ - Display", "Un-tone-mapped", 2.4e-5),
    Row("--view srgb --display rec2020-hlg --white-nits 100", STUDIO_ACES_2, "Rec.2100-HLG - Display", "Un-tone-mapped", 2.2e-5),
    Row("--view aces2", STUDIO_ACES_2, "sRGB - Display", "ACES 2.0 - SDR 100 nits (Rec.709)", 6e-5),
    Row("--view aces2 --display p3", STUDIO_ACES_2, "Display P3 - Display", "ACES 2.0 - SDR 100 nits (P3 D65)", 7.5e-5),
    Row("--view aces2 --display rec1886", STUDIO_ACES_2, "Rec.1886 Rec.709 - Display", "ACES 2.0 - SDR 100 nits (Rec.709)", 1.9e-4, toe=0.01),
    Row("--view aces2 --display rec2020-pq", STUDIO_ACES_2, "Rec.2100-PQ - Display", "ACES 2.0 - HDR 1000 nits (P3 D65)", 1.5e-4),
    Row("--view aces2 --display rec2020-hlg", STUDIO_ACES_2, "Rec.2100-HLG - Display", "ACES 2.0 - HDR 1000 nits (P3 D65)", 1.4e-4),
]


def color_checker():
    """The 24 patches under D65 in linear Rec.709, scaled such that white is (1, 1, 1)."""
    lines = [line for line in COLORCHECKER.read_text().splitlines() if line.startswith("D65,")]
    patches = {name: [float(n) for n in xyz] for _, name, *xyz in (line.split(",") for line in lines)}
    rgb = {name: np.array(TO_REC709) @ xyz for name, xyz in patches.items()}
    return [color / rgb["white"] for name, color in rgb.items() if name != "white" and not name.startswith("metamer")]


def colors():
    """Linear Rec.709, three to a row: the same each time."""
    random = np.random.default_rng(SEED)
    many = 40_000

    def exposed(triples, least, most):
        return triples * 2 ** random.uniform(least, most, (len(triples), 1))

    primaries = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (0, 1, 1), (1, 0, 1)]
    stops = np.arange(-10, 10.0005, 0.001)
    return np.concatenate(
        [
            [(0, 0, 0)],
            0.18 * np.repeat(2**stops[:, None], 3, axis=1),
            [np.array(color) * 2.0**ev for color in primaries for ev in np.arange(-10, 10.05, 0.1)],
            color_checker(),
            # Saturated: the cubes of even numbers are mostly small.
            exposed(random.random((many, 3)) ** 3, -8, 6),
            # Reds, dark ones among them, which ACES 1 treats apart.
            exposed(random.random((many, 3)) * [1, 0.5, 0.5], -10, 3),
            # Of any sign.
            exposed(random.normal(size=(many, 3)), -8, 5),
        ]
    ).astype(np.float32)


def written(rgb, path):
    """Writes colors as FLOAT, line by line, and black after the last."""
    height = -(-len(rgb) // WIDTH)
    pixels = np.zeros((height * WIDTH, 3), np.float32)
    pixels[: len(rgb)] = rgb
    spec = oiio.ImageSpec(WIDTH, height, 3, oiio.FLOAT)
    image = oiio.ImageBuf(spec)
    image.set_pixels(spec.roi, pixels.reshape(height, WIDTH, 3))
    if not image.write(str(path)):
        sys.exit(f"{path}: {image.geterror()}")


def of_candela(program, row, source, count):
    """candela's code values, 0 to 1."""
    picture = source.with_suffix(".png")
    command = [program, "tonemap", source, "-o", picture, *row.options.split(), "--bits", "16", "--dither", "none"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"candela tonemap {row.options}: {done.stderr}")
    codes = oiio.ImageBuf(str(picture)).get_pixels(oiio.UINT16)
    return codes.reshape(-1, 3)[:count].astype(np.float64) / 65535


def of_opencolorio(row, rgb):
    """OpenColorIO's code values, 0 to 1."""
    config = ocio.Config.CreateFromBuiltinConfig(row.config)
    view = ocio.DisplayViewTransform(src="Linear Rec.709 (sRGB)", display=row.display, view=row.view)
    processor = config.getProcessor(view).getOptimizedCPUProcessor(ocio.OPTIMIZATION_NONE)
    codes = np.ascontiguousarray(rgb)
    processor.applyRGB(codes)
    return codes.astype(np.float64).clip(0, 1)


def printed(numbers):
    return "(" + " ".join(f"{number:.6g}" for number in numbers) + ")"


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: ocio.py path/to/candela")
    rgb = colors()
    is_right = True
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "colors.exr"
        written(rgb, source)
        for row in ROWS:
            actual = of_candela(sys.argv[1], row, source, len(rgb))
            expected = of_opencolorio(row, rgb.copy())
            is_compared = np.abs(rgb).max(axis=1) <= row.largest
            # What is not a number differs by more than any limit.
            channels = np.nan_to_num(np.abs(actual - expected), nan=math.inf)
            channels[(actual < row.toe) & (expected < row.toe)] = 0
            difference = channels.max(axis=1) * is_compared
            worst = difference.argmax()
            within = difference[worst] <= row.limit
            is_right &= bool(within)
            print(
                f"{row.options}, {row.display}, {row.view}: {difference[worst]:.2e} at {printed(rgb[worst])}, "
                f"candela {printed(actual[worst])}, OpenColorIO {printed(expected[worst])}; "
                f"{is_compared.sum()} colors, limit {row.limit:.1e}{'' if within else ': FAILED'}"
            )
    sys.exit(0 if is_right else 1)


if __name__ == "__main__":
    main()
