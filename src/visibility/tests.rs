//! The projection against packets alone, on every instruction set: all ways to the same bits.

use std::fmt::Write as _;

use fearless_simd::Simd;

use super::batch::Column;
use super::projection::State;
use super::*;
use crate::camera::{Camera, Projection};
use crate::mesh::{MeshFile, MeshNormals};
use crate::scene::{Entry, Object, Scene, ShadowTerminator, Span};
use crate::simd::{F64x16, Kernel, LANES, SimdLevel};

mod contacts;
mod disks;
mod incoherent;
mod lifted;
mod mirrored;
mod parallel;
mod parts;
mod shafts;
mod suns;
mod together;

/// Columns and rows of the images.
const RESOLUTION: [u32; 2] = [64, 48];

/// The part of the rays of an ordinary scene that the projection may leave to the packets.
const FALLS_BACK: f64 = 0.01;

/// Numbers without order from 0 to 1: multiples of irrational ones.
fn scattered(index: u32, dimension: u32) -> f64 {
    // No number of this kind is a square.
    let step = f64::from(dimension * 4 + 2).sqrt();
    ((f64::from(index) + 1.0) * step).fract()
}

/// A scene in some place and size: coordinates x are written as place + size · x.
struct Writer {
    /// The scene is seen through each of these.
    cameras: Vec<String>,
    text: String,
    size: f64,
    place: [f64; 3],
    objects: u32,
    /// Objects that are no text: meshes without a file.
    meshes: Vec<Object>,
    /// Disks, which no scene has: their centers, normals and radii.
    disks: Vec<([f64; 3], [f64; 3], f64)>,
}

impl Writer {
    /// Seen in perspective, and by parallel rays as far apart as those are in the middle.
    fn new(size: f64, place: [f64; 3], vertical_fov: f64, eye: [f64; 3]) -> Self {
        let mut writer = Self::empty(size, place);
        let distance = DVec3::from_array(eye).length() * size;
        let height = 2.0 * distance * (vertical_fov.to_radians() * 0.5).tan();
        let (eye, middle) = (writer.point(eye), writer.point([0.0; 3]));
        writer.cameras = vec![
            format!(
                "[camera.perspective]\neye = {eye}\nlook_at = {middle}\n\
                 vertical_fov = {vertical_fov}\n"
            ),
            format!(
                "[camera.orthographic]\neye = {eye}\nlook_at = {middle}\nheight = {height:e}\n"
            ),
        ];
        writer
    }

    /// Seen by parallel rays alone, over a height of the image.
    fn orthographic(height: f64, eye: [f64; 3], look_at: [f64; 3]) -> Self {
        let mut writer = Self::empty(1.0, [0.0; 3]);
        writer.cameras = vec![format!(
            "[camera.orthographic]\neye = {eye:?}\nlook_at = {look_at:?}\nheight = {height:e}\n"
        )];
        writer
    }

    fn empty(size: f64, place: [f64; 3]) -> Self {
        let [width, height] = RESOLUTION;
        Self {
            cameras: Vec::new(),
            text: format!(
                "[image]\nresolution = [{width}, {height}]\n[materials.m.phong]\ndiffuse = 0.5\n"
            ),
            size,
            place,
            objects: 0,
            meshes: Vec::new(),
            disks: Vec::new(),
        }
    }

    fn point(&self, [x, y, z]: [f64; 3]) -> String {
        let [x, y, z] = [
            self.place[0] + self.size * x,
            self.place[1] + self.size * y,
            self.place[2] + self.size * z,
        ];
        format!("[{x:e}, {y:e}, {z:e}]")
    }

    fn light(&mut self, position: [f64; 3]) {
        let position = self.point(position);
        self.objects += 1;
        let _ = write!(
            self.text,
            "[lights.l{}.point]\nposition = {position}\nintensity = 1\n",
            self.objects,
        );
    }

    fn object(&mut self, shape: &str, rest: &str) {
        self.objects += 1;
        let _ = write!(
            self.text,
            "[objects.o{}.{shape}]\nmaterial = \"m\"\n{rest}\n",
            self.objects,
        );
    }

    fn triangle(&mut self, corners: [[f64; 3]; 3]) {
        let [a, b, c] = corners.map(|corner| self.point(corner));
        self.object("triangle", &format!("vertices = [{a}, {b}, {c}]"));
    }

    fn sphere(&mut self, center: [f64; 3], radius: f64) {
        let (center, radius) = (self.point(center), self.size * radius);
        self.object("sphere", &format!("center = {center}\nradius = {radius:e}"));
    }

    fn plane(&mut self, point: [f64; 3], normal: [f64; 3]) {
        let point = self.point(point);
        self.object("plane", &format!("point = {point}\nnormal = {normal:?}"));
    }

    /// Triangles and spheres without order within 1 of the middle.
    fn clutter(&mut self, triangles: u32, spheres: u32, largest: f64) {
        let around = |index, dimension: u32, spread: f64| {
            [0, 1, 2].map(|axis: u32| (scattered(index, dimension + axis) * 2.0 - 1.0) * spread)
        };
        for index in 0..triangles {
            let middle = around(index, 0, 1.0);
            self.triangle([3, 6, 9].map(|dimension| {
                let offset = around(index, dimension, largest);
                [0, 1, 2].map(|axis: usize| middle[axis] + offset[axis])
            }));
        }
        for index in 0..spheres {
            let radius = largest * (0.1 + 0.5 * scattered(index, 7));
            self.sphere(around(index, 12, 1.0), radius);
        }
    }

    fn lights(&mut self) {
        for position in [[2.0, 3.0, 2.0], [-3.0, 1.0, 0.5], [0.1, 0.2, 0.0]] {
            self.light(position);
        }
    }

    /// Renders both ways on every instruction set; the part of all rays that the projection left to the
    /// packets, at most.
    #[track_caller]
    fn agrees(&self) -> f64 {
        let mut most_again = 0.0_f64;
        for camera in &self.cameras {
            most_again = most_again.max(self.agrees_through(camera));
        }
        most_again
    }

    #[track_caller]
    fn agrees_through(&self, camera: &str) -> f64 {
        self.with_ways(camera, |compare| {
            let mut bits = None;
            let mut most_again = 0.0_f64;
            for (name, level) in SimdLevel::available() {
                let (fallback, seen) = level.run(compare);
                most_again = most_again.max(fallback);
                // The way of one instruction set is the way of all.
                assert!(*bits.get_or_insert_with(|| seen.clone()) == seen, "{name}");
            }
            most_again
        })
    }

    /// Both ways of the scene that a camera sees.
    fn with_ways<T>(&self, camera: &str, work: impl FnOnce(Compare<'_>) -> T) -> T {
        let text = format!("{}{camera}", self.text);
        let mut scene = Scene::parse(&text, "test.toml").unwrap_or_else(|e| panic!("{e}"));
        lifted::add_meshes(&mut scene, &self.meshes);
        let (mut world, camera) = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        self.add_disks(&mut world);
        let plan = Plan::new(&world);
        let projection = Visibility::new(&world, &plan);
        let packets = Visibility {
            uses_projection: false,
            ..Visibility::new(&world, &plan)
        };
        work(Compare {
            world: &world,
            camera: &camera,
            ways: [&projection, &packets],
        })
    }
}

#[derive(Clone, Copy)]
struct Compare<'w> {
    world: &'w World,
    camera: &'w Camera,
    ways: [&'w Visibility<'w>; 2],
}

impl Compare<'_> {
    /// The primary rays through a tile of 16 × 16 pixels, of which `varying` is what differs.
    fn rays<F>(&self, tile: &[u32; 2], varying: F) -> RayBatch<'_, F> {
        let camera = self.camera;
        match camera.projection() {
            Projection::Perspective { .. } => RayBatch::FromPoint {
                origin: camera.eye(),
                direction: varying,
                count: BATCH,
                around: Some([[0, 0], [16, 0], [0, 16], [16, 16]].map(|[right, down]| {
                    let [x, y] = [tile[0] + right, tile[1] + down].map(f64::from);
                    camera.ray(x, y).direction
                })),
            },
            Projection::Orthographic { .. } => RayBatch::Along {
                direction: camera.forward().get(),
                origin: varying,
                count: BATCH,
            },
        }
    }
}

/// The segments from a light to points of surfaces, as if they shared nothing.
fn segments_from(light: Point, points: &Points) -> IncoherentSegments {
    let mut segments = IncoherentSegments::default();
    let starts = points.starts();
    for slot in 0..BATCH {
        let [x, y, z] = starts.position;
        let position = DVec3::new(x[slot], y[slot], z[slot]);
        let (error, primitive) = (starts.error[slot], points.primitive[slot]);
        segments.start.set(slot, light.0, 0.0, u64::MAX);
        segments.end.set(slot, position, error, primitive);
    }
    segments.count = BATCH;
    segments
}

impl Kernel for Compare<'_> {
    /// The part of all rays that the projection left to the packets, and the bits of all that was seen.
    type Output = (f64, Vec<u64>);

    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let [width, height] = RESOLUTION;
        // A batch is 16 × 16 pixels, in squares of four by four.
        let mut spaces: [Workspace; 3] = Default::default();
        let mut points: [Points; 3] = Default::default();
        let (mut asked, mut fell_back) = (0_u32, 0_u32);
        let mut all = Vec::new();
        for tile in 0..(width / 16) * (height / 16) {
            let corner = [tile % (width / 16) * 16, tile / (width / 16) * 16];
            let mut places = [Column::ZERO; 2];
            for (axis, places) in places.iter_mut().enumerate() {
                for (slot, place) in (0..).zip(places.iter_mut()) {
                    let (packet, lane): (u32, u32) = (slot / 16, slot % 16);
                    let pixel = [packet % 4 * 4 + lane % 4, packet / 4 * 4 + lane / 4];
                    // In every second batch through the middle of pixels, where edges and corners are.
                    let within = if tile % 2 == 0 {
                        0.5
                    } else {
                        scattered(slot, axis as u32)
                    };
                    *place = f64::from(corner[axis] + pixel[axis]) + within;
                }
            }
            let rays = self.rays(&corner, |packet| {
                let [x, y] = places.each_ref().map(|places| &places[packet * LANES..]);
                let [x, y] = [F64x16::load(simd, x), F64x16::load(simd, y)];
                self.camera.varying(simd, x, y)
            });
            for way in 0..2 {
                self.ways[way].nearest(simd, &rays, &mut spaces[way], &mut points[way]);
            }
            // The same rays, of which it is not known that they share anything.
            let separate = incoherent::separate(simd, &rays);
            let batch: RayBatch<'_, fn(usize) -> DVec3x16<S>> = RayBatch::Any(&separate);
            self.ways[0].nearest(simd, &batch, &mut spaces[2], &mut points[2]);
            mirrored::compare(
                simd,
                self.world,
                self.ways,
                &points[1],
                &separate,
                &mut spaces[2],
            );
            // A projection that does not fit leaves all rays to the packets, one that is only bounded none.
            let fallback = |space: &Workspace, bits: &dyn Fn(usize) -> u32| -> u32 {
                let fallback = |packet| match space.projection.state {
                    State::Projected => space.projection.falls_back(packet) & bits(packet),
                    State::Unfit => bits(packet),
                    State::Bounded | State::Occluded | State::Overlapping => 0,
                };
                (0..PACKETS)
                    .map(|packet| fallback(packet).count_ones())
                    .sum()
            };
            asked += BATCH as u32;
            fell_back += fallback(&spaces[0], &|_| u32::from(u16::MAX));
            let [seen, expected, separate] = &points;
            assert_eq!(seen.hit, expected.hit);
            assert_eq!(separate.hit, expected.hit);
            for slot in (0..BATCH).filter(|&slot| expected.is_hit(slot)) {
                assert_eq!(seen.primitive[slot], expected.primitive[slot]);
                let bits = |points: &Points| {
                    let columns = [&points.position, points.shading_normals()];
                    columns.map(|vector| vector.each_ref().map(|column| column[slot].to_bits()))
                };
                assert_eq!(bits(seen), bits(expected), "{:?}", seen.primitive[slot]);
                assert_eq!(separate.primitive[slot], expected.primitive[slot]);
                assert_eq!(bits(separate), bits(expected), "{:?}", seen.primitive[slot]);
                all.push(seen.primitive[slot]);
                all.extend(bits(seen).as_flattened());
            }
            for light in self.world.lights() {
                let (light, to_light) = (light.value.position(), light.value.direction());
                let facing = seen.facing(simd, self.world, light).above;
                let [lit, expected] = [0, 1].map(|way: usize| {
                    let segments = SegmentBatch::ToPoint {
                        end: light,
                        to_light,
                        number: 0,
                        points: &points[way],
                        facing: &facing,
                    };
                    self.ways[way].free(simd, segments, &mut spaces[way])
                });
                assert_eq!(lit, expected);
                // From the light, what is far away from it is rounded.
                if !is_far(light, &points[1]) {
                    let segments = segments_from(light, &points[1]);
                    let free =
                        self.ways[0].free(simd, SegmentBatch::Any(&segments), &mut spaces[2]);
                    for packet in 0..PACKETS {
                        assert_eq!(free[packet] & facing[packet], expected[packet]);
                    }
                }
                all.extend(lit.map(u64::from));
                asked += facing.iter().map(|bits| bits.count_ones()).sum::<u32>();
                fell_back += fallback(&spaces[0], &|packet| lit[packet]);
            }
        }
        (f64::from(fell_back) / f64::from(asked), all)
    }
}

const EYE: [f64; 3] = [0.3, 1.1, 3.0];

#[test]
fn an_ordinary_scene_is_decided_by_the_projection() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.clutter(300, 60, 0.2);
    scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    scene.lights();
    let fallback = scene.agrees();
    assert!(fallback < FALLS_BACK, "{fallback}");
}

#[test]
fn size_and_place_make_no_difference() {
    for (size, place) in [
        (1e-6, [0.0; 3]),
        (1e6, [0.0; 3]),
        (1e-3, [100.0, -50.0, 7.0]),
        (1e-30, [0.0; 3]),
        (1e29, [0.0; 3]),
    ] {
        let mut scene = Writer::new(size, place, 40.0, EYE);
        scene.clutter(100, 30, 0.3);
        scene.plane([0.0, -1.0, 0.0], [0.1, 1.0, 0.2]);
        scene.lights();
        scene.agrees();
    }
}

/// Neighbors share edges and corners, which rays pass through, and every triangle is there twice.
#[test]
fn edges_corners_and_ties() {
    let mut scene = Writer::new(1.0, [0.0; 3], 50.0, [0.0, 0.0, 3.0]);
    for twice in 0..2 {
        for cell in 0..64_u32 {
            let (x, y) = (
                f64::from(cell % 8) / 4.0 - 1.0,
                f64::from(cell / 8) / 4.0 - 1.0,
            );
            let height = |x: f64, y: f64| (x * 3.0).sin() * (y * 2.0).cos() * 0.2;
            let corner = |dx: f64, dy: f64| {
                let (x, y) = (x + dx / 4.0, y + dy / 4.0);
                [x, y, height(x, y)]
            };
            let (a, b, c, d) = (
                corner(0.0, 0.0),
                corner(1.0, 0.0),
                corner(1.0, 1.0),
                corner(0.0, 1.0),
            );
            if twice == 0 {
                scene.triangle([a, b, c]);
                scene.triangle([a, c, d]);
            } else {
                scene.triangle([b, c, a]);
                scene.triangle([d, a, c]);
            }
        }
    }
    // A light in the plane of some, and one at a corner.
    scene.lights();
    scene.light([-1.0, -1.0, 1.0]);
    scene.light([3.0, 0.0, 0.0]);
    scene.agrees();
}

#[test]
fn slivers_and_triangles_around_the_viewer() {
    let mut scene = Writer::new(1.0, [0.0; 3], 90.0, EYE);
    for index in 0..60 {
        let at = |dimension| scattered(index, dimension) * 2.0 - 1.0;
        let a = [at(0), at(1), at(2)];
        let b = [at(3), at(4), at(5)];
        let far = [0, 1, 2].map(|axis: usize| a[axis] * 0.3 + b[axis] * 0.7 + 1e-9);
        scene.triangle([a, b, far]);
        // Edge-on, behind, and through the viewer's plane.
        let edge_on = [0, 1, 2].map(|axis: usize| EYE[axis] * 0.5 + a[axis] * 0.5);
        if index % 3 == 0 {
            scene.triangle([edge_on, a, [at(6), at(7), at(8)]]);
        }
        scene.triangle([
            [a[0] * 9.0, a[1] * 9.0, -4.0],
            [b[0] * 9.0, b[1] * 9.0, 8.0],
            [at(6) * 9.0, at(7) * 9.0, 8.0],
        ]);
    }
    scene.lights();
    scene.agrees();
}

/// The viewer and a light within a sphere, one on it, spheres that touch each other and a plane, a
/// planet and pebbles.
#[test]
fn spheres_around_and_beside() {
    let mut scene = Writer::new(1.0, [0.0; 3], 60.0, EYE);
    scene.sphere([0.0; 3], 5.0);
    scene.sphere([0.0, -1001.0, 0.0], 1000.0);
    scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    for index in 0..40_u32 {
        let x = f64::from(index % 8) * 0.25 - 1.0;
        let z = f64::from(index / 8) * 0.25 - 0.5;
        scene.sphere([x, -0.875, z], 0.125);
        scene.sphere([x, -0.7495, z], 5e-4);
    }
    scene.lights();
    scene.light([0.0, 4.99, 0.0]);
    scene.light([0.0, 7.0, 0.0]);
    scene.light([0.0, 0.0, 5.0]);
    scene.agrees();
}

/// A batch spans half of all directions.
#[test]
fn the_widest_view() {
    let mut scene = Writer::new(1.0, [0.0; 3], 175.0, [0.0, 0.1, 0.2]);
    scene.clutter(120, 40, 0.3);
    scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    scene.lights();
    scene.agrees();
}

/// A scene as it is written, through each camera.
#[track_caller]
fn agrees(cameras: &[&str], text: &str) {
    let mut scene = Writer::empty(1.0, [0.0; 3]);
    scene.cameras = cameras.iter().map(|&camera| camera.to_owned()).collect();
    scene.text.push_str(text);
    scene.agrees();
}

/// Beside the far triangle, the depth of the near one is less than the smallest f32.
#[test]
fn depths_beyond_f32() {
    agrees(
        &[
            "[camera.perspective]\neye = [0, 0, 1e-20]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n",
            "[camera.orthographic]\neye = [0, 0, 1e-20]\nlook_at = [0, 0, 0]\nheight = 2e-21\n",
            "[camera.orthographic]\neye = [0, 0, 1e-20]\nlook_at = [0, 0, 0]\nheight = 2e20\n",
        ],
        "[objects.far.triangle]\nmaterial = \"m\"\n\
         vertices = [[0, 0, -1e20], [1e20, 0, -1e20], [0, 1e20, -1e20]]\n\
         [objects.near.triangle]\nmaterial = \"m\"\n\
         vertices = [[-1e-21, -1e-21, 0], [3e-21, 0, 0], [0, 3e-21, 0]]\n",
    );
}

/// From far enough away the corners of a triangle are in one place, which no ray passes around.
#[test]
fn triangles_without_extent() {
    for distance in [1e14, 1e15, 1e16, 1e17, 1e18] {
        let place = format!("eye = [0, 0, {distance:e}]\nlook_at = [0, 0, 0]\n");
        let wide = format!(
            "[camera.orthographic]\n{place}height = {:e}\n",
            distance * 0.1
        );
        agrees(
            &[
                &format!("[camera.perspective]\n{place}vertical_fov = 40\n"),
                &format!("[camera.orthographic]\n{place}height = 2\n"),
                &wide,
            ],
            "[objects.a.triangle]\nmaterial = \"m\"\n\
             vertices = [[-1, -1, 0], [1, 0, 0.3], [0, 1, 0.1]]\n",
        );
    }
}

/// Far from the origin of the world f64 has few digits left for shapes, and f32 has none but in the axes
/// of a projection.
#[test]
fn far_from_the_origin() {
    for place in [1e3, 1e6, 1e9, 1e12] {
        let mut scene = Writer::new(1.0, [place, -place * 0.7, place * 0.3], 40.0, EYE);
        scene.clutter(200, 30, 0.2);
        scene.light([2.0, 3.0, 2.0]);
        // What the scene is relative to is where the camera looks: the clutter is elsewhere.
        scene.light([-place, place * 0.7, -place * 0.3]);
        scene.agrees();
        let mut elsewhere = Writer::new(1.0, [0.0; 3], 10.0, [place, place * 0.2, place * 0.5]);
        elsewhere.clutter(100, 20, 0.2);
        elsewhere.lights();
        elsewhere.agrees();
    }
}

/// Blocks of triangles that differ a million times in size: to the small ones their middle is far away.
#[test]
fn large_beside_small() {
    for factor in [1e-2, 1e-4, 1e-6] {
        let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
        scene.clutter(40, 0, 0.5);
        let mut small = Writer::new(factor, [0.3, 0.2, 0.1], 40.0, EYE);
        (small.text, small.objects) = (std::mem::take(&mut scene.text), scene.objects);
        small.cameras = scene.cameras;
        small.clutter(200, 0, 0.4);
        small.size = 1.0;
        small.lights();
        small.agrees();
        // So near that they fill the view, with the large ones around the viewer.
        let eye = [0.3 + 3.0 * factor, 0.2 + factor, 0.1 + 2.0 * factor];
        let mut near = Writer::new(1.0, [0.0; 3], 50.0, eye);
        near.clutter(12, 0, 0.5);
        (near.size, near.place) = (factor, [0.3, 0.2, 0.1]);
        near.clutter(300, 0, 0.4);
        near.light([2.0, 3.0, 2.0]);
        near.light([0.0; 3]);
        near.agrees();
    }
}

/// Triangles smaller than a pixel, of which most hold no ray.
#[test]
fn triangles_between_rays() {
    for largest in [0.03, 0.003] {
        let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
        scene.clutter(4000, 0, largest);
        scene.triangle([[-9.0, -1.0, -9.0], [0.0, -1.0, 9.0], [9.0, -1.0, -9.0]]);
        scene.lights();
        let fallback = scene.agrees();
        assert!(fallback < FALLS_BACK, "{fallback}");
    }
}

/// All of them before a few batches: their projections give up.
#[test]
fn far_more_triangles_than_rays() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE.map(|x| 8.0 * x));
    scene.clutter(4000, 0, 0.003);
    scene.lights();
    let fallback = scene.agrees();
    assert!(fallback > FALLS_BACK, "{fallback}");
}

/// Triangles that touch each other with corners, edges and faces, and lights on them.
#[test]
fn points_of_contact() {
    let mut scene = Writer::new(1.0, [0.1, -0.7, 0.3], 50.0, EYE);
    for index in 0..40 {
        let at = |dimension| scattered(index, dimension) * 2.0 - 1.0;
        let [a, b, c] =
            [0, 3, 6].map(|dimension| [at(dimension), at(dimension + 1), at(dimension + 2)]);
        let between = |s: f64, t: f64| {
            [0, 1, 2].map(|axis: usize| a[axis] + (b[axis] - a[axis]) * s + (c[axis] - a[axis]) * t)
        };
        scene.triangle([a, b, c]);
        // A corner within, an edge within, a face within, and one that goes through.
        scene.triangle([
            between(0.3, 0.3),
            [at(9), at(10), at(11)],
            [at(12), at(13), at(14)],
        ]);
        scene.triangle([
            between(0.1, 0.2),
            between(0.6, 0.2),
            [at(15), at(16), at(17)],
        ]);
        scene.triangle([between(0.1, 0.1), between(0.2, 0.5), between(0.5, 0.1)]);
        let [near, far] = [between(0.4, 0.3), between(0.2, 0.6)];
        scene.triangle([
            near,
            far,
            [0, 1, 2].map(|axis: usize| near[axis] * 2.0 - at(18 + axis as u32)),
        ]);
        if index % 10 == 0 {
            scene.light(between(0.25, 0.25));
            scene.light(a);
        }
    }
    scene.agrees();
}

/// Suns and telescopes: rays almost parallel.
#[test]
fn far_away() {
    for distance in [1e6, 1e9, 1.5e11, 1e13] {
        let towards = [0.3 * distance, 0.7 * distance, 0.4 * distance];
        let mut scene = Writer::new(1.0, [0.0; 3], 10.0, EYE);
        scene.clutter(300, 60, 0.1);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        scene.light(towards);
        scene.agrees();
        let mut scene = Writer::new(1.0, [0.0; 3], 100.0 / distance, towards);
        scene.clutter(200, 60, 0.2);
        scene.lights();
        scene.agrees();
    }
}
