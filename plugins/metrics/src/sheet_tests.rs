use std::fs;

use super::*;

fn temporary(test: &str) -> PathBuf {
    std::env::temp_dir().join(format!("regatta-metrics-{test}-{}.csv", std::process::id()))
}

/// A file that is removed when the test ends.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        // The test may not have made it.
        let _ = fs::remove_file(&self.0);
    }
}

#[test]
fn rows_are_added_to_what_is_there() {
    let file = Temporary(temporary("rows"));
    for row in ["1", "2"] {
        let mut sheet = Sheet::new(&file.0);
        assert!(sheet.add(row).is_none());
        assert_eq!(sheet.rows(), Rows { written: 1, lost: 0 });
    }
    assert_eq!(fs::read_to_string(&file.0).expect("a file"), format!("{}\n1\n2\n", header()));
}

#[test]
fn a_file_with_other_columns_is_left_alone() {
    let file = Temporary(temporary("other"));
    fs::write(&file.0, "a,b\n1,2\n").expect("written");
    let mut sheet = Sheet::new(&file.0);
    let Some(Change::Failed(error)) = sheet.add("1") else { panic!("it must fail") };
    assert!(error.to_string().contains("other columns"), "{error}");
    assert_eq!(fs::read_to_string(&file.0).expect("a file"), "a,b\n1,2\n");
}

#[test]
fn failure_and_recovery_are_told_once_each() {
    let file = Temporary(temporary("failure"));
    fs::create_dir(&file.0).expect("a folder in its place");
    let mut sheet = Sheet::new(&file.0);
    assert!(matches!(sheet.add("1"), Some(Change::Failed(SheetError::Io { .. }))));
    assert!(sheet.add("2").is_none(), "told already");
    fs::remove_dir(&file.0).expect("removed");
    assert!(matches!(sheet.add("3"), Some(Change::Recovered(2))));
    assert_eq!(sheet.rows(), Rows { written: 1, lost: 2 });
    assert_eq!(fs::read_to_string(&file.0).expect("a file"), format!("{}\n3\n", header()));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_told_and_counted() {
    let mut sheet = Sheet::new(Path::new("/dev/full"));
    let Some(Change::Failed(error)) = sheet.add("1") else { panic!("it must fail") };
    assert!(error.to_string().contains("/dev/full"), "{error}");
    assert_eq!(sheet.rows(), Rows { written: 0, lost: 1 });
}

#[test]
fn a_row_that_a_crash_has_cut_goes() {
    let file = Temporary(temporary("cut"));
    fs::write(&file.0, format!("{}\n1\n2,3", header())).expect("written");
    assert!(Sheet::new(&file.0).add("4").is_none());
    assert_eq!(fs::read_to_string(&file.0).expect("a file"), format!("{}\n1\n4\n", header()));
}
