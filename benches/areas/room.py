"""scenes/room.toml in Mitsuba 3 and on Embree, to be timed and compared with candela.

    pip install mitsuba numpy
    python benches/areas/room.py render OUT.exr --spp 256
    python benches/areas/room.py measure REFERENCE.exr --candela target/release/candela

`render` makes one picture with Mitsuba. `measure` renders with ever more samples, all programs in turn, and prints the
error of each against REFERENCE.exr as a share of its mean, the median of the seconds, and the time to --target that a
straight line through log error over log time gives.

All of the scene is read from the file, but only what room.toml has is known: planes, triangles, spheres, matt `phong`
and one rectangle that shines. candela's k_d is the albedo over pi, and its luminance is Mitsuba's radiance.
"""

import argparse
import functools
import json
import math
import os
import resource
import statistics
import struct
import subprocess
import tempfile
import time
import tomllib
from pathlib import Path

import mitsuba as mi
import numpy as np

ROOM = Path(__file__).parents[2] / "scenes" / "room.toml"

# The room is 2 m x 2 m x 6 m: planes as squares of this half side reach past it.
FAR = 8.0


def frame(point, normal, up, half):
    """A rectangle of half sides `half` around a point."""
    point, normal, up = (np.array(v, dtype=float) for v in (point, normal, up))
    transform = mi.ScalarTransform4f().look_at(
        origin=point.tolist(), target=(point + normal).tolist(), up=up.tolist()
    )
    return transform @ mi.ScalarTransform4f().scale([half[0], half[1], 1])


def across(normal):
    return [0, 0, 1] if abs(normal[1]) > 0.5 else [0, 1, 0]


def scene(resolution, integrator, sampler, spp):
    room = tomllib.loads(ROOM.read_text())
    materials = {}
    for name, material in room["materials"].items():
        diffuse = material["phong"]["diffuse"]
        diffuse = diffuse if isinstance(diffuse, list) else [diffuse] * 3
        color = {"type": "rgb", "value": [math.pi * k for k in diffuse]}
        materials[name] = {"type": "diffuse", "reflectance": color}

    camera = room["camera"]["perspective"]
    made = {
        "type": "scene",
        "integrator": integrator,
        "sensor": {
            "type": "perspective",
            "fov": camera["vertical_fov"],
            "fov_axis": "y",
            "near_clip": 0.01,
            "far_clip": 100.0,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=camera["eye"], target=camera["look_at"], up=[0, 1, 0]
            ),
            "film": {
                "type": "hdrfilm",
                "width": resolution[0],
                "height": resolution[1],
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": sampler, "sample_count": spp},
        },
    }
    for name, light in room["lights"].items():
        light = light["rectangle"]
        half = [side / 2 for side in light["size"]]
        radiance = {"type": "rgb", "value": light["luminance"]}
        made["light_" + name] = {
            "type": "rectangle",
            "to_world": frame(light["center"], light["direction"], across(light["direction"]), half),
            "emitter": {"type": "area", "radiance": radiance},
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0, 0, 0]}},
        }

    triangles = {}
    for name, shape in room["objects"].items():
        if "plane" in shape:
            plane = shape["plane"]
            made[name] = {
                "type": "rectangle",
                "to_world": frame(plane["point"], plane["normal"], across(plane["normal"]), [FAR, FAR]),
                "bsdf": materials[plane["material"]],
            }
        elif "sphere" in shape:
            sphere = shape["sphere"]
            made[name] = {
                "type": "sphere",
                "center": sphere["center"],
                "radius": sphere["radius"],
                "bsdf": materials[sphere["material"]],
            }
        else:
            triangle = shape["triangle"]
            # A box for each word that their names begin with, so that its outside is known.
            corners = triangles.setdefault((name.split("_")[0], triangle["material"]), [])
            corners.append(triangle["vertices"])
    for (name, material), corners in triangles.items():
        made[name] = box(name, np.array(corners, dtype=float), materials[material])
    return mi.load_dict(made)


def box(name, corners, material):
    """A mesh of triangles whose front is outside."""
    center = corners.reshape(-1, 3).mean(axis=0)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    is_inside = ((corners[:, 0] - center) * normals).sum(axis=1) < 0
    corners[is_inside] = corners[is_inside][:, ::-1]
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(material)
    mesh = mi.Mesh(name, 3 * len(corners), len(corners), props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = corners.ravel().astype(np.float32)
    parameters["faces"] = np.arange(3 * len(corners), dtype=np.uint32)
    parameters.update()
    return mesh


INTEGRATORS = {
    "light": lambda n: {"type": "direct", "emitter_samples": n, "bsdf_samples": 0},
    "both": lambda n: {"type": "direct", "emitter_samples": n, "bsdf_samples": n},
    "path": lambda n: {"type": "path", "max_depth": 2},
}


class Mitsuba:
    """The room with so many samples a pixel, and so many points of the light a sample."""

    def __init__(self, options, spp, seed=0):
        integrator = INTEGRATORS[options.integrator](options.points)
        # Mitsuba itself parts what would be too much at once.
        if options.per_pass and spp > options.per_pass:
            integrator["samples_per_pass"] = options.per_pass
        self.scene = scene(options.resolution, integrator, options.sampler, spp)
        self.spp, self.seed = spp, seed
        self.render()  # The first one compiles.

    def render(self):
        """An image, its seconds, and those of all processors."""
        self.seed += 1
        start, start_all = time.perf_counter(), time.process_time()
        image = mi.render(self.scene, spp=self.spp, seed=self.seed)
        image = np.array(image)
        seconds, all_seconds = time.perf_counter() - start, time.process_time() - start_all
        return image.astype(np.float64), seconds, all_seconds


class Embree:
    """The room in benches/embree/panel.cpp, by points of the panel."""

    def __init__(self, options, folder):
        program, path = Path(folder) / "panel", Path(folder) / "panel.bin"
        source = ROOM.parents[1] / "benches" / "embree" / "panel.cpp"
        command = ["c++", "-std=c++17", "-O3", "-march=native", "-ffast-math", "-DEMBREE=%d" % options.embree]
        command += [source, "-o", program, "-lembree%d" % options.embree, "-lpthread"]
        subprocess.run(command, check=True)
        path.write_bytes(embree_scene(options.resolution))
        self.threads, self.size, self.folder = options.threads, options.resolution, folder
        pipe = subprocess.PIPE
        command = [program, path, str(options.threads)]
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)
        self.version = self.process.stdout.readline().split()[1]

    def ask(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise RuntimeError("the yardstick ended")
        return answer

    def render(self, samples, side, points):
        answer = self.ask("render %d %d %d %s" % (samples, self.threads, side, points))
        seconds, all_seconds = map(float, answer.split())
        path = Path(self.folder) / "panel.rgb"
        self.ask("save %s" % path)
        image = np.fromfile(path, dtype=np.float32).reshape(self.size[1], self.size[0], 3)
        return image.astype(np.float64), seconds, all_seconds


def embree_scene(resolution):
    """What panel.cpp reads."""
    room = tomllib.loads(ROOM.read_text())
    camera = room["camera"]["perspective"]
    eye = np.array(camera["eye"])
    forward = np.array(camera["look_at"]) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    pixel = 2 * math.tan(math.radians(camera["vertical_fov"]) / 2) / resolution[1]
    first = forward - right * pixel * resolution[0] / 2 + up * pixel * resolution[1] / 2
    data = [struct.pack("2I", *resolution)]

    def floats(*values):
        data.append(np.concatenate([np.ravel(value) for value in values]).astype(np.float32).tobytes())

    def counted(values, kind):
        values = np.ravel(values).astype(kind)
        data.append(struct.pack("I", len(values)) + values.tobytes())

    def vectors(values):
        values = np.asarray(values, dtype=np.float32).reshape(-1, 3)
        data.append(struct.pack("I", len(values)) + values.tobytes())

    def rectangle(center, normal, half):
        """A corner, two sides and the normal."""
        normal = np.array(normal, dtype=float)
        u = np.cross(across(normal), normal)
        v = np.cross(normal, u)
        u, v = 2 * half[0] * u, 2 * half[1] * v
        return np.array(center) - (u + v) / 2, u, v, normal

    def mesh(corners):
        vectors(corners)
        counted(np.arange(len(np.reshape(corners, (-1, 3)))), np.uint32)

    def quad(center, normal, half):
        a, u, v, _ = rectangle(center, normal, half)
        return [a, a + u, a + u + v, a, a + u + v, a + v]

    (light,) = (light["rectangle"] for light in room["lights"].values())
    half = [side / 2 for side in light["size"]]
    floats(eye, first, right * pixel, -up * pixel)
    floats(*rectangle(light["center"], light["direction"], half), light["luminance"])
    flat, spheres = {}, {}
    for shape in room["objects"].values():
        if "sphere" in shape:
            sphere = shape["sphere"]
            spheres.setdefault(sphere["material"], []).append([*sphere["center"], sphere["radius"]])
        elif "plane" in shape:
            plane = shape["plane"]
            flat.setdefault(plane["material"], []).extend(quad(plane["point"], plane["normal"], [FAR, FAR]))
        else:
            triangle = shape["triangle"]
            flat.setdefault(triangle["material"], []).extend(triangle["vertices"])
    data.append(struct.pack("I", 1 + len(flat) + len(spheres)))

    def part(kind, diffuse):
        data.append(struct.pack("I", kind))
        floats(diffuse if isinstance(diffuse, list) else [diffuse] * 3)

    part(2, 0.0)
    mesh(quad(light["center"], light["direction"], half))
    for material, corners in flat.items():
        part(1, room["materials"][material]["phong"]["diffuse"])
        mesh(corners)
    for material, values in spheres.items():
        part(0, room["materials"][material]["phong"]["diffuse"])
        counted(values, np.float32)
    return b"".join(data)


def read(path):
    rgb, float32 = mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32
    bitmap = mi.Bitmap(str(path)).convert(rgb, float32, srgb_gamma=False)
    return np.array(bitmap, dtype=np.float64)


def candela(options, arguments):
    """candela's image, the seconds that it takes to build trees and to render, and those of all processors, which have
    starting, loading and writing in them."""
    with tempfile.TemporaryDirectory() as folder:
        exr, stats = Path(folder) / "room.exr", Path(folder) / "room.json"
        size = "image.resolution=[%d, %d]" % tuple(options.resolution)
        command = [options.candela, "render", ROOM, "--quiet", "--compression", "none", "--set", size]
        command += ["--threads", str(options.threads), "-o", exr, "--stats", stats, *arguments]
        start = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run(command, check=True)
        all_seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - start
        seconds = json.loads(stats.read_text())["seconds"]
        return read(exr), seconds["build"] + seconds["render"], all_seconds


def error(image, reference, mask=None):
    """The root of the mean square of all channels, as a share of the reference's mean."""
    square = (image - reference) ** 2
    if mask is not None:
        square = square[mask]
    return math.sqrt(square.mean()) / reference.mean()


def beside_panel(reference):
    """False in the pixels around the edge of what is seen of the panel."""
    light = reference.max(axis=2)
    low, high = light.copy(), light.copy()
    for axis in (0, 1):
        for step in (-1, 1):
            low, high = np.minimum(low, np.roll(low, step, axis)), np.maximum(high, np.roll(high, step, axis))
    return high - low < 0.1 * light.max()


def time_to(target, rows, error_column, time_column):
    """By a line through log error over log time; and its slope."""
    errors, seconds = ([row[column] for row in rows] for column in (error_column, time_column))
    slope, start = np.polyfit(np.log(seconds), np.log(errors), 1)
    return math.exp((math.log(target) - start) / slope), slope


LINE = "rmse %.5f, without the panel's edge %.5f, %.3f s, of all processors %.3f s, mean %+.1e"


def measure(options):
    with tempfile.TemporaryDirectory() as folder:
        measure_in(options, folder)


def measure_in(options, folder):
    reference = read(options.reference)
    mask = beside_panel(reference)
    print("reference: mean %.6f; %d pixels at the edge of the panel" % (reference.mean(), (~mask).sum()))
    # Of each series, with ever more samples, what they are and how to render.
    series = {"Mitsuba": [(spp, Mitsuba(options, spp).render) for spp in options.spp]}
    if options.yardstick:
        embree = Embree(options, folder)
        print("Embree", embree.version)
        for text in options.yardstick:
            samples, side, points = text.split(",")
            render = functools.partial(embree.render, int(samples), int(side), points)
            series.setdefault("Embree, %s x %s %s" % (side, side, points), []).append((samples, render))
    if options.candela:
        for samples in options.samples:
            render = functools.partial(candela, options, ["--samples", str(samples)])
            series.setdefault("candela --samples", []).append((samples, render))
        for text in options.max_error:
            options_of = ["--max-error", "--error-floor", "--max-samples"]
            arguments = sum(map(list, zip(options_of, text.split("@"))), [])
            render = functools.partial(candela, options, arguments)
            series.setdefault("candela --max-error", []).append((text, render))
    found = {name: [] for name in series}
    for _ in range(options.runs):
        for name, renders in series.items():
            rows = []
            for what, render in renders:
                image, *seconds = render()
                errors = error(image, reference), error(image, reference, mask)
                rows.append((*errors, *seconds, image.mean() / reference.mean() - 1))
                print("%s, %s: %s" % (name, what, LINE % rows[-1]), flush=True)
            found[name].append(rows)
    for column, part in ((0, "whole image"), (1, "without the panel's edge")):
        print("\n%s, to %.2f %%, medians of %d" % (part, 100 * options.target, options.runs))
        for name, runs in found.items():
            if len(series[name]) > 1:
                seconds, slopes = zip(*(time_to(options.target, rows, column, 2) for rows in runs))
                of_all, _ = zip(*(time_to(options.target, rows, column, 3) for rows in runs))
                values = tuple(map(statistics.median, (seconds, of_all, slopes)))
                print("  %s: %.2f s, %.2f s of all processors; slope %.2f" % (name, *values))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--resolution", type=int, nargs=2, default=[1920, 1080])
    parser.add_argument("--integrator", choices=INTEGRATORS, default="light")
    parser.add_argument("--points", type=int, default=1, help="points of the light a sample")
    parser.add_argument("--sampler", default="multijitter")
    parser.add_argument("--per-pass", type=int, help="samples a pixel at a time")
    commands = parser.add_subparsers(dest="command", required=True)
    render = commands.add_parser("render")
    render.add_argument("output")
    render.add_argument("--spp", type=int, default=64)
    compare = commands.add_parser("measure")
    compare.add_argument("reference")
    compare.add_argument("--candela", help="the program")
    compare.add_argument("--spp", type=int, nargs="*", default=[16, 36, 64, 144, 256])
    compare.add_argument("--yardstick", nargs="*", default=[], help="such as 16,4,centers or 16,1,spread")
    compare.add_argument("--embree", type=int, choices=(3, 4), default=4)
    compare.add_argument("--samples", type=int, nargs="*", default=[1, 4, 16, 64])
    compare.add_argument("--max-error", nargs="*", default=[], help="such as 1%%, with a floor 1%%@0.3, with the most samples 1%%@0.3@16")
    compare.add_argument("--runs", type=int, default=3)
    compare.add_argument("--target", type=float, default=0.005)
    options = parser.parse_args()
    mi.set_variant(options.variant)
    if options.command == "render":
        image, seconds, _ = Mitsuba(options, options.spp).render()
        mi.Bitmap(image.astype(np.float32)).write(options.output)
        print("%.3f s" % seconds)
    else:
        measure(options)


if __name__ == "__main__":
    main()
