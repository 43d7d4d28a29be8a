use std::fs;

use super::*;

const HEADER: &str = "tick,robots";

/// A path for a file, in a folder that is removed when the test ends.
struct Temporary(PathBuf);

impl Temporary {
    fn new(test: &str) -> Self {
        let folder =
            std::env::temp_dir().join(format!("regatta-csv-{test}-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        Self(folder.join("rows.csv"))
    }

    fn open(&self) -> CsvFile {
        CsvFile::open(&self.0, HEADER).expect("opened")
    }

    fn text(&self) -> String {
        fs::read_to_string(&self.0).expect("a file")
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        self.0.parent().map(fs::remove_dir_all).expect("a folder").expect("removed");
    }
}

#[test]
fn rows_are_appended_to_an_existing_file() {
    let file = Temporary::new("rows");
    drop(file.open());
    assert_eq!(file.text(), "tick,robots\n", "even a file without rows has its header");
    for rows in ["1,2\n", "2,2\n3,2\n"] {
        let mut csv_file = file.open();
        assert!(csv_file.append(rows).is_none());
        assert_eq!(csv_file.rows(), RowCounts { written: rows.lines().count() as u64, lost: 0 });
    }
    assert_eq!(file.text(), "tick,robots\n1,2\n2,2\n3,2\n");
}

#[test]
fn a_file_with_another_header_is_refused_and_left_alone() {
    let file = Temporary::new("other");
    for text in ["a,b\n1,2\n", "tick,robots,more\n", "\n", "x"] {
        fs::write(&file.0, text).expect("written");
        let error =
            CsvFile::open(&file.0, HEADER).map(drop).expect_err("another header").to_string();
        assert!(
            error.contains("rows.csv") && error.contains("another file") && !error.contains('\n'),
            "{error}"
        );
        assert_eq!(file.text(), text);
    }
    let error = CsvFile::open(Path::new("/no/such/folder/rows.csv"), HEADER)
        .map(drop)
        .expect_err("no folder");
    assert!(error.to_string().contains("/no/such/folder/rows.csv"), "{error}");
}

#[test]
fn what_a_crash_has_cut_is_removed() {
    let file = Temporary::new("cut");
    for cut in ["tick,robots\n1,2\n2,", "tick,robots\n1,2\n", "tick,rob", "tick,robots", ""] {
        fs::write(&file.0, cut).expect("written");
        assert!(file.open().append("4,2\n").is_none());
        let before = if cut.contains('1') { "1,2\n" } else { "" };
        assert_eq!(file.text(), format!("tick,robots\n{before}4,2\n"), "{cut:?}");
    }
}

#[test]
#[cfg(unix)]
fn after_a_rotation_rows_go_to_a_new_file() {
    let file = Temporary::new("moved");
    let mut csv_file = file.open();
    assert!(csv_file.append("1,2\n").is_none());
    let old = file.0.with_extension("1");
    fs::rename(&file.0, &old).expect("moved");
    assert!(csv_file.append("2,2\n").is_none());
    assert_eq!(
        (file.text(), fs::read_to_string(&old).expect("a file")),
        ("tick,robots\n2,2\n".to_owned(), "tick,robots\n1,2\n".to_owned())
    );
    fs::remove_file(&file.0).expect("removed");
    assert!(csv_file.append("3,2\n").is_none());
    assert_eq!(file.text(), "tick,robots\n3,2\n");
    // Another program's file is in its place.
    fs::rename(&old, &file.0).and_then(|()| fs::write(&file.0, "a,b\n")).expect("written");
    assert!(matches!(
        csv_file.append("4,2\n"),
        Some(CsvChange::Failed(CsvError::OtherHeader { .. }))
    ));
    assert_eq!(file.text(), "a,b\n");
}

#[test]
fn after_a_truncation_the_file_begins_anew() {
    let file = Temporary::new("truncated");
    let mut csv_file = file.open();
    assert!(csv_file.append(&"1,2\n".repeat(1000)).is_none());
    // As `copytruncate` of logrotate does.
    OpenOptions::new().write(true).truncate(true).open(&file.0).expect("truncated");
    assert!(csv_file.append("2,2\n").is_none());
    assert_eq!(file.text(), "tick,robots\n2,2\n");
}

#[test]
fn failure_and_recovery_are_reported_once_each() {
    let file = Temporary::new("failure");
    let mut csv_file = file.open();
    fs::remove_file(&file.0).and_then(|()| fs::create_dir(&file.0)).expect("a folder in its place");
    let Some(failed) = csv_file.append("1,2\n") else { panic!("writing must fail") };
    assert!(
        failed.to_string().contains("rows.csv")
            && failed.to_string().ends_with("until it can be written")
    );
    assert!(csv_file.append("2,2\n3,2\n").is_none(), "already reported");
    fs::remove_dir(&file.0).expect("removed");
    let recovered = csv_file.append("4,2\n").expect("a change").to_string();
    assert!(recovered.ends_with("3 rows were lost"), "{recovered}");
    assert_eq!(csv_file.rows(), RowCounts { written: 1, lost: 3 });
    assert_eq!(file.text(), "tick,robots\n4,2\n");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_reported_and_lost_rows_are_counted() {
    let mut csv_file = CsvFile::open(Path::new("/dev/full"), HEADER).expect("it can be opened");
    let Some(CsvChange::Failed(error)) = csv_file.append("1,2\n") else {
        panic!("writing must fail")
    };
    assert!(error.to_string().contains("/dev/full"), "{error}");
    assert_eq!(csv_file.rows(), RowCounts { written: 0, lost: 1 });
}
