//! The arrows of the architecture, held against the manifests and the sources.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn manifest(folder: &str) -> String {
    let path = root().join(folder).join("Cargo.toml");
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Names under `[dependencies]` of a crate's manifest: what it needs to be built, not tested.
fn dependencies(folder: &str) -> Vec<String> {
    let text = manifest(folder);
    let mut section = "";
    let mut names = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
        } else if section == "[dependencies]" && !line.starts_with('#') {
            names.extend(line.split(['.', ' ', '=']).next().filter(|name| !name.is_empty()).map(str::to_owned));
        }
    }
    names
}

/// Every crate of the workspace, by folder.
fn crates() -> Vec<String> {
    let text = manifest(".");
    let members = text.split("members = [").nth(1).and_then(|rest| rest.split(']').next()).expect("members");
    members.split(',').map(|name| name.trim().trim_matches('"').to_owned()).filter(|name| !name.is_empty()).collect()
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let skipped = ["target", ".git", "fuzz"].iter().any(|name| path.file_name().is_some_and(|file| file == *name));
        if path.is_dir() && !skipped {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

#[test]
fn the_contract_depends_on_nothing_of_ours() {
    let ours: Vec<_> = dependencies("plugins/api").into_iter().filter(|name| name.starts_with("regatta")).collect();
    assert!(ours.is_empty(), "{ours:?}");
}

#[test]
fn the_engine_knows_only_the_contract() {
    let ours: Vec<_> = dependencies("engine").into_iter().filter(|name| name.starts_with("regatta")).collect();
    assert_eq!(ours, ["regatta-plugin"]);
}

#[test]
fn motion_depends_on_nothing_of_the_fleet() {
    let folder = root().join("engine/src/motion");
    let files = sources(&folder);
    assert!(!files.is_empty(), "no sources in {}", folder.display());
    for path in files.into_iter().chain([folder.with_extension("rs")]) {
        let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(!text.contains("crate::fleet"), "{} names crate::fleet", path.display());
    }
}

#[test]
fn plugins_know_only_the_contract() {
    for folder in crates().iter().filter(|folder| folder.starts_with("plugins/") && *folder != "plugins/api") {
        let ours: Vec<_> = dependencies(folder).into_iter().filter(|name| name.starts_with("regatta")).collect();
        assert_eq!(ours, ["regatta-plugin"], "{folder}");
    }
}

#[test]
fn only_the_command_line_and_bench_depend_on_the_engine() {
    for folder in crates() {
        let uses_engine = dependencies(&folder).iter().any(|name| name == "regatta-engine");
        assert!(!uses_engine || folder == "bench", "{folder} depends on the engine");
    }
}

#[test]
fn each_heavy_dependency_has_one_owner() {
    let owners = [
        ("iceoryx2", "plugins/api"),
        ("serde_yaml", "engine"),
        ("rayon", "engine"),
        ("wgpu", "viewer"),
        ("winit", "viewer"),
        ("egui", "viewer"),
    ];
    for folder in crates().iter().map(String::as_str).chain(["."]) {
        for (dependency, owner) in owners {
            let uses = dependencies(folder).iter().any(|name| name == dependency);
            assert!(!uses || folder == owner, "{folder} depends on {dependency}, which belongs to {owner}");
        }
    }
}

/// Rows of the README's table of dependencies: crates, and who may use them.
fn table_of_dependencies() -> Vec<(Vec<String>, String)> {
    let text = fs::read_to_string(root().join("README.md")).expect("README.md");
    let table = text.split("| crate | used by | why |").nth(1).expect("the table");
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|row| {
        let cells: Vec<_> = row.split('|').map(str::trim).collect();
        (cells[1].split(", ").map(str::to_owned).collect(), cells[2].to_owned())
    })
    .collect()
}

#[test]
fn the_table_of_dependencies_is_true() {
    let table = table_of_dependencies();
    let mut used = Vec::new();
    for folder in crates().iter().map(String::as_str).chain(["."]) {
        for dependency in dependencies(folder).iter().filter(|name| !name.starts_with("regatta")) {
            let row = table.iter().find(|(names, _)| names.contains(dependency));
            let users = row.map_or("nobody", |(_, users)| users);
            let place = match folder {
                "." => "the command line",
                folder => folder,
            };
            let any_plugin = folder.starts_with("plugins/") && users.contains("plugins") && !users.contains("plugins/");
            assert!(
                users == "all" || users.split(", ").any(|user| user == place) || any_plugin,
                "{folder} depends on {dependency}, which the README gives to {users}"
            );
            used.push(dependency.clone());
        }
    }
    for (names, users) in table.iter().filter(|(_, users)| !users.ends_with("alone")) {
        let unused = names.iter().find(|name| !used.contains(name));
        assert_eq!(unused, None, "given to {users}, but nobody depends on it");
    }
}

#[test]
fn versions_are_pinned_once_in_the_workspace() {
    for folder in crates() {
        let text = manifest(&folder);
        let versioned = text.lines().find(|line| line.contains("version = \""));
        assert_eq!(versioned, None, "{folder} pins a version of its own");
    }
    let text = manifest(".");
    let shared =
        text.split("[workspace.dependencies]").nth(1).and_then(|rest| rest.split("\n[").next()).expect("section");
    for line in shared.lines().filter(|line| line.contains(" = ") && !line.contains("path = ")) {
        assert!(line.contains("\"="), "not pinned: {line}");
    }
}

#[test]
fn unsafe_code_stands_only_where_the_design_allows_it() {
    let allowed = ["plugins/api/src", "engine/src/motion/vector", "engine/src/motion/pieces.rs"];
    for path in sources(root()) {
        let relative = path.strip_prefix(root()).expect("below the root").to_string_lossy().replace('\\', "/");
        let text = fs::read_to_string(&path).expect("readable");
        let code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
        let has_unsafe = code
            .into_iter()
            .any(|line| line.contains("unsafe {") || line.contains("unsafe fn") || line.contains("unsafe impl"));
        let is_this_file = relative == "tests/architecture.rs";
        assert!(!has_unsafe || is_this_file || allowed.iter().any(|place| relative.starts_with(place)), "{relative}");
    }
}

#[test]
fn paths_that_the_readmes_name_exist() {
    for readme in ["README.md", "graphs/README.md", "plugins/README.md", "plugins/python/README.md"] {
        let text = fs::read_to_string(root().join(readme)).expect(readme);
        let folder = root().join(readme).parent().expect("a folder").to_path_buf();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let path = link.split('#').next().unwrap_or("");
            if !path.is_empty() && !path.contains("://") {
                assert!(folder.join(path).exists(), "{readme} names {path}");
            }
        }
        let quoted = text.split('`').skip(1).step_by(2);
        for path in quoted.filter(|path| is_path_of_ours(path)) {
            assert!(root().join(path).exists() || folder.join(path).exists(), "{readme} names {path}");
        }
    }
}

/// `engine/src/x.rs`, `graphs/porto.yaml`, `plugins/api`: no spaces, and a folder of ours first.
fn is_path_of_ours(text: &str) -> bool {
    let ours = ["engine/", "plugins/", "graphs/", "bench/", "tests/", "src/", "examples/", "fuzz/"];
    ours.iter().any(|folder| text.starts_with(folder)) && !text.contains([' ', '*', '\n', '…', 'N'])
}
