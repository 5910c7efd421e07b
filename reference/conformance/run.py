#!/usr/bin/env python3
"""Renders the conformance suite with a program and scores it against the expected pictures.

    reference/conformance/run.py --renderer candela
    reference/conformance/run.py --renderer povray --program /usr/bin/povray phong-50 phong-1
    reference/conformance/run.py --renderer mitsuba      (with a Python that has `mitsuba`)
    reference/conformance/run.py --renderer radiance     (with a Python that has `pyradiance`)

The exit code is 0 where every case that the renderer can express is within its tolerance, else 1.
docs/conformance.md says how a renderer is added.
"""

import argparse
import importlib
import json
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import exr
from described import Refused, described

HERE = Path(__file__).resolve().parent
RENDERERS = ["candela", "mitsuba", "povray", "radiance"]

# Below this part of the picture's peak, errors are relative to that.
FLOOR = 1e-3


def score(width, height, actual, expected):
    """The largest error of a pixel, and where."""
    peak = max(abs(number) for channel in "RGB" for number in expected[channel])
    worst, place = 0.0, None
    for i in range(width * height):
        scale = max([abs(expected[channel][i]) for channel in "RGB"] + [FLOOR * peak])
        error = max(abs(actual[channel][i] - expected[channel][i]) for channel in "RGB") / scale
        # Alpha counts where the renderer has one.
        if "A" in actual:
            error = max(error, abs(actual["A"][i] - expected["A"][i]))
        if not error <= worst:
            worst, place = error, (i % width, i // width)
    return worst, place


def judged(case, renderer, options):
    """The row of a case, and its pixels as lines."""
    name = case["name"]
    # The last digit of what it writes is not its mistake.
    tolerance = (options.tolerance or case["tolerance"]) + getattr(renderer, "LAST_BIT", 0)
    path = HERE / f"{name}.toml"
    width, height, expected = exr.read(HERE / f"{name}.exr")
    row = {"case": name, "tolerance": tolerance}
    try:
        # candela reads the file itself; all others get what it says in plain words.
        scene = path if options.renderer == "candela" else described(tomllib.loads(path.read_text()), HERE)
        peak = max(abs(number) for channel in "RGB" for number in expected[channel])
        actual = renderer.render(scene, options.program, peak)
    except Refused as reason:
        return row | {"verdict": "not expressible", "reason": str(reason)}, []
    worst, place = score(width, height, actual, expected)
    row |= {"verdict": "pass" if worst <= tolerance else "FAIL", "error": worst, "pixel": place}
    lines = []
    for i in range(width * height):
        rgb = ",".join(f"{actual[channel][i]:.8g}" for channel in "RGB")
        lines.append(f"{name},{i % width},{i // width},{rgb}\n")
    return row, lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--renderer", required=True, choices=RENDERERS)
    parser.add_argument("--program", help="its executable, if it is not found by its name")
    parser.add_argument("--tolerance", type=float, help="in place of each case's own")
    parser.add_argument("--json", metavar="FILE", help="also writes the scores")
    parser.add_argument("--values", metavar="FILE", help="also writes the pixels, as lines of case,x,y,R,G,B")
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time")
    parser.add_argument("case", nargs="*", help="some cases by name; all without")
    options = parser.parse_args()
    renderer = importlib.import_module(f"renderer_{options.renderer}")
    suite = json.loads((HERE / "suite.json").read_text())
    unknown = set(options.case) - {case["name"] for case in suite}
    if unknown:
        parser.error(f"no case is called {', '.join(sorted(unknown))}")
    chosen = [case for case in suite if not options.case or case["name"] in options.case]
    rows, values = [], []
    with ThreadPoolExecutor(options.jobs) as pool:
        for row, lines in pool.map(lambda case: judged(case, renderer, options), chosen):
            rows.append(row)
            values += lines
            error = f"{row['error']:.1e}" if "error" in row else ""
            place = f"at {row['pixel'][0]},{row['pixel'][1]}" if row.get("pixel") else ""
            columns = f"{row['case']:30} {error:>8} {row['tolerance']:8.0e}  {row['verdict']:15}"
            print(f"{columns} {row.get('reason') or place}".rstrip(), flush=True)
    count = lambda verdict: sum(row["verdict"] == verdict for row in rows)
    print(
        f"\n{options.renderer}: {count('pass')} pass, {count('FAIL')} fail, "
        f"{count('not expressible')} not expressible, of {len(rows)}"
    )
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=1) + "\n")
    if options.values:
        head = f"# Made by reference/conformance/run.py --renderer {options.renderer}.\ncase,x,y,R,G,B\n"
        Path(options.values).write_text(head + "".join(values))
    return 1 if count("FAIL") else 0


if __name__ == "__main__":
    sys.exit(main())
