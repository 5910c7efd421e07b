"""Embree 3: the yardstick of `benches/embree`, which shades as candela does, in f32."""

import struct
import subprocess
import tempfile
from math import radians, tan
from pathlib import Path

import exr
from described import Refused
from peer import Missing, setting, without_planes
from vectors import add, mul, sub

SOURCE = Path(__file__).resolve().parents[2] / "benches/embree/yardstick.cpp"


class Peer:
    NAME, TITLE = "embree", "Embree 3"

    def __init__(self, scene, options):
        if any(material.model != "phong" for material in scene.materials.values()):
            raise Refused("a normalized lobe")
        if any(light.kind != "point" for light in scene.lights):
            raise Refused("lights other than points")
        self.options, self.folder = options, tempfile.TemporaryDirectory()
        has_planes = any(object_.kind == "plane" for object_ in scene.objects)
        self.scene = without_planes(scene)
        folder = Path(self.folder.name)
        program = folder / "yardstick"
        build = ["c++", "-std=c++17", "-O3", "-march=native", "-ffast-math", SOURCE, "-o", program, "-lembree3", "-lpthread"]
        try:
            subprocess.run(build, check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            raise Missing("Embree 3 or a C++ compiler is not there (Debian: libembree-dev g++)") from None
        (folder / "scene.bin").write_bytes(packed(self.scene))
        self.process = subprocess.Popen(
            [program, folder / "scene.bin", str(options.threads)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        version = self.answer().split()[3]
        self.series = f"Embree {version}"
        self.remarks = [
            f"Embree {version}: a program of candela's benchmarks on it, in f32, with packets of 16 rays and samples on a "
            "lattice; its tree's build is not in the time"
            + ("; a plane is a large square" if has_planes else "")
        ]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait()
        self.folder.cleanup()

    def answer(self):
        return self.process.stdout.readline().strip()

    def ask(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return self.answer()

    def settings(self, scene, options):
        for count in options.samples:
            name = "1 sample" if count == 1 else f"{count} samples"
            yield setting(self.series, name, str(count), count)

    def render(self, setting):
        return float(self.ask(f"render {setting.samples} {self.options.threads} {len(self.scene.lights)}"))

    def save(self, setting, path):
        raw = Path(self.folder.name) / "picture"
        self.ask(f"save {raw}")
        data = raw.read_bytes()
        values = struct.unpack(f"<{len(data) // 4}f", data)
        width, height = self.scene.width, self.scene.height
        exr.write(path, width, height, {channel: values[i::3] for i, channel in enumerate("RGB")})


def packed(scene):
    """A scene as the yardstick reads it: 32-bit numbers."""
    count = lambda number: struct.pack("<I", number)
    numbers = lambda *values: struct.pack(f"<{len(values)}f", *values)
    seen, width, height = scene.camera, scene.width, scene.height
    half = seen.size / 2 if seen.kind == "orthographic" else tan(radians(seen.size) / 2)
    # From the left and the top of the image, a column and a row further.
    column, row = mul(seen.right, 2 * half / height), mul(seen.up, -2 * half / height)
    corner = add(mul(column, -width / 2), mul(row, -height / 2))
    still = [0.0] * 3
    if seen.kind == "orthographic":
        camera = [add(seen.eye, corner), column, row, seen.forward, still, still]
    else:
        camera = [seen.eye, still, still, add(seen.forward, corner), column, row]
    parts = [count(width), count(height)] + [numbers(*vector) for vector in camera]
    parts.append(count(len(scene.lights)))
    parts += [numbers(*light.position, *light.intensity) for light in scene.lights]
    parts.append(numbers(*scene.background))
    shapes = {}
    for object_ in scene.objects:
        if object_.kind == "sphere":
            shapes.setdefault((object_.material, 0), []).append([*object_.center, object_.radius])
        else:
            for triangle in object_.triangles:
                kind = 1 if triangle[1] is None else 2
                shapes.setdefault((object_.material, kind), []).append(triangle)
    parts.append(count(len(shapes)))
    for (name, kind), members in shapes.items():
        material = scene.materials[name]
        parts += [count(kind), numbers(*material.diffuse, *material.specular, material.shininess)]
        if kind == 0:
            parts.append(count(4 * len(members)))
            parts += [numbers(*sphere) for sphere in members]
            continue
        corners = struct.pack(f"<{3 * len(members)}I", *range(3 * len(members)))
        for column in range(kind):
            parts.append(count(3 * len(members)))
            parts += [numbers(*vector) for triangle in members for vector in triangle[column]]
            parts += [count(3 * len(members)), corners]
    return b"".join(parts)
