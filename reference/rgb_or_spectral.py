"""By how much RGB misses the colors of the ColorChecker under lamps: ΔE00, mean and worst of the 24 patches.

    python3 reference/rgb_or_spectral.py

Needs colour-science 0.4.7 (BSD-3-Clause) for CIEDE2000 and L*a*b*. The tables are candela's own, which are the
CIE's; sums are over 1 nm, the lamps cubic between their 5 nm. White is the daylight of chromaticity 0.3127, 0.3290.
Prints what tests/colorimetry.rs has as `PUBLISHED`.
"""

from pathlib import Path

import colour
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "src" / "spectrum" / "data"
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
WHITE = (0.3127, 0.3290)
SPACES = {
    "rec709": ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), WHITE),
    "p3-d65": ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060), WHITE),
    "rec2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046), WHITE),
    "acescg": ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044), (0.32168, 0.33767)),
}


def table(path):
    """The names of the columns, and the numbers."""
    lines = path.read_text().splitlines()
    names = [line for line in lines if line.startswith("#")][-1].strip("# ").split(",")
    rows = [[float(cell) for cell in line.split(",")] for line in lines if not line.startswith("#")]
    return names, np.array(rows)


_, OBSERVER = table(DATA / "cie_1931_2_degree.csv")
GRID, BARS = OBSERVER[:, 0], OBSERVER[:, 1:4]


def white():
    """S0 + M1 S1 + M2 S2 whose chromaticity is WHITE."""
    _, rows = table(DATA / "daylight.csv")
    parts = [np.interp(GRID, rows[:, 0], rows[:, column]) for column in (1, 2, 3)]

    def remainder(part):
        seen = part @ BARS
        return [seen[i] - WHITE[i] * seen.sum() for i in (0, 1)]

    at_0, of_1, of_2 = (remainder(part) for part in parts)
    m1, m2 = np.linalg.solve(np.array([of_1, of_2]).T, -np.array(at_0))
    return parts[0] + m1 * parts[1] + m2 * parts[2]


def lamp(file, name):
    """Cubic through two points on each side; where that is negative, the larger outer point has less by as much."""
    names, rows = table(DATA / file)
    at, values = rows[:, 0], rows[:, names.index(name)]
    light = np.interp(GRID, at, values)
    for i in range(len(at) - 3):
        p, q, r, s = values[i : i + 4]
        for nm in np.arange(at[i + 1] + 1, at[i + 2]):
            u = (nm - at[i]) / 5
            third = u * (u - 1) * (u - 2) / 6 * (s - 3 * r + 3 * q - p)
            value = p + u * (q - p) + u * (u - 1) / 2 * (r - 2 * q + p) + third
            light[int(nm - GRID[0])] = max(value, 0)
            if value < 0:
                light[int((at[i] if p >= s else at[i + 3]) - GRID[0])] += value
    return light


def tungsten():
    return 100 * (560 / GRID) ** 5 * np.expm1(1.435e7 / (2848 * 560)) / np.expm1(1.435e7 / (2848 * GRID))


def xyz_of(x, y):
    return np.array([x / y, 1, (1 - x - y) / y])


def conversions(space, seen):
    """From XYZ under a white to RGB, and from RGB to the XYZ of the space."""
    red, green, blue, own = SPACES[space]
    columns = np.array([xyz_of(*place) for place in (red, green, blue)]).T
    to_xyz = columns * (np.linalg.inv(columns) @ xyz_of(*own))
    gains = np.diag((BRADFORD @ xyz_of(*own)) / (BRADFORD @ seen))
    return np.linalg.inv(to_xyz) @ np.linalg.inv(BRADFORD) @ gains @ BRADFORD, to_xyz


def main():
    patches = []
    for path in sorted((ROOT / "scenes" / "curves" / "colorchecker").glob("*.csv")):
        _, rows = table(path)
        patches.append(np.interp(GRID, rows[:, 0], rows[:, 1]))
    lights = {
        "A": tungsten(),
        "F2": lamp("fluorescent.csv", "F2"),
        "F11": lamp("fluorescent.csv", "F11"),
        "LED-B3": lamp("led.csv", "LED-B3"),
        "HP1": lamp("discharge.csv", "HP1"),
    }
    daylight = white()
    seen = daylight @ BARS / (daylight @ BARS)[1]
    for name, light in lights.items():
        row = []
        for space in SPACES:
            to_rgb, to_xyz = conversions(space, seen)
            rgb = lambda spectrum: to_rgb @ (spectrum @ BARS)
            of_light = rgb(light)
            adapted = to_xyz @ of_light
            lab = lambda rgb: colour.XYZ_to_Lab(to_xyz @ rgb / adapted[1], colour.XYZ_to_xy(adapted))
            off = [
                colour.delta_E(
                    lab(rgb(light * patch)), lab(of_light * rgb(daylight * patch) / rgb(daylight)), method="CIE 2000"
                )
                for patch in patches
            ]
            row.append(f"[{np.mean(off):.3f}, {max(off):.3f}]")
        print(name, *row)


if __name__ == "__main__":
    main()
