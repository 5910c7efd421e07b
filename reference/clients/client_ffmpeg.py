"""FFmpeg: the program `ffmpeg`, or that of PyPI's imageio-ffmpeg. FFMPEG names another."""

import os
import re
import shutil
import subprocess

import numpy as np

from handed import arguments, hand_back, not_here


def program():
    named = os.environ.get("FFMPEG") or shutil.which("ffmpeg")
    if named:
        return named
    try:
        import imageio_ffmpeg
    except ImportError as error:
        not_here(error)
    return imageio_ffmpeg.get_ffmpeg_exe()


path, folder, layers = arguments()
ffmpeg = program()
version = subprocess.run([ffmpeg, "-version"], capture_output=True, text=True).stdout.split()[2]
planes, notes = {}, []
for layer in ["", *layers]:
    pick = ["-layer", layer] if layer else []
    # In the format of its own decoder: what FFmpeg converts has no more than 16 bits on the way.
    run = subprocess.run([ffmpeg, "-hide_banner", *pick, "-i", path, "-f", "rawvideo", "-"], capture_output=True)
    said = run.stderr.decode(errors="replace")
    found = re.search(r"Video: exr, (gbrap|gbrp|gray)f(16|32)le.*?, (\d+)x(\d+)", said)
    if run.returncode or not found or not run.stdout:
        trouble = [line.split("] ")[-1] for line in said.splitlines() if "not implemented" in line or "rror" in line]
        notes.append(f"{layer or 'picture'}: {trouble[0] if trouble else 'no picture'}")
        continue
    kind, bits, width, height = found[1], *map(int, found.groups()[1:])
    names = {"gbrap": "GBRA", "gbrp": "GBR", "gray": "Y"}[kind]
    for name, plane in zip(names, np.frombuffer(run.stdout, f"<f{bits // 8}").reshape(len(names), height, width)):
        planes[f"{layer}.{name}" if layer else name] = plane
if not planes:
    raise SystemExit("; ".join(notes))
hand_back(folder, f"FFmpeg {version}", planes, note="; ".join(notes))
