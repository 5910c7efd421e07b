//! A few shapes around and upon each other: one of them may resolve a whole batch, or none may.

use super::*;

/// Numbers without order (Steele, Lea & Flood 2014: SplitMix64).
struct Dice(u64);

impl Dice {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let bits = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ bits >> 31
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number of any magnitude between powers of ten.
    fn magnitude(&mut self, least: f64, most: f64) -> f64 {
        10_f64.powf(self.between(least, most))
    }

    fn one_of<T: Copy>(&mut self, of: &[T]) -> Option<T> {
        (!of.is_empty()).then(|| of[self.bits() as usize % of.len()])
    }

    fn point(&mut self, reach: f64) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| self.between(-reach, reach)))
    }

    fn direction(&mut self) -> DVec3 {
        self.point(1.0).normalize()
    }
}

/// Where shapes, lights and viewers of a scene may be upon.
#[derive(Default)]
struct Places {
    spheres: Vec<(DVec3, f64)>,
    triangles: Vec<[DVec3; 3]>,
    planes: Vec<(DVec3, DVec3)>,
}

impl Places {
    /// A point on a shape, within it, or just beside it, and the way out there.
    fn upon(&self, dice: &mut Dice) -> Option<(DVec3, DVec3)> {
        match dice.bits() % 3 {
            0 => dice.one_of(&self.spheres).map(|(center, radius)| {
                let out = dice.direction();
                let height = [1.0, 1.0 - 1e-7, 1.0 + 1e-7, 0.5, 0.0];
                let height = dice.one_of(&height).expect("there are some");
                (center + out * (radius * height), out)
            }),
            1 => dice.one_of(&self.triangles).map(|[a, b, c]| {
                let (u, v) = (dice.between(-0.2, 0.8), dice.between(0.0, 0.5));
                let out = (b - a).cross(c - a).normalize();
                (a + (b - a) * u + (c - a) * v, out)
            }),
            _ => dice.one_of(&self.planes).map(|(point, normal)| {
                let other = dice.point(2.0);
                (other - normal * normal.dot(other - point), normal)
            }),
        }
    }

    fn upon_or_anywhere(&self, dice: &mut Dice, reach: f64) -> (DVec3, DVec3) {
        let upon = self.upon(dice).filter(|_| dice.bits() % 3 < 2);
        upon.unwrap_or_else(|| (dice.point(reach), dice.direction()))
    }
}

#[test]
fn few_shapes_upon_each_other() {
    for seed in 0..48 {
        let dice = &mut Dice(seed << 32);
        let mut places = Places::default();
        for _ in 0..1 + dice.bits() % 8 {
            let (at, out) = places.upon_or_anywhere(dice, 1.0);
            match dice.bits() % 7 {
                0..3 => {
                    let radius = dice.magnitude(-2.0, 1.0);
                    let side = dice.between(-1.0, 1.0).signum();
                    places.spheres.push((at + out * (radius * side), radius));
                }
                3..6 => {
                    let size = dice.magnitude(-1.0, 2.0);
                    let [b, c] = [0; 2].map(|_| at + out.cross(dice.direction()) * size);
                    places.triangles.push([at, b, c]);
                }
                _ => places.planes.push((at, out)),
            }
        }
        let (eye, _) = places.upon_or_anywhere(dice, 3.0);
        let size = [1.0, 1e-6, 1e6][dice.bits() as usize % 3];
        let fov = dice.between(5.0, 120.0);
        let mut scene = Writer::new(size, [0.0; 3], fov, (eye + dice.direction()).to_array());
        for &(point, normal) in &places.planes {
            scene.plane(point.to_array(), normal.to_array());
        }
        for &(center, radius) in &places.spheres {
            scene.sphere(center.to_array(), radius);
        }
        for corners in &places.triangles {
            scene.triangle(corners.map(|corner| corner.to_array()));
        }
        for _ in 0..3 {
            let (at, _) = places.upon_or_anywhere(dice, 3.0);
            scene.light(at.to_array());
        }
        scene.agrees();
    }
}

/// Where a ray touches a sphere, rounding may turn the normal inwards: there a sphere seen from outside hides
/// points of its own that face a light.
#[test]
fn rays_that_touch_a_sphere() {
    const CAMERA: &str = "[camera.perspective]\neye = [0, 0, 0]\nlook_at = [0, 0, -1]\n\
                          vertical_fov = 90\n";
    agrees(
        &[CAMERA],
        "[lights.a.point]\nintensity = 1\n\
         position = [4.819573184583371, -1.9702824007529287, 3.29083718958012e-2]\n\
         [lights.b.point]\nintensity = 1\n\
         position = [-6.979522416238382e-2, -4.162104818373697, -1.5576146040052716]\n\
         [objects.ball.sphere]\nmaterial = \"m\"\nradius = 0.3039766715293524\n\
         center = [2.480039443609773, 0.1580737718166018, -2.0421290556327936]\n",
    );
    // Beside others, so that no shape resolves a whole batch.
    agrees(
        &[CAMERA],
        "[lights.a.point]\nintensity = 1\n\
         position = [4.955666282537832, -0.1322319520951618, -2.598010041380514]\n\
         [lights.b.point]\nintensity = 1\n\
         position = [4.9919157941218195, -0.5323084672202025, 1.5185830483471996e-2]\n\
         [objects.ball.sphere]\nmaterial = \"m\"\nradius = 0.5\n\
         center = [0.32315221660011556, -0.42503817866592347, -0.9845077294569933]\n\
         [objects.wall.plane]\nmaterial = \"m\"\npoint = [0, 0, -9]\nnormal = [0, 0, 1]\n",
    );
    let half = f64::from(RESOLUTION[1]) / 2.0;
    for index in 0..12 {
        let mut scene = Writer::new(1.0, [0.0; 3], 90.0, [0.0, 0.0, 1.0]);
        for ball in 0..6 {
            let at = |dimension| scattered(index * 6 + ball, dimension);
            let [column, row] = [0, 1].map(|axis: u32| {
                let count = RESOLUTION[axis as usize];
                (at(axis) * f64::from(count)).floor() + 0.5 - f64::from(count) / 2.0
            });
            let ray = DVec3::new(column / half, -row / half, -1.0);
            let any = DVec3::new(at(2) - 0.5, at(3) - 0.5, at(4) - 0.5);
            let (distance, radius) = (1.0 + 3.0 * at(5), 0.1 + 0.4 * at(6));
            let center = ray * distance + ray.cross(any).normalize() * radius;
            scene.sphere((center + DVec3::Z).to_array(), radius);
        }
        for light in 0..4 {
            let at = |dimension| scattered(index * 4 + light, dimension) * 10.0 - 5.0;
            scene.light([at(7), at(8), at(9)]);
        }
        scene.agrees();
    }
}

/// Far from where the scene is relative to, a point of a sphere is so far off that the way to it passes beside.
#[test]
fn spheres_that_hide_what_is_beside_them() {
    agrees(
        &["[camera.perspective]\n\
         eye = [2.520171881976074, 0.9204047352870787, -2.6699483954553678]\n\
         look_at = [5.063403578114252e10, 5.514789428797495e9, 2.5372383614007327e11]\n\
         vertical_fov = 24.58436248611003\n"],
        "\
         [lights.a.point]\nintensity = 1\n\
         position = [-34.22479650321694, -78.52531760858241, -159.89059644994106]\n\
         [objects.ground.plane]\nmaterial = \"m\"\n\
         point = [2.5369728686063775, 0.9223765649700554, -2.581257862275146]\n\
         normal = [-0.9757259253836982, 5.458830455241365e-2, 0.2120826148938631]\n\
         [objects.ball.sphere]\nmaterial = \"m\"\nradius = 2.9696605909858604\n\
         center = [-0.36060195960880126, 1.0844853017280922, -1.9514444787916099]\n",
    );
}
