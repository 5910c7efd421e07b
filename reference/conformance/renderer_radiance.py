"""Radiance's `rtrace`: point lights as spheres of a thousandth, on Lambertian surfaces.

Rays go through the middle of each pixel, in double precision both ways.
"""

import shutil
import struct
import subprocess
import tempfile
from math import pi
from pathlib import Path

from described import Refused, rays
from vectors import length, mul, sub

RTRACE = "-h -ov -ab 0 -dt 0 -dc 1 -dj 0 -ds 0 -dp 0 -st 1 -lr 0 -fdd".split()


def programs(program):
    """The folder of oconv and rtrace."""
    if program:
        return Path(program).parent
    found = shutil.which("rtrace")
    if found:
        return Path(found).parent
    try:
        import pyradiance
    except ImportError:
        raise SystemExit("neither rtrace nor the Python package pyradiance is there") from None
    return Path(pyradiance.__file__).parent / "bin"


def number(x):
    return f"{x:.17g}"


def numbers(v):
    return " ".join(map(number, v))


def shapes(object_, name, extent):
    if object_.kind == "sphere":
        yield f"{object_.material} sphere {name}\n0\n0\n4 {numbers(object_.center)} {number(object_.radius)}\n"
    elif object_.kind == "plane":
        size = number(1e4 * extent)
        yield f"{object_.material} ring {name}\n0\n0\n8 {numbers(object_.point)} {numbers(object_.normal)} 0 {size}\n"
    else:
        for part, (corners, normals) in enumerate(object_.triangles):
            if normals is not None:
                raise Refused("interpolated normals")
            flat = [x for v in corners for x in v]
            yield f"{object_.material} polygon {name}_{part}\n0\n0\n9 {numbers(flat)}\n"


def render(scene, program, peak):
    if any(scene.background):
        raise Refused("a background that does not light")
    extent = max(length(sub(light.position, scene.camera.look_at)) for light in scene.lights)
    parts = []
    for name, material in scene.materials.items():
        if any(material.specular):
            raise Refused("a specular lobe")
        k = mul(material.diffuse, 1 / pi) if material.model == "normalized_phong" else material.diffuse
        # Its reflectance ρ is ρ/π of light: the lights are π times as strong.
        parts.append(f"void plastic {name}\n0\n0\n5 {numbers(k)} 0 0\n")
    for index, object_ in enumerate(scene.objects):
        parts += shapes(object_, f"shape{index}", extent)
    for index, light in enumerate(scene.lights):
        if light.kind == "spot":
            raise Refused("the falloff of a spot")
        # Smaller ones it refuses, and of larger ones the size would show.
        radius = max(1e-3 * min(1.0, extent), 1e-5)
        if radius > 0.1 * extent:
            raise Refused("lengths this small")
        radiance = mul(light.intensity, pi / (pi * radius * radius))
        parts.append(f"void illum lamp{index}\n1 void\n0\n3 {numbers(radiance)}\n")
        parts.append(f"lamp{index} sphere bulb{index}\n0\n0\n4 {numbers(light.position)} {number(radius)}\n")
    folder_of = programs(program)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "scene.rad").write_text("\n".join(parts))
        with open(folder / "scene.oct", "wb") as out:
            subprocess.run([folder_of / "oconv", "scene.rad"], cwd=folder, stdout=out, stderr=subprocess.PIPE, check=True)
        asked = b"".join(struct.pack("<6d", *origin, *way) for origin, way in rays(scene))
        traced = subprocess.run(
            [folder_of / "rtrace", *RTRACE, "scene.oct"], cwd=folder, input=asked, capture_output=True
        )
        if traced.returncode:
            raise SystemExit(traced.stderr.decode())
        answer = traced.stdout
    values = struct.unpack(f"<{len(answer) // 8}d", answer)
    return {channel: list(values[i::3]) for i, channel in enumerate("RGB")}
