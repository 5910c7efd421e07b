//! More integrals over what one point sees of a light: what the oracle's quadrature says of them, written down.

use candela::oracle::Oracle;
use candela::scene::Scene;

use super::{AtOrigin, ROUNDING};
use crate::measured::Measured;

/// One point of a surface across +z.
struct Vector {
    what: &'static str,
    material: &'static str,
    to_viewer: [f64; 3],
    light: &'static str,
    objects: &'static str,
    /// By the oracle, to twelve digits.
    radiance: f64,
}

/// Half of the last of twelve digits, at most.
const WRITTEN: f64 = 5e-12;

/// What the oracle states to be off by at most, as a part.
const STATED: f64 = Measured::ROOM * 1.83e-8;

const FREE: [Vector; 20] = [
    Vector {
        what: "the back of a tilted rectangle that shines to both sides",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "rectangle]\ncenter = [0.4, -0.3, 0.9]\ndirection = [0.5, 0.2, 1]\nsize = [0.8, 0.5]\ntwo_sided = true",
        objects: "",
        radiance: 0.266_377_544_649,
    },
    Vector {
        what: "a rectangle that the horizon cuts across its diagonal",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "rectangle]\ncenter = [0.6, 0.5, 0.1]\ndirection = [-1, -0.7, 0.4]\nup = [0.3, 0.2, 1]\nsize = [1.2, 1.5]",
        objects: "",
        radiance: 0.214_608_578_795,
    },
    Vector {
        what: "a large rectangle just above",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "rectangle]\ncenter = [0.2, 0.1, 0.001]\ndirection = [0, 0, -1]\nsize = [1, 1]",
        objects: "",
        radiance: 3.141_577_846_34,
    },
    Vector {
        what: "a long and thin rectangle",
        material: "phong]\ndiffuse = 0.3\nspecular = 0.5\nshininess = 7",
        to_viewer: [-0.5, 0.2, 0.7],
        light: "rectangle]\ncenter = [0.5, 0, 0.8]\ndirection = [-0.5, 0, -0.8]\nup = [0, 1, 0.1]\nsize = [0.0001, 4]",
        objects: "",
        radiance: 0.000_084_771_785_402_3,
    },
    Vector {
        what: "a rectangle seen nearly edge-on",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "rectangle]\ncenter = [0.3, 0, 1]\ndirection = [-1.0005, 0, 0.3]\nsize = [0.7, 0.9]",
        objects: "",
        radiance: 0.000_083_197_817_231_6,
    },
    Vector {
        what: "a mirrored view near the horizon, which cuts the rectangle",
        material: "phong]\nspecular = 1\nshininess = 30",
        to_viewer: [-0.99, 0.1, 0.14],
        light: "rectangle]\ncenter = [1, 0, 0]\ndirection = [-1, 0.2, 0.1]\nsize = [0.8, 0.6]",
        objects: "",
        radiance: 0.115_899_036_328,
    },
    Vector {
        what: "a sharp lobe on an edge of a rectangle",
        material: "phong]\nspecular = 1\nshininess = 100000",
        to_viewer: [-0.5, -0.1, 1.0],
        light: "rectangle]\ncenter = [0, 0, 1]\ndirection = [0, 0, -1]\nsize = [1, 1]",
        objects: "",
        radiance: 0.000_031_415_612_379_8,
    },
    Vector {
        what: "a normalized lobe beside an edge of a rectangle",
        material: "normalized_phong]\nspecular = 1\nshininess = 1000000",
        to_viewer: [-0.5, -0.4995, 1.0],
        light: "rectangle]\ncenter = [0, 0, 1]\ndirection = [0, 0, -1]\nsize = [1, 1]",
        objects: "",
        radiance: 0.287_005_917_475,
    },
    Vector {
        what: "a lobe wider than a cosine",
        material: "normalized_phong]\ndiffuse = 0.2\nspecular = 0.6\nshininess = 0.25",
        to_viewer: [0.6, -0.3, 0.4],
        light: "rectangle]\ncenter = [0.2, 0.5, 0.7]\ndirection = [-0.1, -0.5, -1]\nsize = [0.9, 0.4]",
        objects: "",
        radiance: 0.072_618_186_686_3,
    },
    Vector {
        what: "the back of a disk that the horizon cuts",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "disk]\ncenter = [0.7, -0.2, 0.15]\ndirection = [1, 0.1, -0.3]\nradius = 0.5\ntwo_sided = true",
        objects: "",
        radiance: 0.154_646_309_867,
    },
    Vector {
        what: "a lobe beside the rim of a tilted disk",
        material: "phong]\nspecular = 1\nshininess = 300",
        to_viewer: [-0.62, 0.1, 1.0],
        light: "disk]\ncenter = [0.2, 0, 1.1]\ndirection = [0.3, -0.2, -1]\nradius = 0.45",
        objects: "",
        radiance: 0.000_888_002_221_707,
    },
    Vector {
        what: "a normalized lobe of a disk that the horizon cuts",
        material: "normalized_phong]\nspecular = 1\nshininess = 2.5",
        to_viewer: [-0.8, -0.1, 0.3],
        light: "disk]\ncenter = [0.9, 0.2, 0.1]\ndirection = [-1, 0, 0.2]\nradius = 0.6",
        objects: "",
        radiance: 0.081_307_500_232,
    },
    Vector {
        what: "a disk as large as the sky",
        material: "phong]\nspecular = 1\nshininess = 12",
        to_viewer: [0.3, 0.3, 0.5],
        light: "disk]\ncenter = [100, 50, 1]\ndirection = [0, 0, -1]\nradius = 1000",
        objects: "",
        radiance: 0.483_088_411_199,
    },
    Vector {
        what: "a sharp lobe on the rim of a disk",
        material: "phong]\nspecular = 1\nshininess = 1000000",
        to_viewer: [-0.5, 0.0, 1.0],
        light: "disk]\ncenter = [0, 0, 1]\ndirection = [0, 0, -1]\nradius = 0.5",
        objects: "",
        radiance: 3.139_082_886_23e-6,
    },
    Vector {
        what: "the sharpest lobe there is, on a disk",
        material: "normalized_phong]\nspecular = 1\nshininess = 1000000000",
        to_viewer: [-0.1, -0.2, 1.0],
        light: "disk]\ncenter = [0, 0, 1]\ndirection = [0, 0, -1]\nradius = 0.5",
        objects: "",
        radiance: 0.975_900_072_949,
    },
    Vector {
        what: "a lobe on a sphere that the horizon cuts",
        material: "phong]\nspecular = 1\nshininess = 3",
        to_viewer: [-0.9, -0.2, 0.3],
        light: "sphere]\ncenter = [1.1, 0.4, -0.1]\nradius = 0.6",
        objects: "",
        radiance: 0.302_248_979_411,
    },
    Vector {
        what: "a sphere that all but touches the point",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "sphere]\ncenter = [0.3, 0.2, 0.95]\nradius = 1.0161",
        objects: "",
        radiance: 3.034_860_433_52,
    },
    Vector {
        what: "a normalized lobe on the rim of a sphere",
        material: "normalized_phong]\nspecular = 1\nshininess = 10000",
        to_viewer: [-0.577350269, 0.0, 1.0],
        light: "sphere]\ncenter = [0, 0, 2]\nradius = 1",
        objects: "",
        radiance: 0.432_015_263_864,
    },
    Vector {
        what: "the last of a sphere above the horizon",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "sphere]\ncenter = [1.9, 0.3, -0.99]\nradius = 1",
        objects: "",
        radiance: 1.062_297_143_26e-6,
    },
    Vector {
        what: "a small sphere far away",
        material: "phong]\ndiffuse = 0.4\nspecular = 0.3\nshininess = 50",
        to_viewer: [-0.3, -0.2, 1.0],
        light: "sphere]\ncenter = [310, 190, 1000]\nradius = 2",
        objects: "",
        radiance: 7.487_362_613_85e-6,
    },
];

const HIDDEN: [Vector; 14] = [
    Vector {
        what: "a glossy rectangle past a triangle",
        material: "phong]\ndiffuse = 0.2\nspecular = 0.7\nshininess = 40",
        to_viewer: [-0.1, 0.2, 1.0],
        light: "rectangle]\ncenter = [0, -0.1, 1.3]\ndirection = [0.1, 0.1, -1]\nsize = [0.9, 0.7]",
        objects: "[objects.t.triangle]\nmaterial = \"m\"\nvertices = [[-0.2, -0.3, 0.6], [0.3, -0.1, 0.7], [0.05, 0.2, 0.5]]\n",
        radiance: 0.041_833_498_820_3,
    },
    Vector {
        what: "a rectangle past a ball at its edge",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "rectangle]\ncenter = [0.2, 0.1, 1]\ndirection = [0, 0, -1]\nsize = [0.8, 1.1]",
        objects: "[objects.b.sphere]\nmaterial = \"m\"\ncenter = [0.3, 0.2, 0.5]\nradius = 0.15\n",
        radiance: 0.557_120_878_832,
    },
    Vector {
        what: "a rectangle past two balls, one before the other",
        material: "phong]\ndiffuse = 0.5\nspecular = 0.3\nshininess = 9",
        to_viewer: [0.1, -0.2, 1.0],
        light: "rectangle]\ncenter = [-0.1, 0.2, 1.2]\ndirection = [0.2, 0, -1]\nsize = [1.1, 0.9]",
        objects: "[objects.a.sphere]\nmaterial = \"m\"\ncenter = [-0.1, 0.1, 0.5]\nradius = 0.12\n[objects.b.sphere]\nmaterial = \"m\"\ncenter = [0.05, 0.15, 0.7]\nradius = 0.14\n",
        radiance: 0.195_428_341_801,
    },
    Vector {
        what: "a rectangle that the horizon cuts past a triangle below it",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "rectangle]\ncenter = [1, 0, 0.1]\ndirection = [-1, 0, 0]\nsize = [0.9, 1]",
        objects: "[objects.t.triangle]\nmaterial = \"m\"\nvertices = [[0.5, -0.3, -0.2], [0.6, 0.3, -0.1], [0.5, 0.05, 0.2]]\n",
        radiance: 0.086_919_094_894_1,
    },
    Vector {
        what: "a disk past a triangle",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "disk]\ncenter = [0.1, 0.2, 1]\ndirection = [0.2, 0.3, -1]\nradius = 0.6",
        objects: "[objects.t.triangle]\nmaterial = \"m\"\nvertices = [[-0.3, 0.1, 0.5], [0.3, -0.1, 0.4], [0.1, 0.4, 0.6]]\n",
        radiance: 0.408_796_842_801,
    },
    Vector {
        what: "a glossy disk past a ball at its rim",
        material: "normalized_phong]\ndiffuse = 0.1\nspecular = 0.8\nshininess = 25",
        to_viewer: [-0.2, -0.1, 1.0],
        light: "disk]\ncenter = [0, 0, 1.5]\ndirection = [0, 0, -1]\nradius = 0.7",
        objects: "[objects.b.sphere]\nmaterial = \"m\"\ncenter = [0.2, 0.1, 0.8]\nradius = 0.25\n",
        radiance: 0.158_415_683_502,
    },
    Vector {
        what: "a disk past a plane",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "disk]\ncenter = [-0.2, 0.4, 1.4]\ndirection = [0, -0.3, -1]\nradius = 0.8",
        objects: "[objects.p.plane]\nmaterial = \"m\"\npoint = [0.1, 0.2, 1]\nnormal = [1, 0.4, 0.6]\n",
        radiance: 0.300_267_316_901,
    },
    Vector {
        what: "a disk past a disk within it",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "disk]\ncenter = [0.1, 0, 2]\ndirection = [0, 0, -1]\nradius = 1",
        objects: "[lights.screen.disk]\ncenter = [0.1, 0.05, 1]\ndirection = [0.2, 0.1, 1]\nradius = 0.3\nluminance = 1\n",
        radiance: 0.372_748_056_213,
    },
    Vector {
        what: "a disk past a rectangle across its rim",
        material: "phong]\ndiffuse = 0.3\nspecular = 0.4\nshininess = 16",
        to_viewer: [0.1, 0.1, 0.9],
        light: "disk]\ncenter = [0, 0.3, 1.1]\ndirection = [0, -0.2, -1]\nradius = 0.5",
        objects: "[lights.card.rectangle]\ncenter = [0.15, 0.3, 0.6]\ndirection = [0.1, 0, 1]\nup = [0.3, 1, 0]\nsize = [0.2, 0.5]\nluminance = 1\n",
        radiance: 0.162_187_130_974,
    },
    Vector {
        what: "a sphere past a triangle",
        material: "normalized_phong]\ndiffuse = 0.2\nspecular = 0.7\nshininess = 6",
        to_viewer: [-0.3, 0.2, 0.8],
        light: "sphere]\ncenter = [0.3, -0.2, 1.2]\nradius = 0.5",
        objects: "[objects.t.triangle]\nmaterial = \"m\"\nvertices = [[0, -0.3, 0.4], [0.4, -0.1, 0.6], [0.1, 0.1, 0.7]]\n",
        radiance: 0.198_664_623_259,
    },
    Vector {
        what: "a sphere past a disk",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "sphere]\ncenter = [0.2, 0.3, 1.5]\nradius = 0.4",
        objects: "[lights.screen.disk]\ncenter = [0.2, 0.1, 0.9]\ndirection = [-0.1, 0.2, 1]\nradius = 0.22\nluminance = 1\n",
        radiance: 0.076_435_051_584,
    },
    Vector {
        what: "a glossy sphere past two balls that cover each other in part",
        material: "phong]\ndiffuse = 0.1\nspecular = 0.9\nshininess = 60",
        to_viewer: [0.05, -0.1, 1.0],
        light: "sphere]\ncenter = [0, 0, 2]\nradius = 0.7",
        objects: "[objects.a.sphere]\nmaterial = \"m\"\ncenter = [0.05, 0.1, 1]\nradius = 0.15\n[objects.b.sphere]\nmaterial = \"m\"\ncenter = [-0.1, 0.05, 1.2]\nradius = 0.18\n",
        radiance: 0.057_280_807_816_4,
    },
    Vector {
        what: "a sphere past three balls in one place",
        material: "phong]\ndiffuse = 1",
        to_viewer: [0.0, 0.0, 1.0],
        light: "sphere]\ncenter = [0.1, 0.2, 2]\nradius = 0.8",
        objects: "[objects.a.sphere]\nmaterial = \"m\"\ncenter = [0.05, 0.1, 1]\nradius = 0.2\n[objects.b.sphere]\nmaterial = \"m\"\ncenter = [-0.1, 0.15, 1.1]\nradius = 0.2\n[objects.c.sphere]\nmaterial = \"m\"\ncenter = [0, -0.05, 0.9]\nradius = 0.2\n",
        radiance: 0.255_931_725_997,
    },
    Vector {
        what: "a disk past a ball, a triangle and a plane",
        material: "phong]\ndiffuse = 0.6\nspecular = 0.2\nshininess = 4",
        to_viewer: [0.2, 0.2, 0.8],
        light: "disk]\ncenter = [0, 0, 1.2]\ndirection = [0, 0, -1]\nradius = 0.6",
        objects: "[objects.b.sphere]\nmaterial = \"m\"\ncenter = [0.1, 0.1, 0.7]\nradius = 0.12\n[objects.t.triangle]\nmaterial = \"m\"\nvertices = [[-0.3, -0.1, 0.5], [0, -0.2, 0.6], [-0.05, 0.1, 0.55]]\n[objects.p.plane]\nmaterial = \"m\"\npoint = [0.2, 0, 1]\nnormal = [1, -0.3, 0.9]\n",
        radiance: 0.144_352_017_674,
    },
];

/// What has no closed form here: the renderer keeps a bound of its error, which is 1e-5 of the light with nothing in the
/// way.
const BOUNDED: [Vector; 1] = [Vector {
    what: "a sphere that the horizon cuts past a plane through it",
    material: "phong]\ndiffuse = 1",
    to_viewer: [0.0, 0.0, 1.0],
    light: "sphere]\ncenter = [0.9, 0.1, 0.2]\nradius = 0.5",
    objects: "[objects.p.plane]\nmaterial = \"m\"\npoint = [0.4, 0, 0.1]\nnormal = [0.2, 1, 0.4]\n",
    radiance: 0.058_066_888_559_4,
}];

/// The oracle says what is written, to the digits that it claims to know, and the pixel is that but for so much.
#[track_caller]
fn hold(vectors: &[Vector], tolerance: f64) {
    for vector in vectors {
        let Vector { what, radiance, .. } = vector;
        let place = AtOrigin {
            normal: [0.0, 0.0, 1.0],
            material: vector.material,
            to_viewer: vector.to_viewer,
            light: vector.light,
            objects: vector.objects,
        };
        let scene = Scene::parse(&place.scene(), "vector.toml").unwrap();
        let sample = Oracle::new(&scene).radiance(0.5, 0.5);
        let ([oracle, ..], [stated, ..]) = (sample.radiance, sample.error);
        let pixel = place.radiance();
        let off = (pixel / radiance - 1.0).abs();
        println!(
            "{what}: {oracle:.11e}, stated {:e}, pixel {off:e}",
            stated / radiance
        );
        assert!(stated <= STATED * radiance, "{what}: {stated:e}");
        assert!(
            (oracle - radiance).abs() <= stated + WRITTEN * radiance,
            "{what}: the oracle has {oracle:.11e}, of which {stated:e} may be off"
        );
        assert!(off <= tolerance, "{what}: {pixel}, expected {radiance}");
    }
}

#[test]
fn of_lights_with_nothing_in_the_way() {
    hold(&FREE, ROUNDING);
}

#[test]
fn of_lights_past_shapes() {
    hold(&HIDDEN, ROUNDING);
}

#[test]
fn of_lights_past_shapes_to_a_bound() {
    hold(&BOUNDED, Measured::ROOM * 1.83e-5);
}
