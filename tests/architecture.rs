//! Checks of the architecture: who depends on whom, where `unsafe` is, and whether the documents
//! match the repository.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn manifest(folder: &str) -> String {
    let path = root().join(folder).join("Cargo.toml");
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Returns the names under `[dependencies]` of a crate's manifest. Dev-dependencies and build
/// dependencies aren't among them.
fn dependencies(folder: &str) -> Vec<String> {
    let text = manifest(folder);
    let mut section = "";
    let mut names = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
        } else if section == "[dependencies]" && !line.starts_with('#') {
            names.extend(
                line.split(['.', ' ', '='])
                    .next()
                    .filter(|name| !name.is_empty())
                    .map(str::to_owned),
            );
        }
    }
    names
}

/// Returns the folder of every crate of the workspace.
fn crates() -> Vec<String> {
    let text = manifest(".");
    let members =
        text.split("members = [").nth(1).and_then(|rest| rest.split(']').next()).expect("members");
    members
        .split(',')
        .map(|name| name.trim().trim_matches('"').to_owned())
        .filter(|name| !name.is_empty())
        .collect()
}

/// Returns all Rust files below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let skipped = ["target", ".git", "fuzz"]
            .iter()
            .any(|name| path.file_name().is_some_and(|file| file == *name));
        if path.is_dir() && !skipped {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

/// Returns the crates of this workspace that a crate depends on.
fn workspace_dependencies(folder: &str) -> Vec<String> {
    dependencies(folder).into_iter().filter(|name| name.starts_with("regatta")).collect()
}

/// The arrows between the crates of the workspace: a crate, and those that it may depend on.
/// Plugins that aren't listed may depend on `SHELF`.
const ARROWS: [(&str, &[&str]); 18] = [
    ("engine/base", &[]),
    ("engine/layout", &["regatta-base"]),
    ("engine/motion", &["regatta-base"]),
    ("engine/scenario", &["regatta-base", "regatta-layout"]),
    (
        "engine",
        &["regatta-base", "regatta-layout", "regatta-motion", "regatta-plugin", "regatta-scenario"],
    ),
    ("plugins/api", &[]),
    ("plugins/kit", &["regatta-base", "regatta-plugin"]),
    ("plugins/messages", &["regatta-base", "regatta-plugin"]),
    ("plugins/fleet_manager/orders", &["regatta-base", "regatta-kit", "regatta-plugin"]),
    // An independent judge shares nothing with those that it judges.
    ("plugins/validator", &["regatta-plugin"]),
    // A plugin that users copy knows the contract only.
    ("plugins/hello", &["regatta-plugin"]),
    // Panels don't know graphics cards, and the renderer no panels: what both know is plain data.
    ("viewer/scene", &["regatta-base", "regatta-plugin"]),
    ("viewer/interface", &["regatta-base", "regatta-plugin", "regatta-scene"]),
    ("viewer/gpu", &["regatta-base", "regatta-plugin", "regatta-scene"]),
    (
        "viewer",
        &[
            "regatta-base",
            "regatta-gpu",
            "regatta-interface",
            "regatta-kit",
            "regatta-orders",
            "regatta-plugin",
            "regatta-scene",
        ],
    ),
    // A study changes layouts and scenarios; it never sees a fleet.
    ("study", &["regatta-base", "regatta-layout", "regatta-meter", "regatta-scenario"]),
    // A run in one process takes any plugin: it knows none of them.
    ("study/run", &["regatta-engine", "regatta-plugin", "regatta-scenario"]),
    // Benches measure all crates.
    ("bench", ANY),
];
const ANY: &[&str] = &["*"];
/// The crates that any plugin may depend on.
const SHELF: &[&str] =
    &["regatta-base", "regatta-kit", "regatta-messages", "regatta-orders", "regatta-plugin"];

#[test]
fn crates_depend_only_along_the_arrows() {
    for folder in crates() {
        let listed = ARROWS.iter().find(|(name, _)| *name == folder);
        let allowed = match listed {
            Some((_, allowed)) => *allowed,
            None if folder.starts_with("plugins/") => SHELF,
            None => panic!("{folder} isn't in ARROWS"),
        };
        for dependency in workspace_dependencies(&folder) {
            let may = allowed == ANY || allowed.contains(&dependency.as_str());
            assert!(may, "{folder} depends on {dependency}");
        }
    }
}

#[test]
fn the_command_line_depends_on_nothing_of_the_bench() {
    assert!(!workspace_dependencies(".").contains(&"regatta-bench".to_owned()));
}

#[test]
fn each_heavy_dependency_has_one_owner() {
    let owners: [(&str, &[&str]); 9] = [
        ("iceoryx2", &["plugins/api"]),
        ("serde_yaml", &["engine/scenario"]),
        // Orders read the hidden rows of workbooks.
        ("quick-xml", &["engine/base", "engine/layout", "plugins/fleet_manager/orders"]),
        ("dxf", &["engine/layout"]),
        ("rayon", &["engine", "engine/layout"]),
        // The window connects the renderer to a surface, and draws the panels' meshes by it.
        ("wgpu", &["viewer", "viewer/gpu"]),
        ("winit", &["viewer"]),
        ("zenoh", &["plugins/mirror"]),
        ("egui", &["viewer", "viewer/gpu", "viewer/interface"]),
    ];
    for folder in crates().iter().map(String::as_str).chain(["."]) {
        for (dependency, owners) in owners {
            let uses = dependencies(folder).iter().any(|name| name == dependency);
            assert!(
                !uses || owners.contains(&folder),
                "{folder} depends on {dependency}, which belongs to {owners:?}"
            );
        }
    }
}

/// Returns the rows of the table in docs/dependencies.md: crates, and the folders that may use
/// them.
fn table_of_dependencies() -> Vec<(Vec<String>, String)> {
    let text = read("docs/dependencies.md");
    let table = text.split("| crate | used by | why |").nth(1).expect("the table");
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|row| {
        let cells: Vec<_> = row.split('|').map(str::trim).collect();
        (cells[1].split(", ").map(str::to_owned).collect(), cells[2].to_owned())
    })
    .collect()
}

/// Whether an entry of the column "used by" stands for a folder: `all`, the folder itself, or
/// `PARENT/*` for a folder and those below it.
fn is_user(folder: &str, user: &str) -> bool {
    let place = if folder == "." { "the command line" } else { folder };
    match user.strip_suffix("/*") {
        Some(parent) => Path::new(place).starts_with(parent),
        None => user == "all" || user == place,
    }
}

#[test]
fn the_table_of_dependencies_matches_the_manifests() {
    let table = table_of_dependencies();
    let mut used = Vec::new();
    for folder in crates().iter().map(String::as_str).chain(["."]) {
        for dependency in dependencies(folder).iter().filter(|name| !name.starts_with("regatta")) {
            let row = table.iter().find(|(names, _)| names.contains(dependency));
            let users = row.map_or("no folder", |(_, users)| users);
            assert!(
                users.split(", ").any(|user| is_user(folder, user)),
                "{folder} depends on {dependency}, but docs/dependencies.md lists it for {users}"
            );
            used.push(dependency.clone());
        }
    }
    for (names, users) in table.iter().filter(|(_, users)| !users.ends_with("only")) {
        let unused = names.iter().find(|name| !used.contains(name));
        assert_eq!(
            unused, None,
            "docs/dependencies.md lists it for {users}, but no crate depends on it"
        );
    }
}

#[test]
fn versions_stand_once_in_the_workspace_and_cargo_lock_pins_them() {
    for folder in crates() {
        let text = manifest(&folder);
        let versioned = text.lines().find(|line| line.contains("version = \""));
        assert_eq!(versioned, None, "{folder} has a version of its own");
    }
    let text = manifest(".");
    let shared = text
        .split("[workspace.dependencies]")
        .nth(1)
        .and_then(|rest| rest.split("\n[").next())
        .expect("section");
    for line in shared.lines().filter(|line| line.contains(" = ") && !line.contains("path = ")) {
        // Another version of iceoryx2 sees no fleet. A user's plugin may need a later patch of all
        // others.
        let is_exact = line.contains("\"=");
        assert_eq!(is_exact, line.starts_with("iceoryx2 = "), "not by caret: {line}");
    }
    assert!(root().join("Cargo.lock").exists());
}

/// The crates that `cargo package` packs, so that programs of others can depend on them. `.ci/run`
/// packs them.
const PACKED: [&str; 8] = [
    "engine/base",
    "engine/layout",
    "engine/motion",
    "engine/scenario",
    "engine",
    "plugins/api",
    "plugins/kit",
    "plugins/fleet_manager/orders",
];

#[test]
fn packed_crates_have_a_version_licences_and_a_description() {
    let workspace = manifest(".");
    let checks = read(".ci/run");
    for folder in PACKED {
        let text = manifest(folder);
        let package = format!("--package {}", name(folder));
        assert!(checks.contains(&package), ".ci/run doesn't pack {folder}");
        for key in
            ["description = ", "readme", "keywords", "categories", "[package.metadata.docs.rs]"]
        {
            assert!(text.lines().any(|line| line.starts_with(key)), "{folder} has no {key}");
        }
        let path = format!("= {{ path = \"{folder}\", version = \"");
        assert!(workspace.contains(&path), "{folder} has no version in [workspace.dependencies]");
        assert_has_licences(folder);
        for dependency in workspace_dependencies(folder) {
            let is_packed = PACKED.iter().any(|packed| name(packed) == dependency);
            assert!(is_packed, "{folder} depends on {dependency}, which isn't packed");
        }
    }
    assert_has_licences("plugins/python");
}

/// Returns the name of a crate.
fn name(folder: &str) -> String {
    let text = manifest(folder);
    let name = text.lines().find_map(|line| line.strip_prefix("name = "));
    name.unwrap_or_default().trim_matches('"').to_owned()
}

/// A package holds its own licences: links to them, or copies.
fn assert_has_licences(folder: &str) {
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        assert!(read(&format!("{folder}/{licence}")) == read(licence), "{folder}: {licence}");
    }
}

#[test]
fn the_python_package_has_the_version_of_the_workspace() {
    let workspace = version(&manifest("."));
    assert!(workspace.is_some(), "the workspace has a version");
    assert_eq!(version(&read("plugins/python/pyproject.toml")), workspace);
}

fn version(manifest: &str) -> Option<String> {
    manifest.lines().find(|line| line.starts_with("version = ")).map(str::to_owned)
}

#[test]
fn unsafe_code_is_only_in_the_contract_and_in_the_vector_code() {
    let allowed = ["plugins/api/src", "engine/motion/src/vector", "engine/motion/src/pieces.rs"];
    for path in sources(root()) {
        let relative =
            path.strip_prefix(root()).expect("below the root").to_string_lossy().replace('\\', "/");
        let text = fs::read_to_string(&path).expect("readable");
        let code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
        let has_unsafe = code.into_iter().any(|line| {
            line.contains("unsafe {") || line.contains("unsafe fn") || line.contains("unsafe impl")
        });
        let is_this_file = relative == "tests/architecture.rs";
        assert!(
            !has_unsafe || is_this_file || allowed.iter().any(|place| relative.starts_with(place)),
            "{relative}"
        );
    }
}

/// Code that opens files that this program has written itself, or that the system shows.
const OPENERS: [&str; 11] = [
    "engine/base/src/file.rs",
    "engine/src/fleet/graph_size.rs",
    "plugins/api/src",
    "plugins/kit/src/csv_file.rs",
    "plugins/record/src/sink",
    "plugins/udp/src/socket.rs",
    "src/experiment.rs",
    "src/experiment/report.rs",
    "src/lockstep_run.rs",
    "viewer/src/bench.rs",
    "viewer/src/picture.rs",
];

#[test]
fn files_that_somebody_names_are_opened_by_one_module() {
    let calls = ["File::open(", "fs::read(", "fs::read_to_string("];
    for path in sources(root()) {
        let relative =
            path.strip_prefix(root()).expect("below the root").to_string_lossy().replace('\\', "/");
        let is_test = relative.contains("tests/") || relative.ends_with("tests.rs");
        let is_other = ["bench/", "examples/", "build.rs", "/examples/", "/build.rs"]
            .iter()
            .any(|place| relative.starts_with(place) || relative.contains(place));
        if is_test || is_other || OPENERS.iter().any(|place| relative.starts_with(place)) {
            continue;
        }
        let text = fs::read_to_string(&path).expect("readable");
        let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
        for line in lines {
            let is_opened = calls.iter().any(|call| begins_with_call(line, call));
            assert!(!is_opened, "{relative}: open it by regatta_base::file: {}", line.trim());
        }
    }
}

/// Whether a line calls a function, and not one whose name ends like it.
fn begins_with_call(line: &str, call: &str) -> bool {
    line.match_indices(call).any(|(at, _)| !line[..at].ends_with(char::is_alphanumeric))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Returns the paths of the files in `docs/`.
fn docs() -> Vec<String> {
    let entries = fs::read_dir(root().join("docs")).expect("docs/");
    let mut docs = Vec::new();
    for entry in entries {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        if name.ends_with(".md") {
            docs.push(format!("docs/{name}"));
        }
    }
    assert!(!docs.is_empty(), "docs/ has no documents");
    docs
}

#[test]
fn paths_in_the_documents_exist() {
    let fixed = [
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
        "docs/formats/README.md",
        "graphs/README.md",
        "graphs/imported/README.md",
        "plugins/README.md",
        "plugins/collision/README.md",
        "plugins/metrics/README.md",
        "plugins/python/README.md",
        "plugins/record/README.md",
        "plugins/udp/README.md",
        "viewer/README.md",
    ];
    let documents = fixed.map(str::to_owned).into_iter().chain(docs());
    let missing: Vec<_> = documents.flat_map(|path| missing_paths(&path)).collect();
    assert!(missing.is_empty(), "these paths don't exist: {missing:#?}");
}

/// Returns the links and the paths in backticks of a document that lead to no file or folder.
fn missing_paths(document: &str) -> Vec<String> {
    let text = read(document);
    let document_path = root().join(document);
    let folder = document_path.parent().expect("a folder");
    let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    let links = links
        .filter(|link| !link.is_empty() && !link.contains("://") && !folder.join(link).exists());
    let paths = text.split('`').skip(1).step_by(2).filter(|text| is_path(text));
    let paths = paths.filter(|path| !root().join(path).exists() && !folder.join(path).exists());
    links.chain(paths).map(|path| format!("{document}: {path}")).collect()
}

/// Whether a text in backticks is a path: it begins with a folder of the repository, and has no
/// spaces or placeholders.
fn is_path(text: &str) -> bool {
    let folders = [
        "engine/",
        "plugins/",
        "study/",
        "viewer/",
        "graphs/",
        "bench/",
        "tests/",
        "src/",
        "examples/",
        "fuzz/",
        "docs/",
        ".ci/",
    ];
    folders.iter().any(|folder| text.starts_with(folder))
        && !text.contains([' ', '*', '\n', '…', 'N'])
}

/// The largest number of words of README.md, counted as `wc -w` does. What doesn't fit belongs into
/// `docs/`.
const MAX_README_WORDS: usize = 900;
/// The largest number of characters in a cell of a table.
const MAX_CELL_CHARS: usize = 100;

#[test]
fn the_readme_is_short() {
    let words = read("README.md").split_whitespace().count();
    assert!(words <= MAX_README_WORDS, "README.md has {words} words");
}

#[test]
fn cells_of_tables_are_short() {
    for document in ["README.md".to_owned(), "ARCHITECTURE.md".to_owned()].into_iter().chain(docs())
    {
        let text = read(&document);
        let cells = text
            .lines()
            .filter(|line| line.starts_with('|'))
            .flat_map(|row| row.split('|').map(str::trim));
        let long = cells.into_iter().find(|cell| cell.chars().count() > MAX_CELL_CHARS);
        assert_eq!(long, None, "{document} has a cell of more than {MAX_CELL_CHARS} characters");
    }
}
