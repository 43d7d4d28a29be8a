//! Studies as job arrays, for users who have only Slurm or a shell.

use std::path::Path;

use regatta_study::plan::Plan;
use regatta_study::store::Store;

use crate::failure::Failure;
use crate::output::{unwritable, write_inside};

/// The largest number of tasks in an array: Slurm's `MaxArraySize` is 1001 unless it is set, and
/// indices are below it. With more jobs, each task does several.
const LARGEST_ARRAY: usize = 1000;

/// Writes the runs of the first round, which any answer needs, as a job array.
pub fn export(plan: &Plan, store: &Store) -> Result<(), Failure> {
    let mut ids = Vec::new();
    for variant in &plan.variants {
        let layout = store.keep_layout(&variant.layout_text())?;
        for robots in plan.robots.grid().into_iter().rev() {
            for seed in 1..=plan.precision.least_seeds {
                let job = variant.job(&layout, robots, seed, plan.time, &plan.program);
                store.keep_job(&job)?;
                ids.push(job.id().to_string());
            }
        }
    }
    for doubt in store.take_doubts() {
        regatta_plugin::tell!("study: {doubt}");
    }
    let folder = store.folder();
    write_inside(&folder.join("jobs.txt"), (ids.join("\n") + "\n").as_bytes())?;
    let tasks = ids.len().min(LARGEST_ARRAY);
    let script = include_str!("job-array.sh").replace("@TASKS@", &tasks.to_string());
    let path = folder.join("run.sh");
    write_inside(&path, script.as_bytes())?;
    make_executable(&path).map_err(|error| unwritable(&path, &error))?;
    let folder = folder.display();
    println!(
        "{folder}: {} jobs. `cd {folder} && sbatch run.sh`, or `{folder}/run.sh` in a shell, \
         executes all of them;",
        ids.len()
    );
    println!(
        "then the same `regatta study` with `--output {folder}` instead of `--export-jobs` \
         continues from there."
    );
    Ok(())
}

#[cfg(unix)]
fn make_executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn make_executable(_path: &Path) -> std::io::Result<()> {
    Ok(())
}
