//! `candela check`: is a scene legal, what will be modeled, what will it cost.

use std::io::Write;

use candela::Renderer;
use candela::internal::Size;
use candela::internal::{counted, printable, printable_path};
use candela::scene::{Motion, Scene, Transport};
use candela::world::difference::differences;
use candela::world::material::Model;
use candela::world::plan::{self, Acceleration};
use candela::world::{AreaLight, Delta, Light, Loaded, Plan, Shape, World, physics};

use super::Failure;
use super::frames::{Frame, Frames, frames};
use super::legality::{self, Triangles};
use super::light::in_planes;
use super::source::SceneArguments;

/// Check a scene without rendering it: is it legal, what will be computed and what left out, what
/// will it cost
///
/// Prints the scene's objects, materials and lights, the plan with its reasons, the memory it
/// takes, and warnings about what is legal but physically odd.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela check scenes/lecture.toml
  generate | candela check - --base models
      A scene from another program, whose files are in models
  candela check shot.toml --frames 1-240
      Is every frame legal; without, those of keys are looked at")]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// Also check each of these frames, beside those of keys; what is printed is of the first
    #[arg(long, visible_alias = "frame", value_name = "LIST", value_parser = frames, allow_hyphen_values = true)]
    frames: Option<Frames>,
}

pub(crate) fn run(arguments: &Arguments, output: &mut impl Write) -> Result<(), Failure> {
    let frames = arguments.frames.as_ref().map_or(&[][..], Frames::list);
    let first = frames.first().map(|frame| frame.number());
    let Loaded {
        scene,
        world,
        camera,
        motion,
    } = arguments.scene.load(first, |_| {})?;
    // What a key says is wrong at whatever frames are looked at.
    let keys = motion.key_frames().iter().copied();
    let mut numbers: Vec<f64> = frames
        .iter()
        .map(|frame| frame.number())
        .chain(keys)
        .collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    legality::check_frames(&numbers, &motion, &scene, &world, Triangles::Placed)?;
    let renderer = Renderer::new(&world)?;
    let plan = renderer.plan();

    let [width, height] = camera.resolution();
    writeln!(
        output,
        "{} is legal",
        printable_path(arguments.scene.name())
    )?;
    writeln!(
        output,
        "\nimage      {width} × {height}, {}",
        world.color_space().name()
    )?;
    print_motion(&motion, frames, output)?;
    print_objects(&world, output)?;
    print_materials(&world, output)?;
    print_lights(&world, output)?;
    print_plan(&world, plan, output)?;
    print_differences(scene, &world, plan, output)?;

    let film = u64::from(width) * u64::from(height) * size_of::<[f32; 4]>() as u64;
    let shapes = (world.triangles().memory() + renderer.memory()) as u64;
    writeln!(
        output,
        "\nmemory     {} film, {} shapes and trees",
        Size(film),
        Size(shapes)
    )?;
    if let Some(memory) = world.products_memory() {
        let lights = counted(world.lights().len(), "light", "lights");
        let materials = counted(world.used_materials().len(), "material", "materials");
        let products = format!("products of the spectra of {lights} and {materials}");
        if memory == 0 && !world.lights().is_empty() {
            let made = "too many for a table: each tile makes its own";
            writeln!(output, "           {products}: {made}")?;
        } else {
            writeln!(output, "           {} {products}", Size(memory))?;
        }
    }
    let shadow_rays = world.lights().len();
    let pixels = width as usize * height as usize;
    writeln!(
        output,
        "rays       {} a sample, and up to {} for each",
        counted(pixels, "camera ray", "camera rays"),
        counted(shadow_rays, "shadow ray", "shadow rays"),
    )?;

    let warnings = physics::warnings(&world);
    if !warnings.is_empty() {
        writeln!(output, "\nwarnings   {}", warnings.len())?;
        for warning in warnings.iter().take(LISTED) {
            writeln!(output, "  {warning}")?;
        }
        print_rest(warnings.len(), output)?;
    }
    Ok(())
}

/// More pairs of a light and a material than this are not compared.
const COMPARED: usize = 1_000_000;

/// Nor are more lights and materials, which may all have colors of their own: a spectrum for each takes
/// 0.1 ms to find.
const SOLVED: usize = 10_000;

/// More entries of a kind than this are counted, not listed.
const LISTED: usize = 20;

fn print_motion(motion: &Motion, frames: &[Frame], output: &mut impl Write) -> Result<(), Failure> {
    let Some([first, last]) = motion.frames() else {
        return Ok(());
    };
    let names: Vec<String> = motion.names().iter().map(|name| printable(name)).collect();
    writeln!(output, "\nmoves      {}", names.join(", "))?;
    writeln!(output, "           keys from frame {first} to {last}")?;
    if let [first, .., last] = frames {
        let count = frames.len();
        writeln!(
            output,
            "           {count} frames from {first} to {last} are legal"
        )?;
    }
    Ok(())
}

fn print_objects(world: &World, output: &mut impl Write) -> Result<(), Failure> {
    // Lights that are seen are listed as lights.
    let (lights, objects): (Vec<_>, Vec<_>) = world
        .objects()
        .iter()
        .partition(|object| object.emits.is_some());
    let triangles = world.triangles().len();
    write!(
        output,
        "\nobjects    {}, with {}",
        objects.len(),
        counted(triangles, "triangle", "triangles"),
    )?;
    match lights.len() {
        0 => writeln!(output)?,
        count => writeln!(
            output,
            ", and {} seen",
            counted(count, "light that is", "lights that are")
        )?,
    }
    for object in objects.iter().take(LISTED) {
        let material = printable(&world.materials()[object.material].name);
        let shape = match object.shape {
            Shape::Sphere(_) => "sphere".to_owned(),
            Shape::Plane(_) => "plane".to_owned(),
            Shape::Disk(_) => "disk".to_owned(),
            Shape::Mesh(index) => {
                let mesh = &world.triangles().meshes()[index];
                let normals = if mesh.normals.is_some() {
                    "smooth"
                } else {
                    "flat"
                };
                let triangles = counted(mesh.triangles.len(), "triangle", "triangles");
                format!("{triangles}, {normals}")
            }
        };
        let name = printable(&object.name);
        writeln!(output, "  {name:<20} {shape}, of {material}")?;
    }
    print_rest(objects.len(), output)
}

fn print_materials(world: &World, output: &mut impl Write) -> Result<(), Failure> {
    let seen = world.objects().iter();
    let seen = seen.filter(|object| object.emits.is_some()).count();
    // Behind them are those of lights that are seen, which are black.
    let materials = &world.materials()[..world.materials().len() - seen];
    writeln!(output, "\nmaterials  {}", materials.len())?;
    for (index, material) in materials.iter().enumerate().take(LISTED) {
        let delta = world.delta(index);
        if let Some(delta) = delta
            && !delta.has_lobes()
        {
            let name = printable(&material.name);
            writeln!(output, "  {name:<20} {}", smooth(delta, world))?;
            continue;
        }
        let model = match material.value.model() {
            Model::Phong => "phong",
            Model::NormalizedPhong => "normalized_phong",
        };
        let lobes = if material.value.is_specular() {
            format!(
                "diffuse and specular, shininess {}",
                material.value.shininess()
            )
        } else {
            "diffuse".to_owned()
        };
        let albedo = physics::albedo_at_normal_incidence(&material.value);
        let albedo = albedo.map(|channel| format!("{channel:.3}")).join(" ");
        writeln!(
            output,
            "  {:<20} {model}: {lobes}; reflects [{albedo}] of the light along its normal{}",
            printable(&material.name),
            delta.map_or_else(String::new, |delta| format!(
                ", under a {}",
                smooth(delta, world)
            )),
        )?;
    }
    print_rest(materials.len(), output)
}

/// What a perfectly smooth material is, and what of it is not computed.
fn smooth(delta: &Delta, world: &World) -> String {
    let is_spectral = world.spectra().is_some();
    let rising = |schlick: bool| {
        if schlick {
            ", rising to 1 at grazing"
        } else {
            ""
        }
    };
    match delta {
        Delta::Mirror(tint) => {
            let [r, g, b] = tint.rgb.map(rounded);
            format!("mirror: reflects [{r} {g} {b}]{}", rising(tint.schlick))
        }
        Delta::Coat {
            reflectance,
            schlick,
        } => format!(
            "coat that reflects {}{}",
            rounded(*reflectance),
            rising(*schlick)
        ),
        Delta::Metal(_) if is_spectral => {
            "metal: Fresnel's reflectance at each wavelength".to_owned()
        }
        Delta::Metal(_) => "metal: Fresnel's reflectance, as RGB under daylight, D65".to_owned(),
        Delta::Glass(glass) => {
            let mut text = format!("glass: n = {}", rounded(glass.n));
            if glass.dispersion.is_some() {
                text.push_str(if is_spectral {
                    " at 587.6 nm, disperses"
                } else {
                    "; with RGB nothing is dispersed"
                });
            }
            if let Some(absorption) = &glass.absorption {
                let [r, g, b] = absorption.rgb.map(rounded);
                text.push_str(&format!(", absorbs [{r} {g} {b}] per metre"));
            }
            text + "; opaque to the light of lamps, which lights nothing through it"
        }
        Delta::Pane { n } => format!(
            "pane: n = {}, unbent; lets the light of lamps pass",
            rounded(*n)
        ),
    }
}

fn print_lights(world: &World, output: &mut impl Write) -> Result<(), Failure> {
    writeln!(output, "\nlights     {}", world.lights().len())?;
    for (index, light) in world.lights().iter().enumerate().take(LISTED) {
        let mut channels = light.value.intensity().0.0;
        let mut unit = "cd";
        // A part of the largest intensity, as the whole angle at which that is.
        let mut widths = String::new();
        let name = printable(&light.name);
        let kind = match &light.value {
            Light::Point(_) => "point".to_owned(),
            Light::Spot(spot) => {
                let [inner, outer] =
                    [spot.cone.inner(), spot.cone.outer()].map(|angle| rounded(angle.to_degrees()));
                let [beam, field] =
                    [0.5, 0.1].map(|part| rounded(2.0 * spot.cone.angle_at(part).to_degrees()));
                widths = format!(", beam {beam}°, field {field}°");
                format!("spot to {inner}° and {outer}°")
            }
            Light::Ies(ies) => {
                let file = &ies.luminaire;
                let photometry = &file.photometry;
                widths = format!(
                    ", beam {}, field {}",
                    in_planes(photometry.beam_angle()),
                    in_planes(photometry.field_angle())
                );
                unit = "cd at most";
                let rated = match file.rated_lumens() {
                    Some(lumens) => format!("lamps of {} lm", rounded(lumens)),
                    None => "absolute".to_owned(),
                };
                let zonal = rounded(photometry.zonal_lumens());
                format!(
                    "ies, {}, {rated}, zonal sum {zonal} lm",
                    photometry.coordinates()
                )
            }
            Light::Area(area) => {
                (channels, unit) = (area.luminance(), "cd/m²");
                let peak = rounded(world.candelas(index));
                widths = format!(", {peak} cd{}", beams(area));
                described(area)
            }
            Light::Sun(sun) => {
                unit = "lx";
                let [x, y, z] = (-sun.to_light.get()).to_array().map(rounded);
                format!("sun along [{x} {y} {z}]")
            }
        };
        let flux = light.value.flux().map_or_else(String::new, |flux| {
            format!(", {} lm", rounded(flux * world.candelas(index)))
        });
        let [r, g, b] = channels.map(rounded);
        writeln!(
            output,
            "  {name:<20} {kind}, [{r} {g} {b}] {unit}{flux}{widths}"
        )?;
    }
    print_rest(world.lights().len(), output)
}

/// Where the intensity of a flat light, a cosine, is a half and a tenth; a sphere's is the same everywhere.
fn beams(light: &AreaLight) -> String {
    if light.is_flat() {
        let [beam, field] = [0.5_f64, 0.1].map(|part| rounded(2.0 * part.acos().to_degrees()));
        format!(" along its normal, beam {beam}°, field {field}°")
    } else {
        String::new()
    }
}

/// What a light with an area is.
fn described(light: &AreaLight) -> String {
    let lengths: Vec<String> = light
        .lengths()
        .map(|length| rounded(length).to_string())
        .collect();
    let mut text = format!("{} {}", light.shape(), lengths.join(" × "));
    if light.is_two_sided() {
        text.push_str(", two-sided");
    }
    if !light.is_visible {
        text.push_str(", not seen");
    }
    text
}

/// Six digits of a number.
fn rounded(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

/// How different the colors would be if light were carried in the other way.
fn print_differences(
    mut scene: Scene,
    world: &World,
    plan: &Plan,
    output: &mut impl Write,
) -> Result<(), Failure> {
    let (lights, materials) = (world.lights().len(), world.materials().len());
    let pairs = lights * world.used_materials().len();
    if pairs > COMPARED || lights + materials > SOLVED {
        writeln!(
            output,
            "\ncolors     not compared with other transport: {lights} lights and {materials} \
             materials take too long"
        )?;
        return Ok(());
    }
    let (other, what) = match plan.transport() {
        plan::Transport::Rgb if world.spectral_values().is_empty() => (
            Transport::Spectral,
            "ΔE00 to smooth spectra of the same RGB values (`transport = \"spectral\"`)",
        ),
        plan::Transport::Rgb => (Transport::Spectral, "ΔE00 that RGB misses the spectra by"),
        plan::Transport::Spectral => (
            Transport::Rgb,
            "ΔE00 that RGB (`transport = \"rgb\"`) would miss this by",
        ),
    };
    scene.image.transport.value = other;
    writeln!(output, "\ncolors     {what}")?;
    let other = match World::new(&scene) {
        Ok((other, _)) => other,
        Err(errors) => {
            let why = errors.list().first().map(|error| error.problem.to_string());
            let why = why.unwrap_or_default();
            writeln!(output, "  cannot be said: {why}")?;
            return Ok(());
        }
    };
    let differences = differences(world, &other);
    if differences.is_empty() {
        writeln!(output, "  nothing is lit")?;
    }
    for difference in differences.iter().take(LISTED) {
        writeln!(
            output,
            "  {:<20} mean {:.2}, worst {:.2} on {}",
            printable(&world.lights()[difference.light].name),
            difference.mean,
            difference.worst,
            printable(&world.materials()[difference.worst_material].name),
        )?;
    }
    print_rest(differences.len(), output)?;
    if differences.len() > 1 {
        let pairs: usize = differences.iter().map(|of| of.materials).sum();
        let sum: f64 = differences
            .iter()
            .map(|of| of.mean * of.materials as f64)
            .sum();
        let worst = differences.iter().map(|of| of.worst).fold(0.0, f64::max);
        let mean = sum / pairs as f64;
        writeln!(
            output,
            "  {:<20} mean {mean:.2}, worst {worst:.2}",
            "all together"
        )?;
    }
    Ok(())
}

fn print_rest(count: usize, output: &mut impl Write) -> Result<(), Failure> {
    if count > LISTED {
        writeln!(output, "  and {} more", count - LISTED)?;
    }
    Ok(())
}

fn print_plan(world: &World, plan: &Plan, output: &mut impl Write) -> Result<(), Failure> {
    let (included, left_out): (Vec<_>, Vec<_>) = plan
        .decisions(world)
        .into_iter()
        .partition(|decision| decision.included);
    writeln!(output, "\nplan       computed")?;
    for decision in included {
        writeln!(output, "  {:<24} {}", decision.subject, decision.reason)?;
    }
    writeln!(output, "           left out")?;
    for decision in left_out {
        writeln!(output, "  {:<24} {}", decision.subject, decision.reason)?;
    }
    let trees = [plan.spheres(), plan.triangles()];
    if !trees.contains(&Acceleration::Tree) {
        writeln!(
            output,
            "  {:<24} so few shapes are faster one by one",
            "acceleration tree"
        )?;
    }
    Ok(())
}
