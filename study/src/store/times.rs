//! The wall-clock times of runs: the one file of a study that differs from machine to machine.

use std::collections::BTreeMap;
use std::path::Path;

use regatta_base::file;

use super::{MAX_FILE_BYTES, StoreError, write_whole};

const FILE: &str = "times.csv";
const HEADER: &str = "job,wall_secs";

/// The wall-clock times in seconds of runs on this machine, by job.
pub type Times = BTreeMap<String, f64>;

/// Returns the times in the folder of a study; none if there is no such file, and without the lines
/// that can't be read.
pub fn times(folder: &Path) -> Times {
    let text = file::read_text(&folder.join(FILE), MAX_FILE_BYTES).unwrap_or_default();
    let mut times = Times::new();
    for line in text.lines().skip(1) {
        if let Some((job, secs)) = line.split_once(',')
            && let Ok(secs) = secs.parse()
        {
            times.insert(job.to_owned(), secs);
        }
    }
    times
}

/// Writes the times into the folder of a study.
pub(super) fn write(folder: &Path, times: &Times) -> Result<(), StoreError> {
    let mut text = format!("{HEADER}\n");
    for (job, secs) in times {
        text += &format!("{job},{secs:.3}\n");
    }
    write_whole(&folder.join(FILE), text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(times(folder.path()), Times::new());
        let known = Times::from([("a".to_owned(), 1.25), ("b".to_owned(), 0.5)]);
        write(folder.path(), &known).expect("written");
        assert_eq!(times(folder.path()), known);
        std::fs::write(folder.path().join(FILE), "job,wall_secs\na,x\nb\nc,2\n").expect("written");
        assert_eq!(times(folder.path()), Times::from([("c".to_owned(), 2.0)]));
    }
}
