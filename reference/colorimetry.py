#!/usr/bin/env python3
"""Makes the tables of colors in reference/ and the curves in scenes/curves/, by colour-science:

    tests/setup.sh
    target/colour-science/bin/python -W ignore reference/colorimetry.py

The same files to the byte each time, with the versions that the first line installs. Interpolation
and sums are colour-science's own, so that the tables judge candela independently of its code.
"""

import sys
from pathlib import Path

import colour
import numpy as np

VERSION = "0.4.7"

REFERENCE = Path(__file__).resolve().parent
CURVES = REFERENCE.parent / "scenes" / "curves"

SOURCE = [
    f"Made by reference/colorimetry.py with colour-science {VERSION},",
    "BSD-3-Clause, Copyright 2013 Colour Developers.",
]

# candela's grid, and the one that most of CIE's tables have.
FINE = colour.SpectralShape(360, 830, 1)
TABULATED = colour.SpectralShape(380, 780, 5)

OBSERVER = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
LUMENS_PER_WATT = 683
# Second radiation constant in m·K, exact since 2019: h c / k_B.
C2 = 1.438776877e-2
# The scale of temperature on which D50 … D75 got their names had c₂ = 0.014380.
D_SERIES_SCALE = 1.4388 / 1.4380

CHECKER_LIGHTS = ["D65", "A", "F2", "F11", "LED-B3", "HP1"]
METAMER_LIGHTS = ["D65", "A", "E", "F2", "F11", "LED-B3"]

D_SERIES = {"D50": 5000, "D55": 5500, "D65": 6500, "D75": 7500}
# The lamps by the names that scenes and colour-science call them.
LAMPS = {f"F{i}": f"FL{i}" for i in range(1, 13)}
LAMPS |= {f"LED-{kind}": f"LED-{kind}" for kind in "B1 B2 B3 B4 B5 BH1 RGB1 V1 V2".split()}
LAMPS |= {f"HP{i}": f"HP{i}" for i in range(1, 6)}
DAYLIGHTS = [4500, 5600, 9300]
BLACKBODIES = [2000, 3200, 5000, 10000]


def curve(wavelengths, values):
    return colour.SpectralDistribution(np.array(values), np.array(wavelengths))


def on(shape, sd):
    """Interpolated linearly, and constant beyond the curve's ends."""
    return sd.copy().align(
        shape,
        interpolator=colour.LinearInterpolator,
        extrapolator=colour.Extrapolator,
        extrapolator_kwargs={"method": "Constant", "left": None, "right": None},
    )


def lamp(sd):
    """One of CIE's lamps at 1 nm: constant beyond its table, straight in the first and the last step, and between all
    others cubic through the two points on each side. What would be below zero is taken from the larger of the two outer
    points."""
    table = sd[TABULATED.wavelengths]
    light = dict(zip(FINE.wavelengths, on(FINE, sd).values))
    for i in range(1, len(table) - 2):
        points = range(i - 1, i + 3)
        for part in range(1, 5):
            weights = colour.algebra.lagrange_coefficients(1 + part / 5, 4)
            value = sum(weights * table[i - 1 : i + 3])
            light[380 + 5 * i + part] = max(value, 0)
            outer = max(points[0], points[3], key=lambda j: table[j])
            light[380 + 5 * outer] += min(value, 0)
    return curve(list(light), list(light.values()))


def xyz(reflectance, light, shape):
    """CIE XYZ where a perfect white under this light has Y = 1."""
    return (
        colour.sd_to_XYZ(
            on(shape, reflectance),
            OBSERVER.copy().align(shape),
            on(shape, light),
            method="Integration",
            shape=shape,
        )
        / 100
    )


def white(light, shape):
    return xyz(colour.sd_ones(shape), light, shape)


def difference(a, b, light, shape):
    """ΔE00 of two reflectances to an eye adapted to the light."""
    adapted = colour.XYZ_to_xy(white(light, shape))
    labs = [colour.XYZ_to_Lab(xyz(sd, light, shape), adapted) for sd in (a, b)]
    return colour.delta_E(*labs, method="CIE 2000")


def daylight(temperature):
    """Daylight by the equations of CIE 15, with M1 and M2 rounded as there, at 5 nm."""
    return colour.sd_CIE_illuminant_D_series(
        colour.temperature.CCT_to_xy_CIE_D(temperature),
        M1_M2_rounding=True,
        shape=colour.SpectralShape(300, 830, 5),
    )


def lights():
    """Spectra by the names that scenes call them; those of A and E and the D series by equation."""
    tables = colour.SDS_ILLUMINANTS
    named = {
        "A": colour.sd_CIE_standard_illuminant_A(FINE),
        "A table": tables["A"],
        "E": colour.sd_ones(FINE),
    }
    for name, temperature in D_SERIES.items():
        named[name] = daylight(temperature * D_SERIES_SCALE)
        if name == "D65":
            named["D65 table"] = tables["D65"]
    named |= {name: lamp(tables[other]) for name, other in LAMPS.items()}
    named |= {f"daylight {t}": daylight(t) for t in DAYLIGHTS}
    named |= {f"blackbody {t}": colour.sd_blackbody(t, FINE, c2=C2) for t in BLACKBODIES}
    return named


def file_name(patch):
    """white 9.5 (.05 D) is white-9-5."""
    return patch.split(" (")[0].replace(" ", "-").replace(".", "-")


def checker():
    """The reflectances of the chart's patches, in its order, by the names of their files."""
    patches = colour.SDS_COLOURCHECKERS["cc_ohta"]
    return {file_name(patch): sd for patch, sd in patches.items()}


def metamers():
    """Two reflectances with one color under D65: a flat one, and with a metameric black added.

    The black is what is left of a cosine in the space that the observer does not see under D65
    (Cohen & Kappauf 1982: R is the projection onto the space that it sees).
    """
    light = on(TABULATED, colour.SDS_ILLUMINANTS["D65"])
    seen = OBSERVER.copy().align(TABULATED).values * light.values[:, None]
    wavelengths = TABULATED.wavelengths
    wave = np.cos(2 * np.pi * (wavelengths - 380) / 100)
    black = wave - seen @ np.linalg.solve(seen.T @ seen, seen.T @ wave)
    black *= 0.35 / np.max(np.abs(black))
    return {
        "metamer-a": curve(wavelengths, np.full(len(wavelengths), 0.4)),
        # As it is written, so that scene and tables mean the same curve.
        "metamer-b": curve(wavelengths, np.round(0.4 + black, 9)),
    }


def a_lamp(candela=100):
    """Illuminant A at 5 nm in W/(sr nm), with this luminous intensity on the 1 nm grid."""
    shape = colour.SpectralShape(360, 830, 5)
    light = colour.sd_CIE_standard_illuminant_A(shape)
    unscaled = LUMENS_PER_WATT * np.sum(on(FINE, light).values * OBSERVER.values[:, 1])
    return light * (candela / unscaled)


def write(path, comments, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [f"# {comment}" for comment in comments] + [",".join(row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_curve(path, comments, sd, form):
    rows = [(f"{nm:g}", form(value)) for nm, value in zip(sd.wavelengths, sd.values)]
    write(path, comments, rows)


def decimals(values, digits=9):
    return [f"{value:.{digits}f}" for value in values]


def write_curves(patches, pair):
    for name, sd in patches.items():
        comments = [
            f"Reflectance of the ColorChecker's patch {name}; nm, 0 to 1.",
            "Measured by Ohta (1997), as contained in colour-science.",
            *SOURCE,
        ]
        write_curve(CURVES / "colorchecker" / f"{name}.csv", comments, sd, "{:g}".format)
    for name, sd in pair.items():
        comments = [
            f"Reflectance of {name}, one of two that look the same under D65; nm, 0 to 1.",
            *SOURCE,
        ]
        write_curve(CURVES / f"{name}.csv", comments, sd, "{:.9g}".format)
    comments = [
        "A tungsten lamp: illuminant A with a luminous intensity of 100 cd; nm, W/(sr nm).",
        *SOURCE,
    ]
    write_curve(CURVES / "a-lamp.csv", comments, a_lamp(), "{:.10g}".format)


def write_checker(named, patches):
    rows = [("light", "patch", "X", "Y", "Z")]
    for light in CHECKER_LIGHTS:
        rows.append((light, "white", *decimals(white(named[light], FINE))))
        for patch, sd in patches.items():
            rows.append((light, patch, *decimals(xyz(sd, named[light], FINE))))
    comments = [
        "CIE XYZ (1931, 2°) of the ColorChecker and of scenes/curves/metamer-*.csv under six",
        "lights, relative: Y = 1 for the perfect white, which is the patch `white`. Sums at 1 nm,",
        "360 to 830 nm.",
        "Reflectances measured by Ohta (1997), as contained in colour-science.",
        *SOURCE,
    ]
    write(REFERENCE / "colorchecker.csv", comments, rows)


def write_illuminants(named):
    rows = [("light", "x", "y")]
    for name, sd in named.items():
        rows.append((name, *decimals(colour.XYZ_to_xy(white(sd, FINE)))))
    comments = [
        "CIE 1931 2° chromaticities of lights, from sums at 1 nm, 360 to 830 nm. Spectra: A by its",
        "equation at 1 nm; D50 to D75, at 1.4388/1.4380 times their nominal temperatures, and",
        "`daylight`, at the temperature as it stands, by those of CIE 15 at 5 nm; `blackbody` by",
        "Planck's law with c2 = 0.01438776877 m K at 1 nm; lamps from CIE's tables at 5 nm, cubic",
        "between their points. published-illuminants.csv has the CIE's own chromaticities of lamps.",
        *SOURCE,
    ]
    write(REFERENCE / "illuminants.csv", comments, rows)


def write_published():
    known = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]
    rows = [("light", "x", "y")]
    rows += [(name, *decimals(known[other], 4)) for name, other in LAMPS.items()]
    comments = [
        "CIE 1931 2° chromaticities of the CIE's lamps, as CIE 15:2018 publishes them. The sums of its",
        "tables at 5 nm, 380 to 780 nm, round to the same four decimals.",
        *SOURCE,
    ]
    write(REFERENCE / "published-illuminants.csv", comments, rows)


def write_metamers(named, pair):
    rows = [("light", "dE00_5nm", "dE00_1nm")]
    for name in METAMER_LIGHTS:
        differences = [
            difference(*pair.values(), named[name], shape)
            for shape in (TABULATED, FINE)
        ]
        rows.append((name, *decimals(differences, 4)))
    comments = [
        "How different scenes/curves/metamer-a.csv and metamer-b.csv look under six lights:",
        "CIEDE2000, the eye adapted to the light; sums at 5 nm, 380 to 780 nm, and at 1 nm,",
        "360 to 830 nm.",
        *SOURCE,
    ]
    write(REFERENCE / "metamers.csv", comments, rows)


def main():
    if colour.__version__ != VERSION:
        sys.exit(f"colorimetry.py: needs colour-science {VERSION}, not {colour.__version__}")
    named, patches, pair = lights(), checker(), metamers()
    write_curves(patches, pair)
    write_checker(named, patches | pair)
    write_illuminants(named)
    write_published()
    write_metamers(named, pair)


if __name__ == "__main__":
    main()
