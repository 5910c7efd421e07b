#!/usr/bin/env python3
"""Writes three look-up tables of random numbers, and what OpenColorIO makes of colors by them: cube-*.cube, cube-*.csv.

    reference/display/cube.py      (with a Python that has `opencolorio` 2.6 and `numpy`)

Interpolation is linear in one dimension and tetrahedral in three, in 32 bits, without optimizations that would change it.
"""

from pathlib import Path

import numpy as np
import PyOpenColorIO as ocio

HERE = Path(__file__).resolve().parent
random = np.random.default_rng(1)


def entries(count):
    """Codes, some of them beyond 0 to 1."""
    return random.random((count, 3)) * 1.2 - 0.1


def shaper(count):
    """A cube root: what a table of three dimensions takes well."""
    return np.linspace(0.0, 1.0, count)[:, None] ** (1 / 3) * np.ones(3)


TABLES = {
    "cube-3d": (
        'TITLE "three dimensions"\nLUT_3D_SIZE 4\nDOMAIN_MIN -0.25 0 0.125\nDOMAIN_MAX 1.5 2 1\n',
        [entries(4**3)],
    ),
    "cube-1d": ("LUT_1D_SIZE 9\nDOMAIN_MIN -0.5 0 0\nDOMAIN_MAX 2 1 4\n", [entries(9)]),
    "cube-both": (
        "LUT_1D_SIZE 17\nLUT_1D_INPUT_RANGE 0.0 4.0\nLUT_3D_SIZE 3\nLUT_3D_INPUT_RANGE 0.0 1.0\n",
        [shaper(17), entries(3**3)],
    ),
}

for name, (head, tables) in TABLES.items():
    path = HERE / f"{name}.cube"
    lines = [" ".join(f"{value:.6f}" for value in entry) for table in tables for entry in table]
    path.write_text(head + "\n".join(lines) + "\n")
    interpolation = ocio.INTERP_LINEAR if name == "cube-1d" else ocio.INTERP_TETRAHEDRAL
    transform = ocio.FileTransform(str(path), interpolation=interpolation)
    processor = ocio.Config.CreateRaw().getProcessor(transform)
    processor = processor.getOptimizedCPUProcessor(ocio.OPTIMIZATION_NONE)
    colors = (random.random((200, 3)) * 5.0 - 0.75).astype(np.float32)
    colors[:120] = (random.random((120, 3)) * 2.0 - 0.25).astype(np.float32)
    # On borders of cells, and grays.
    colors[:20] = np.round(colors[:20] * 4) / 4
    colors[20:30] = colors[20:30, :1]
    codes = colors.copy()
    processor.applyRGB(codes)
    rows = [",".join(f"{value:.9g}" for value in [*color, *code]) for color, code in zip(colors, codes)]
    head = f"# OpenColorIO {ocio.__version__}, {name}.cube, by {Path(__file__).name}\nr,g,b,code_r,code_g,code_b\n"
    (HERE / f"{name}.csv").write_text(head + "\n".join(rows) + "\n")
