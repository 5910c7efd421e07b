//! What to write instead of what other programs call an option or a command.

use std::ffi::OsString;
use std::path::Path;

use candela::internal::printable;
use clap::CommandFactory;
use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue};

/// What is called otherwise here: the commands that it is about, its names elsewhere, and the tip.
type Advice = (
    &'static [&'static str],
    &'static [&'static str],
    &'static str,
);

const OPTIONS: [Advice; 21] = [
    (
        &["render"],
        &[
            "--spp",
            "--sample",
            "--samples-per-pixel",
            "--num-samples",
            "-s",
            "-n",
            "-N",
        ],
        "samples a pixel are `--samples N`",
    ),
    (
        &["render"],
        &[
            "--width",
            "--height",
            "--resolution",
            "--res",
            "--size",
            "--dimensions",
            "-w",
            "-W",
            "-H",
            "-r",
            "--aspect",
        ],
        "the size of the picture is the scene's: `resolution = [width, height]` in its `[image]`",
    ),
    (
        &["render"],
        &[
            "-j",
            "--jobs",
            "-t",
            "--thread",
            "--nthreads",
            "--num-threads",
            "--cores",
            "--cpus",
        ],
        "threads are `--threads N`",
    ),
    (
        &["render", "tonemap", "contact-sheet", "relight", "merge"],
        &[
            "--out",
            "--outfile",
            "--out-file",
            "--output-file",
            "--of",
            "-O",
            "--dest",
        ],
        "the file to write is `-o FILE`",
    ),
    (
        &["render", "tonemap", "contact-sheet"],
        &[
            "--ev",
            "--exposure-value",
            "--stops",
            "--exposure-compensation",
            "--gain",
            "-e",
        ],
        "the exposure is `--exposure EV`, in powers of 2",
    ),
    (
        &["render", "tonemap"],
        &["--gamma", "--srgb", "--brightness"],
        "a PNG is always sRGB-coded; `--exposure EV` makes it brighter, `--view NAME` chooses how light \
         beyond the screen is shown",
    ),
    (
        &["render", "tonemap"],
        &[
            "--tonemap",
            "--tone-map",
            "--tonemapper",
            "--operator",
            "--curve",
            "--filmic",
            "--aces",
        ],
        "how light beyond the screen is shown is `--view NAME`",
    ),
    (
        &["render"],
        &[
            "--aov",
            "--aovs",
            "--layer",
            "--passes",
            "--pass",
            "--aux",
            "--albedo",
            "--normal",
            "--normals",
            "--depth",
        ],
        "what is written beside the picture is `--layers LIST`, such as `--layers lights,depth,normal`",
    ),
    (
        &["render"],
        &[
            "--region",
            "--window",
            "--roi",
            "--cropwindow",
            "--crop-window",
            "--border",
        ],
        "a part of the picture is `--crop X0,Y0,X1,Y1`, in pixels",
    ),
    (
        &["render"],
        &[
            "--tiles",
            "--tile-count",
            "--tile-index",
            "--bucket",
            "--slice",
        ],
        "one of N tiles for one of N machines is `--tile I/N`, and `candela merge` makes the whole of them",
    ),
    (
        &["render"],
        &["--seed", "--random-seed"],
        "nothing is random: samples are a fixed pattern, the same on every machine",
    ),
    (
        &["render"],
        &["-f", "--start", "--end", "--animation", "-a"],
        "frames are `--frames 1-100`, with a name such as `-o f.####.exr`",
    ),
    (
        &["render"],
        &["--denoise", "--denoiser", "--noise-threshold"],
        "there is no noise to remove: edges alone need `--samples N`",
    ),
    (
        &["render"],
        &["--max-depth", "--depth-limit", "--bounces", "--integrator"],
        "only light that comes straight from a lamp is computed, so that there is nothing to choose",
    ),
    (
        &["render"],
        &["--gpu", "--device", "--backend", "--cuda"],
        "candela renders on the processor, with `--threads N`",
    ),
    (
        &["render"],
        &["--png", "--tonemapped", "--image"],
        "a picture beside the EXR is `--preview OUT.png`",
    ),
    (
        &["render"],
        &["--format", "--type", "-F"],
        "`-o` writes OpenEXR, and `--preview OUT.png` a picture beside it",
    ),
    (
        &["render"],
        &["-v", "--verbose", "--log", "--profile", "--time"],
        "counts and times are written by `--stats FILE.json`",
    ),
    (
        &["render"],
        &["--silent", "--no-progress", "--noprogress"],
        "no progress bar and no summary: `--quiet`",
    ),
    (
        &["render"],
        &["--spectral", "--mode", "--variant"],
        "how light is carried is the scene's: `transport = \"spectral\"` in its `[image]`; \
         `--layers spectral` writes a spectral image",
    ),
    (
        &["probe"],
        &[
            "--at",
            "--xy",
            "--px",
            "--coord",
            "-p",
            "-x",
            "--x",
            "--position",
        ],
        "the pixel is `--pixel X,Y`",
    ),
];

const COMMANDS: [(&[&str], &str); 8] = [
    (
        &[
            "convert", "view", "show", "display", "preview", "png", "topng", "develop", "expose",
        ],
        "a picture of an EXR is made by `candela tonemap IN.exr`",
    ),
    (
        &["validate", "lint", "info", "stat", "stats", "plan"],
        "what a scene holds, and whether it is legal, says `candela check SCENE.toml`",
    ),
    (
        &["compare", "idiff", "metrics", "flip", "difference", "psnr"],
        "how far an image is from another says `candela diff A.exr B.exr`",
    ),
    (
        &["bench", "benchmark", "convergence", "speed", "profile"],
        "speed against error is measured by `candela report SCENE.toml -o DIR`",
    ),
    (
        &["explain", "pixel", "inspect", "debug"],
        "one pixel is explained by `candela probe SCENE.toml --pixel X,Y`",
    ),
    (
        &["trace", "raytrace", "run", "draw", "start"],
        "a scene is rendered by `candela render SCENE.toml`",
    ),
    (
        &["init", "create", "template", "example", "demo"],
        "a first scene is written by `candela new`",
    ),
    (
        &["version"],
        "the version is printed by `candela --version`",
    ),
];

/// A usage error with a tip, where there is one that clap itself cannot know.
pub(super) fn advised(mut error: clap::Error, words: &[OsString]) -> clap::Error {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        _ => None,
    };
    let tip = if let Some(command) = text(ContextKind::InvalidSubcommand) {
        of_command(&command)
    } else if let Some(argument) = text(ContextKind::InvalidArg) {
        of_argument(&argument, words)
    } else {
        None
    };
    let Some(tip) = tip else {
        remove_dashes_tip(&mut error);
        keep_nearest_command(&mut error);
        return error;
    };
    for kind in [
        ContextKind::SuggestedArg,
        ContextKind::SuggestedSubcommand,
        ContextKind::SuggestedCommand,
    ] {
        error.remove(kind);
    }
    // The usage names the option that it took for the one that was meant.
    if let Some(usage) = usage(words) {
        error.insert(ContextKind::Usage, ContextValue::StyledStr(usage));
    }
    let tips = ContextValue::StyledStrs(vec![tip.into()]);
    error.insert(ContextKind::Suggested, tips);
    error
}

/// Removes clap's tip that `-- --option` makes an option a file name: it is seldom what was meant.
fn remove_dashes_tip(error: &mut clap::Error) {
    let Some(ContextValue::StyledStrs(mut tips)) = error.remove(ContextKind::Suggested) else {
        return;
    };
    tips.retain(|tip| !tip.to_string().contains(" as a value, use "));
    if !tips.is_empty() {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
    }
}

/// Keeps the most similar of the commands that clap offers, which is its last.
fn keep_nearest_command(error: &mut clap::Error) {
    let Some(ContextValue::Strings(mut commands)) = error.remove(ContextKind::SuggestedSubcommand)
    else {
        return;
    };
    if let Some(nearest) = commands.pop() {
        let nearest = ContextValue::Strings(vec![nearest]);
        error.insert(ContextKind::SuggestedSubcommand, nearest);
    }
}

/// How the command among the words is used.
fn usage(words: &[OsString]) -> Option<StyledStr> {
    let mut commands = super::Arguments::command();
    commands.build();
    let mut words = words.iter().skip(1).filter_map(|word| word.to_str());
    let name = words.find(|word| commands.find_subcommand(word).is_some())?;
    Some(commands.find_subcommand_mut(name)?.render_usage())
}

/// What stands where a command should be: a file, most often.
fn of_command(word: &str) -> Option<String> {
    let shown = printable(word);
    let extension = Path::new(word).extension().unwrap_or_default();
    Some(match extension.to_string_lossy().to_lowercase().as_str() {
        "toml" => format!("a scene is rendered by `candela render {shown}`"),
        "exr" => format!("a picture of an EXR is made by `candela tonemap {shown}`"),
        "ply" | "obj" => {
            format!("a mesh is part of a scene: `[objects.NAME.mesh]` with `file = \"{shown}\"`")
        }
        _ if word == "-" => {
            "a scene from standard input is rendered by `candela render -`".to_owned()
        }
        _ => {
            let word = word.to_lowercase();
            let known = COMMANDS.iter().find(|(words, _)| words.contains(&&*word));
            let is_file = !extension.is_empty() || word.contains(['/', '\\']);
            let tip = known.map(|(_, tip)| *tip);
            let any_file = "a scene is a TOML file, which `candela render SCENE.toml` renders";
            tip.or(is_file.then_some(any_file))?.to_owned()
        }
    })
}

/// What stands where no argument is expected, or none of this name.
fn of_argument(argument: &str, words: &[OsString]) -> Option<String> {
    let commands = super::Arguments::command();
    let mut words = words.iter().skip(1).filter_map(|word| word.to_str());
    let Some(command) = words.find(|word| commands.find_subcommand(word).is_some()) else {
        let tip = "a command comes first, such as `candela render SCENE.toml`";
        return argument.starts_with('-').then(|| tip.to_owned());
    };
    let name = argument.split('=').next().unwrap_or(argument);
    let option = OPTIONS
        .iter()
        .find(|(commands, names, _)| commands.contains(&command) && names.contains(&name));
    if let Some((_, _, tip)) = option {
        return Some((*tip).to_owned());
    }
    let shown = printable(argument);
    let extension = Path::new(argument).extension().unwrap_or_default();
    let extension = extension.to_string_lossy().to_lowercase();
    let is_pixel = argument.split(',').all(|part| part.parse::<u32>().is_ok());
    match (command, extension.as_str()) {
        ("probe", _) if is_pixel => Some(format!("the pixel is `--pixel {shown}`")),
        ("render", "exr") | ("contact-sheet", "png") => {
            Some(format!("the file to write is `-o {shown}`"))
        }
        ("render", "png") => Some(format!("a picture beside the EXR is `--preview {shown}`")),
        ("render" | "check" | "probe", "toml") => Some("one scene is read at a time".to_owned()),
        ("contact-sheet", "exr") => Some("one EXR is read at a time".to_owned()),
        _ => None,
    }
}

/// The part of a file name that stands for the number of a frame to other programs: `####`, `%04d`,
/// `$F4`, `<frame>`, `{frame}`.
pub(super) fn frame_number(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    if let Some(start) = name.find("##") {
        let end = name[start..]
            .find(|c| c != '#')
            .map_or(name.len(), |end| start + end);
        return Some(name[start..end].to_owned());
    }
    if let Some(start) = name.find('%') {
        let digits = name[start + 1..]
            .chars()
            .take_while(char::is_ascii_digit)
            .count();
        let end = start + 1 + digits;
        let mut after = name[end..].chars();
        if after.next() == Some('d') && !after.next().is_some_and(char::is_alphanumeric) {
            return Some(name[start..=end].to_owned());
        }
    }
    if let Some(start) = name.find("$F") {
        let digits = name[start + 2..]
            .chars()
            .take_while(char::is_ascii_digit)
            .count();
        return Some(name[start..start + 2 + digits].to_owned());
    }
    let lower = name.to_ascii_lowercase();
    let words = ["<frame>", "<f>", "{frame}", "[frame]"];
    words.iter().find_map(|word| {
        let start = lower.find(word)?;
        Some(name[start..start + word.len()].to_owned())
    })
}

/// The same, of a name that frames are written to: it has one such place, or none.
///
/// # Errors
/// There are two.
pub(super) fn place_of_number(path: &Path) -> Result<Option<String>, String> {
    let Some(part) = frame_number(path) else {
        return Ok(None);
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let rest = name.replacen(&part, "1", 1);
    match frame_number(Path::new(&rest)) {
        Some(other) => Err(format!(
            "{} has two places for the number of a frame, `{part}` and `{other}`; leave one of them",
            printable(&path.to_string_lossy()),
        )),
        None => Ok(Some(part)),
    }
}

/// The error that a file name with such a part is where one file is written.
pub(super) fn no_frames(path: &Path) -> Result<(), String> {
    match frame_number(path) {
        Some(part) => Err(format!(
            "`{part}` stands for the number of a frame, and this is one file; give it a name of its own, such as {}",
            printable(&path.to_string_lossy().replacen(&part, "all", 1)),
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tip(line: &str) -> Option<String> {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let error = <super::super::Arguments as clap::Parser>::try_parse_from(&words).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{line}");
        let text = advised(error, &words).to_string();
        let tips: Vec<_> = text
            .lines()
            .filter_map(|line| line.trim().strip_prefix("tip: "))
            .collect();
        assert!(tips.len() < 2, "{text}");
        tips.first().map(|tip| (*tip).to_owned())
    }

    #[test]
    fn commands_that_there_are_not() {
        for (line, expected) in [
            (
                "candela scene.toml",
                "a scene is rendered by `candela render scene.toml`",
            ),
            (
                "candela a/b.TOML -o x.exr",
                "a scene is rendered by `candela render a/b.TOML`",
            ),
            (
                "candela x.exr",
                "a picture of an EXR is made by `candela tonemap x.exr`",
            ),
            (
                "candela x.ply",
                "a mesh is part of a scene: `[objects.NAME.mesh]` with `file = \"x.ply\"`",
            ),
            (
                "candela README.md",
                "a scene is a TOML file, which `candela render SCENE.toml` renders",
            ),
            (
                "candela scenes/",
                "a scene is a TOML file, which `candela render SCENE.toml` renders",
            ),
            ("candela init", "a first scene is written by `candela new`"),
            (
                "candela validate a.toml",
                "what a scene holds, and whether it is legal, says `candela check SCENE.toml`",
            ),
            (
                "candela --samples 4 a.toml",
                "a command comes first, such as `candela render SCENE.toml`",
            ),
            (
                "candela rendr a.toml",
                "a similar subcommand exists: 'render'",
            ),
        ] {
            assert_eq!(tip(line).as_deref(), Some(expected), "{line}");
        }
    }

    #[test]
    fn options_that_there_are_not() {
        for (line, expected) in [
            (
                "candela render --spp 4",
                "samples a pixel are `--samples N`",
            ),
            (
                "candela render --spp=4",
                "samples a pixel are `--samples N`",
            ),
            ("candela render a.toml -j8", "threads are `--threads N`"),
            ("candela render a.toml -t 8", "threads are `--threads N`"),
            (
                "candela render --out a.exr",
                "the file to write is `-o FILE`",
            ),
            (
                "candela render a.toml b.exr",
                "the file to write is `-o b.exr`",
            ),
            (
                "candela render a.toml b.png",
                "a picture beside the EXR is `--preview b.png`",
            ),
            (
                "candela tonemap a.exr --ev 2",
                "the exposure is `--exposure EV`, in powers of 2",
            ),
            ("candela probe a.toml 3,4", "the pixel is `--pixel 3,4`"),
            (
                "candela render --sampels 4",
                "a similar argument exists: '--samples'",
            ),
        ] {
            assert_eq!(tip(line).as_deref(), Some(expected), "{line}");
        }
        for line in ["--width 800", "--resolution 1,2", "--height=8"] {
            let tip = tip(&format!("candela render {line}")).unwrap();
            assert!(
                tip.contains("`resolution = [width, height]` in its `[image]`"),
                "{tip}"
            );
        }
    }

    /// No tip is for what is an option, and none is for two things.
    #[test]
    fn tips_are_for_what_there_is_not() {
        let mut command = super::super::Arguments::command();
        command.build();
        for (commands, names, _) in OPTIONS {
            for command_name in commands {
                let command = command.find_subcommand(command_name).unwrap();
                for name in names {
                    let is_option = command.get_arguments().any(|argument| {
                        let long = argument.get_long().map(|long| format!("--{long}"));
                        let short = argument.get_short().map(|short| format!("-{short}"));
                        long.as_deref() == Some(*name) || short.as_deref() == Some(*name)
                    });
                    assert!(!is_option, "{command_name} {name}");
                    let of = |(of, names, _): &&Advice| {
                        of.contains(command_name) && names.contains(name)
                    };
                    assert_eq!(
                        OPTIONS.iter().filter(of).count(),
                        1,
                        "{command_name} {name}"
                    );
                }
            }
        }
    }

    #[test]
    fn options_of_other_commands_are_not_offered_as_file_names() {
        for line in [
            "candela tonemap a.exr --samples 3",
            "candela check a.toml -q",
        ] {
            assert_eq!(tip(line), None);
        }
        // What is nearly an option is still told.
        let near = tip("candela render a.toml --previw b.png").unwrap();
        assert!(near.contains("'--preview'"), "{near}");
    }

    /// clap shows the option that it took for the one that was meant.
    #[test]
    fn the_usage_is_that_of_the_command() {
        let words = ["candela", "render", "a.toml", "--width", "4"].map(OsString::from);
        let error = <super::super::Arguments as clap::Parser>::try_parse_from(&words).unwrap_err();
        let text = advised(error, &words).to_string();
        assert!(
            text.contains("\nUsage: candela render [OPTIONS] [SCENE.toml]\n"),
            "{text}"
        );
    }

    #[test]
    fn numbers_of_frames() {
        for (name, part) in [
            ("f.####.exr", "####"),
            ("f.##.exr", "##"),
            ("f.%04d.exr", "%04d"),
            ("f%d.exr", "%d"),
            ("a/f.$F4.exr", "$F4"),
            ("f.$F.exr", "$F"),
            ("f.<frame>.exr", "<frame>"),
            ("f.{frame}.exr", "{frame}"),
        ] {
            assert_eq!(
                frame_number(Path::new(name)).as_deref(),
                Some(part),
                "{name}"
            );
        }
        for name in [
            "a.exr",
            "shot#3.exr",
            "100%.exr",
            "50%diffuse.png",
            "$HOME.exr",
            "####/a.exr",
            "",
        ] {
            assert_eq!(frame_number(Path::new(name)), None, "{name}");
        }
        let error = no_frames(Path::new("a/f.####.exr")).unwrap_err();
        assert!(error.ends_with("such as a/f.all.exr"), "{error}");
    }
}
