//! The yardstick: the same work on Embree, by the program in `benches/embree`.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use candela::Point;
use candela::world::material::Model;
use candela::world::{Light, World};
use candela::{Camera, Projection};

use super::Result;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/embree/yardstick.cpp");

/// A running yardstick that has a scene.
#[derive(Debug)]
pub(crate) struct Yardstick {
    process: Child,
    commands: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// Seconds to read the scene and put it into Embree's buffers.
    pub(crate) load: f64,
    /// Seconds to build Embree's tree.
    pub(crate) build: f64,
    /// Embree's version.
    pub(crate) version: String,
}

/// Compiles the yardstick; where it is, or why it is not there.
pub(crate) fn compile(folder: &Path, embree: Option<u8>) -> Result<PathBuf> {
    compile_from(SOURCE, &folder.join("yardstick"), embree)
}

/// Compiles a program that uses Embree of this version or else, Embree 4 where it is installed and 3 where it is not.
/// It is compiled each time, as another Embree may be installed now.
pub(crate) fn compile_from(source: &str, program: &Path, embree: Option<u8>) -> Result<PathBuf> {
    match embree {
        Some(version) => compile_with(source, program, version),
        None => compile_with(source, program, 4).or_else(|_| compile_with(source, program, 3)),
    }
}

fn compile_with(source: &str, program: &Path, embree: u8) -> Result<PathBuf> {
    let output = Command::new("c++")
        .args([
            "-std=c++17",
            "-O3",
            "-march=native",
            "-ffast-math",
            &format!("-DEMBREE={embree}"),
            source,
            "-o",
        ])
        .arg(program)
        .args([&format!("-lembree{embree}"), "-lpthread"])
        .output()
        .map_err(|error| format!("no C++ compiler (c++): {error}"))?;
    if output.status.success() {
        Ok(program.to_owned())
    } else {
        let message = String::from_utf8_lossy(&output.stderr);
        Err(message.lines().next().unwrap_or_default().into())
    }
}

impl Yardstick {
    /// Starts `program` on a scene, and waits until it has built its tree.
    pub(crate) fn start(program: &Path, scene: &Path, threads: usize) -> Result<Self> {
        let mut process = Command::new(program)
            .arg(scene)
            .arg(threads.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let commands = process.stdin.take().ok_or("no input to the yardstick")?;
        let answers = process.stdout.take().ok_or("no output of the yardstick")?;
        let mut yardstick = Self {
            process,
            commands,
            answers: BufReader::new(answers),
            load: 0.0,
            build: 0.0,
            version: String::new(),
        };
        let ready = yardstick.answer()?;
        let ["ready", load, build, version] = ready.split_whitespace().collect::<Vec<_>>()[..]
        else {
            return Err(format!("the yardstick says {ready:?}").into());
        };
        yardstick.load = load.parse()?;
        yardstick.build = build.parse()?;
        yardstick.version = version.to_owned();
        Ok(yardstick)
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

    /// Renders with the first `lights` lights; the seconds that it took.
    pub(crate) fn render(&mut self, samples: u32, threads: usize, lights: usize) -> Result<f64> {
        Ok(self
            .ask(&format!("render {samples} {threads} {lights}"))?
            .parse()?)
    }

    /// The seconds that the same takes where no ray is traced: arithmetic and memory of shading.
    pub(crate) fn shade(&mut self, samples: u32, threads: usize, lights: usize) -> Result<f64> {
        Ok(self
            .ask(&format!("shade {samples} {threads} {lights}"))?
            .parse()?)
    }

    /// R, G, B of every pixel of the last image, row by row from the top.
    pub(crate) fn image(&mut self, folder: &Path) -> Result<Vec<[f32; 3]>> {
        let path = folder.join("yardstick.rgb");
        self.ask(&format!("save {}", path.display()))?;
        let bytes = fs::read(&path)?;
        fs::remove_file(&path)?;
        let (values, _) = bytes.as_chunks::<4>();
        let (pixels, _) = values.as_chunks::<3>();
        Ok(pixels
            .iter()
            .map(|pixel| pixel.map(f32::from_ne_bytes))
            .collect())
    }
}

impl Drop for Yardstick {
    fn drop(&mut self) {
        // It is ours and has nothing to lose; that it may have ended already is no matter.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// 32-bit numbers into a file.
struct Numbers(BufWriter<File>);

impl Numbers {
    fn count(&mut self, count: usize) -> Result<()> {
        let count = u32::try_from(count)?;
        Ok(self.0.write_all(&count.to_ne_bytes())?)
    }

    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) -> Result<()> {
        for number in numbers {
            self.0.write_all(&(number as f32).to_ne_bytes())?;
        }
        Ok(())
    }

    fn corners(&mut self, corners: &[[u32; 3]]) -> Result<()> {
        self.count(3 * corners.len())?;
        for corner in corners.as_flattened() {
            self.0.write_all(&corner.to_ne_bytes())?;
        }
        Ok(())
    }

    fn vectors(&mut self, vectors: &[[f32; 3]]) -> Result<()> {
        self.count(vectors.len())?;
        for number in vectors.as_flattened() {
            self.0.write_all(&number.to_ne_bytes())?;
        }
        Ok(())
    }
}

/// All triangles of one material, with or without vertex normals.
#[derive(Default)]
struct Triangles {
    positions: Vec<[f32; 3]>,
    corners: Vec<[u32; 3]>,
    normals: Vec<[f32; 3]>,
    normal_corners: Vec<[u32; 3]>,
}

/// Writes a world as the yardstick reads it: what candela renders, resolved and transformed, in f32.
pub(crate) fn write_scene(world: &World, camera: &Camera, path: &Path) -> Result<()> {
    if !world.planes().is_empty() {
        return Err("the yardstick knows no planes".into());
    }
    let mut file = Numbers(BufWriter::new(File::create(path)?));
    let [width, height] = camera.resolution();
    file.count(width as usize)?;
    file.count(height as usize)?;
    write_camera(camera, &mut file)?;
    file.count(world.lights().len())?;
    for light in world.lights() {
        let Light::Point(light) = light.value else {
            return Err("the yardstick knows no lights but points".into());
        };
        file.numbers(light.position.0.to_array())?;
        file.numbers(light.intensity.0.0)?;
    }
    file.numbers(world.background().0.0)?;

    let triangles = triangles_by_material(world);
    let spheres = spheres_by_material(world);
    file.count(triangles.len() + spheres.len())?;
    for (material, is_smooth, part) in &triangles {
        file.count(if *is_smooth { 2 } else { 1 })?;
        write_material(world, *material, &mut file)?;
        file.vectors(&part.positions)?;
        file.corners(&part.corners)?;
        if *is_smooth {
            file.vectors(&part.normals)?;
            file.corners(&part.normal_corners)?;
        }
    }
    for (material, spheres) in &spheres {
        file.count(0)?;
        write_material(world, *material, &mut file)?;
        file.count(spheres.as_flattened().len())?;
        file.numbers(spheres.as_flattened().iter().copied())?;
    }
    Ok(file.0.flush()?)
}

/// A ray at pixel (0, 0), and what a column and a row add to it.
fn write_camera(camera: &Camera, file: &mut Numbers) -> Result<()> {
    let [width, height] = camera.resolution().map(f64::from);
    let origin = |x, y| camera.ray(x, y).origin.0;
    let direction = |x, y| camera.ray(x, y).direction;
    let first = Point(origin(0.0, 0.0));
    let (right, below) = match camera.projection() {
        Projection::Perspective { .. } => (first, first),
        Projection::Orthographic { .. } => (Point(origin(width, 0.0)), Point(origin(0.0, height))),
    };
    file.numbers(first.0.to_array())?;
    file.numbers((right.from(first) / width).to_array())?;
    file.numbers((below.from(first) / height).to_array())?;
    let first = direction(0.0, 0.0);
    file.numbers(first.to_array())?;
    file.numbers(((direction(width, 0.0) - first) / width).to_array())?;
    file.numbers(((direction(0.0, height) - first) / height).to_array())
}

fn write_material(world: &World, material: usize, file: &mut Numbers) -> Result<()> {
    let material = &world.materials()[material].value;
    if material.model() != Model::Phong {
        return Err("the yardstick knows `phong` only".into());
    }
    let reflectance = material.reflectance();
    file.numbers(reflectance.diffuse.0.0)?;
    file.numbers(reflectance.specular.0.0)?;
    file.numbers([material.shininess()])
}

fn spheres_by_material(world: &World) -> Vec<(usize, Vec<[f64; 4]>)> {
    let mut parts: Vec<(usize, Vec<[f64; 4]>)> = Vec::new();
    for sphere in world.spheres() {
        let material = world.objects()[sphere.object as usize].material;
        let part = parts.iter().position(|(known, _)| *known == material);
        let part = part.unwrap_or_else(|| {
            parts.push((material, Vec::new()));
            parts.len() - 1
        });
        let [x, y, z] = sphere.center.0.to_array();
        parts[part].1.push([x, y, z, sphere.radius]);
    }
    parts
}

fn triangles_by_material(world: &World) -> Vec<(usize, bool, Triangles)> {
    let mut parts: Vec<(usize, bool, Triangles)> = Vec::new();
    let mut vertices: Vec<HashMap<[u32; 3], u32>> = Vec::new();
    for mesh in world.triangles().meshes() {
        let material = world.objects()[mesh.object as usize].material;
        let kind = (material, mesh.normals.is_some());
        let place = parts.iter().position(|part| (part.0, part.1) == kind);
        let place = place.unwrap_or_else(|| {
            parts.push((kind.0, kind.1, Triangles::default()));
            vertices.push(HashMap::new());
            parts.len() - 1
        });
        let part = &mut parts[place].2;
        for triangle in mesh.triangles.clone() {
            // Triangles share vertices again, as they do in the mesh's file.
            part.corners
                .push(world.triangles().vertices(triangle).map(|vertex| {
                    let position = vertex.as_vec3().to_array();
                    let known = vertices[place].entry(position.map(f32::to_bits));
                    *known.or_insert_with(|| {
                        part.positions.push(position);
                        part.positions.len() as u32 - 1
                    })
                }));
        }
        if let Some(normals) = &mesh.normals {
            let mut known = HashMap::new();
            for triangle in mesh.triangles.clone() {
                let triangles = world.triangles();
                let corners = triangles.normals_at(normals, mesh.triangles.start, triangle);
                // Triangles share normals again.
                part.normal_corners.push(corners.map(|normal| {
                    let normal = normal.get().as_vec3().to_array();
                    *known.entry(normal.map(f32::to_bits)).or_insert_with(|| {
                        part.normals.push(normal);
                        part.normals.len() as u32 - 1
                    })
                }));
            }
        }
    }
    parts
}
