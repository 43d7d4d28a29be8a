use std::fs;

use super::*;

fn temporary(test: &str) -> PathBuf {
    std::env::temp_dir().join(format!("regatta-metrics-{test}-{}.csv", std::process::id()))
}

/// A file that is removed when the test ends.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        // The test may not have created it.
        let _ = fs::remove_file(&self.0);
    }
}

#[test]
fn rows_are_appended_to_an_existing_file() {
    let file = Temporary(temporary("rows"));
    for row in ["1", "2"] {
        let mut csv_file = CsvFile::new(&file.0);
        assert!(csv_file.add(row).is_none());
        assert_eq!(csv_file.rows(), RowCounts { written: 1, lost: 0 });
    }
    assert_eq!(fs::read_to_string(&file.0).expect("a file"), format!("{}\n1\n2\n", header()));
}

#[test]
fn a_file_with_other_columns_is_left_alone() {
    let file = Temporary(temporary("other"));
    fs::write(&file.0, "a,b\n1,2\n").expect("written");
    let mut csv_file = CsvFile::new(&file.0);
    let Some(Transition::Failed(error)) = csv_file.add("1") else { panic!("writing must fail") };
    assert!(error.to_string().contains("other columns"), "{error}");
    assert_eq!(fs::read_to_string(&file.0).expect("a file"), "a,b\n1,2\n");
}

#[test]
fn failure_and_recovery_are_reported_once_each() {
    let file = Temporary(temporary("failure"));
    fs::create_dir(&file.0).expect("a folder in its place");
    let mut csv_file = CsvFile::new(&file.0);
    assert!(matches!(csv_file.add("1"), Some(Transition::Failed(CsvError::Io { .. }))));
    assert!(csv_file.add("2").is_none(), "already reported");
    fs::remove_dir(&file.0).expect("removed");
    assert!(matches!(csv_file.add("3"), Some(Transition::Recovered(2))));
    assert_eq!(csv_file.rows(), RowCounts { written: 1, lost: 2 });
    assert_eq!(fs::read_to_string(&file.0).expect("a file"), format!("{}\n3\n", header()));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_reported_and_lost_rows_are_counted() {
    let mut csv_file = CsvFile::new(Path::new("/dev/full"));
    let Some(Transition::Failed(error)) = csv_file.add("1") else { panic!("writing must fail") };
    assert!(error.to_string().contains("/dev/full"), "{error}");
    assert_eq!(csv_file.rows(), RowCounts { written: 0, lost: 1 });
}

#[test]
fn a_row_cut_by_a_crash_is_removed() {
    let file = Temporary(temporary("cut"));
    fs::write(&file.0, format!("{}\n1\n2,3", header())).expect("written");
    assert!(CsvFile::new(&file.0).add("4").is_none());
    assert_eq!(fs::read_to_string(&file.0).expect("a file"), format!("{}\n1\n4\n", header()));
}
