#!/usr/bin/env python3
"""Makes the cases of the conformance suite: for each a scene, and the picture that its formula gives.

    python3 reference/conformance/generate.py

Nothing but Python's standard library is used, and nothing of candela but the CIE's tables in
src/spectrum/data. Each case below has its scene as a text and its formula as a function of a pixel,
written for this scene alone. A case is refused whose pixels lie so closely at an edge that rounding
might decide their side.
"""

import argparse
import json
import textwrap
from math import acos, cos, degrees, expm1, pi, radians, sin, sqrt, tan
from pathlib import Path

import exr
from vectors import *

HERE = Path(__file__).resolve().parent
DATA = HERE.parent.parent / "src" / "spectrum" / "data"

# Relative to a pixel's brightest channel: what single precision leaves of a well-conditioned formula, and
# of one whose cosine is small or changes fast.
WELL = 1e-5
ILL = 1e-4

CASES = []
MESHES = {}


def case(name, formula, tolerance=WELL):
    """Registers a function that returns a scene's text, its resolution, and what a pixel shows.

    What a pixel shows is R, G, B, A at a point of the image in pixels from the top left.
    """

    def register(function):
        CASES.append((name, formula, tolerance, function))
        return function

    return register


# ---------------------------------------------------------------- words of scenes


def numbers(value):
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(numbers, value)) + "]"
    return repr(float(value)) if isinstance(value, float) else repr(value)


def table(head, **keys):
    lines = [f"[{head}]"]
    lines += [f"{key} = {numbers(value)}" for key, value in keys.items()]
    return "\n".join(lines) + "\n"


def image(resolution, **keys):
    return table("image", resolution=list(resolution), **keys)


def phong(name, **keys):
    return table(f"materials.{name}.phong", **keys)


def normalized(name, **keys):
    return table(f"materials.{name}.normalized_phong", **keys)


def light(name, position, intensity):
    return table(f"lights.{name}.point", position=position, intensity=intensity)


def sphere(name, material, center, radius):
    return table(f"objects.{name}.sphere", material=f'"{material}"', center=center, radius=radius)


def plane(name, material, point, normal):
    return table(f"objects.{name}.plane", material=f'"{material}"', point=point, normal=normal)


def triangle(name, material, vertices):
    return table(f"objects.{name}.triangle", material=f'"{material}"', vertices=vertices)


def scene(*parts):
    return "\n".join(parts)


# ---------------------------------------------------------------- cameras


class Camera:
    """L1: rays through an image of this resolution."""

    def __init__(self, kind, resolution, eye, look_at, size, up=(0, 1, 0)):
        self.kind, self.resolution, self.eye, self.size = kind, resolution, list(eye), size
        keys = dict(eye=list(eye), look_at=list(look_at), up=list(up))
        keys["vertical_fov" if kind == "perspective" else "height"] = size
        self.text = table(f"camera.{kind}", **keys)
        self.forward = unit(sub(look_at, eye))
        self.right = unit(cross(self.forward, up))
        self.up = cross(self.right, self.forward)

    def ray(self, px, py):
        width, height = self.resolution
        # From −1 to 1 upwards, and as far to the right as the aspect makes it.
        x = (2 * px - width) / height
        y = (height - 2 * py) / height
        if self.kind == "orthographic":
            half = self.size / 2
            aside = add(mul(self.right, x * half), mul(self.up, y * half))
            return add(self.eye, aside), self.forward
        half = tan(radians(self.size) / 2)
        aside = add(mul(self.right, x * half), mul(self.up, y * half))
        return self.eye, unit(add(self.forward, aside))


SMALL = (24, 16)


def from_above(height=6.0, resolution=SMALL):
    return Camera("orthographic", resolution, (0, 10, 0), (0, 0, 0), height, up=(0, 0, -1))


def on_floor(camera, px, py):
    """x and z of a point of an image from above."""
    (x, _, z), _ = camera.ray(px, py)
    return x, z


# ---------------------------------------------------------------- the equations


def of(value):
    return list(value) if isinstance(value, (list, tuple)) else [value] * 3


def lambert(p, n, p_l, intensity, k_d):
    """I/d² · k_d cos(n, ω_i), L3 and L5."""
    way = sub(p_l, p)
    cosine = dot(n, way) / length(way)
    if cosine <= 0:
        return [0.0] * 3
    return [i * k * cosine / dot(way, way) for i, k in zip(of(intensity), of(k_d))]


def lobe(p, n, view, p_l, intensity, k_s, shininess):
    """I/d² · k_s cosⁿ(ω_o, ω_r), L6 and L7; `view` points to the viewer."""
    way = sub(p_l, p)
    to_light = unit(way)
    above = dot(n, to_light)
    if above <= 0:
        return [0.0] * 3
    reflected = sub(mul(n, 2 * above), to_light)
    cosine = max(dot(view, reflected), 0.0)
    return [i * k * cosine**shininess / dot(way, way) for i, k in zip(of(intensity), of(k_s))]


def normalized_lobe(p, n, view, p_l, intensity, rho_s, shininess):
    """The same times cos(n, ω_i) (n + 2)/(2π)."""
    way = sub(p_l, p)
    cosine = dot(n, way) / length(way)
    factor = cosine * (shininess + 2) / (2 * pi)
    return mul(lobe(p, n, view, p_l, intensity, rho_s, shininess), factor)


def total(*terms):
    return [sum(channel) for channel in zip(*terms)]


def covered(rgb):
    return [*rgb, 1.0]


NOTHING = [0.0] * 4


def facing(n, view):
    """The normal on the viewer's side."""
    return n if dot(n, view) > 0 else mul(n, -1)


# ---------------------------------------------------------------- distance and angle


@case(
    "inverse-square",
    "Square steps at the depths h = 1, 2 and 4 below a light of 30 cd: L = k_d I h / (h² + r²)^(3/2); straight "
    "below it k_d I / h².",
)
def _():
    camera = from_above(8.0)
    k_d, intensity, bulb = 0.5, 30.0, [0.0, 1.0, 0.0]
    steps = [(0.0, 1.5, -3.0), (1.5, 3.0, -1.0), (3.0, 9.0, 0.0)]
    parts = [image(SMALL), camera.text, phong("m", diffuse=k_d), light("l", bulb, intensity)]
    for number, (low, high, y) in enumerate(steps):
        for side in (1.0, -1.0):
            a, b = low * side, high * side
            corners = [[a, y, -20.0], [b, y, -20.0], [b, y, 20.0], [a, y, 20.0]]
            name = f"step{number}{'r' if side > 0 else 'l'}"
            parts.append(triangle(name + "0", "m", [corners[0], corners[1], corners[2]]))
            parts.append(triangle(name + "1", "m", [corners[0], corners[2], corners[3]]))

    def pixel(px, py):
        x, z = on_floor(camera, px, py)
        h = next(1.0 - y for low, high, y in steps if low <= abs(x) < high)
        return covered([k_d * intensity * h / (h * h + x * x + z * z) ** 1.5] * 3)

    return scene(*parts), SMALL, pixel


@case(
    "cosine-law",
    "A Lambertian ball before a lamp of 1e6 cd at 1000 m on the camera's axis: L = k_d I (n·ω_i) / d², which is "
    "k_d cos θ to a part in 1000.",
)
def _():
    camera = Camera("orthographic", SMALL, (0, 0, 5), (0, 0, 0), 2.2)
    bulb = [0.0, 0.0, 1000.0]
    text = scene(
        image(SMALL), camera.text, phong("m", diffuse=0.8), light("l", bulb, 1e6), sphere("ball", "m", [0, 0, 0], 1.0)
    )

    def pixel(px, py):
        (x, y, _), _ = camera.ray(px, py)
        rest = 1 - x * x - y * y
        if rest < 0:
            return NOTHING
        p = [x, y, sqrt(rest)]
        return covered(lambert(p, p, bulb, 1e6, 0.8))

    return text, SMALL, pixel


@case("lambert-plane", "A floor of three reflectances below a light: L = k_d I h / (h² + r²)^(3/2).")
def _():
    camera, bulb, k_d = from_above(), [0.5, 1.5, -0.25], [0.2, 0.5, 0.75]
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=k_d),
        light("l", bulb, 30.0),
        plane("floor", "m", [0, 0, 0], [0, 1, 0]),
    )

    def pixel(px, py):
        x, z = on_floor(camera, px, py)
        x, z, h = x - bulb[0], z - bulb[2], bulb[1]
        return covered([k * 30.0 * h / (h * h + x * x + z * z) ** 1.5 for k in k_d])

    return text, SMALL, pixel


@case(
    "illuminance-of-a-white-floor",
    "1000 lm and 100 cd above a white floor (albedo 1, normalized): L = E/π with E = Φ/(4π) h/d³ + I h'/d'³ in lux.",
)
def _():
    camera = from_above()
    text = scene(
        image(SMALL),
        camera.text,
        normalized("white", diffuse=1.0),
        light("lumens", [-1.0, 2.0, 0.0], "{ lumens = 1000 }"),
        light("candela", [2.0, 3.0, 1.0], "{ candela = 100 }"),
        plane("floor", "white", [0, 0, 0], [0, 1, 0]),
    )

    def pixel(px, py):
        x, z = on_floor(camera, px, py)
        lux = 1000 / (4 * pi) * 2.0 / ((x + 1) ** 2 + 4 + z * z) ** 1.5
        lux += 100 * 3.0 / ((x - 2) ** 2 + 9 + (z - 1) ** 2) ** 1.5
        return covered([lux / pi] * 3)

    return text, SMALL, pixel


@case(
    "grazing-light",
    "A light 1 mm above a floor that is seen 6 m wide: L = k_d I h / (h² + r²)^(3/2), from 1e-4 to 1e-1 of the peak.",
    tolerance=ILL,
)
def _():
    camera, h = from_above(), 1e-3
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=0.5),
        light("l", [0.0, h, 0.0], 10.0),
        plane("floor", "m", [0, 0, 0], [0, 1, 0]),
    )

    def pixel(px, py):
        x, z = on_floor(camera, px, py)
        return covered([0.5 * 10.0 * h / (h * h + x * x + z * z) ** 1.5] * 3)

    return text, SMALL, pixel


@case("off-center-plane", "A plane with the normal (1, 3, −2)/√14 through (1, −2, 0.5), Lambert: L = k_d I (n·ω_i)/d².")
def _():
    camera = Camera("perspective", SMALL, (0.0, 2.0, 6.0), (0.5, 0.0, -1.0), 30.0)
    n, point, bulb = unit([1.0, 3.0, 2.0]), [1.0, -2.0, 0.5], [2.0, 3.0, 1.0]
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=[0.9, 0.6, 0.3]),
        light("l", bulb, 50.0),
        plane("slope", "m", point, [1.0, 3.0, 2.0]),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        p = at(origin, way, meets_plane(origin, way, point, n))
        return covered(lambert(p, n, bulb, 50.0, [0.9, 0.6, 0.3]))

    return text, SMALL, pixel


@case(
    "two-sides",
    "A plane seen from below, a light of 5 cd above it and one of 20 cd below: the one above adds nothing, the normal "
    "is turned towards the viewer.",
)
def _():
    camera = Camera("perspective", SMALL, (0.0, -3.0, 2.0), (0.0, 0.0, 0.0), 40.0)
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=0.5),
        light("above", [0.5, 1.0, 0.0], 5.0),
        light("below", [-1.0, -2.0, 0.0], 20.0),
        plane("ceiling", "m", [0, 0, 0], [0, 1, 0]),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        t = meets_plane(origin, way, [0, 0, 0], [0, 1, 0])
        if t is None:
            return NOTHING
        return covered(lambert(at(origin, way, t), [0, -1, 0], [-1.0, -2.0, 0.0], 20.0, 0.5))

    return text, SMALL, pixel


# ---------------------------------------------------------------- lobes


def highlight(name, shininess, camera, bulb, intensity):
    """A floor with nothing but L7."""

    @case(
        name,
        f"A floor with a specular lobe alone, n = {shininess:g}: L = k_s I/d² cosⁿ(ω_o, ω_r), without a cosine of the "
        "incident light.",
    )
    def _():
        text = scene(
            image(SMALL),
            camera.text,
            phong("m", specular=0.4, shininess=shininess),
            light("l", bulb, intensity),
            plane("floor", "m", [0, 0, 0], [0, 1, 0]),
        )

        def pixel(px, py):
            origin, way = camera.ray(px, py)
            p = at(origin, way, meets_plane(origin, way, [0, 0, 0], [0, 1, 0]))
            return covered(lobe(p, [0, 1, 0], mul(way, -1), bulb, intensity, 0.4, shininess))

        return text, SMALL, pixel


OBLIQUE = Camera("perspective", SMALL, (0.0, 3.0, 5.0), (0.0, 0.0, 0.0), 35.0)
highlight("phong-0.5", 0.5, OBLIQUE, [1.0, 2.0, -1.0], 9.0)
highlight("phong-1", 1.0, from_above(4.0), [0.25, 2.0, 0.5], 9.0)
highlight("phong-50", 50.0, OBLIQUE, [0.5, 2.5, -4.0], 9.0)
highlight("phong-1000", 1000.0, Camera("perspective", SMALL, (0.0, 3.0, 5.0), (0.0, 0.0, 0.0), 12.0), [0.1, 3.0, -5.0], 9.0)


@case("phong-sum", "A ball with L8 = L5 + L6 and n = 20 under two lights, in perspective.")
def _():
    camera = Camera("perspective", SMALL, (0.0, 0.5, 5.0), (0.0, 0.0, 0.0), 26.0)
    lights = [([2.0, 3.0, 4.0], 25.0), ([-4.0, 1.0, 2.0], 15.0)]
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=[0.6, 0.3, 0.1], specular=0.5, shininess=20),
        *[light(f"l{i}", *bulb) for i, bulb in enumerate(lights)],
        sphere("ball", "m", [0, 0, 0], 1.0),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        t = meets_sphere(origin, way, [0, 0, 0], 1.0)
        if t is None:
            return NOTHING
        p = at(origin, way, t)
        terms = [lambert(p, p, *bulb, [0.6, 0.3, 0.1]) for bulb in lights]
        terms += [lobe(p, p, mul(way, -1), *bulb, 0.5, 20) for bulb in lights]
        return covered(total(*terms))

    return text, SMALL, pixel


@case(
    "normalized-phong",
    "A floor of ρ_d = 0.3, ρ_s = 0.6, n = 30: L = I/d² cos(n, ω_i) [ρ_d/π + ρ_s (n+2)/(2π) cosⁿ(ω_o, ω_r)].",
)
def _():
    camera, bulb = OBLIQUE, [0.5, 2.5, -3.0]
    text = scene(
        image(SMALL),
        camera.text,
        normalized("m", diffuse=0.3, specular=0.6, shininess=30),
        light("l", bulb, 40.0),
        plane("floor", "m", [0, 0, 0], [0, 1, 0]),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        n = [0, 1, 0]
        p = at(origin, way, meets_plane(origin, way, [0, 0, 0], n))
        diffuse = mul(lambert(p, n, bulb, 40.0, 0.3), 1 / pi)
        return covered(total(diffuse, normalized_lobe(p, n, mul(way, -1), bulb, 40.0, 0.6, 30)))

    return text, SMALL, pixel


@case("normalized-phong-ball", "The same on a ball with n = 5 and colored lobes.")
def _():
    camera, bulb = Camera("orthographic", SMALL, (0, 0, 5), (0, 0, 0), 2.2), [1.5, 2.0, 4.0]
    rho_d, rho_s = [0.5, 0.3, 0.1], [0.2, 0.4, 0.6]
    text = scene(
        image(SMALL),
        camera.text,
        normalized("m", diffuse=rho_d, specular=rho_s, shininess=5),
        light("l", bulb, 60.0),
        sphere("ball", "m", [0, 0, 0], 1.0),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        t = meets_sphere(origin, way, [0, 0, 0], 1.0)
        if t is None:
            return NOTHING
        p = at(origin, way, t)
        diffuse = mul(lambert(p, p, bulb, 60.0, rho_d), 1 / pi)
        return covered(total(diffuse, normalized_lobe(p, p, mul(way, -1), bulb, 60.0, rho_s, 5)))

    return text, SMALL, pixel


# ---------------------------------------------------------------- sums


def floor_under(camera, lights, k_d, k_s=0.0, shininess=1.0):
    keys = dict(diffuse=k_d)
    if k_s:
        keys.update(specular=k_s, shininess=shininess)
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", **keys),
        *[light(f"l{i}", *bulb) for i, bulb in enumerate(lights)],
        plane("floor", "m", [0, 0, 0], [0, 1, 0]),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        t = meets_plane(origin, way, [0, 0, 0], [0, 1, 0])
        if t is None:
            return NOTHING
        p = at(origin, way, t)
        terms = [lambert(p, [0, 1, 0], *bulb, k_d) for bulb in lights]
        terms += [lobe(p, [0, 1, 0], mul(way, -1), *bulb, k_s, shininess) for bulb in lights]
        return covered(total(*terms))

    return text, SMALL, pixel


@case("several-lights", "L9: five white lights of 2 to 32 cd at 0.5 to 4 m; the sum of five Lambertian terms.")
def _():
    lights = [
        ([-2.0, 0.5, 1.0], 2.0),
        ([2.0, 1.0, 0.5], 4.0),
        ([0.0, 2.0, -1.0], 8.0),
        ([-1.0, 3.0, -2.0], 16.0),
        ([3.0, 4.0, 2.0], 32.0),
    ]
    return floor_under(from_above(), lights, 0.5)


@case("colored-lights", "Three lights of different colors on a colored floor: component by component.")
def _():
    lights = [
        ([-1.5, 1.0, 0.5], [20.0, 1.0, 0.5]),
        ([1.5, 1.0, 0.5], [0.0, 12.0, 2.0]),
        ([0.0, 1.5, -1.0], [1.0, 3.0, 30.0]),
    ]
    return floor_under(from_above(), lights, [0.8, 0.4, 0.2])


@case("thirty-lights", "Thirty lights on a circle over a floor with L8, n = 12, orthographic.")
def _():
    lights = []
    for i in range(30):
        angle = 2 * pi * i / 30
        lights.append(([3 * cos(angle), 1.5 + 0.05 * i, 3 * sin(angle)], 1.0 + 0.1 * i))
    camera = Camera("orthographic", SMALL, (0, 6, 6), (0, 0, 0), 5.0)
    return floor_under(camera, lights, 0.3, 0.4, 12.0)


# ---------------------------------------------------------------- visibility


@case(
    "shadow-of-a-sphere",
    "A ball of R = 0.5 between a light and a floor: V = 0 where the way to the light passes its center by less than R.",
)
def _():
    camera = Camera("perspective", SMALL, (0.0, 5.0, 4.0), (0.0, 0.0, 0.0), 40.0)
    bulb, center, radius = [1.0, 4.0, -1.0], [0.3, 1.0, -0.2], 0.5
    text = scene(
        image(SMALL),
        camera.text,
        phong("floor", diffuse=0.5),
        phong("ball", diffuse=[0.7, 0.2, 0.1]),
        light("l", bulb, 40.0),
        plane("floor", "floor", [0, 0, 0], [0, 1, 0]),
        sphere("ball", "ball", center, radius),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        t = meets_sphere(origin, way, center, radius)
        if t is not None:
            p = at(origin, way, t)
            return covered(lambert(p, unit(sub(p, center)), bulb, 40.0, [0.7, 0.2, 0.1]))
        p = at(origin, way, meets_plane(origin, way, [0, 0, 0], [0, 1, 0]))
        to_light = unit(sub(bulb, p))
        aside = length(cross(sub(center, p), to_light))
        if aside < radius:
            return covered([0.0] * 3)
        return covered(lambert(p, [0, 1, 0], bulb, 40.0, 0.5))

    return text, SMALL, pixel


@case(
    "shadow-of-a-triangle",
    "A triangle at y = 1 under a light at y = 3: on the floor its shadow is the triangle, from the light's foot 3/2 as "
    "large.",
)
def _():
    camera = Camera("orthographic", SMALL, (0, 4, 8), (0, 0, 0), 6.0)
    bulb, corners = [0.4, 3.0, 0.2], [[-1.0, 1.0, -0.8], [1.2, 1.0, -0.5], [0.1, 1.0, 1.1]]
    text = scene(
        image(SMALL),
        camera.text,
        phong("floor", diffuse=0.5),
        phong("wing", diffuse=[0.1, 0.3, 0.6]),
        light("l", bulb, 20.0),
        plane("floor", "floor", [0, 0, 0], [0, 1, 0]),
        triangle("wing", "wing", corners),
    )
    foot = [bulb[0], 0.0, bulb[2]]
    shadow = [add(foot, [1.5 * (c[0] - foot[0]), 0.0, 1.5 * (c[2] - foot[2])]) for c in corners]

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        t = meets_triangle(origin, way, corners)
        if t is not None:
            return covered(lambert(at(origin, way, t), [0, 1, 0], bulb, 20.0, [0.1, 0.3, 0.6]))
        p = at(origin, way, meets_plane(origin, way, [0, 0, 0], [0, 1, 0]))
        if min(barycentric(p, shadow)) > 0:
            return covered([0.0] * 3)
        return covered(lambert(p, [0, 1, 0], bulb, 20.0, 0.5))

    return text, SMALL, pixel


@case(
    "shadow-of-a-plane",
    "A wall without end at x = 0 that is seen edge-on from above, a light on its right: the floor on its left is black.",
)
def _():
    camera, bulb = from_above(), [1.0, 2.0, 0.0]
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=0.5),
        light("l", bulb, 20.0),
        plane("floor", "m", [0, 0, 0], [0, 1, 0]),
        plane("wall", "m", [0, 0, 0], [1, 0, 0]),
    )

    def pixel(px, py):
        x, z = on_floor(camera, px, py)
        if x < 0:
            return covered([0.0] * 3)
        return covered(lambert([x, 0.0, z], [0, 1, 0], bulb, 20.0, 0.5))

    return text, SMALL, pixel


def occluder(name, gap, remark):
    """A triangle this far above another, and a window at its edge."""

    @case(
        name,
        f"Two triangles of 2 m, one {gap:g} m above the other, and a window of four times that at the upper one's edge: "
        f"its shadow is as wide as the gap, at 45°. {remark}",
    )
    def _():
        camera = Camera("orthographic", SMALL, (gap / 2, 1, 0), (gap / 2, 0, 0), 4.1 * gap, up=(0, 0, -1))
        bulb = [-1.0, 1.0, 0.0]
        lower = [[-2.0, 0.0, -1.0], [2.0, 0.0, -1.0], [0.0, 0.0, 2.0]]
        upper = [[-2.0, gap, 0.0], [0.0, gap, -1.0], [0.0, gap, 1.0]]
        text = scene(
            image(SMALL),
            camera.text,
            phong("lower", diffuse=0.5),
            phong("upper", diffuse=[0.6, 0.3, 0.1]),
            light("l", bulb, 2.0),
            triangle("lower", "lower", lower),
            triangle("upper", "upper", upper),
        )

        def pixel(px, py):
            (x, _, z), _ = camera.ray(px, py)
            if x < 0:
                return covered(lambert([x, gap, z], [0, 1, 0], bulb, 2.0, [0.6, 0.3, 0.1]))
            # Where the way to the light is at the height of the upper one.
            share = gap / bulb[1]
            if x + (bulb[0] - x) * share < 0:
                return covered([0.0] * 3)
            return covered(lambert([x, 0.0, z], [0, 1, 0], bulb, 2.0, 0.5))

        return text, SMALL, pixel


occluder("close-occluder", 1e-5, "Shadow rays that start a thousandth off the surface lose it.")
occluder("closer-occluder", 1e-8, "Any fixed epsilon loses it.")


@case(
    "silhouettes",
    "Three balls behind each other in perspective: the nearest counts, A is 0 where there is none, and each is lit by "
    "a lamp beside the eye that no other ball hides.",
    tolerance=ILL,
)
def _():
    camera = Camera("perspective", (32, 20), (0, 0, 8), (0, 0, 0), 24.0)
    # A light so near to the eye that what is seen is lit.
    bulb = [0.0, 0.0, 8.0 + 1e-6]
    balls = [([-0.6, 0.2, 1.0], 0.7, 0.8), ([0.5, -0.1, -0.5], 0.9, 0.5), ([0.2, 0.8, -2.0], 0.8, 0.3)]
    text = scene(
        image((32, 20)),
        camera.text,
        *[phong(f"m{i}", diffuse=k) for i, (_, _, k) in enumerate(balls)],
        light("l", bulb, 100.0),
        *[sphere(f"ball{i}", f"m{i}", c, r) for i, (c, r, _) in enumerate(balls)],
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        hits = [(meets_sphere(origin, way, c, r), c, k) for c, r, k in balls]
        hits = [hit for hit in hits if hit[0] is not None]
        if not hits:
            return NOTHING
        t, center, k_d = min(hits, key=lambda hit: hit[0])
        p = at(origin, way, t)
        return covered(lambert(p, unit(sub(p, center)), bulb, 100.0, k_d))

    return text, (32, 20), pixel


@case(
    "sphere-terminator",
    "A ball lit from the side at 3 R: its light ends where p·p_L = R², not on the great circle.",
    tolerance=ILL,
)
def _():
    camera, bulb = Camera("orthographic", (32, 20), (0, 0, 5), (0, 0, 0), 2.2), [3.0, 0.5, 0.0]
    text = scene(
        image((32, 20)),
        camera.text,
        phong("m", diffuse=0.7),
        light("l", bulb, 20.0),
        sphere("ball", "m", [0, 0, 0], 1.0),
    )

    def pixel(px, py):
        (x, y, _), _ = camera.ray(px, py)
        rest = 1 - x * x - y * y
        if rest < 0:
            return NOTHING
        p = [x, y, sqrt(rest)]
        return covered(lambert(p, p, bulb, 20.0, 0.7))

    return text, (32, 20), pixel


@case(
    "inside-a-sphere",
    "Eye and light inside of a sphere of R = 2 with its normals inwards: L = k_d I (n·ω_i)/d² all over, no shadow.",
)
def _():
    camera, bulb = Camera("perspective", SMALL, (0.2, 0.1, 0.3), (1.0, 0.5, -2.0), 90.0), [0.5, -0.4, 0.6]
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=0.5),
        light("l", bulb, 10.0),
        sphere("room", "m", [0, 0, 0], 2.0),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        p = at(origin, way, meets_sphere(origin, way, [0, 0, 0], 2.0))
        return covered(lambert(p, mul(p, -0.5), bulb, 10.0, 0.5))

    return text, SMALL, pixel


@case(
    "closed-room",
    "A white room of 4 m of six planes, 10 000 lm off its middle, seen in perspective: L = Φ/(4π²) (n·ω_i)/d².",
)
def _():
    camera = Camera("perspective", (32, 20), (-1.2, 0.33, 1.5), (1.0, -0.43, -2.0), 75.0)
    bulb = [0.7, 0.9, -0.5]
    walls = [([s * 2.0 if i == a else 0.0 for i in range(3)], [s * -1.0 if i == a else 0.0 for i in range(3)])
             for a in range(3) for s in (1, -1)]
    text = scene(
        image((32, 20)),
        camera.text,
        normalized("white", diffuse=1.0),
        light("l", bulb, "{ lumens = 10000 }"),
        *[plane(f"wall{i}", "white", *wall) for i, wall in enumerate(walls)],
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        hits = [(meets_plane(origin, way, *wall), wall[1]) for wall in walls]
        t, n = min((hit for hit in hits if hit[0] is not None), key=lambda hit: hit[0])
        p = at(origin, way, t)
        return covered(mul(lambert(p, n, bulb, 10000 / (4 * pi), 1.0), 1 / pi))

    return text, (32, 20), pixel


# ---------------------------------------------------------------- triangles


@case("triangle", "One oblique triangle before nothing: inside where its barycentric coordinates are positive.")
def _():
    camera = Camera("perspective", SMALL, (0, 0, 4), (0, 0, 0), 40.0)
    corners, bulb = [[-1.31, -0.93, 0.4], [1.52, -0.61, -0.7], [0.23, 1.19, -0.2]], [1.0, 2.0, 3.0]
    text = scene(
        image(SMALL), camera.text, phong("m", diffuse=0.9), light("l", bulb, 12.0), triangle("t", "m", corners)
    )
    n = unit(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])))

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        t = meets_triangle(origin, way, corners)
        if t is None:
            return NOTHING
        return covered(lambert(at(origin, way, t), facing(n, mul(way, -1)), bulb, 12.0, 0.9))

    return text, SMALL, pixel


PYRAMID = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.5, 0.0]]
SIDES = [[0, 4, 1], [1, 4, 2], [2, 4, 3], [3, 4, 0]]


@case(
    "mesh",
    "A pyramid from an OBJ file, scaled by (1, 0.8, 1.2), turned by 30° about y and moved, on a floor: Lambert on flat "
    "sides, and its shadow.",
)
def _():
    camera = Camera("perspective", (32, 20), (1.0, 3.5, 5.0), (0.2, 0.4, 0.0), 34.0)
    bulb = [2.0, 4.0, 3.0]
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in PYRAMID]
    lines += ["f " + " ".join(str(i + 1) for i in side) for side in SIDES]
    MESHES["pyramid.obj"] = "# Four sides on a square.\n" + "\n".join(lines) + "\n"
    text = scene(
        image((32, 20)),
        camera.text,
        phong("floor", diffuse=0.3),
        phong("stone", diffuse=[0.8, 0.7, 0.5]),
        light("l", bulb, 30.0),
        plane("floor", "floor", [0, 0, 0], [0, 1, 0]),
        table(
            "objects.pyramid.mesh",
            material='"stone"',
            file='"pyramid.obj"',
            scale=[1.0, 0.8, 1.2],
            rotate=[0, 30, 0],
            translate=[0.1, 0.2, -0.3],
        ),
    )
    s, c = sin(radians(30)), cos(radians(30))

    def placed(v):
        x, y, z = v[0], v[1] * 0.8, v[2] * 1.2
        return [c * x + s * z + 0.1, y + 0.2, c * z - s * x - 0.3]

    triangles = [[placed(PYRAMID[i]) for i in side] for side in SIDES]

    def hidden(p, own):
        way = sub(bulb, p)
        for number, corners in enumerate(triangles):
            t = None if number == own else meets_triangle(p, unit(way), corners)
            if t is not None and t < length(way):
                return True
        return False

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        hits = [(meets_triangle(origin, way, corners), i) for i, corners in enumerate(triangles)]
        hits = [hit for hit in hits if hit[0] is not None]
        hits.append((meets_plane(origin, way, [0, 0, 0], [0, 1, 0]), None))
        t, own = min((hit for hit in hits if hit[0] is not None), key=lambda hit: hit[0])
        p = at(origin, way, t)
        if own is None:
            n, k_d = [0, 1, 0], 0.3
        else:
            a, b, corner = triangles[own]
            n, k_d = facing(unit(cross(sub(b, a), sub(corner, a))), mul(way, -1)), [0.8, 0.7, 0.5]
        if hidden(p, own):
            return covered([0.0] * 3)
        return covered(lambert(p, n, bulb, 30.0, k_d))

    return text, (32, 20), pixel


@case(
    "smooth-normals",
    "A square of two triangles with normals at its corners: n is the normalized sum of the corners' by barycentric "
    "coordinates, in L5 and in L6 and L7 (n = 15).",
)
def _():
    camera, bulb = Camera("perspective", SMALL, (0.3, 0.2, 4), (0, 0, 0), 34.0), [0.5, 1.0, 3.0]
    corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]
    normals = [[-0.3, -0.2, 1.0], [0.4, -0.1, 1.0], [0.2, 0.3, 0.9], [-0.1, 0.4, 1.0]]
    faces = [[0, 1, 2], [0, 2, 3]]
    lines = ["v {:g} {:g} {:g}".format(*v) for v in corners] + ["vn {:g} {:g} {:g}".format(*n) for n in normals]
    lines += ["f " + " ".join(f"{i + 1}//{i + 1}" for i in face) for face in faces]
    MESHES["pillow.obj"] = "# A square with normals that spread.\n" + "\n".join(lines) + "\n"
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=[0.5, 0.4, 0.2], specular=0.3, shininess=15),
        light("l", bulb, 15.0),
        table("objects.pillow.mesh", material='"m"', file='"pillow.obj"'),
    )
    # Normals of files are directions: their length does not count.
    normals = [unit(n) for n in normals]

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        for face in faces:
            t = meets_triangle(origin, way, [corners[i] for i in face])
            if t is not None:
                p = at(origin, way, t)
                weights = barycentric(p, [corners[i] for i in face])
                n = unit(total(*[mul(normals[i], w) for i, w in zip(face, weights)]))
                gloss = lobe(p, n, mul(way, -1), bulb, 15.0, 0.3, 15)
                return covered(total(lambert(p, n, bulb, 15.0, [0.5, 0.4, 0.2]), gloss))
        return NOTHING

    return text, SMALL, pixel


# ---------------------------------------------------------------- cameras


@case("orthographic-camera", "An oblique orthographic view with a tilted up: rays start at eye + x u + y v, all along the view.")
def _():
    camera = Camera("orthographic", (30, 20), (3, 4, 5), (0.5, 0, 0.2), 5.0, up=(0.3, 1, -0.1))
    text, _, pixel = floor_under(camera, [([1.0, 1.2, 0.5], 10.0)], 0.5)
    return text.replace("resolution = [24, 16]", "resolution = [30, 20]"), (30, 20), pixel


@case(
    "perspective-camera",
    "100° from edge to edge with a tilted up: ω = f + tan(50°) (x u + y v), x to ±aspect, y to ±1 from the middle.",
)
def _():
    camera = Camera("perspective", (30, 20), (1, 3, 2), (0.5, 0, -0.2), 100.0, up=(0.3, 1, -0.1))
    text, _, pixel = floor_under(camera, [([1.0, 1.2, 0.5], 10.0)], 0.5)
    return text.replace("resolution = [24, 16]", "resolution = [30, 20]"), (30, 20), pixel


@case("background", "A ball before a background of (0.2, 0.4, 1.5) cd/m², with A = 0 there.")
def _():
    camera, bulb, sky = Camera("orthographic", SMALL, (0, 0, 5), (0, 0, 0), 3.0), [2.0, 2.0, 4.0], [0.2, 0.4, 1.5]
    text = scene(
        image(SMALL, background=sky),
        camera.text,
        phong("m", diffuse=0.5),
        light("l", bulb, 20.0),
        sphere("ball", "m", [0.23, 0.11, 0], 1.0),
    )

    def pixel(px, py):
        origin, way = camera.ray(px, py)
        t = meets_sphere(origin, way, [0.23, 0.11, 0], 1.0)
        if t is None:
            return [*sky, 0.0]
        p = at(origin, way, t)
        return covered(lambert(p, sub(p, [0.23, 0.11, 0]), bulb, 20.0, 0.5))

    return text, SMALL, pixel


# ---------------------------------------------------------------- spots


def spot(name, formula, falloff, inner, outer, intensity, on_axis, share):
    """A spot that shines obliquely onto a floor; `share` is its falloff by the angle's cosine."""

    @case(name, formula)
    def _():
        camera, bulb, target = from_above(4.0), [0.5, 2.0, 0.25], [-0.25, 0.0, 0.1]
        text = scene(
            image(SMALL),
            camera.text,
            phong("m", diffuse=0.5),
            table(
                "lights.l.spot",
                position=bulb,
                look_at=target,
                intensity=intensity,
                inner=inner,
                outer=outer,
                falloff=f'"{falloff}"',
            ),
            plane("floor", "m", [0, 0, 0], [0, 1, 0]),
        )
        axis = unit(sub(target, bulb))

        def pixel(px, py):
            x, z = on_floor(camera, px, py)
            p = [x, 0.0, z]
            cosine = dot(unit(sub(p, bulb)), axis)
            return covered(mul(lambert(p, [0, 1, 0], bulb, on_axis, 0.5), share(cosine)))

        return text, SMALL, pixel


def fraction(cosine, inner, outer):
    x = (cosine - cos(radians(outer))) / (cos(radians(inner)) - cos(radians(outer)))
    return min(max(x, 0.0), 1.0)


def linear_angle(cosine, inner, outer):
    return min(max((outer - degrees(acos(min(cosine, 1.0)))) / (outer - inner), 0.0), 1.0)


def smooth(x):
    return x * x * (3 - 2 * x)


spot(
    "spot",
    "A spot of 30 cd, full to 15°, dark from 35°: f = x² (3 − 2x), x = (cos θ − cos 35°)/(cos 15° − cos 35°).",
    "smooth", 15.0, 35.0, 30.0, 30.0, lambda c: smooth(fraction(c, 15, 35)),
)
spot(
    "spot-gltf",
    "A spot with the falloff of glTF: f = x².",
    "gltf", 10.0, 40.0, 30.0, 30.0, lambda c: fraction(c, 10, 40) ** 2,
)
spot(
    "spot-linear",
    "A spot whose falloff is linear in the angle: f = (40° − θ)/(40° − 10°).",
    "linear_angle", 10.0, 40.0, 30.0, 30.0, lambda c: linear_angle(c, 10, 40),
)
spot(
    "spot-lumens",
    "A spot of 300 lm, full to 20°, dark from 30°: I = Φ / (2π [(1 − cos 20°) + (cos 20° − cos 30°)/2]).",
    "smooth", 20.0, 30.0, "{ lumens = 300 }",
    300 / (2 * pi * ((1 - cos(radians(20))) + (cos(radians(20)) - cos(radians(30))) / 2)),
    lambda c: smooth(fraction(c, 20, 30)),
)


# ---------------------------------------------------------------- sizes and places


def ball_of(size, middle, intensity):
    """A ball on a floor, lengths times `size`, moved by `middle`."""
    to = lambda v: [size * x + m for x, m in zip(v, middle)]
    camera = Camera("perspective", SMALL, to([0.0, 1.5, 4.0]), to([0.0, 0.5, 0.0]), 32.0)
    near = Camera("perspective", SMALL, (0.0, 1.5, 4.0), (0.0, 0.5, 0.0), 32.0)
    bulb, center = [2.0, 3.0, 2.0], [0.0, 0.6, 0.0]
    text = scene(
        image(SMALL),
        camera.text,
        phong("m", diffuse=0.5),
        light("l", to(bulb), intensity),
        plane("floor", "m", to([0.0, 0.0, 0.0]), [0, 1, 0]),
        sphere("ball", "m", to(center), 0.6 * size),
    )
    strength = intensity / size**2

    def pixel(px, py):
        origin, way = near.ray(px, py)
        t = meets_sphere(origin, way, center, 0.6)
        if t is not None:
            p = at(origin, way, t)
            return covered(lambert(p, unit(sub(p, center)), bulb, strength, 0.5))
        t = meets_plane(origin, way, [0, 0, 0], [0, 1, 0])
        if t is None:
            return NOTHING
        p = at(origin, way, t)
        if length(cross(sub(center, p), unit(sub(bulb, p)))) < 0.6:
            return covered([0.0] * 3)
        return covered(lambert(p, [0, 1, 0], bulb, strength, 0.5))

    return text, SMALL, pixel


@case("a-micrometre", "A ball on a floor, all lengths times 2⁻²⁰ and the light times 2⁻⁴⁰: the picture of the metre.")
def _():
    return ball_of(2.0**-20, [0.0, 0.0, 0.0], 20.0 * 2.0**-40)


@case("a-thousand-kilometres", "The same, lengths times 2²⁰ and the light times 2⁴⁰.")
def _():
    return ball_of(2.0**20, [0.0, 0.0, 0.0], 20.0 * 2.0**40)


@case("far-from-the-origin", "The same, moved by (2¹⁴, −2¹⁴, 2¹⁵) m: single precision has 2 mm left there.")
def _():
    return ball_of(1.0, [2.0**14, -(2.0**14), 2.0**15], 20.0)


# ---------------------------------------------------------------- spectra


def csv(name):
    rows = [line for line in (DATA / name).read_text().splitlines() if line and not line.startswith("#")]
    return [[float(cell) for cell in row.split(",")] for row in rows]


OBSERVER = csv("cie_1931_2_degree.csv")
GRID = [row[0] for row in OBSERVER]


def linear(points, nm):
    """Between points (nm, value), constant beyond them."""
    if nm <= points[0][0]:
        return points[0][1]
    for (a, u), (b, v) in zip(points, points[1:]):
        if nm <= b:
            return u + (v - u) * (nm - a) / (b - a)
    return points[-1][1]


def xyz(spectrum):
    """683 Σ S x̄, in photometric units."""
    return [683 * sum(s * row[i] for s, row in zip(spectrum, OBSERVER)) for i in (1, 2, 3)]


def apply(matrix, v):
    return [dot(row, v) for row in matrix]


def inverse(m):
    a, b, c = m
    columns = [cross(b, c), cross(c, a), cross(a, b)]
    return [[column[i] / dot(a, columns[0]) for column in columns] for i in range(3)]


def rec709(spectrum):
    """Linear Rec.709 of light: nothing is adapted, as the space's white is D65's."""
    chroma = lambda x, y: [x / y, 1.0, (1 - x - y) / y]
    primaries = [chroma(0.64, 0.33), chroma(0.30, 0.60), chroma(0.15, 0.06)]
    white = chroma(0.3127, 0.3290)
    columns = [list(row) for row in zip(*primaries)]
    strengths = apply(inverse(columns), white)
    to_xyz = [[row[i] * strengths[i] for i in range(3)] for row in columns]
    return apply(inverse(to_xyz), xyz(spectrum))


def planck(kelvin):
    c2 = 6.62607015e-34 * 299792458.0 / 1.380649e-23
    return [(nm * 1e-3) ** -5 / expm1(c2 / (nm * 1e-9 * kelvin)) for nm in GRID]


def spectral(name, formula, intensity, spectrum, diffuse=0.5, curve=None):
    """A floor under a light of this spectrum in W/(sr nm); `curve` is the floor's reflectance, if not gray."""

    @case(name, formula)
    def _():
        camera, bulb = from_above(), [0.5, 1.5, -0.25]
        text = scene(
            image(SMALL, transport='"spectral"'),
            camera.text,
            phong("m", diffuse=diffuse),
            light("l", bulb, intensity),
            plane("floor", "m", [0, 0, 0], [0, 1, 0]),
        )
        reflected = [s * (linear(curve, nm) if curve else diffuse) for s, nm in zip(spectrum, GRID)]
        rgb = rec709(reflected)

        def pixel(px, py):
            x, z = on_floor(camera, px, py)
            p = [x, 0.0, z]
            return covered(mul(rgb, lambert(p, [0, 1, 0], bulb, 1.0, 1.0)[0]))

        return text, SMALL, pixel


def of_candela(spectrum, candela):
    factor = candela / xyz(spectrum)[1]
    return [s * factor for s in spectrum]


def lines(pairs):
    return [sum(power * max(0.0, 1 - abs(nm - line)) for line, power in pairs) for nm in GRID]


spectral(
    "blackbody",
    "100 cd of a black body of 3000 K on gray: Planck's law, the CIE's 2° observer at 1 nm, the matrix of Rec.709.",
    "{ candela = 100, color = { blackbody = 3000 } }",
    of_candela(planck(3000.0), 100),
)
spectral(
    "a-line-at-555-nm",
    "1 W/sr at 555 nm: 683 cd, of a color that Rec.709 has not, with a negative red.",
    "{ lines = [[555, 1.0]] }",
    lines([(555, 1.0)]),
)
LED = [(465.0, 0.12), (525.0, 0.2), (635.5, 0.3)]
PAINT = [(400.0, 0.1), (480.0, 0.2), (560.0, 0.7), (640.0, 0.3), (700.0, 0.6)]
spectral(
    "three-lines-on-paint",
    "Lines at 465, 525 and 635.5 nm, as of an RGB LED, on a measured reflectance that is linear between its points: "
    "K_m Σ I(λ) k(λ) c̄(λ).",
    "{ lines = " + numbers([list(line) for line in LED]) + " }",
    lines(LED),
    "{ wavelengths = " + numbers([nm for nm, _ in PAINT]) + ", values = " + numbers([v for _, v in PAINT]) + " }",
    PAINT,
)


# ---------------------------------------------------------------- writing

# In pixels: an edge that is nearer to a pixel's center is refused.
NEAR = 2e-3
# Of the picture's peak: what changes more over that is an edge.
JUMP = 0.02


def make(folder, name, formula, tolerance, function):
    text, (width, height), pixel = function()
    values = [[pixel(x + 0.5, y + 0.5) for x in range(width)] for y in range(height)]
    peak = max(abs(c) for row in values for rgba in row for c in rgba[:3])
    for y, row in enumerate(values):
        for x, rgba in enumerate(row):
            for dx, dy in [(NEAR, 0), (-NEAR, 0), (0, NEAR), (0, -NEAR)]:
                beside = pixel(x + 0.5 + dx, y + 0.5 + dy)
                if any(abs(a - b) > JUMP * peak for a, b in zip(rgba[:3], beside)) or beside[3] != rgba[3]:
                    raise SystemExit(f"{name}: pixel {x}, {y} lies at an edge")
    if text.count("[objects") == 0 or not peak > 0:
        raise SystemExit(f"{name}: nothing is to be seen")
    comment = "\n".join("# " + line for line in textwrap.wrap(formula, 98))
    (folder / f"{name}.toml").write_text(comment + "\n\n" + text)
    flat = [rgba for row in values for rgba in row]
    channels = {c: [rgba[i] for rgba in flat] for i, c in enumerate("RGBA")}
    exr.write(folder / f"{name}.exr", width, height, channels)
    return {"name": name, "formula": formula, "tolerance": tolerance}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=HERE, help="where the files go")
    folder = parser.parse_args().folder
    for pattern in ("*.toml", "*.exr", "*.obj"):
        for old in folder.glob(pattern):
            old.unlink()
    suite = [make(folder, *entry) for entry in CASES]
    for name, text in MESHES.items():
        (folder / name).write_text(text)
    (folder / "suite.json").write_text(json.dumps(suite, indent=1, ensure_ascii=False) + "\n")
    print(f"{len(suite)} cases")


if __name__ == "__main__":
    main()
