//! The options of a validation, live or of a recording, and the files of its report.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::findings::Kind;
use crate::judge::Settings;
use crate::report::plural;
use crate::report::{KindReport, Report};

/// The groups of options in the help.
const FINDINGS: &str = "Findings";
const REPORT: &str = "Report";

/// Options of `regatta plugin validator` and `regatta validate`.
#[derive(Args, Clone, Debug)]
#[group(skip)]
pub struct JudgeOptions {
    /// Write the report to this file as JSON
    #[arg(long, value_name = "FILE", help_heading = REPORT)]
    json: Option<PathBuf>,
    /// Write the report to this file as Markdown
    #[arg(long, value_name = "FILE", help_heading = REPORT)]
    markdown: Option<PathBuf>,
    /// Don't fail on findings of these kinds
    #[arg(long, value_name = "KIND", value_delimiter = ',', help_heading = FINDINGS)]
    allow: Vec<Kind>,
    /// An order that isn't finished after this time is a finding
    #[arg(long, value_name = "TIME", default_value = "20min", help_heading = FINDINGS)]
    unserved_after: humantime::Duration,
    /// A robot that is idle for this time while orders wait is a finding
    #[arg(long, value_name = "TIME", default_value = "20min", help_heading = FINDINGS)]
    idle_after: humantime::Duration,
    /// Time after which a standstill of all robots with orders is a finding; at the end of the run,
    /// 40 % of it is enough
    #[arg(long, value_name = "TIME", default_value = "5min", help_heading = FINDINGS)]
    standstill_after: humantime::Duration,
    /// A robot that stands with an order for this time is a finding, and so are robots that drive
    /// this long without reaching a stop of their orders
    #[arg(long, value_name = "TIME", default_value = "10min", help_heading = FINDINGS)]
    stuck_after: humantime::Duration,
    /// Number of examples of each kind in the report
    #[arg(long, value_name = "N", default_value = "10", help_heading = REPORT)]
    examples: usize,
}

/// The error of a judgement.
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// The report can't be written.
    #[error("can't write {path} ({reason})")]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// There are findings that are not allowed.
    #[error(
        "the validator found {}: {kinds}; `--allow KIND` ignores a kind",
        plural(*count, "finding")
    )]
    Findings {
        /// Their number.
        count: u64,
        /// Their kinds.
        kinds: String,
    },
}

impl JudgeOptions {
    /// The settings of the judge.
    pub fn settings(&self) -> Settings {
        Settings {
            unserved_after_secs: self.unserved_after.as_secs_f64(),
            idle_after_secs: self.idle_after.as_secs_f64(),
            standstill_after_secs: self.standstill_after.as_secs_f64(),
            stuck_after_secs: self.stuck_after.as_secs_f64(),
            examples: self.examples,
        }
    }

    /// Writes the report to the requested files. The caller prints it.
    ///
    /// # Errors
    /// [`JudgeError::Write`], or [`JudgeError::Findings`] if there are findings of other kinds than
    /// those that are allowed.
    pub fn conclude(&self, report: &Report) -> Result<(), JudgeError> {
        let files = [(&self.json, report.to_json()), (&self.markdown, report.to_markdown())];
        for (path, text) in files {
            if let Some(path) = path {
                write(path, &text)?;
            }
        }
        let count = report.count_without(&self.allow);
        if count == 0 {
            return Ok(());
        }
        let kinds: Vec<_> = report
            .found()
            .filter(|report| !self.allow.contains(&report.kind))
            .map(|KindReport { kind, count, .. }| format!("{count} {kind}"))
            .collect();
        Err(JudgeError::Findings { count, kinds: kinds.join(", ") })
    }
}

fn write(path: &Path, text: &str) -> Result<(), JudgeError> {
    fs::write(path, text).map_err(|reason| JudgeError::Write { path: path.to_owned(), reason })
}
