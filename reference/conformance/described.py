"""A scene of the suite in the plain words that translators need: numbers, vectors, triangles."""

from math import cos, pi, radians, sin, tan
from types import SimpleNamespace

from ply import ply
from vectors import add, cross, mul, sub, unit


class Refused(Exception):
    """A renderer, or its translator, cannot express a scene; the message says why."""


def rgb(value, solid_angle=4 * pi):
    """Of a value: R, G, B, in candela for lights."""
    if isinstance(value, (int, float)):
        return [float(value)] * 3
    if isinstance(value, list):
        return [float(x) for x in value]
    if "lumens" in value and len(value) == 1:
        return [value["lumens"] / solid_angle] * 3
    if "candela" in value and len(value) == 1:
        return [float(value["candela"])] * 3
    raise Refused("spectra")


def described(scene, folder):
    """Camera, materials, lights and objects of a scene that is read from TOML."""
    image = scene["image"]
    kind, camera = next(iter(scene["camera"].items()))
    forward = unit(sub(camera["look_at"], camera["eye"]))
    right = unit(cross(forward, camera.get("up", [0, 1, 0])))
    width, height = image["resolution"]
    return SimpleNamespace(
        width=width,
        height=height,
        background=rgb(image.get("background", 0)),
        camera=SimpleNamespace(
            kind=kind,
            eye=[float(x) for x in camera["eye"]],
            look_at=[float(x) for x in camera["look_at"]],
            forward=forward,
            right=right,
            up=cross(right, forward),
            # The whole angle in degrees, or the height in scene units.
            size=float(camera["vertical_fov" if kind == "perspective" else "height"]),
        ),
        materials={name: material(entry) for name, entry in scene["materials"].items()},
        lights=[light(entry) for entry in scene.get("lights", {}).values()],
        objects=[shape(entry, folder) for entry in scene["objects"].values()],
    )


def material(entry):
    model, keys = next(iter(entry.items()))
    return SimpleNamespace(
        model=model,
        diffuse=rgb(keys.get("diffuse", 0)),
        specular=rgb(keys.get("specular", 0)),
        shininess=keys.get("shininess", 1),
        # Of smooth materials, as they are written.
        keys=keys,
    )


def light(entry):
    kind, keys = next(iter(entry.items()))
    found = SimpleNamespace(kind=kind, position=[float(x) for x in keys["position"]], cone=None)
    if kind == "point":
        found.intensity = rgb(keys["intensity"])
        return found
    found.inner, found.outer = float(keys.get("inner", 0)), float(keys["outer"])
    found.falloff = keys.get("falloff", "smooth")
    found.look_at = [float(x) for x in keys["look_at"]]
    inner, outer = cos(radians(found.inner)), cos(radians(found.outer))
    # Of the smooth falloff; others are given in candela.
    found.intensity = rgb(keys["intensity"], 2 * pi * ((1 - inner) + (inner - outer) / 2))
    return found


def shape(entry, folder):
    kind, keys = next(iter(entry.items()))
    found = SimpleNamespace(kind=kind, material=keys["material"])
    if kind == "sphere":
        found.center, found.radius = [float(x) for x in keys["center"]], float(keys["radius"])
    elif kind == "plane":
        found.point, found.normal = [float(x) for x in keys["point"]], unit(keys["normal"])
    elif kind == "triangle":
        found.kind = "triangles"
        found.triangles = [(keys["vertices"], None)]
    else:
        found.kind = "triangles"
        found.triangles = placed(mesh(folder / keys["file"]), keys)
    return found


def mesh(path):
    """Triangles of a file, by the end of its name."""
    return (ply if path.suffix.lower() == ".ply" else obj)(path)


def obj(path):
    """Triangles with the normals of their corners, or None."""
    vertices, normals, triangles = [], [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words and words[0] == "v":
            vertices.append([float(x) for x in words[1:4]])
        elif words and words[0] == "vn":
            normals.append(unit([float(x) for x in words[1:4]]))
        elif words and words[0] == "f":
            corners = [word.split("/") for word in words[1:]]
            smooth = len(corners[0]) == 3
            triangles.append(
                (
                    [vertices[int(corner[0]) - 1] for corner in corners],
                    [normals[int(corner[2]) - 1] for corner in corners] if smooth else None,
                )
            )
    return triangles


def placed(triangles, keys):
    """Scaled, turned about x, y, z, moved."""
    scale, moved = keys.get("scale", [1, 1, 1]), keys.get("translate", [0, 0, 0])
    if isinstance(scale, (int, float)):
        scale = [scale] * 3
    angles = [radians(angle) for angle in keys.get("rotate", [0, 0, 0])]

    def turned(v):
        x, y, z = v
        s, c = sin(angles[0]), cos(angles[0])
        y, z = c * y - s * z, s * y + c * z
        s, c = sin(angles[1]), cos(angles[1])
        x, z = c * x + s * z, c * z - s * x
        s, c = sin(angles[2]), cos(angles[2])
        return [c * x - s * y, s * x + c * y, z]

    def to(v):
        return add(turned([a * b for a, b in zip(v, scale)]), moved)

    def across(n):
        return unit(turned([a / b for a, b in zip(n, scale)]))

    return [
        ([to(v) for v in corners], [across(n) for n in normals] if normals else None)
        for corners, normals in triangles
    ]


def rays(scene):
    """Origin and direction of the ray through the middle of each pixel, row by row."""
    seen = scene.camera
    half = seen.size / 2 if seen.kind == "orthographic" else tan(radians(seen.size) / 2)
    for row in range(scene.height):
        for column in range(scene.width):
            x = half * (2 * column + 1 - scene.width) / scene.height
            y = half * (scene.height - 2 * row - 1) / scene.height
            aside = add(mul(seen.right, x), mul(seen.up, y))
            if seen.kind == "orthographic":
                yield add(seen.eye, aside), seen.forward
            else:
                yield seen.eye, unit(add(seen.forward, aside))
