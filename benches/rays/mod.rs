//! Rays that share nothing: candela's rays a second beside Embree's on the same random bundle, one thread each.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use candela::DVec3;
use candela::internal::Tracer;
use candela::render::SimdLevel;
use candela::world::World;

use super::Result;
use super::compare::Spread;
use super::scenes::Scene;
use super::yardstick::compile_from;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/rays/yardstick.cpp");

/// Rays and segments of each bundle.
const COUNT: usize = 1 << 20;

/// Of a bundle, rays that may meet something else than Embree's, whose f32 sees another edge here and there.
const DIFFERENT: f64 = 1e-3;

/// A ray o + t ω, or a segment from t = 0 to 1. All numbers are f32.
type Ray = [DVec3; 2];

/// Numbers without order (xorshift*), the same in every run.
struct Numbers(u64);

impl Numbers {
    /// From 0 to below 1.
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    /// Any direction, all alike.
    fn direction(&mut self) -> DVec3 {
        loop {
            let vector = self.vector() * 2.0 - 1.0;
            let square = vector.length_squared();
            if square > 1e-6 && square <= 1.0 {
                return vector / square.sqrt();
            }
        }
    }
}

/// A bundle of rays, and one of segments.
struct Bundle {
    name: &'static str,
    rays: Vec<Ray>,
    segments: Vec<Ray>,
}

fn single(vector: DVec3) -> DVec3 {
    vector.as_vec3().as_dvec3()
}

/// The box around all triangles and spheres but a floor that is much larger than they are.
fn bounds(world: &World) -> [DVec3; 2] {
    let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let mut add = |least: DVec3, most: DVec3| {
        if (most - least).max_element() < 10.0 {
            bounds = [bounds[0].min(least), bounds[1].max(most)];
        }
    };
    for triangle in 0..world.triangles().len() as u32 {
        let [a, b, c] = world.triangles().vertices(triangle);
        add(a.min(b).min(c), a.max(b).max(c));
    }
    for sphere in world.spheres() {
        add(
            sphere.center.0 - sphere.radius,
            sphere.center.0 + sphere.radius,
        );
    }
    bounds
}

/// A point a little above a surface, and the normal there.
fn above_surface(world: &World, numbers: &mut Numbers, size: f64) -> [DVec3; 2] {
    let (triangles, spheres) = (world.triangles().len(), world.spheres().len());
    let index = (numbers.next() * (triangles + spheres) as f64) as usize;
    let (position, normal) = if index < triangles {
        let [a, b, c] = world.triangles().vertices(index as u32);
        let (mut u, mut v) = (numbers.next(), numbers.next());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let normal = (b - a).cross(c - a).normalize();
        (a + (b - a) * u + (c - a) * v, normal)
    } else {
        let sphere = &world.spheres()[index - triangles];
        let normal = numbers.direction();
        (sphere.center.0 + normal * sphere.radius, normal)
    };
    [position + normal * (size * 1e-4), normal]
}

/// Pixels along each side of the picture of a mirror ball.
const BALL_PIXELS: usize = 1024;

/// What an eye sees in a mirror ball amid the scene, in tiles of 16 × 16 pixels, row by row; segments from the ball to a
/// light above.
fn mirrored([least, most]: [DVec3; 2]) -> Bundle {
    let mut bundle = Bundle {
        name: "mirrored",
        rays: Vec::with_capacity(COUNT),
        segments: Vec::with_capacity(COUNT),
    };
    let size = (most - least).max_element();
    let (center, radius) = ((least + most) * 0.5, size * 0.2);
    let to_eye = DVec3::new(0.3, 0.4, 1.0).normalize();
    let right = DVec3::Y.cross(to_eye).normalize();
    let up = to_eye.cross(right);
    let light = most.with_x(center.x).with_z(center.z) + DVec3::Y * size;
    let tiles = BALL_PIXELS / 16;
    for pixel in 0..BALL_PIXELS * BALL_PIXELS {
        let (tile, place) = (pixel / 256, pixel % 256);
        let column = tile % tiles * 16 + place % 16;
        let row = tile / tiles * 16 + place / 16;
        let at = |pixel: usize| (pixel as f64 + 0.5) / BALL_PIXELS as f64 * 2.0 - 1.0;
        let (x, y) = (at(column), at(row));
        // Parallel rays: the normal has these coordinates.
        let square = x * x + y * y;
        if square >= 1.0 {
            continue;
        }
        let normal = right * x + up * y + to_eye * (1.0 - square).sqrt();
        let start = single(center + normal * (radius + size * 1e-4));
        let direction = normal * (2.0 * normal.dot(to_eye)) - to_eye;
        bundle.rays.push([start, single(direction)]);
        bundle.segments.push([start, single(light - start)]);
    }
    bundle
}

/// Rays from anywhere to anywhere, rays that leave a surface as diffuse light does, and those of a mirror ball; segments
/// between any two points, and from surfaces to a square of light above all.
fn bundles(world: &World) -> [Bundle; 3] {
    let [least, most] = bounds(world);
    let extent = most - least;
    let mut numbers = Numbers(0x9e37_79b9_7f4a_7c15);
    let mut scattered = Bundle {
        name: "scattered",
        rays: Vec::with_capacity(COUNT),
        segments: Vec::with_capacity(COUNT),
    };
    let mut bounced = Bundle {
        name: "bounced",
        rays: Vec::with_capacity(COUNT),
        segments: Vec::with_capacity(COUNT),
    };
    for _ in 0..COUNT {
        let start = single(least + extent * numbers.vector());
        scattered.rays.push([start, single(numbers.direction())]);
        let end = single(least + extent * numbers.vector());
        scattered.segments.push([start, single(end - start)]);
        let [start, normal] = above_surface(world, &mut numbers, extent.max_element());
        let start = single(start);
        // By the cosine: a point on the unit sphere around the tip of the normal.
        let direction = normal + numbers.direction();
        bounced.rays.push([start, single(direction)]);
        let light = DVec3::new(numbers.next() - 0.5, 0.0, numbers.next() - 0.5);
        let light = most.with_x(0.0).with_z(0.0) + (light + DVec3::Y) * extent.max_element();
        bounced.segments.push([start, single(light - start)]);
    }
    [scattered, bounced, mirrored([least, most])]
}

fn write_bundle(world: &World, bundle: &Bundle, path: &Path) -> Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    let mut vectors = |count: usize, vectors: &mut dyn Iterator<Item = DVec3>, more: &[f64]| {
        file.write_all(&(count as u32).to_ne_bytes())?;
        for (place, vector) in vectors.enumerate() {
            for number in vector.to_array() {
                file.write_all(&(number as f32).to_ne_bytes())?;
            }
            if let Some(&number) = more.get(place) {
                file.write_all(&(number as f32).to_ne_bytes())?;
            }
        }
        Ok::<(), std::io::Error>(())
    };
    let triangles = world.triangles();
    let corners = (0..triangles.len() as u32).flat_map(|triangle| triangles.vertices(triangle));
    vectors(triangles.len(), &mut corners.into_iter(), &[])?;
    let radii: Vec<f64> = world.spheres().iter().map(|sphere| sphere.radius).collect();
    let centers = world.spheres().iter().map(|sphere| sphere.center.0);
    vectors(radii.len(), &mut centers.into_iter(), &radii)?;
    for rays in [&bundle.rays, &bundle.segments] {
        vectors(rays.len(), &mut rays.iter().flatten().copied(), &[])?;
    }
    Ok(file.flush()?)
}

/// The yardstick with a bundle.
struct Yardstick {
    process: Child,
    commands: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Yardstick {
    fn start(program: &Path, bundle: &Path) -> Result<(Self, String)> {
        let mut process = Command::new(program)
            .arg(bundle)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let commands = process.stdin.take().ok_or("no input to the yardstick")?;
        let answers = process.stdout.take().ok_or("no output of the yardstick")?;
        let mut yardstick = Self {
            process,
            commands,
            answers: BufReader::new(answers),
        };
        let ready = yardstick.answer()?;
        let version = ready.strip_prefix("ready ").ok_or("not ready")?.to_owned();
        Ok((yardstick, version))
    }

    fn answer(&mut self) -> Result<String> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            return Err(format!("the yardstick ended: {}", self.process.wait()?).into());
        }
        Ok(line.trim().to_owned())
    }

    fn ask(&mut self, command: &str) -> Result<String> {
        writeln!(self.commands, "{command}")?;
        self.answer()
    }

    fn seconds(&mut self, command: &str) -> Result<f64> {
        Ok(self.ask(command)?.parse()?)
    }

    /// What it found: t of all rays, and 1 for each segment that is not free.
    fn found(&mut self, folder: &Path) -> Result<Vec<f32>> {
        let path = folder.join("rays.found");
        self.ask(&format!("save {}", path.display()))?;
        let bytes = fs::read(&path)?;
        fs::remove_file(&path)?;
        let (numbers, _) = bytes.as_chunks::<4>();
        Ok(numbers.iter().copied().map(f32::from_ne_bytes).collect())
    }
}

impl Drop for Yardstick {
    fn drop(&mut self) {
        // It is ours and has nothing to lose; that it may have ended already is no matter.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Measures all scenes; a table in Markdown.
pub(crate) fn measure(
    folder: &Path,
    scenes: &[&Scene],
    runs: u32,
    embree: Option<u8>,
) -> Result<String> {
    let program = compile_from(SOURCE, &folder.join("ray-yardstick"), embree);
    if let Err(error) = &program {
        eprintln!("The yardstick of rays cannot be compiled: {error}\ncandela is measured alone.");
    }
    let program = program.ok();
    let mut table = String::from(
        "Million rays a second of processor time, one thread; how many times as fast candela is: the median of the runs, \
         with the least and the most.\n\n\
         | scene | bundle | question | candela | Embree | ratio | different | Embree, ray by ray | ratio |\n\
         | --- | --- | --- | ---: | ---: | --- | ---: | ---: | --- |\n",
    );
    for scene in scenes {
        let world = World::load(&scene.path)?.world;
        for bundle in bundles(&world) {
            eprintln!("{}: {} …", scene.name, bundle.name);
            let path = folder.join(format!("{}-{}.rays", scene.name, bundle.name));
            write_bundle(&world, &bundle, &path)?;
            let yardstick = program
                .as_deref()
                .map(|program| Yardstick::start(program, &path));
            let (yardstick, _) = yardstick.transpose()?.unzip();
            table += &measure_bundle(folder, &scene.name, &world, &bundle, yardstick, runs)?;
            fs::remove_file(path)?;
        }
    }
    Ok(table)
}

/// Seconds that this thread has had of a processor.
#[cfg(unix)]
fn processor_time() -> Result<f64> {
    let time = nix::time::clock_gettime(nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID)?;
    Ok(time.tv_sec() as f64 + time.tv_nsec() as f64 * 1e-9)
}

/// Seconds since the first call.
#[cfg(not(unix))]
fn processor_time() -> Result<f64> {
    use std::sync::OnceLock;
    use std::time::Instant;
    static START: OnceLock<Instant> = OnceLock::new();
    Ok(START.get_or_init(Instant::now).elapsed().as_secs_f64())
}

fn measure_bundle(
    folder: &Path,
    scene: &str,
    world: &World,
    bundle: &Bundle,
    mut yardstick: Option<Yardstick>,
    runs: u32,
) -> Result<String> {
    let mut tracer = Tracer::new(world, SimdLevel::default());
    let room = bundle.rays.len();
    let (mut t, mut free) = (Vec::with_capacity(room), Vec::with_capacity(room));
    let (mut ours, mut theirs) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
    let mut singles = [Vec::new(), Vec::new()];
    // In turn, and the first run of each warms up.
    for run in 0..=runs {
        for question in 0..2 {
            let start = processor_time()?;
            if question == 0 {
                tracer.nearest(&bundle.rays, &mut t);
            } else {
                tracer.free(&bundle.segments, &mut free);
            }
            let seconds = processor_time()? - start;
            let mut ask = |command: &str| {
                let seconds = yardstick
                    .as_mut()
                    .map(|yardstick| yardstick.seconds(command));
                seconds.transpose()
            };
            // Packets last, which is what is saved.
            let single = ask(["nearest1", "occluded1"][question])?;
            let packets = ask(["nearest", "occluded"][question])?;
            if run > 0 {
                ours[question].push(seconds);
                singles[question].extend(single);
                theirs[question].extend(packets);
            }
        }
    }
    let all = bundle.rays.len() as f64;
    let share = |count: usize| 100.0 * count as f64 / all;
    eprintln!(
        "  {:.1} % of the rays hit something, {:.1} % of the segments are free",
        share(t.iter().filter(|t| t.is_finite()).count()),
        share(free.iter().filter(|&&free| free).count()),
    );
    let mut different = [None; 2];
    if let Some(yardstick) = &mut yardstick {
        let found = yardstick.found(folder)?;
        let (their_t, their_dark) = found.split_at(t.len());
        let is_near = |ours: f64, theirs: f64| {
            ours == theirs || (ours - theirs).abs() <= 1e-3 * ours.abs().max(1e-2)
        };
        let count = |differ: usize| Some(differ as f64 / all);
        let pairs = t.iter().zip(their_t);
        different[0] = count(pairs.filter(|&(&a, &b)| !is_near(a, f64::from(b))).count());
        let pairs = free.iter().zip(their_dark);
        different[1] = count(pairs.filter(|&(&free, &dark)| free == (dark > 0.5)).count());
    }
    let mut rows = String::new();
    for (question, name) in ["nearest", "free"].into_iter().enumerate() {
        let rate = |seconds: &[f64]| all / Spread::of(seconds.to_vec()).median / 1e6;
        let (ours, theirs) = (&ours[question], &theirs[question]);
        write!(
            rows,
            "| {scene} | {} | {name} | {:.2} |",
            bundle.name,
            rate(ours)
        )?;
        if theirs.is_empty() {
            writeln!(rows, " | | | | |")?;
            continue;
        }
        let ratio_to =
            |theirs: &[f64]| Spread::of(theirs.iter().zip(ours).map(|(b, a)| b / a).collect());
        let (ratio, to_single) = (ratio_to(theirs), ratio_to(&singles[question]));
        let differ = different[question].unwrap_or_default();
        let mark = if differ > DIFFERENT { " (!)" } else { "" };
        writeln!(
            rows,
            " {:.2} | {:.2} ({:.2}–{:.2}) | {differ:.1e}{mark} | {:.2} | {:.2} ({:.2}–{:.2}) |",
            rate(theirs),
            ratio.median,
            ratio.min,
            ratio.max,
            rate(&singles[question]),
            to_single.median,
            to_single.min,
            to_single.max,
        )?;
    }
    Ok(rows)
}
