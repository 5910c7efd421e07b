//! A batch script for Slurm: an array of tasks, and the merge of tiles as a second job of the same script.

use candela::internal::{printable, shell_word};

use super::Job;

/// How often a task is put back into the queue.
const TRIES: u32 = 5;

/// Seconds before the end of its time at which a task is told.
const NOTICE: u32 = 60;

pub(super) fn script(job: &Job) -> String {
    let tasks = match (job.tiles, &job.frames) {
        (None, None) => 1,
        (None, Some(_)) => job.chunks().len(),
        (Some(tiles), None) => tiles as usize,
        (Some(tiles), Some(frames)) => tiles as usize * frames.list().len(),
    };
    let last = tasks - 1;
    let submit = if job.tiles.is_some() {
        "render=$(sbatch --parsable job.sh)
#   sbatch --array=0 --dependency=afterok:$render job.sh merge"
    } else {
        "sbatch job.sh"
    };
    let mut script = format!(
        "#!/bin/bash
# candela: {}
# {}
# Submit it where the output should go, with a --time of its own if that is needed:
#   {submit}
# A cluster limits the size of arrays (MaxArraySize of slurm.conf, 1001 by default).
#SBATCH --job-name=candela
#SBATCH --array=0-{last}
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:USR1@{NOTICE}
set -u

candela=${{CANDELA:-candela}}

# Puts the task back into the queue, at most {TRIES} times; it goes on where it was ended.
again() {{
    if [ -n \"${{SLURM_ARRAY_JOB_ID:-}}\" ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt {TRIES} ]; then
        scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\"
    fi
}}

# Runs candela. Exit code 75 is what a later try may cure; 137 is SIGKILL, by which a system that is short of
# memory ends programs; USR1 comes before the time is over.
run() {{
    local code out_of_time=0
    \"$candela\" \"$@\" &
    local child=$!
    trap 'kill -TERM \"$child\" 2>/dev/null' TERM INT
    trap 'out_of_time=1; kill -TERM \"$child\" 2>/dev/null' USR1
    # A signal ends `wait` before the child is gone.
    while wait \"$child\"; code=$?; kill -0 \"$child\" 2>/dev/null; do :; done
    trap - TERM INT USR1
    if [ \"$code\" = 75 ] || [ \"$code\" = 137 ] || {{ [ \"$out_of_time\" = 1 ] && [ \"$code\" != 0 ]; }}; then
        again
    fi
    return \"$code\"
}}

",
        printable(&job.scene),
        job.remark(),
    );
    if job.tiles.is_some() || job.frames.is_some() {
        script.push_str("task=${SLURM_ARRAY_TASK_ID:-0}\n");
    }
    script.push_str(&body(job));
    script
}

/// What a task does.
fn body(job: &Job) -> String {
    let scene = shell_word(&job.scene_word());
    let options: String = job
        .options
        .iter()
        .map(|word| format!(" {}", shell_word(word)))
        .collect();
    let rest = format!("--skip-done --quiet{options}");
    let list = |name: &str, values: &[String]| {
        let lines: String = values
            .iter()
            .map(|value| format!("    {}\n", shell_word(value)))
            .collect();
        format!("{name}=(\n{lines})\n")
    };
    let whole = shell_word(&job.path(&job.name));
    match (job.tiles, &job.frames) {
        (None, None) => format!("run render {scene} -o {whole} {rest}\n"),
        (None, Some(_)) => {
            let frames = list("frames", &job.chunks());
            format!("{frames}run render {scene} --frames=\"${{frames[task]}}\" -o {whole} {rest}\n")
        }
        (Some(tiles), None) => {
            let (start, end) = around(job, None);
            let merged = shell_word(&format!("{start}%d{end}"));
            format!(
                "if [ \"${{1:-}}\" = merge ]; then
    run merge {merged} -o {whole} --quiet
else
    run render {scene} --tile \"$task/{tiles}\" -o {}\"$task\"{} {rest}
fi
",
                shell_word(&start),
                shell_word(&end),
            )
        }
        (Some(tiles), Some(_)) => {
            let numbers = list("numbers", &job.numbers());
            let (before, after) = around_number(job);
            let whole = format!("{}\"$number\"{}", shell_word(&before), shell_word(&after));
            let (_, end) = around(job, None);
            let stem = after.strip_suffix(".exr").unwrap_or(&after);
            let start = format!(
                "{}\"$number\"{}",
                shell_word(&before),
                shell_word(&format!("{stem}.tile"))
            );
            format!(
                "{numbers}if [ \"${{1:-}}\" = merge ]; then
    for number in \"${{numbers[@]}}\"; do
        run merge {start}{} -o {whole} --quiet || exit
    done
else
    number=${{numbers[task / {tiles}]}}
    tile=$((task % {tiles}))
    run render {scene} --frames=\"$number\" --tile \"$tile/{tiles}\" -o {start}\"$tile\"{} {rest}
fi
",
                shell_word(&format!("%d{end}")),
                shell_word(&end),
            )
        }
    }
}

/// The path of a tile, before and after the number of the tile.
fn around(job: &Job, number: Option<&str>) -> (String, String) {
    let end = format!(".of{}.exr", job.tiles.unwrap_or(1));
    let path = job.path(&job.tile_name(number, ""));
    let start = path.strip_suffix(&end).unwrap_or(&path).to_owned();
    (start, end)
}

/// The path of an image, before and after the number of the frame.
fn around_number(job: &Job) -> (String, String) {
    let path = job.path(&job.name);
    let part =
        crate::cli::advice::frame_number(std::path::Path::new(&job.name)).unwrap_or_default();
    match path.rsplit_once(&part) {
        Some((before, after)) if !part.is_empty() => (before.to_owned(), after.to_owned()),
        Some(_) | None => (
            path.strip_suffix(".exr").unwrap_or(&path).to_owned(),
            ".exr".to_owned(),
        ),
    }
}
