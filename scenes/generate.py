#!/usr/bin/env python3
"""Writes what is too long to write by hand: the meshes of scenes/meshes/, many-spheres.toml,
many-lights.toml, colorchecker*.toml, blackbody.toml and sodium.toml. Needs Python 3 alone; the same
files to the byte each time:

    python3 scenes/generate.py

The curves of scenes/curves/ are made by reference/colorimetry.py.
"""

import colorsys
import csv
from math import cos, dist, pi, sin, sqrt, tau
from pathlib import Path

GOLDEN_ANGLE = pi * (3 - sqrt(5))

SCENES = Path(__file__).resolve().parent
MESHES = SCENES / "meshes"
REFERENCE = SCENES.parent / "reference"


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def scale(s, a):
    return tuple(s * x for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def unit(a):
    return scale(1 / sqrt(dot(a, a)), a)


def number(x, digits=4):
    """A float with few digits, without trailing zeros and without -0."""
    return f"{round(x, digits) + 0.0:.{digits}f}".rstrip("0").rstrip(".")


def numbers(values, digits=4):
    return ", ".join(number(value, digits) for value in values)


def knot(t, p=2, q=3, ring=0.62, swing=0.27):
    """The (p, q) torus knot at t in [0, 2π), about the y axis."""
    r = ring + swing * cos(q * t)
    return (r * cos(p * t), swing * sin(q * t), r * sin(p * t))


def torus_knot(along=190, around=15, tube=0.13):
    """A tube around the knot as PLY text: vertices with normals, and triangles."""
    vertices, triangles = [], []
    for i in range(along):
        t = 2 * pi * i / along
        center = knot(t)
        tangent = unit(sub(knot(t + 1e-4), knot(t - 1e-4)))
        # A frame from the torus itself returns to where it began, so that the tube closes.
        axis = (0.62 * cos(2 * t), 0.0, 0.62 * sin(2 * t))
        side = unit(sub(center, axis))
        side = unit(sub(side, scale(dot(side, tangent), tangent)))
        other = cross(tangent, side)
        for j in range(around):
            angle = 2 * pi * j / around
            normal = add(scale(cos(angle), side), scale(sin(angle), other))
            vertices.append((add(center, scale(tube, normal)), normal))
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = (a + around) % (along * around), (b + around) % (along * around)
            triangles += [(a, b, c), (b, d, c)]
    lines = [
        "ply",
        "format ascii 1.0",
        "comment a (2, 3) torus knot, by scenes/generate.py",
        f"element vertex {len(vertices)}",
        *(f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")),
        f"element face {len(triangles)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    for position, normal in vertices:
        values = [number(x) for x in position] + [number(x, 3) for x in normal]
        lines.append(" ".join(values))
    lines += ["3 " + " ".join(map(str, triangle)) for triangle in triangles]
    return "\n".join(lines) + "\n"


def gem(sides=8):
    """A cut stone as OBJ text: table, crown, girdle and pavilion are groups, no normals."""
    rings = [(0.30, 0.62, 0.5), (0.47, 0.49, 0.0), (0.55, 0.36, 0.5), (0.55, 0.32, 0.5)]
    lines = ["# A brilliant, by scenes/generate.py", "o gem"]
    for radius, height, turn in rings:
        for i in range(sides):
            angle = 2 * pi * (i + turn) / sides
            at = (radius * cos(angle), height - 0.32, radius * sin(angle))
            lines.append("v " + " ".join(number(x) for x in at))
    lines.append(f"v 0 {number(-0.36)} 0")

    def at(ring, i):
        return 1 + ring * sides + i % sides

    def face(*corners):
        lines.append("f " + " ".join(map(str, corners)))

    lines.append("g table")
    face(*(at(0, i) for i in reversed(range(sides))))
    lines.append("g crown")
    for i in range(sides):
        face(at(0, i), at(0, i + 1), at(1, i + 1))
        face(at(0, i), at(1, i + 1), at(2, i))
        face(at(0, i + 1), at(2, i + 1), at(1, i + 1))
        face(at(1, i + 1), at(2, i + 1), at(2, i))
    lines.append("g girdle")
    for i in range(sides):
        face(at(2, i), at(2, i + 1), at(3, i + 1), at(3, i))
    lines.append("g pavilion")
    for i in range(sides):
        face(at(3, i), at(3, i + 1), 4 * sides + 1)
    return "\n".join(lines) + "\n"


def square():
    """A square of side 1 about the origin, across the z axis, as OBJ text."""
    return """\
# A square, by scenes/generate.py
o square
v -0.5 -0.5 0
v 0.5 -0.5 0
v 0.5 0.5 0
v -0.5 0.5 0
f 1 2 3 4
"""


MANY_SPHERES = """\
# Each of COUNT spheres stands at the golden angle from the one before it, as the seeds of a sunflower do: many shapes, one tree.
#
# Written by scenes/generate.py.

[image]
resolution = [960, 540]

[camera.perspective]
eye = [0.0, 7.0, 8.2]
look_at = [0.0, 0.1, 0.52]
vertical_fov = 33.5

# Diffuse colors below 1/π = 0.318, which would be a perfect white.

[materials.soil.phong]
diffuse = [0.05, 0.055, 0.08]

"""

SEEDS = 1200
RINGS = 24  # of one color each


def many_spheres():
    text = MANY_SPHERES.replace("COUNT", str(SEEDS))
    for i in range(RINGS):
        hue = (0.97 + 0.66 * i / RINGS) % 1.0
        color = [0.26 * x for x in colorsys.hsv_to_rgb(hue, 0.78, 1.0)]
        text += (
            f"[materials.ring{i}.phong]\ndiffuse = [{numbers(color, 3)}]\n"
            "specular = 0.5\nshininess = 60\n\n"
        )
    text += "# In candela.\n\n"
    for name, position, intensity in [
        ("key", (-5, 6.5, 3), (125, 115, 100)),
        ("fill", (6, 5, 4), (38, 48, 66)),
        ("front", (1, 7, 9), (60, 60, 60)),
    ]:
        text += (
            f"[lights.{name}.point]\nposition = [{numbers(position)}]\n"
            f"intensity = [{numbers(intensity)}]\n\n"
        )
    text += (
        '[objects.ground.plane]\nmaterial = "soil"\n'
        "point = [0, 0, 0]\nnormal = [0, 1, 0]\n\n"
    )
    for i in range(SEEDS):
        distance = 0.118 * sqrt(i + 0.5)
        angle = i * GOLDEN_ANGLE
        height = 0.4 + 0.30 * cos(2.1 * distance)
        center = (distance * cos(angle), height, distance * sin(angle))
        radius = 0.085 + 0.022 * distance / 4
        text += (
            f'[objects.seed{i}.sphere]\nmaterial = "ring{i * RINGS // SEEDS}"\n'
            f"center = [{numbers(center, 3)}]\nradius = {number(radius, 3)}\n\n"
        )
    return text.rstrip() + "\n"


def vector(*numbers):
    return "[" + ", ".join(f"{number:.4g}" for number in numbers) + "]"


def many_lights(count=100):
    """Lamps on a flat sunflower, their hue the angle, over a matte floor with spheres."""
    text = f"""\
# Many lights are no problem: every pixel is the sum over all {count} (L9), none of them picked at
# random, so that there is no noise.
#
# Written by generate.py: {count} colored lamps of about 1 cd, candles, 0.5 m over the floor on a
# spiral. Metres and candela.

[image]
resolution = [1280, 720]

[camera.perspective]
eye = [0.0, 9.0, 11.0]
look_at = [0.0, 0.1, 0.35]
vertical_fov = 29.0

[materials.floor.phong]
diffuse = 0.14

[materials.pearl.phong]
diffuse = 0.2
specular = 0.3
shininess = 40

[objects.floor.plane]
material = "floor"
point = [0.0, 0.0, 0.0]
normal = [0.0, 1.0, 0.0]
"""
    spheres = [(0.0, 0.0, 1.0)]
    spheres += [
        (2.9 * cos(a), 2.9 * sin(a), 0.45)
        for a in (tau * (k + 0.25) / 6 for k in range(6))
    ]
    lamps = 0
    for i in range(2 * count):
        distance = 0.6 * sqrt(i + 0.5)
        angle = i * GOLDEN_ANGLE
        x, z = distance * cos(angle), distance * sin(angle)
        # A lamp in a sphere would light nothing but its inside.
        outside = all(dist((x, 0.5, z), (u, r, v)) > 1.15 * r for u, v, r in spheres)
        if lamps < count and outside:
            hue = angle / tau % 1
            rgb = [1.2 * channel for channel in colorsys.hsv_to_rgb(hue, 0.8, 1.0)]
            text += f"""
[lights.l{lamps}.point]
position = {vector(x, 0.5, z)}
intensity = {vector(*rgb)}
"""
            lamps += 1
    for k, (x, z, radius) in enumerate(spheres):
        text += f"""
[objects.pearl-{k}.sphere]
material = "pearl"
center = {vector(x, radius, z)}
radius = {radius}
"""
    return text


CHECKER_CLAIMS = {
    "D65": """\
# Colors from measured spectra: the 24 patches of a ColorChecker under D65, daylight at noon, have the
# colors that colorimetry gives them (reference/colorchecker.csv).
""",
    "A": """\
# The light decides what a color is: the chart of colorchecker.toml under illuminant A, tungsten. The
# picture is not adapted to the light, so that white is orange.
""",
    "F11": """\
# The light decides what a color is: the chart of colorchecker.toml under illuminant F11, a
# fluorescent lamp of three narrow bands, where RGB colors would be wrong by ΔE00 3.5 on the average.
""",
    "LED-B3": """\
# The light decides what a color is: the chart of colorchecker.toml under illuminant LED-B3, a blue
# diode with a phosphor, where RGB colors would be wrong by ΔE00 3.2 on the average.
""",
    "HP1": """\
# The light decides what a color is: the chart of colorchecker.toml under illuminant HP1, high-pressure
# sodium, where RGB colors would be wrong by ΔE00 18 on the average.
""",
}

# cd/m² of a perfect white: as much as leaves its strongest channel on the screen.
CHECKER_WHITES = {"D65": 1.0, "A": 0.5, "F11": 0.7, "LED-B3": 0.7, "HP1": 0.35}

CHECKER = """\
#
# Written by scenes/generate.py. Metres and candela. The strip below is a perfect white of WHITE cd/m².

[image]
resolution = [960, 810]

# 0.32 m by 0.27 m, three pixels to the millimetre.
[camera.orthographic]
eye = [0.0, 0.0, 1.0]
look_at = [0.0, 0.0, 0.0]
height = 0.27

# So far away that it shines on all patches alike: LUX lx, π times the white's luminance.
[lights.lamp.point]
position = [0.0, 0.0, 100.0]
intensity = { candela = CANDELA, color = { illuminant = "LAMP" } }

[materials]
board.normalized_phong = { diffuse = 0.04 }
white.normalized_phong = { diffuse = 1.0 }
"""


def checker_patches():
    """The names of the chart's patches, row by row."""
    with open(REFERENCE / "colorchecker.csv", encoding="utf-8") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        names = [row["patch"] for row in rows if row["light"] == "D65"]
    return [name for name in names if name != "white" and not name.startswith("metamer")]


def checker(lamp):
    """The chart: six by four patches of 40 mm, 50 mm apart, over a strip of white."""
    white = CHECKER_WHITES[lamp]
    text = CHECKER_CLAIMS[lamp] + CHECKER.replace("WHITE", number(white)).replace(
        "CANDELA", number(pi * white * 100**2)
    ).replace("LUX", number(pi * white, 3)).replace("LAMP", lamp)
    patches = checker_patches()
    for name in patches:
        curve = f'{{ file = "curves/colorchecker/{name}.csv" }}'
        text += f"{name}.normalized_phong = {{ diffuse = {curve} }}\n"
    text += """
[objects]
board.plane = { material = "board", point = [0, 0, 0], normal = [0, 0, 1] }
"""

    def rectangle(name, x, y, width):
        return (
            f'{name}.mesh = {{ material = "{name}", file = "meshes/square.obj", '
            f"scale = [{width}, 0.04, 1], translate = [{numbers((x, y, 0.001))}] }}\n"
        )

    for i, name in enumerate(patches):
        text += rectangle(name, -0.125 + 0.05 * (i % 6), 0.1 - 0.05 * (i // 6), 0.04)
    return text + rectangle("white", 0, -0.1, 0.29)


BLACKBODY = """\
# Heat alone gives a light its color (Planck's law): blackbodies of KELVINS K from left to right,
# all with the same luminous intensity, so that only the color differs.
#
# Written by scenes/generate.py. Metres and candela. Each cell has two lamps of its temperature, one above
# and one in front.

[image]
resolution = [1260, 480]

# One cell is 1 m wide and 180 pixels.
[camera.orthographic]
eye = [0.0, 2.1, 6.0]
look_at = [0.0, 0.82, -0.3]
height = 2.6666667

[materials.plaster.normalized_phong]
diffuse = 0.6

[materials.glaze.normalized_phong]
diffuse = 0.5
specular = 0.03
shininess = 60

[objects.floor.plane]
material = "plaster"
point = [0.0, 0.0, 0.0]
normal = [0.0, 1.0, 0.0]

[objects.wall.plane]
material = "plaster"
point = [0.0, 0.0, -0.7]
normal = [0.0, 0.0, 1.0]

# Planes without end between the cells keep each lamp's light to itself. The camera sees them edge-on,
# so not at all.
"""

TEMPERATURES = [2000, 2500, 3200, 4000, 5000, 6500, 10000]


def blackbody():
    kelvins = ", ".join(map(str, TEMPERATURES[:-1])) + f" and {TEMPERATURES[-1]}"
    text = BLACKBODY.replace("KELVINS", kelvins)
    first = -(len(TEMPERATURES) - 1) / 2
    for i, (left, right) in enumerate(zip(TEMPERATURES, TEMPERATURES[1:])):
        text += f"""
[objects.between-{left}-and-{right}.plane]
material = "plaster"
point = [{first + i + 0.5}, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
"""
    for i, temperature in enumerate(TEMPERATURES):
        x = first + i
        text += f"""
[lights.blackbody-{temperature}.point]
position = [{number(x - 0.38)}, 2.2, 1.9]
intensity = {{ candela = 10, color = {{ blackbody = {temperature} }} }}

[lights.blackbody-{temperature}-in-front.point]
position = [{number(x + 0.42)}, 1.0, 4.4]
intensity = {{ candela = 10, color = {{ blackbody = {temperature} }} }}

[objects.ball-{temperature}.sphere]
material = "glaze"
center = [{x}, 0.36, 0.0]
radius = 0.36
"""
    return text


SODIUM = """\
# Where there is one wavelength there is one color: under low-pressure sodium, at the right, whose two
# lines are 0.6 nm apart, things are lighter or darker and no more. At the left, the same under D65.
#
# Written by scenes/generate.py. Metres and candela. A divider in the middle keeps each lamp's light
# to its own half, and one half is the other's mirror image. Reflectances are measured ones, of the
# ColorChecker. The yellow of sodium is beyond Rec.709, so that its blue is below 0.

[image]
resolution = [1280, 720]

# A micrometre beside the plane of the divider, so that it is seen edge-on and no ray runs within it.
[camera.perspective]
eye = [0.0, 1.55, 7.4]
look_at = [0.0, 0.6, 0.0]
vertical_fov = 20.5

[materials.room.normalized_phong]
diffuse = 0.55

[objects.floor.plane]
material = "room"
point = [0.0, 0.0, 0.0]
normal = [0.0, 1.0, 0.0]

[objects.wall.plane]
material = "room"
point = [0.0, 0.0, -1.0]
normal = [0.0, 0.0, 1.0]

# From the wall to in front of the lamps, and higher than they are.
[objects.divider.mesh]
material = "room"
file = "meshes/square.obj"
scale = [8.0, 6.0, 1.0]
rotate = [0.0, 90.0, 0.0]
translate = [1e-6, 3.0, 3.0]
"""

# Half, side, color, candela of its lamps. The sodium D lines: nm, and how strong one is beside the other.
SODIUM_HALVES = [
    ("daylight", -1, 'illuminant = "D65"', (48, 20, 22)),
    ("sodium", 1, "lines = [[589.0, 0.5], [589.6, 0.5]]", (25, 11, 12)),
]

# Of the right half.
SODIUM_LAMPS = [
    ("key", (2.5, 3.3, 3.6)),
    ("fill", (0.3, 2.3, 4.4)),
    ("front", (1.4, 1.3, 6.9)),
]

# Patch, center in the right half, radius.
SODIUM_BALLS = [
    ("red", (1.78, 0.27, 0.62), 0.27),
    ("yellow", (1.16, 0.2, 1.0), 0.2),
    ("purplish-blue", (0.56, 0.25, 0.66), 0.25),
    ("green", (2.08, 0.38, -0.25), 0.38),
]


def sodium():
    """The same things in two halves, under two kinds of lamp."""
    text = SODIUM
    for patch in [*(patch for patch, _, _ in SODIUM_BALLS), "bluish-green", "magenta"]:
        text += f"""
[materials.{patch}.normalized_phong]
diffuse = {{ file = "curves/colorchecker/{patch}.csv" }}
specular = 0.03
shininess = 60
"""
    for half, side, color, intensities in SODIUM_HALVES:

        def place(center):
            x, y, z = center
            return numbers((side * x, y, z))

        for (lamp, position), intensity in zip(SODIUM_LAMPS, intensities):
            text += f"""
[lights.{half}-{lamp}.point]
position = [{place(position)}]
intensity = {{ candela = {intensity}, color = {{ {color} }} }}
"""
        for patch, center, radius in SODIUM_BALLS:
            text += f"""
[objects.{half}-{patch}.sphere]
material = "{patch}"
center = [{place(center)}]
radius = {radius}
"""
        text += f"""
[objects.{half}-knot.mesh]
material = "bluish-green"
file = "meshes/knot.ply"
scale = [{-side * 0.6}, 0.6, 0.6]
rotate = [66.0, 0.0, 0.0]
translate = [{place((1.14, 0.66, -0.2))}]

[objects.{half}-gem.mesh]
material = "magenta"
file = "meshes/gem.obj"
scale = [{-side * 0.8}, 0.8, 0.8]
rotate = [0.0, {-side * 14.0}, {side * 57.0}]
translate = [{place((0.34, 0.33, -0.25))}]
"""
    return text


def ply(vertices, faces):
    """A mesh as text."""
    lines = [
        "ply",
        "format ascii 1.0",
        f"element vertex {len(vertices)}",
        "property float x",
        "property float y",
        "property float z",
        f"element face {len(faces)}",
        "property list uchar uint vertex_indices",
        "end_header",
        *(" ".join(number(x) for x in vertex) for vertex in vertices),
        *(" ".join(str(i) for i in (len(face), *face)) for face in faces),
    ]
    return "\n".join(lines) + "\n"


def tiles(parity, side=0.5, count=12):
    """Every other square of a floor in y = 0."""
    vertices, faces = [], []
    for row in range(count):
        for column in range(count):
            if (row + column) % 2 != parity:
                continue
            x, z = (side * (place - count / 2) for place in (column, row))
            first = len(vertices)
            vertices += [(x, 0, z), (x, 0, z + side), (x + side, 0, z + side), (x + side, 0, z)]
            faces.append((first, first + 1, first + 2, first + 3))
    return ply(vertices, faces)


def prism(length=2.0):
    """A prism with equal sides of 1 along z, closed, its triangles turned outwards."""
    ends = [(-0.5, 0.0), (0.5, 0.0), (0.0, sqrt(0.75))]
    vertices = [(x, y, z) for z in (-length / 2, length / 2) for x, y in ends]
    faces = [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
    return ply(vertices, faces)


def main():
    MESHES.mkdir(exist_ok=True)
    (MESHES / "knot.ply").write_text(torus_knot())
    (MESHES / "gem.obj").write_text(gem())
    (MESHES / "square.obj").write_text(square())
    (MESHES / "tiles-light.ply").write_text(tiles(0))
    (MESHES / "tiles-dark.ply").write_text(tiles(1))
    (MESHES / "prism.ply").write_text(prism())
    (SCENES / "many-spheres.toml").write_text(many_spheres())
    (SCENES / "many-lights.toml").write_text(many_lights())
    for lamp in CHECKER_CLAIMS:
        suffix = "" if lamp == "D65" else f"-{lamp.lower()}"
        (SCENES / f"colorchecker{suffix}.toml").write_text(checker(lamp))
    (SCENES / "blackbody.toml").write_text(blackbody())
    (SCENES / "sodium.toml").write_text(sodium())


if __name__ == "__main__":
    main()
