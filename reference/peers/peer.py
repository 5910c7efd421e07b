"""What the programs have in common."""

from types import SimpleNamespace

from described import rays
from vectors import add, at, cross, dot, length, meets_plane, mul, sub, unit


class Missing(Exception):
    """A program is not there; the message says what to install."""


def setting(series, name, label, samples, **more):
    """A point of a program's curve. `samples` is None where the program itself decides."""
    return SimpleNamespace(series=series, name=name, label=label, samples=samples, **more)


def without_planes(scene):
    """The scene with a square in the place of each plane: twice as large as what is seen of it, and as far as the lights."""
    if not any(object_.kind == "plane" for object_ in scene.objects):
        return scene
    coarse = SimpleNamespace(**vars(scene))
    # Rays through a coarser image, which has its corners almost.
    coarse.width, coarse.height = min(scene.width, 96), max(1, min(scene.width, 96) * scene.height // scene.width)
    seen = list(rays(coarse))
    from_center = lambda point: length(sub(point, scene.camera.look_at))
    extent = max([from_center(scene.camera.eye)] + [from_center(light.position) for light in scene.lights])
    objects = [square(o, scene, seen, extent) if o.kind == "plane" else o for o in scene.objects]
    return SimpleNamespace(**(vars(scene) | {"objects": objects}))


def square(plane, scene, seen, extent):
    """Two triangles."""
    n = plane.normal
    foot = at(scene.camera.look_at, n, dot(sub(plane.point, scene.camera.look_at), n))
    others = [o for o in scene.objects if o.kind == "plane"]
    half = extent
    for ray in seen:
        t = meets_plane(*ray, plane.point, n)
        before = [meets_plane(*ray, o.point, o.normal) for o in others]
        if t is not None and t == min(hit for hit in before if hit is not None):
            half = max(half, length(sub(at(*ray, t), foot)))
    # Towards a horizon there is no end.
    half = 2 * min(half, 1e3 * extent)
    aside = unit(cross(n, [1, 0, 0] if abs(n[0]) < 0.9 else [0, 1, 0]))
    along = cross(n, aside)
    corner = lambda a, b: add(foot, add(mul(aside, a * half), mul(along, b * half)))
    a, b, c, d = corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)
    return SimpleNamespace(kind="triangles", material=plane.material, triangles=[([a, b, c], None), ([a, c, d], None)])
