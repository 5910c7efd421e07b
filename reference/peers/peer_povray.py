"""POV-Ray 3.7 with its adaptive anti-aliasing, into OpenEXR."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from peer import Missing, setting
from renderer_povray import camera, color, lamp, shapes, texture
from vectors import length, sub

# Threshold of +A, and +R: rays across a pixel for +AM1, levels of subdivision for +AM2.
ADAPTIVE = {1: [(0.3, 2), (0.1, 3), (0.03, 4), (0.01, 6), (0.003, 9)], 2: [(0.3, 1), (0.1, 2), (0.03, 3), (0.01, 4), (0.003, 5)]}


class Peer:
    NAME, TITLE = "povray", "POV-Ray 3.7"

    def __init__(self, scene, options):
        self.scene, self.options = scene, options
        self.program = shutil.which("povray")
        if self.program is None:
            raise Missing("it is not there (Debian: povray)")
        self.folder = tempfile.TemporaryDirectory()
        folder = Path(self.folder.name)
        size = min(length(sub(light.position, scene.camera.look_at)) for light in scene.lights)
        finish = {name: texture(material) for name, material in scene.materials.items()}
        lines = ["#version 3.7;", "global_settings { assumed_gamma 1 max_trace_level 1 }", "#declare gain = 1;", camera(scene)]
        lines += [f"background {{ {color(scene.background)} }}"]
        lines += [lamp(light, size) for light in scene.lights]
        lines += [shape for object_ in scene.objects for shape in shapes(object_, finish[object_.material])]
        (folder / "scene.pov").write_text("\n".join(lines) + "\n")
        self.remarks = [
            "POV-Ray 3.7: +AM1 and +AM2 with +A and +R as said, without jitter; the trace time that it tells, to the millisecond; "
            "its EXR is of half floats"
        ]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.folder.cleanup()

    def settings(self, scene, options):
        for method, pairs in ADAPTIVE.items():
            series = f"POV-Ray 3.7 +AM{method}"
            for threshold, depth in pairs:
                flags = [f"+AM{method}", f"+A{threshold}", f"+R{depth}"]
                yield setting(series, f"+A{threshold} +R{depth}", f"A{threshold}", None, flags=flags)

    def render(self, setting):
        folder, scene = Path(self.folder.name), self.scene
        done = subprocess.run(
            [self.program, "scene.pov", "+Oout.exr", "+FE", "File_Gamma=1", "-J", "-D", *setting.flags,
             f"+W{scene.width}", f"+H{scene.height}", f"Work_Threads={self.options.threads}"],
            cwd=folder, check=True, capture_output=True, text=True,
        )
        told = re.search(r"Trace Time:.*\(([\d.]+) seconds\)", done.stdout + done.stderr)
        return float(told.group(1))

    def save(self, setting, path):
        shutil.copyfile(Path(self.folder.name) / "out.exr", path)
