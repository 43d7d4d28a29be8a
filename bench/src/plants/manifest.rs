//! The plants of a report: layouts that come with Regatta, and those of given folders.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use regatta::experiment::write;
use regatta::failure::Failure;

/// A layout in a file.
#[derive(Debug, PartialEq, Eq)]
pub struct Source {
    /// Its name in the report.
    pub name: String,
    pub path: PathBuf,
    pub kind: Kind,
}

/// The origin of a layout. The report counts them apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Drawn by somebody, or a test case.
    File,
    Generated,
}

impl Kind {
    /// The plants of the kind, as the beginning of a heading.
    pub fn words(self) -> &'static str {
        match self {
            Self::File => "Plants of files",
            Self::Generated => "Generated plants",
        }
    }
}

/// A file of the repository, as part of this program.
struct Shipped {
    /// The path below the repository.
    name: &'static str,
    text: &'static str,
}

macro_rules! shipped {
    ($($name:literal)*) => {
        &[$(Shipped { name: $name, text: include_str!(concat!("../../../", $name)) }),*]
    };
}

/// A plant of the repository that is always there.
const PROBE: &str = "graphs/square.yaml";
/// The plants of the repository: small route graphs, and the layouts of `graphs/imported` in which
/// a robot that is alone carries orders. In the others, `regatta study` refuses stations that can't
/// be reached, or one-way roads end nowhere; a map of ROS has no roads.
const PLANTS: &[Shipped] = shipped![
    "graphs/square.yaml"
    "graphs/porto.yaml"
    "graphs/thirty.yaml"
    "graphs/small/blocks3.yaml"
    "graphs/small/comb.yaml"
    "graphs/small/comb-pairs.yaml"
    "graphs/small/corridor.yaml"
    "graphs/small/door.yaml"
    "graphs/small/hash4.yaml"
    "graphs/small/loop4.yaml"
    "graphs/small/roundabout.yaml"
    "graphs/imported/csv/depot-edges.csv"
    "graphs/imported/dxf/cc_dxflib.dxf"
    "graphs/imported/dxf/depot.dxf"
    "graphs/imported/lif/ex_10_2.lif.json"
    "graphs/imported/lif/ex_10_3.lif.json"
    "graphs/imported/lif/ex_10_4.lif.json"
    "graphs/imported/lif/ex_10_7.lif.json"
    "graphs/imported/lif/ex_10_13.lif.json"
    "graphs/imported/lif/ex_10_17.lif.json"
    "graphs/imported/movingai/empty-8-8.map"
    "graphs/imported/movingai/random-32-32-10.map"
    "graphs/imported/movingai/random-32-32-10-random-1.scen"
    "graphs/imported/nav2/aws_graph.geojson"
    "graphs/imported/nav2/sample_graph.geojson"
    "graphs/imported/nav2/turtlebot4_graph.geojson"
    "graphs/imported/open-rmf/battle_royale.building.yaml"
    "graphs/imported/open-rmf/battle_royale/0.yaml"
    "graphs/imported/open-rmf/campus.building.yaml"
    "graphs/imported/open-rmf/campus/0.yaml"
    "graphs/imported/open-rmf/hotel.building.yaml"
    "graphs/imported/open-rmf/hotel/0.yaml"
    "graphs/imported/open-rmf/hotel/1.yaml"
    "graphs/imported/open-rmf/hotel/2.yaml"
    "graphs/imported/open-rmf/office.building.yaml"
    "graphs/imported/open-rmf/office/0.yaml"
    "graphs/imported/opentcs/Demo-01.xml"
];
/// Files that plants are read with.
const COMPANIONS: &[Shipped] = shipped!["graphs/imported/csv/depot-nodes.csv"];

/// The extensions of layouts.
const EXTENSIONS: [&str; 9] =
    ["csv", "dxf", "geojson", "json", "map", "scen", "xml", "yaml", "yml"];
/// Words in the names of tables of nodes, and in those of the tables of edges beside them.
const NODES: [&str; 3] = ["nodes", "vertices", "points"];
const EDGES: [&str; 4] = ["edges", "lanes", "paths", "links"];

/// Writes the shipped plants to a folder.
pub fn write_shipped(folder: &Path) -> Result<Vec<Source>, Failure> {
    for file in PLANTS.iter().chain(COMPANIONS) {
        let path = folder.join(file.name);
        fs::create_dir_all(path.parent().unwrap_or(folder))?;
        write(&path, file.text)?;
    }
    let mut sources = Vec::new();
    for Shipped { name, .. } in PLANTS {
        let (name, path) = ((*name).to_owned(), folder.join(name));
        sources.push(Source { name, path, kind: Kind::File });
    }
    Ok(sources)
}

/// Returns a shipped plant in the folder of all, on which options can be checked.
pub fn probe(folder: &Path) -> PathBuf {
    folder.join(PROBE)
}

/// Returns all layouts of a folder and its subfolders, by name.
///
/// # Errors
/// If it can't be read, or has none.
pub fn find(folder: &Path) -> Result<Vec<Source>, Failure> {
    let mut paths = Vec::new();
    collect(folder, &mut paths)?;
    paths.sort();
    if paths.is_empty() {
        let known = EXTENSIONS.join(", ");
        return Err(
            format!("{}: no layouts; give a folder with files {known}", folder.display()).into()
        );
    }
    let kind = Kind::File;
    Ok(paths.into_iter().map(|path| Source { name: name(folder, &path), path, kind }).collect())
}

/// Adds all layouts of a folder and its subfolders.
fn collect(folder: &Path, paths: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for entry in fs::read_dir(folder).map_err(|error| unreadable(folder, &error))? {
        let entry = entry.map_err(|error| unreadable(folder, &error))?;
        // A link to a folder isn't followed: it may lead in a circle.
        let kind = entry.file_type().map_err(|error| unreadable(folder, &error))?;
        let path = entry.path();
        if kind.is_dir() {
            collect(&path, paths)?;
        } else if has_layout_extension(&path) && !is_read_with_edges(&path) {
            paths.push(path);
        }
    }
    Ok(())
}

fn unreadable(folder: &Path, error: &std::io::Error) -> Failure {
    format!("{}: can't read: {error}; give a folder with layouts", folder.display()).into()
}

fn has_layout_extension(path: &Path) -> bool {
    let extension = path.extension().and_then(OsStr::to_str).unwrap_or_default();
    EXTENSIONS.iter().any(|known| known.eq_ignore_ascii_case(extension))
}

/// Whether a file is a table of nodes, and the table of edges beside it is the same plant.
fn is_read_with_edges(path: &Path) -> bool {
    let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
    let Some(word) = NODES.iter().find(|word| name.contains(**word)) else { return false };
    EDGES.iter().any(|other| path.with_file_name(name.replace(word, other)).is_file())
}

/// Returns the name of a layout: its path, beginning with the folder's name.
fn name(folder: &Path, path: &Path) -> String {
    let below = path.strip_prefix(folder).unwrap_or(path);
    let beginning = Path::new(folder.file_name().unwrap_or_default());
    beginning.join(below).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_plants_are_written_with_what_they_need() {
        let folder = tempfile::tempdir().expect("a folder");
        let sources = write_shipped(folder.path()).expect("they are written");
        assert!(sources.iter().all(|source| source.path.is_file()));
        assert!(probe(folder.path()).is_file());
        let tables = folder.path().join("graphs/imported/csv");
        assert_eq!(find(&tables).expect("a table").len(), 1, "two tables are one plant");
    }

    #[test]
    fn the_layouts_of_a_folder_have_its_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path().join("site");
        fs::create_dir_all(root.join("hall")).expect("a folder");
        for file in ["b.YAML", "hall/a.json", "README.md", "map.pgm"] {
            fs::write(root.join(file), "").expect("it is written");
        }
        let found = find(&root).expect("layouts");
        let names: Vec<&str> = found.iter().map(|source| &*source.name).collect();
        assert_eq!(names, ["site/b.YAML", "site/hall/a.json"]);
    }

    #[test]
    fn a_folder_without_layouts_is_an_error() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = find(folder.path()).expect_err("it is empty").to_string();
        assert!(error.contains(": no layouts; give a folder"), "{error}");
        let error = find(&folder.path().join("a")).expect_err("it is missing").to_string();
        assert!(error.contains("can't read") && error.contains("give a folder"), "{error}");
    }
}
