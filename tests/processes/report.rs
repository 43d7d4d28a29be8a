//! `regatta report`: it ends whatever its options, replaces nothing, and measures nothing with
//! options that are out of range.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::fleet::regatta;

fn report(folder: &Path, args: &[&str]) -> Output {
    regatta().arg("report").args(args).arg("--out").arg(folder).output().expect("regatta starts")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_report_of_a_few_robots_ends_and_is_replaced_only_by_force() {
    let folder = tempfile::tempdir().expect("a folder");
    let args = ["scaling", "--max-robots", "10", "--speed", "100", "--secs", "1"];
    let output = report(folder.path(), &args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(folder.path()), ["scaling.json", "scaling.md", "scaling.svg"]);
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("scaling.json")).expect("readable"))
            .expect("JSON");
    assert_eq!(
        (&json["loads"][0]["robots"], json["loads"].as_array().map(Vec::len)),
        (&10.into(), Some(1))
    );

    let refused = report(folder.path(), &args);
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && message.contains("--force replaces it"), "{message}");
    assert!(refused.stdout.is_empty(), "nothing is measured in vain");
}

#[test]
fn options_out_of_range_are_refused_before_anything_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    for (args, expected) in [
        (["scaling", "--speed", "0"], "from 0.001 to 1000"),
        (["scaling", "--speed", "max"], "from 0.001 to 1000"),
        (["scaling", "--secs", "0"], "1..=86400"),
        (["scaling", "--secs", "18446744073709551615"], "1..=86400"),
        (["scaling", "--threads", "0"], "give 1 to"),
        (["scaling", "--max-robots", "0"], "at least 1 robot"),
    ] {
        let output = report(folder.path(), &args);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains(expected), "{args:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    assert!(names(folder.path()).is_empty());
}
