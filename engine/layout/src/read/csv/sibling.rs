//! The file with the other of two tables.

use std::path::{Path, PathBuf};

use crate::read::file::Source;

/// The words that identify a file of nodes or of edges by its name.
pub(super) const NODE_WORDS: [&str; 3] = ["nodes", "vertices", "points"];
pub(super) const EDGE_WORDS: [&str; 4] = ["edges", "lanes", "paths", "links"];

/// Returns the file with the other table of a file that has only one.
pub(crate) fn sibling(path: &Path) -> Option<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let source = Source { text: "", folder, stem: path.file_stem()?.to_str()? };
    let edges = sibling_files(source, &NODE_WORDS, &EDGE_WORDS);
    let nodes = sibling_files(source, &EDGE_WORDS, &NODE_WORDS);
    edges.into_iter().chain(nodes).find(|file| file.is_file() && file != path)
}

/// Returns the possible paths of the other table: the file's own name with another word.
pub(super) fn sibling_files(source: Source<'_>, words: &[&str], others: &[&str]) -> Vec<PathBuf> {
    let lowercase = source.stem.to_ascii_lowercase();
    let found = words.iter().find_map(|word| Some((lowercase.find(word)?, word.len())));
    let Some((at, length)) = found else { return Vec::new() };
    let (before, after) = (&source.stem[..at], &source.stem[at + length..]);
    let is_capital = source.stem[at..].starts_with(|letter: char| letter.is_ascii_uppercase());
    let mut files = Vec::new();
    for word in others {
        let (first, rest) = word.split_at(1);
        let word = if is_capital {
            format!("{}{rest}", first.to_ascii_uppercase())
        } else {
            (*word).to_owned()
        };
        for ending in ["csv", "tsv", "txt", "CSV"] {
            files.push(source.folder.join(format!("{before}{word}{after}.{ending}")));
        }
    }
    files
}
