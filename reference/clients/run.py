#!/usr/bin/env python3
"""Tries what other programs read of candela's EXRs, and prints a table:

    reference/clients/run.py --renderer target/release/candela

README.md beside this file says what each program needs. This script needs a Python with OpenEXR and numpy.
"""

import argparse
import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from files import FILES, make, stored
from handed import NOT_HERE
from verdicts import VERDICTS

HERE = Path(__file__).resolve().parent

# Seconds after which a program is ended.
PATIENCE = 180


@dataclass
class Client:
    """A program, the script that asks it, and what runs the script; `variable` of the environment names another."""

    name: str
    script: str
    variable: str
    runner: str = field(default=sys.executable)


CLIENTS = [
    Client("OpenImageIO", "client_openimageio.py", "PYTHON_OPENIMAGEIO"),
    Client("OpenEXR", "client_openexr.py", "PYTHON_OPENEXR"),
    Client("pyexr", "client_pyexr.py", "PYTHON_PYEXR"),
    Client("Blender 4.5", "client_blender.py", "PYTHON_BLENDER_45"),
    Client("Blender 5", "client_blender.py", "PYTHON_BLENDER_5"),
    Client("FFmpeg", "client_ffmpeg.py", "PYTHON_FFMPEG"),
    Client("OpenCV", "client_opencv.py", "PYTHON_OPENCV"),
    Client("Mitsuba", "client_mitsuba.py", "PYTHON_MITSUBA"),
    Client("three.js", "client_three.mjs", "NODE", "node"),
]


@dataclass
class Read:
    """What a program made of a file: `said` is read.json, or nothing where it refused or crashed."""

    said: dict | None
    planes: dict
    crash: str = ""
    refusal: str = ""


def asked(client, path, layers, size, folder):
    """What a client hands back of a file; None where its program is not here."""
    import numpy as np

    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("read.*"):
        old.unlink()
    runner = shlex.split(os.environ.get(client.variable, client.runner))
    command = [*runner, HERE / client.script, path, folder, json.dumps(layers), "x".join(map(str, size))]
    try:
        run = subprocess.run(command, capture_output=True, timeout=PATIENCE, env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"})
    except FileNotFoundError:
        return None
    except subprocess.TimeoutExpired:
        return Read(None, {}, crash=f"no end after {PATIENCE} s")
    (folder / "said.txt").write_bytes(run.stdout + run.stderr)
    if run.returncode == NOT_HERE:
        return None
    if (folder / "read.json").exists():
        said = json.loads((folder / "read.json").read_text())
        width, height = said["size"]
        values = np.fromfile(folder / "read.f32", "<f4").reshape(len(said["channels"]), height, width)
        return Read(said, dict(zip(said["channels"], values)))
    lines = (run.stderr or run.stdout).decode(errors="replace").strip().splitlines()
    last = lines[-1] if lines else ""
    if run.returncode < 0 or run.returncode > 128:
        number = -run.returncode if run.returncode < 0 else run.returncode - 128
        return Read(None, {}, crash=signal.Signals(number).name)
    return Read(None, {}, refusal=last or f"exit code {run.returncode}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renderer", required=True, type=Path, help="the program candela")
    parser.add_argument("--folder", type=Path, help="where files are kept [default: a temporary folder]")
    parser.add_argument("--client", action="append", help="only this program")
    parser.add_argument("--file", action="append", help="only this file")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.folder or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        files = [file for file in FILES if not options.file or file.name in options.file]
        made = {}
        for file in files:
            trouble = make(file, options.renderer.resolve(), folder)
            if trouble:
                print(f"{file.name}: not made: {trouble}", flush=True)
            else:
                made[file.name] = stored(folder / f"{file.name}.exr")
        for client in CLIENTS:
            if options.client and client.name not in options.client:
                continue
            program = client.name
            rows = []
            for file in files:
                if file.name not in made:
                    continue
                image = made[file.name]
                read = asked(client, folder / f"{file.name}.exr", image.layers, image.whole, folder / client.name / file.name)
                if read is None:
                    rows = ["not here"]
                    break
                program = read.said["program"] if read.said else program
                verdict, remark = VERDICTS[file.question](image, read)
                rows.append(f"{file.name:<22} {verdict:<8} {remark}".rstrip())
            print(f"\n{program}")
            for row in rows:
                print(f"    {row}", flush=True)


main()
