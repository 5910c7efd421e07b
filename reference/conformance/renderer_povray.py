"""POV-Ray 3.7, whose `phong` is L7 to the letter.

Pictures come as PPM of 16 bits without gamma, in exposures a factor of 4 apart; of each pixel the
brightest one counts that does not clip.
"""

import shutil
import subprocess
import tempfile
from math import pi, radians, tan
from pathlib import Path

from described import Refused
from vectors import dot, length, mul, sub

STEP = 4.0
EXPOSURES = 6
BRIGHTEST = 0.98
# Half a code of 16 bits, of the darkest that another exposure does not show better.
LAST_BIT = 0.5 / 65535 / (BRIGHTEST / STEP)


def vector(v):
    return "<" + ", ".join(f"{x:.17g}" for x in v) + ">"


def color(v):
    return f"rgb {vector(v)}"


def texture(material):
    if material.model == "normalized_phong":
        if any(material.specular):
            raise Refused("a specular lobe with a cosine")
        return f"texture {{ pigment {{ {color(mul(material.diffuse, 1 / pi))} }} finish {{ ambient 0 diffuse 1 }} }}"
    if len(set(material.specular)) > 1:
        raise Refused("a colored specular lobe")
    return (
        f"texture {{ pigment {{ {color(material.diffuse)} }} finish {{ ambient 0 diffuse 1 "
        f"phong {material.specular[0]:.17g} phong_size {material.shininess:.17g} }} }}"
    )


def camera(scene):
    seen, aspect = scene.camera, scene.width / scene.height
    tall = seen.size if seen.kind == "orthographic" else 2 * tan(radians(seen.size) / 2)
    kind = "orthographic " if seen.kind == "orthographic" else ""
    return (
        f"camera {{ {kind}location {vector(seen.eye)} direction {vector(seen.forward)} "
        f"right {vector(mul(seen.right, tall * aspect))} up {vector(mul(seen.up, tall))} }}"
    )


def lamp(light, size):
    # 2/(1 + (d/f)²) · I/(2 f²) = I/(f² + d²)
    fade = 1e-5 * size
    strength = color(mul(light.intensity, 1 / (2 * fade * fade))) + " * gain"
    spot = ""
    if light.kind == "spot":
        if light.falloff != "smooth":
            raise Refused(f"the falloff {light.falloff}")
        spot = f"spotlight point_at {vector(light.look_at)} radius {light.inner:.17g} falloff {light.outer:.17g} tightness 0 "
    return (
        f"light_source {{ {vector(light.position)} {strength} {spot}"
        f"fade_power 2 fade_distance {fade:.17g} }}"
    )


def shapes(object_, finish):
    if object_.kind == "sphere":
        yield f"sphere {{ {vector(object_.center)}, {object_.radius:.17g} {finish} }}"
    elif object_.kind == "plane":
        n = object_.normal
        yield f"plane {{ {vector(n)}, {dot(n, object_.point):.17g} {finish} }}"
    else:
        for corners, normals in object_.triangles:
            if normals is None:
                yield f"triangle {{ {', '.join(map(vector, corners))} {finish} }}"
            else:
                pairs = ", ".join(f"{vector(v)}, {vector(n)}" for v, n in zip(corners, normals))
                yield f"smooth_triangle {{ {pairs} {finish} }}"


def picture(path):
    """R, G, B of a PPM of 16 bits, from 0 to 1."""
    data = path.read_bytes()
    words, at = [], 0
    while len(words) < 4:
        while data[at : at + 1].isspace() or data[at : at + 1] == b"#":
            at = data.index(b"\n", at) + 1 if data[at : at + 1] == b"#" else at + 1
        end = at
        while not data[end : end + 1].isspace():
            end += 1
        words.append(data[at:end])
        at = end
    at += 1
    largest = int(words[3])
    numbers = [int.from_bytes(data[i : i + 2], "big") / largest for i in range(at, len(data) - 1, 2)]
    return [numbers[i::3] for i in range(3)]


def render(scene, program, peak):
    size = min(length(sub(light.position, scene.camera.look_at)) for light in scene.lights)
    finish = {name: texture(material) for name, material in scene.materials.items()}
    lines = [lamp(light, size) for light in scene.lights]
    lines += [shape for object_ in scene.objects for shape in shapes(object_, finish[object_.material])]
    return exposed(scene, program, peak, "max_trace_level 1", lines)


def exposed(scene, program, peak, settings, contents):
    """The picture of lamps and solids that are said in POV-Ray's words."""
    program = program or shutil.which("povray")
    if program is None:
        raise SystemExit("povray is not there; Debian has it as the package povray")
    result = [[None] * (scene.width * scene.height) for _ in range(3)]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        lines = ["#version 3.7;", f"global_settings {{ assumed_gamma 1 {settings} }}"]
        # A frame an exposure.
        lines += [f"#declare gain = {0.9 / peak:.17g} * pow({STEP:g}, frame_number - 1);", camera(scene)]
        lines += [f"background {{ {color(scene.background)} * gain }}"] + contents
        (folder / "scene.pov").write_text("\n".join(lines) + "\n")
        subprocess.run(
            [program, "scene.pov", "+Oout.ppm", "+FP16", "File_Gamma=1", "Dither=off", "-A", "-J", "-D",
             f"+W{scene.width}", f"+H{scene.height}", f"+KFF{EXPOSURES}", "Work_Threads=1"],
            cwd=folder, check=True, capture_output=True,
        )
        for exposure, path in enumerate(sorted(folder.glob("out*.ppm"))):
            gain = 0.9 / peak * STEP**exposure
            channels = picture(path)
            for i in range(scene.width * scene.height):
                if exposure == 0 or all(channel[i] < BRIGHTEST for channel in channels):
                    for channel, whole in zip(channels, result):
                        whole[i] = channel[i] / gain
    return dict(zip("RGB", result))
