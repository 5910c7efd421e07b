#!/usr/bin/env python3
"""Makes aces2.csv by OpenColorIO: what its built-in output transforms of ACES 2.0 make of some colors.

    pip install opencolorio==2.6.0
    reference/display/aces2.py

The same file each time, with this version. Without optimization OpenColorIO computes every color by itself
in f32, of which seven digits are written.
"""

from pathlib import Path

import PyOpenColorIO as ocio

VERSION = "2.6.0"
CONFIG = "studio-config-v4.0.0_aces-v2.0_ocio-v2.5"

# Peak in cd/m², limiting primaries, the name in OpenColorIO.
SCREENS = [
    (100, "Rec.709", "SDR-100nit-REC709_2.0"),
    (100, "P3", "SDR-100nit-P3-D65_2.0"),
    (500, "P3", "HDR-500nit-P3-D65_2.0"),
    (1000, "P3", "HDR-1000nit-P3-D65_2.0"),
    (1000, "Rec.2020", "HDR-1000nit-REC2020_2.0"),
    (4000, "Rec.2020", "HDR-4000nit-REC2020_2.0"),
]

COLORS = [
    # Grays: black, very dark to middle gray, white, and beyond the roof of every screen.
    (0, 0, 0),
    (0.001, 0.001, 0.001),
    (0.18, 0.18, 0.18),
    (1, 1, 1),
    (40, 40, 40),
    (5000, 5000, 5000),
    # The primaries and what is between them, on both sides of the cusp.
    (1, 0, 0),
    (0, 1, 0),
    (0, 0, 1),
    (0, 0.02, 0.02),
    (0.02, 0, 0.02),
    (4, 4, 0),
    (0, 60, 60),
    (60, 0, 60),
    (400, 0, 0),
    # Things: skin, foliage, a blue sky, orange, two flowers, the ColorChecker's cyan.
    (0.45, 0.27, 0.19),
    (0.07, 0.12, 0.03),
    (0.3, 0.5, 1.1),
    (0.8, 0.3, 0.05),
    (0.5, 0.02, 0.3),
    (0.9, 0.7, 0.01),
    (-0.033373, 0.248811, 0.385395),
    # Outside of Rec.709: lasers and LEDs; the last three are outside of AP1 too.
    (3, -0.1, -0.02),
    (-1.2, 4, -0.3),
    (-0.4, -0.05, 2),
    (-1, -1, 5),
    (2, -1, -1),
    (-3, 2, -1),
]


def number(value):
    return f"{value:.7g}" if abs(value) >= 1e-9 else "0"


def main():
    if ocio.__version__ != VERSION:
        raise SystemExit(f"OpenColorIO {VERSION} is needed, this is {ocio.__version__}")
    config = ocio.Config.CreateFromBuiltinConfig(CONFIG)
    lines = [
        "# What OpenColorIO's output transforms of ACES 2.0 make of colors: linear Rec.709 radiance r, g, b to the",
        "# XYZ x, y, z on a screen of a peak in cd/m² and of limiting primaries; y = 1 is 100 cd/m².",
        f"# Made by reference/display/aces2.py with OpenColorIO {VERSION}, BSD-3-Clause,",
        "# Copyright Contributors to the OpenColorIO Project.",
        "peak,primaries,r,g,b,x,y,z",
    ]
    for peak, primaries, name in SCREENS:
        group = ocio.GroupTransform()
        group.appendTransform(ocio.ColorSpaceTransform("Linear Rec.709 (sRGB)", "ACES2065-1"))
        group.appendTransform(
            ocio.BuiltinTransform(f"ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - {name}")
        )
        processor = config.getProcessor(group)
        processor = processor.getOptimizedCPUProcessor(ocio.OPTIMIZATION_NONE)
        for color in COLORS:
            xyz = processor.applyRGB([float(channel) for channel in color])
            numbers = ",".join([*map(number, color), *map(number, xyz)])
            lines.append(f"{peak},{primaries},{numbers}")
    path = Path(__file__).with_name("aces2.csv")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
