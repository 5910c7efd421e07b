#!/usr/bin/env python3
"""Writes the luminaires of scenes/luminaires/, IES files (LM-63-2002) of luminaires that nobody builds. Needs Python 3
alone; the same files to the byte each time:

    python3 reference/luminaires.py

Each has its intensities by a formula, type C, absolute photometry, scaled so that the zonal lumens (LM-41: the mean of a
zone's borders times its solid angle) are a round number.
"""

from math import acos, cos, degrees, exp, pi, radians, sin
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent / "scenes" / "luminaires"

# Intensities have one decimal, angles none that they do not need.
DIGITS = 1
# LM-63 has lines of at most 256 characters; these are easier to read.
IN_A_LINE = 10


def steps(end, step):
    return [i * step for i in range(round(end / step) + 1)]


def smoothstep(start, end, x):
    """1 up to `start`, 0 from `end` on, smooth in between."""
    t = min(max((x - start) / (end - start), 0.0), 1.0)
    return 1 - t * t * (3 - 2 * t)


def bell(x, width):
    return exp(-((x / width) ** 2))


def way(vertical, horizontal):
    """The direction of two angles of type C: towards horizontal angle 0, towards 90, and down."""
    v, h = radians(vertical), radians(horizontal)
    return sin(v) * cos(h), sin(v) * sin(h), cos(v)


def between(a, b):
    """The angle between two directions."""
    return degrees(acos(min(max(sum(x * y for x, y in zip(a, b)), -1.0), 1.0)))


def downlight(vertical, _):
    """cos⁶, and nothing beyond the edge of a deep reflector."""
    return cos(radians(vertical)) ** 6 * smoothstep(22, 46, vertical)


def wall_washer(vertical, horizontal):
    """A beam 55° from nadir towards the wall: a soft core within an edge, and some light around and down."""
    u = way(vertical, horizontal)
    off = between(u, way(55, 0))
    beam = 0.5 * bell(off, 15) + 0.42 * smoothstep(14, 36, off) + 0.08 * bell(off, 44)
    spill = 0.025 * u[2] ** 2
    return (beam + spill) * smoothstep(78, 90, vertical)


def batwing(vertical, horizontal):
    """Two wings to the sides of a linear luminaire, across its length (H = 90°); along it (H = 0) plain cosine."""
    across = sin(radians(horizontal)) ** 2
    wings = 0.45 + 1.1 * bell(vertical - 38, 16)
    along = cos(radians(vertical))
    at_nadir = 0.45 + 1.1 * bell(38, 16)
    return (across * wings + (1 - across) * at_nadir * along) * smoothstep(55, 90, vertical)


LUMINAIRES = [
    # name, catalog, what it is, formula, horizontal angles, lumens, watts, opening in m
    (
        "downlight",
        "CANDELA-D900",
        "Recessed downlight, narrow, soft cut-off at 46 degrees",
        downlight,
        [0],
        900,
        9,
        (-0.1, -0.1, 0),
    ),
    (
        "wall-washer",
        "CANDELA-W1200",
        "Wall washer, asymmetric, its maximum 55 degrees from nadir towards H = 0",
        wall_washer,
        steps(180, 5),
        1200,
        12,
        (-0.1, -0.1, 0),
    ),
    (
        "batwing",
        "CANDELA-B3000",
        "Linear office luminaire, batwing across its length",
        batwing,
        steps(90, 7.5),
        3000,
        27,
        (0.06, 1.2, 0),
    ),
]

VERTICAL = steps(90, 2.5)


def mean_over_turn(horizontal, values):
    """The mean over all horizontal angles of what is linear between those of the file."""
    if len(horizontal) == 1:
        return values[0]
    pairs = zip(zip(horizontal, values), zip(horizontal[1:], values[1:]))
    whole = sum((b - a) * (x + y) / 2 for (a, x), (b, y) in pairs)
    return whole / (horizontal[-1] - horizontal[0])


def zonal_lumens(horizontal, planes):
    means = [mean_over_turn(horizontal, row) for row in zip(*planes)]
    zones = zip(zip(VERTICAL, means), zip(VERTICAL[1:], means[1:]))
    return sum(
        2 * pi * (cos(radians(a)) - cos(radians(b))) * (x + y) / 2 for (a, x), (b, y) in zones
    )


def number(x, digits=DIGITS):
    return f"{round(x, digits) + 0.0:.{digits}f}".rstrip("0").rstrip(".")


def lines(numbers):
    for start in range(0, len(numbers), IN_A_LINE):
        yield " ".join(number(x) for x in numbers[start : start + IN_A_LINE])


def write(name, catalog, about, formula, horizontal, lumens, watts, opening):
    shape = [[max(formula(v, h), 0.0) for v in VERTICAL] for h in horizontal]
    factor = lumens / zonal_lumens(horizontal, shape)

    def rounded(parts_per_million):
        scale = factor * (1 + parts_per_million / 1e6)
        return [[round(scale * x, DIGITS) for x in plane] for plane in shape]

    # Of nearly the same factors the one whose rounded intensities have the sum that is meant.
    candidates = [rounded(parts) for parts in range(-400, 401)]
    planes = min(candidates, key=lambda planes: abs(zonal_lumens(horizontal, planes) - lumens))
    total = zonal_lumens(horizontal, planes)
    assert abs(total - lumens) < 5e-3, (name, total)
    width, length, height = (number(x, 2) for x in opening)
    text = [
        "IESNA:LM-63-2002",
        "[TEST] computed by reference/luminaires.py, measured by nobody",
        "[TESTLAB] none",
        "[ISSUEDATE] 28-NOV-2026",
        "[MANUFAC] candela",
        f"[LUMCAT] {catalog}",
        f"[LUMINAIRE] {about}",
        "[LAMP] LED, white",
        f"[OTHER] zonal lumens {lumens}",
        "TILT=NONE",
        # Lamps, lumens (-1: absolute), multiplier, angles, type C, meters, opening.
        f"1 -1 1 {len(VERTICAL)} {len(horizontal)} 1 2 {width} {length} {height}",
        # Ballast factor, a factor for future use, input watts.
        f"1 1 {watts}",
        *lines(VERTICAL),
        *lines(horizontal),
        *(line for plane in planes for line in lines(plane)),
    ]
    assert all(len(line) <= 256 and line.isascii() for line in text)
    path = FOLDER / f"{name}.ies"
    path.write_text("\r\n".join(text) + "\r\n", newline="")
    peak, v, h = max(
        (x, v, h) for h, plane in zip(horizontal, planes) for v, x in zip(VERTICAL, plane)
    )
    print(f"{path.name}: {total:.2f} lm, at most {peak} cd at V {v}, H {h}")


FOLDER.mkdir(exist_ok=True)
for luminaire in LUMINAIRES:
    write(*luminaire)
