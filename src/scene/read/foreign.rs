//! Files of other kinds that are given as a scene: what they are, and what to do with them.

use std::path::Path;

use super::super::diagnostic::Problem;

/// First bytes that tell a kind of file, what it is called, and what to do with it.
const SIGNATURES: [(&[u8], &str, &str); 24] = [
    (b"\x76\x2f\x31\x01", "an OpenEXR image", TONEMAP),
    (b"\x89PNG\r\n\x1a\n", "a PNG image", IMAGE),
    (b"\xff\xd8\xff", "a JPEG image", IMAGE),
    (b"II*\0", "a TIFF image", IMAGE),
    (b"MM\0*", "a TIFF image", IMAGE),
    (b"#?RADIANCE", "a Radiance HDR image", IMAGE),
    (b"#?RGBE", "a Radiance HDR image", IMAGE),
    (b"GIF8", "a GIF image", IMAGE),
    (b"ply\n", "a PLY mesh", MESH),
    (b"ply\r", "a PLY mesh", MESH),
    (b"ply ", "a PLY mesh", MESH),
    (b"glTF", "a glTF model", EXPORT),
    (b"Kaydara FBX", "an FBX model", EXPORT),
    (b"BLENDER", "a Blender file", EXPORT),
    (b"#usda", "a USD file", EXPORT),
    (b"PXR-USDC", "a USD file", EXPORT),
    (b"solid ", "an STL mesh", EXPORT),
    (b"PK\x03\x04", "a ZIP archive", UNPACK),
    (b"\x1f\x8b", "a gzip archive", UNPACK),
    (b"\x28\xb5\x2f\xfd", "compressed by Zstandard", UNPACK),
    (b"%PDF", "a PDF document", SCENE),
    (b"\x7fELF", "a program", SCENE),
    (b"IESNA", "an IES photometric file", SCENE),
    (b"#!", "a script", SCENE),
];

const TONEMAP: &str = "`candela tonemap` makes a picture of it";
const IMAGE: &str = "it is a picture already; a scene is a TOML file, such as `candela new` writes";
const MESH: &str = "name it in a scene, which is a TOML file: `[objects.NAME.mesh]` with `file = …` and \
                    `material = …`";
const EXPORT: &str = "write its shapes as PLY or OBJ, and name them in a scene, which is a TOML file: \
                      `[objects.NAME.mesh]` with `file = …`";
const UNPACK: &str = "unpack it first";
const SCENE: &str = "a scene is a TOML file; docs/scene-format.md describes it";
const OTHER_SCENE: &str = "a scene of candela is a TOML file with other sections; docs/scene-format.md \
                           describes them";

/// What a file is that is not a scene, by its first bytes; only of a file that is no TOML, of which
/// these could be comments or keys.
pub(super) fn recognized(bytes: &[u8], path: &Path) -> Option<Problem> {
    let not_a_scene = |what, way_out| Problem::NotAScene { what, way_out };
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Some(not_a_scene("UTF-16 text", "save it as UTF-8"));
    }
    let signature = SIGNATURES
        .iter()
        .find(|(start, ..)| bytes.starts_with(start));
    if let Some(&(_, what, way_out)) = signature {
        return Some(not_a_scene(what, way_out));
    }
    let start = &bytes[..bytes.len().min(4096)];
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    let is_markdown = matches!(&*extension, "md" | "markdown");
    let (what, way_out) = if is_markdown {
        ("a Markdown document", SCENE)
    } else {
        by_words(text)?
    };
    Some(not_a_scene(what, way_out))
}

/// What a text is by the words that its first lines begin with.
fn by_words(text: &str) -> Option<(&'static str, &'static str)> {
    if text.starts_with("<scene") || text.starts_with("<?xml") && text.contains("<scene") {
        return Some(("a Mitsuba scene", OTHER_SCENE));
    }
    if text.to_lowercase().starts_with("<!doctype html") || text.starts_with("<html") {
        return Some(("a web page", SCENE));
    }
    if text.starts_with('<') {
        return Some(("XML", SCENE));
    }
    if text.starts_with('{') || text.starts_with("[\n") || text.starts_with("[{") {
        let is_gltf = text.contains("\"asset\"") && text.contains("\"version\"");
        return Some(if is_gltf {
            ("a glTF model", EXPORT)
        } else {
            ("JSON", SCENE)
        });
    }
    if text.lines().any(|line| line.starts_with("```")) {
        return Some(("a Markdown document", SCENE));
    }
    let mut lines = text.lines().map(str::trim);
    let mut lines = lines
        .by_ref()
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .take(8);
    let words: Vec<(&str, &str)> = lines
        .by_ref()
        .map(|line| line.split_once(char::is_whitespace).unwrap_or((line, "")))
        .collect();
    let all =
        |known: &[&str]| !words.is_empty() && words.iter().all(|(word, _)| known.contains(word));
    let any = |known: &[&str]| words.iter().any(|(word, _)| known.contains(word));
    if all(&[
        "newmtl", "Ka", "Kd", "Ks", "Ke", "Ns", "Ni", "d", "illum", "Tr", "Tf", "map_Kd",
    ]) && any(&["newmtl"])
    {
        return Some((
            "a material library of OBJ files",
            "write each as `[materials.NAME.phong]` in a scene, Kd as `diffuse`, Ks as `specular`, \
             Ns as `shininess`",
        ));
    }
    if all(&[
        "v", "vn", "vt", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl",
    ]) {
        return Some(("an OBJ mesh", MESH));
    }
    if any(&[
        "LookAt",
        "Camera",
        "WorldBegin",
        "Film",
        "Integrator",
        "Sampler",
        "PixelFilter",
    ]) {
        return Some(("a pbrt scene", OTHER_SCENE));
    }
    let is_number = |text: &str| text.trim().parse::<f64>().is_ok();
    let is_table = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .take(8)
        .skip(1)
        .all(|line| {
            let columns: Vec<&str> = line
                .split([',', ';', '\t', ' '])
                .filter(|part| !part.is_empty())
                .collect();
            columns.len() >= 2 && columns.into_iter().all(is_number)
        });
    if is_table && words.len() > 1 {
        return Some((
            "a table of numbers",
            "if it is a curve of wavelengths in nm, name it in a scene: `{ file = … }`",
        ));
    }
    let is_yaml = |(word, _): &(&str, &str)| word.ends_with(':') || *word == "---" || *word == "-";
    if words.len() > 1 && words.iter().all(is_yaml) {
        return Some(("YAML", SCENE));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::Reading;
    use super::*;

    fn what(bytes: &[u8]) -> Option<&'static str> {
        match recognized(bytes, Path::new("scene.toml"))? {
            Problem::NotAScene { what, .. } => Some(what),
            problem => panic!("{problem}"),
        }
    }

    #[test]
    fn files_of_other_kinds_are_named() {
        for (bytes, expected) in [
            (&b"\x76\x2f\x31\x01\x02\0\0\0"[..], "an OpenEXR image"),
            (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "a PNG image"),
            (b"\xff\xd8\xff\xe0\0\x10JFIF", "a JPEG image"),
            (b"ply\nformat ascii 1.0\n", "a PLY mesh"),
            (b"ply\r\nformat binary_little_endian 1.0\r\n", "a PLY mesh"),
            (
                b"# Blender\nmtllib a.mtl\no Cube\nv 1 1 1\nv 1 1 -1\n",
                "an OBJ mesh",
            ),
            (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "an OBJ mesh"),
            (
                b"# Blender\nnewmtl clay\nKd 1 1 1\nNs 50\n",
                "a material library of OBJ files",
            ),
            (b"glTF\x02\0\0\0", "a glTF model"),
            (b"{\"asset\": {\"version\": \"2.0\"}}", "a glTF model"),
            (b"{\n  \"image\": { \"width\": 8 }\n}\n", "JSON"),
            (b"<scene version=\"3.0.0\">\n", "a Mitsuba scene"),
            (
                b"<?xml version=\"1.0\"?>\n<scene version=\"2.0.0\">",
                "a Mitsuba scene",
            ),
            (b"<svg>", "XML"),
            (
                b"LookAt 3 4 1.5  .5 .5 0  0 0 1\nCamera \"perspective\" \"float fov\" 45\n",
                "a pbrt scene",
            ),
            (
                b"# candela\n\nA renderer.\n\n```console\n$ cargo run\n```\n",
                "a Markdown document",
            ),
            (b"PK\x03\x04\x14\0", "a ZIP archive"),
            (b"\xff\xfe[\0i\0", "UTF-16 text"),
            (
                b"nm,value\n400,0.1\n500,0.2\n600,0.5\n",
                "a table of numbers",
            ),
            (b"image:\n  width: 8\n  height: 8\n", "YAML"),
            (b"---\ncamera:\n  fov: 40\n", "YAML"),
        ] {
            assert_eq!(
                what(bytes),
                Some(expected),
                "{}",
                String::from_utf8_lossy(bytes)
            );
        }
    }

    #[test]
    fn scenes_with_errors_stay_scenes() {
        for text in [
            "[image]\nresolution = [8, 8\n",
            "# a scene\n[objects.ball.sphere]\nradius: 0.5\n",
            "resolution = [8, 8]\n",
            "radius 0.5\n",
            "",
            "# only comments\n",
        ] {
            assert_eq!(what(text.as_bytes()), None, "{text}");
        }
    }

    /// What is TOML is a scene, whatever it looks like.
    #[test]
    fn toml_is_never_another_kind() {
        let text = "#?RADIANCE\n# ```\n[image]\nresolution = [8, 8]\n";
        let reading = Reading::of_text(text.to_owned(), Path::new("a.toml"));
        let is_other = |problem: &Problem| matches!(problem, Problem::NotAScene { .. });
        assert!(
            !reading
                .diagnostics
                .iter()
                .any(|found| is_other(&found.problem))
        );
        let prose = "# A title\n\nSome words about it.\n";
        let reading = Reading::of_text(prose.to_owned(), Path::new("README.md"));
        assert!(is_other(&reading.diagnostics[0].problem));
        let reading = Reading::of_bytes(
            b"ply\nformat ascii 1.0\n".to_vec(),
            Path::new("a.ply"),
            Path::new(""),
            &[],
        );
        let [diagnostic] = &reading.diagnostics[..] else {
            panic!("one error");
        };
        assert!(is_other(&diagnostic.problem), "{}", diagnostic.problem);
    }
}
