//! Templates of Open Job Description, revision 2023-09, and job bundles of AWS Deadline Cloud.
//!
//! Source: `2023-09-Template-Schemas` and RFC 0001 (task chunking) in the OpenJobDescription/openjd-specifications
//! repository; for bundles the AWS Deadline Cloud Developer Guide, "Job bundles".

use std::path::{Component, Path};

use candela::internal::{printable, shell_word};

use super::quoting::yaml;
use super::{Failure, Job, text};
use crate::cli::advice;

/// Seconds from SIGTERM to SIGKILL. candela ends within one.
const NOTICE: u32 = 10;

/// The most values that a list of a task's parameter may have (2023-09, section 3.4.1.1).
const MOST_VALUES: usize = 1024;

/// The longest name of a job that is made here, in characters; the specification takes 128.
const LONGEST_NAME: usize = 100;

/// Words with the braces of format strings, for which there is no escape: they become parameters of the job.
#[derive(Default)]
struct Words(Vec<String>);

impl Words {
    /// A text in a format string.
    fn literal(&mut self, text: &str) -> String {
        if text.contains("{{")
            || text.contains("}}")
            || text.ends_with('{')
            || text.starts_with('}')
        {
            self.0.push(text.to_owned());
            return format!("{{{{Param.Word{}}}}}", self.0.len());
        }
        text.to_owned()
    }

    fn literals(&mut self, texts: &[String]) -> Vec<String> {
        texts.iter().map(|text| self.literal(text)).collect()
    }
}

/// A parameter of a task: its name, and the lines that describe it.
struct Task(&'static str, String);

/// The template alone, whose paths are relative to it where they are relative.
pub(super) fn template(job: &Job) -> Result<String, Failure> {
    let mut words = Words::default();
    let (steps, frames) = steps(job, &mut words)?;
    let mut text = head(job);
    text.push_str("specificationVersion: jobtemplate-2023-09\n");
    if frames.is_some() {
        text.push_str("extensions: [TASK_CHUNKING]\n");
    }
    text.push_str(&format!("name: {}\n", yaml(&name(job))));
    text.push_str("parameterDefinitions:\n");
    text.push_str(&path("Scene", "FILE", "IN", &job.scene));
    text.push_str(&path("OutDir", "DIRECTORY", "OUT", &job.folder));
    text.push_str(&string("Candela", "candela"));
    if let Some(frames) = frames {
        text.push_str(&string("Frames", &frames));
    }
    for (index, word) in words.0.iter().enumerate() {
        text.push_str(&string(&format!("Word{}", index + 1), word));
    }
    text.push_str("steps:\n");
    text.push_str(&steps);
    Ok(text)
}

/// The files of a bundle, by name.
pub(super) fn bundle(job: &Job) -> Result<[(&'static str, String); 3], Failure> {
    let absolute = |path: &str| {
        let path = if path.is_empty() { "." } else { path };
        text(&std::path::absolute(path)?, "a file")
    };
    let (scene, folder) = (absolute(&job.scene)?, absolute(&job.folder)?);
    let values = format!(
        "parameterValues:\n- name: Scene\n  value: {}\n- name: OutDir\n  value: {}\n",
        yaml(&scene),
        yaml(&folder),
    );
    let inputs: String = job
        .inputs
        .iter()
        .map(|path| format!("    - {}\n", yaml(path)))
        .collect();
    let assets = format!(
        "assetReferences:\n  inputs:\n    filenames:\n{inputs}    directories: []\n  outputs:\n    directories:\n    - {}\n  \
         referencedPaths: []\n",
        yaml(&folder),
    );
    Ok([
        ("template.yaml", template(job)?),
        ("parameter_values.yaml", values),
        ("asset_references.yaml", assets),
    ])
}

/// What a reader should know first.
fn head(job: &Job) -> String {
    let mut missing = String::new();
    for (name, value) in [("Scene", &job.scene), ("OutDir", &job.folder)] {
        if !is_below(value) {
            missing.push_str(&format!(" -p {name}={}", shell_word(value)));
        }
    }
    format!(
        "# candela: {}
# {}
# On this machine:       openjd run job.yaml{}
# On AWS Deadline Cloud: candela job … --bundle DIR, and deadline bundle submit DIR
",
        printable(&job.scene),
        job.remark(),
        printable(&missing),
    )
}

/// The name of the job, without what the specification does not allow there.
fn name(job: &Job) -> String {
    let stem = Path::new(&job.scene).file_stem().unwrap_or_default();
    let stem = stem.to_string_lossy();
    let allowed = |&c: &char| !c.is_control() && c != '{' && c != '}';
    let stem: String = stem.chars().filter(allowed).take(LONGEST_NAME).collect();
    format!("candela {stem}").trim_end().to_owned()
}

/// Whether a path may be a default: it is relative to the template, and stays below it.
fn is_below(path: &str) -> bool {
    let is_normal = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    Path::new(path).components().all(is_normal)
}

fn path(name: &str, object: &str, flow: &str, value: &str) -> String {
    let default = match value {
        "" => "  default: \".\"\n".to_owned(),
        value if is_below(value) => format!("  default: {}\n", yaml(value)),
        // Its value is given when the job is submitted.
        _ => String::new(),
    };
    format!("- name: {name}\n  type: PATH\n  objectType: {object}\n  dataFlow: {flow}\n{default}")
}

fn string(name: &str, value: &str) -> String {
    format!(
        "- name: {name}\n  type: STRING\n  default: {}\n",
        yaml(value)
    )
}

/// A step that runs candela.
fn step(name: &str, after: Option<&str>, tasks: &[Task], words: &[String]) -> String {
    let mut text = format!("- name: {name}\n");
    if let Some(step) = after {
        text.push_str(&format!("  dependencies:\n  - dependsOn: {step}\n"));
    }
    if !tasks.is_empty() {
        text.push_str("  parameterSpace:\n    taskParameterDefinitions:\n");
        for Task(name, lines) in tasks {
            text.push_str(&format!("    - name: {name}\n{lines}"));
        }
    }
    text.push_str(
        "  script:\n    actions:\n      onRun:\n        command: \"{{Param.Candela}}\"\n        args:\n",
    );
    for word in words {
        text.push_str(&format!("        - {}\n", yaml(word)));
    }
    text.push_str(&format!(
        "        cancelation:\n          mode: NOTIFY_THEN_TERMINATE\n          notifyPeriodInSeconds: {NOTICE}\n"
    ));
    text
}

/// All steps, and the frames where these are a parameter of the job.
fn steps(job: &Job, words: &mut Words) -> Result<(String, Option<String>), Failure> {
    let mut options = words.literals(&job.options);
    let mut own = ["--skip-done", "--quiet", "--progress", "openjd"]
        .map(str::to_owned)
        .to_vec();
    own.append(&mut options);
    let render = |more: &[&str], output: String| {
        let mut list = ["render", "{{Param.Scene}}"].map(str::to_owned).to_vec();
        list.extend(more.iter().map(|&word| word.to_owned()));
        list.extend(["-o".to_owned(), format!("{{{{Param.OutDir}}}}/{output}")]);
        list.extend(own.iter().cloned());
        list
    };
    let merge = |from: String, to: String| {
        let path = |name: String| format!("{{{{Param.OutDir}}}}/{name}");
        [
            "merge".to_owned(),
            path(from),
            "-o".to_owned(),
            path(to),
            "--quiet".to_owned(),
        ]
    };
    let Some(count) = job.tiles else {
        let output = words.literal(&job.name);
        let Some(frames) = &job.frames else {
            return Ok((step("Render", None, &[], &render(&[], output)), None));
        };
        if frames.list().iter().any(|frame| !frame.is_whole()) {
            return Err("Open Job Description counts whole frames; give --frames whole numbers, or choose --engine slurm".into());
        }
        let task = Task(
            "Frame",
            format!(
                "      type: CHUNK[INT]\n      range: \"{{{{Param.Frames}}}}\"\n      chunks:\n        defaultTaskCount: {}\n        \
                 rangeConstraint: NONCONTIGUOUS\n",
                job.chunk
            ),
        );
        let words = render(&["--frames", "{{Task.Param.Frame}}"], output);
        let frames = super::chunks::text(frames);
        return Ok((step("Render", None, &[task], &words), Some(frames)));
    };
    let tile = || {
        let last = count - 1;
        Task(
            "Tile",
            format!("      type: INT\n      range: \"0-{last}\"\n"),
        )
    };
    let which = format!("{{{{Task.Param.Tile}}}}/{count}");
    let end = format!(".of{count}.exr");
    let Some(frames) = &job.frames else {
        let stem = job.name.strip_suffix(".exr").unwrap_or(&job.name);
        let start = words.literal(&format!("{stem}.tile"));
        let to = words.literal(&job.name);
        let tiles = render(
            &["--tile", &which],
            format!("{start}{{{{Task.Param.Tile}}}}{end}"),
        );
        let merged = merge(format!("{start}%d{end}"), to);
        let steps =
            step("Render", None, &[tile()], &tiles) + &step("Merge", Some("Render"), &[], &merged);
        return Ok((steps, None));
    };
    let numbers = job.numbers();
    if frames.list().len() > MOST_VALUES {
        return Err(format!(
            "a job takes at most {MOST_VALUES} frames in tiles; make several jobs, or leave out --tiles"
        )
        .into());
    }
    // As they stand in names: a template has no way to fill a number up with zeros.
    let values: String = numbers
        .iter()
        .map(|number| format!("      - {}\n", yaml(number)))
        .collect();
    let frame = || {
        Task(
            "Frame",
            format!("      type: STRING\n      range:\n{values}"),
        )
    };
    let part = advice::frame_number(Path::new(&job.name)).unwrap_or_default();
    let (before, after) = job.name.split_once(&part).unwrap_or((&job.name, ""));
    let stem = after.strip_suffix(".exr").unwrap_or(after);
    let before = words.literal(before);
    let middle = words.literal(&format!("{stem}.tile"));
    let after = words.literal(after);
    let start = format!("{before}{{{{Task.Param.Frame}}}}");
    let more = ["--frames", "{{Task.Param.Frame}}", "--tile", &which];
    let tiles = render(
        &more,
        format!("{start}{middle}{{{{Task.Param.Tile}}}}{end}"),
    );
    let merged = merge(format!("{start}{middle}%d{end}"), format!("{start}{after}"));
    let steps = step("Render", None, &[frame(), tile()], &tiles)
        + &step("Merge", Some("Render"), &[frame()], &merged);
    Ok((steps, None))
}
