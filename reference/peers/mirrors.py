#!/usr/bin/env python3
"""Compares candela's mirrors, metals, glass and panes with Mitsuba 3 and POV-Ray, pixel by pixel.

    reference/peers/mirrors.py
    reference/peers/mirrors.py glass-ball --program target/release/candela --pixels

Prints the table of docs/mirrors.md. README.md beside this file says what each program needs, and how it is asked.
"""

import argparse
import shutil
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "conformance"))

import renderer_candela  # noqa: E402
from described import Refused, described, rays, rgb  # noqa: E402
from peer import Missing  # noqa: E402
from peer_mitsuba import modules  # noqa: E402
from renderer_mitsuba import dark, emitters, matt  # noqa: E402
from renderer_povray import color, exposed, lamp, shapes, texture, vector  # noqa: E402
from vectors import add, cross, length, mul, sub, unit  # noqa: E402

SCENES = [
    "plane-mirror", "facing-mirrors", "mirror-ball", "schlick-ball", "coat", "metal-ball", "glass-ball", "ball-in-ball",
    "glass-cube", "pane", "even-sky",
]

# What Mitsuba's loop does not follow any more.
LEAST = 1e-12

# Mitsuba's rays start 1e-4 m off a surface and more, which moves all that they see. In a second run they start so many metres
# off it.
CLOSER = 4e-6

# Rays by chance that are followed at once, of each pixel.
AT_ONCE = 64

# POV-Ray has no sheets without thickness: a pane is a slab of glass as thick as this, in metres, and a world of millimetres,
# since it leaves out what is within 1e-4 units of where a ray starts.
SLAB, IN_POVRAY = 1e-5, 1e3

# A pixel that differs by more is one where rays have gone another way.
ANOTHER_WAY = 1e-3


def legible(path):
    """A scene with its claim, its depth, and for each glass the index around it."""
    text = path.read_text()
    said = tomllib.loads(text)
    scene = described(said, path.parent)
    scene.claim = text.splitlines()[0].removeprefix("# ")
    scene.depth = said["image"]["max_depth"]
    for material in scene.materials.values():
        material.around = 1.0
    # Of balls one in another Mitsuba wants to know what is around the inner one.
    glass = [o for o in scene.objects if o.kind == "sphere" and scene.materials[o.material].model == "glass"]
    for inner in glass:
        for outer in glass:
            if outer is not inner and length(sub(outer.center, inner.center)) + inner.radius < outer.radius:
                scene.materials[inner.material].around = scene.materials[outer.material].keys["n"]
    return scene


def bsdf(material):
    """A material in Mitsuba's words."""
    keys = material.keys
    if keys.get("schlick"):
        raise Refused("differs: it has no reflectance by Schlick's formula")
    if material.model == "phong" and "reflectance" in keys:
        # A mirror's weight comes out as (w + (1 − w) f cos θ) / (w + (1 − w) p), with f and p of the matt surface.
        raise Refused("differs: its `blendbsdf` adds the densities of a mirror and a matt surface")
    if material.model == "mirror":
        reflectance = {"type": "rgb", "value": rgb(keys["reflectance"])}
        return {"type": "twosided", "nested": {"type": "conductor", "material": "none", "specular_reflectance": reflectance}}
    if material.model == "metal":
        flat = lambda value: {"type": "spectrum", "value": float(value)}
        return {"type": "twosided", "nested": {"type": "conductor", "eta": flat(keys["n"]), "k": flat(keys["k"])}}
    if material.model == "glass":
        return {"type": "dielectric", "int_ior": float(keys["n"]), "ext_ior": float(material.around)}
    if material.model == "pane":
        return {"type": "thindielectric", "int_ior": float(keys["n"]), "ext_ior": 1.0}
    return matt(material)


class Mitsuba:
    """Follows rays through Mitsuba's own shapes and materials, and adds the light of lamps at the first matt surface.

    Its integrator `path` would add the light that matt surfaces throw onto each other. Its `max_depth` would be that of candela
    and two more: it counts the matt surface and the lamp as well.
    """

    def __init__(self, scene, closer):
        mitsuba, drjit, numpy = modules()
        self.mi, self.dr, self.np = mitsuba, drjit, numpy
        self.scene, self.closer = scene, closer
        # What rays see that meet nothing is added here: as an emitter it would light things.
        sky = SimpleNamespace(**(vars(scene) | {"background": [0.0] * 3}))
        said = dark(mitsuba, numpy, sky, {"type": "independent"}, bsdf)
        said |= {f"light_{number}": light for number, light in enumerate(emitters(mitsuba, scene))}
        self.world = mitsuba.load_dict(said)
        kinds = mitsuba.BSDFFlags
        self.ways = [kinds.DeltaReflection, kinds.DeltaTransmission | kinds.Null]

    def lit(self, si, where):
        """The light of all lamps that matt surfaces send back."""
        mi, dr = self.mi, self.dr
        bsdf, context, total = si.bsdf(), mi.BSDFContext(), mi.Color3f(0)
        for emitter in self.world.emitters():
            sample, light = emitter.sample_direction(si, mi.Point2f(0.5), where)
            free = where & ~self.world.ray_test(si.spawn_ray_to(sample.p), where)
            total += dr.select(free, bsdf.eval(context, si, si.to_local(sample.d), free) * light, 0)
        return total

    def meet(self, origins, directions):
        """What is where rays meet something, and what they see there or in the background."""
        mi, dr, np = self.mi, self.dr, self.np
        origins, directions = (mi.Vector3f(*np.asarray(part, np.float32).T) for part in (origins, directions))
        si = self.world.ray_intersect(mi.Ray3f(mi.Point3f(origins), directions))
        flags = si.bsdf().flags()
        is_lit = si.is_valid() & mi.has_flag(flags, mi.BSDFFlags.Smooth)
        seen = dr.select(si.is_valid(), self.lit(si, is_lit), mi.Color3f(*self.scene.background))
        return si, si.is_valid() & mi.has_flag(flags, mi.BSDFFlags.Delta), np.array(seen, dtype=np.float64).T

    def onwards(self, si, smooth, way, drawn):
        """The rays that go on from there: origins, directions, and how much of each arrives."""
        mi, dr, np = self.mi, self.dr, self.np
        context = mi.BSDFContext()
        if way is not None:
            context.type_mask = way
        sample, weight = si.bsdf().sample(context, si, drawn, mi.Point2f(0.5), smooth)
        direction = si.to_world(sample.wo)
        if self.closer:
            start = si.p + si.n * dr.mulsign(mi.Float(CLOSER), dr.dot(si.n, direction))
        else:
            start = si.spawn_ray(direction).o
        parts = (start, direction, dr.select(smooth, weight, 0))
        return [np.array(part, dtype=np.float64).T for part in parts]

    def followed(self, each=1, chance=None):
        """The radiance along rays through the middle of each pixel: both ways at each surface, or one by chance."""
        np = self.np
        origins, directions = (np.repeat(np.array(part), each, axis=0) for part in zip(*rays(self.scene)))
        weights, numbers = np.ones((len(origins), 3)), np.arange(len(origins))
        total = np.zeros((len(origins), 3))
        for depth in range(self.scene.depth + 1):
            si, smooth, seen = self.meet(origins, directions)
            np.add.at(total, numbers, weights * seen)
            parts = []
            for way in self.ways if chance is None else [None]:
                drawn = self.mi.Float(0.5 if chance is None else chance.random(len(numbers), dtype=np.float32))
                *ray, weight = self.onwards(si, smooth, way, drawn)
                weight = weight * weights
                kept = weight.max(axis=1) > LEAST
                parts.append([part[kept] for part in (*ray, weight, numbers)])
            origins, directions, weights, numbers = (np.concatenate(part) for part in zip(*parts))
            if not len(numbers):
                break
        return total.reshape(-1, each, 3)

    def whole(self):
        """Both ways at each surface: without noise."""
        return self.followed()[:, 0]

    def drawn(self, each):
        """One way by chance, so many times a pixel: the mean, and its standard error."""
        np = self.np
        chance = np.random.default_rng(1)
        sums, squares = 0.0, 0.0
        for _ in range(each // AT_ONCE):
            found = self.followed(AT_ONCE, chance)
            sums, squares = sums + found.sum(axis=1), squares + (found**2).sum(axis=1)
        mean = sums / each
        return mean, np.sqrt(np.maximum(squares / each - mean**2, 0) / (each - 1))


def finish(material):
    """A material in POV-Ray's words."""
    keys = material.keys
    if material.model in ("glass", "pane"):
        return (
            "texture { pigment { rgbt 1 } finish { ambient 0 diffuse 0 reflection { 0, 1 fresnel on } conserve_energy } } "
            f"interior {{ ior {keys['n']:.17g} }}"
        )
    if material.model == "metal":
        raise Refused("differs: it has no n + ik")
    if "reflectance" not in keys:
        return texture(material)
    reflectance = rgb(keys["reflectance"])
    reflection = f"{{ {color(reflectance)}, 1 falloff 5 }}" if keys.get("schlick") else color(reflectance)
    # What is below a coat POV-Ray leaves as it is.
    if material.model == "phong" and keys.get("schlick"):
        raise Refused("differs: its coats leave the lobes as they are")
    diffuse = mul(material.diffuse, 1 - reflectance[0]) if material.model == "phong" else [0.0] * 3
    return f"texture {{ pigment {{ {color(diffuse)} }} finish {{ ambient 0 diffuse 1 reflection {reflection} }} }}"


def slab(triangles):
    """A flat sheet made as thick as POV-Ray needs it: two faces, and a wall along each edge of the outline."""
    a, b, c = triangles[0][0]
    aside = mul(unit(cross(sub(b, a), sub(c, a))), SLAB * IN_POVRAY / 2)
    front = [[add(corner, aside) for corner in corners] for corners, _ in triangles]
    back = [[sub(corner, aside) for corner in corners] for corners, _ in triangles]
    edges = [(c[i], c[(i + 1) % 3]) for c, _ in triangles for i in range(3)]
    rim = [(p, q) for p, q in edges if (q, p) not in edges]
    wall = lambda p, q: [[add(p, aside), sub(p, aside), sub(q, aside)], [add(p, aside), sub(q, aside), add(q, aside)]]
    return front + back + [triangle for edge in rim for triangle in wall(*edge)]


def solids(objects, name, said):
    """Objects of a material. POV-Ray's glass lets shadow rays pass: it has a twin that only they see."""
    model = said[name].model
    if model not in ("glass", "pane"):
        return [shape for object_ in objects for shape in shapes(object_, finish(said[name]))]
    lines = []
    for object_ in [o for o in objects if o.kind == "sphere"]:
        lines.append(f"sphere {{ {vector(object_.center)}, {object_.radius:.17g} ")
    triangles = [triangle for o in objects if o.kind == "triangles" for triangle in o.triangles]
    if triangles:
        corners = slab(triangles) if model == "pane" else [corners for corners, _ in triangles]
        listed = " ".join(f"triangle {{ {', '.join(map(vector, three))} }}" for three in corners)
        lines.append(f"mesh {{ {listed} inside_vector <0.1, 0.9, 0.2> ")
    twin = "pigment { rgb 0 } finish { ambient 0 diffuse 0 } no_image no_reflection }"
    bodies = [line + finish(said[name]) + " no_shadow }" for line in lines]
    return bodies + [line + twin for line in lines if model == "glass"]


def larger(scene, factor):
    """The scene with all its lengths times a factor, and the same picture."""
    grown = SimpleNamespace(**vars(scene))
    grown.camera = SimpleNamespace(**(vars(scene.camera) | {"eye": mul(scene.camera.eye, factor)}))
    grown.camera.look_at = mul(scene.camera.look_at, factor)
    grown.lights = [
        SimpleNamespace(**(vars(l) | {"position": mul(l.position, factor), "intensity": mul(l.intensity, factor**2)}))
        for l in scene.lights
    ]
    grown.objects = []
    for o in scene.objects:
        if o.kind == "sphere":
            more = {"center": mul(o.center, factor), "radius": o.radius * factor}
        else:
            more = {"triangles": [([mul(corner, factor) for corner in corners], n) for corners, n in o.triangles]}
        grown.objects.append(SimpleNamespace(**(vars(o) | more)))
    return grown


def povray(scene, peak):
    if shutil.which("povray") is None:
        raise Missing("POV-Ray is not there (Debian: povray)")
    depth = scene.depth
    if any(material.model == "pane" for material in scene.materials.values()):
        # Between the faces of a slab light goes to and fro.
        depth += 40
        scene = larger(scene, IN_POVRAY)
    size = min((length(sub(light.position, scene.camera.look_at)) for light in scene.lights), default=1)
    lines = [lamp(light, size) for light in scene.lights]
    for name in scene.materials:
        lines += solids([o for o in scene.objects if o.material == name], name, scene.materials)
    # The ray of the camera is the first of its levels.
    return exposed(scene, None, peak, f"max_trace_level {depth + 1} adc_bailout 0", lines)


class Compared:
    """How far a picture is from candela's: of each pixel the largest difference, as the conformance suite measures it."""

    def __init__(self, np, own, other, width):
        self.np = np
        floor = 1e-3 * own.max()
        self.errors = np.abs(own - other).max(axis=1) / np.maximum(own.max(axis=1), floor)
        self.places = [(i % width, i // width) for i in np.argsort(-self.errors) if self.errors[i] > ANOTHER_WAY]
        self.own, self.other, self.width = own, other, width

    def __str__(self):
        short = lambda number: f"{number:.1e}".replace("e-0", "e-").replace("e+00", "")
        return f"{short(self.errors.mean())}, {short(self.errors.max())}, {len(self.places)}"

    def told(self, who):
        for x, y in self.places:
            i = y * self.width + x
            print(f"    {x},{y} candela {self.own[i]} {who} {self.other[i]}")


def compare(name, options):
    """A row of the table."""
    import numpy as np

    path = HERE / "mirrors" / f"{name}.toml"
    scene = legible(path)
    flat = lambda channels: np.array([channels[channel] for channel in "RGB"], dtype=np.float64).T
    own = flat(renderer_candela.render(path, options.program, 0))
    row = [f"`{name}`", scene.claim]

    def column(who, picture):
        try:
            compared = Compared(np, own, picture(), scene.width)
        except (Refused, Missing) as reason:
            row.append(str(reason))
            return
        row.append(str(compared))
        if options.pixels:
            compared.told(who)

    column("Mitsuba", lambda: Mitsuba(scene, False).whole())
    column("Mitsuba, closer", lambda: Mitsuba(scene, True).whole())
    try:
        mean, error = Mitsuba(scene, True).drawn(options.chance)
        # Where there is noise at all.
        noisy = error > 1e-6 * own.max()
        within = (np.abs(mean - own) <= 3 * error)[noisy]
        row.append(f"{100 * within.mean():.1f} %" if noisy.any() else "–")
    except (Refused, Missing):
        row.append("–")
    column("POV-Ray", lambda: flat(povray(scene, own.max())))
    print(f"| {' | '.join(row)} |", flush=True)
    if options.pixels and name == "even-sky":
        print(f"    candela is within {np.abs(own - 1).max():.1e} of 1")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="*", help="by name; all without")
    parser.add_argument("--program", help="candela; the newest build without")
    parser.add_argument("--chance", type=int, default=1024, help="rays of a pixel that Mitsuba draws by chance (1024)")
    parser.add_argument("--pixels", action="store_true", help=f"tell the pixels that differ by more than {ANOTHER_WAY:g}")
    options = parser.parse_args()
    print("| scene | claim | Mitsuba 3 | the same, rays start closer | by chance | POV-Ray 3.7 |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name in options.scene or SCENES:
        compare(name, options)


if __name__ == "__main__":
    main()
