//! The fuzz target of studies: no study file and no job makes its reader panic, hang or exhaust
//! memory, and an accepted job keeps its id.

use std::path::Path;

use regatta_scenario::document;
use regatta_study::job::Job;
use regatta_study::plan::{StudyFile, is_study};

/// Reads a text as a study file, and as a job.
pub fn read(text: &str) {
    if is_study(text)
        && let Ok(file) = document::<StudyFile>(text, Path::new("fuzzed.yaml"))
    {
        let _read = (file.axes(), file.precision());
    }
    if let Ok(job) = serde_json::from_str::<Job>(text) {
        let again: Job = serde_json::from_str(&job.text()).expect("its text is a job");
        assert_eq!(again.id(), job.id());
    }
}
