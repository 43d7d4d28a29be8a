//! Large files, part by part. While it reads a text, the YAML library takes about 50 times its size
//! in memory.
//!
//! Files with one node or edge per line, as generators write them, are cut between lines, and each
//! part is read separately. Other files are read as a whole.

/// The number of lines of a part.
const LINES: usize = 20_000;
/// The most keys of the root map: our format has fewer, and each is compared with all others.
const MAX_KEYS: usize = 100;

/// A part of a file that is valid YAML.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part<'text> {
    /// The byte offset in the file.
    pub start: usize,
    /// The key of the root map whose list the text belongs to; `None` for entries of the root map.
    pub key: Option<&'text str>,
    pub text: &'text str,
}

impl<'text> Part<'text> {
    /// Returns the part that is a whole text.
    pub fn whole(text: &'text str) -> Self {
        Self { start: 0, key: None, text }
    }
}

/// Cuts a text into parts; `None` if it has to be read as a whole.
pub(super) fn parts(text: &str) -> Option<Vec<Part<'_>>> {
    // Anchors, aliases and documents refer to other lines.
    if text.contains(['&', '*', '\t']) || text.contains("---") {
        return None;
    }
    let mut parts = Vec::new();
    let mut list: Option<List<'_>> = None;
    let mut keys: Vec<&str> = Vec::new();
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        let content = line.trim_end();
        if content.is_empty() || content.starts_with('#') {
            continue;
        }
        if content.starts_with("- {") && content.ends_with('}') && is_one_item(content) {
            let list = list.as_mut()?;
            list.extend(start, at);
            if list.lines >= LINES {
                parts.extend(list.take(text));
            }
            continue;
        }
        // A key of the root map, which ends the list before it.
        let (key, value) = content.split_once(':')?;
        let is_name = key.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
        // The reader of the whole file reports keys that are given twice.
        if !is_name
            || keys.len() >= MAX_KEYS
            || keys.iter().any(|other| other.eq_ignore_ascii_case(key))
        {
            return None;
        }
        keys.push(key);
        parts.extend(list.as_mut().and_then(|list| list.take(text)));
        let has_value = !value.split('#').next().unwrap_or_default().trim().is_empty();
        list = (!has_value).then_some(List { key, start: at, end: at, lines: 0 });
        if has_value {
            parts.push(Part { start, key: None, text: line });
        }
    }
    parts.extend(list.as_mut().and_then(|list| list.take(text)));
    Some(parts)
}

/// Whether a line in flow style closes its brackets only at its end. Brackets in texts count too,
/// and quoted texts may contain anything. A file with other lines is read as a whole.
fn is_one_item(line: &str) -> bool {
    let mut depth = 0;
    let mut bytes = line.bytes().skip(2).peekable();
    while let Some(byte) = bytes.next() {
        match byte {
            b'{' | b'[' => depth += 1,
            b'}' | b']' => depth -= 1,
            b'"' | b'\'' | b'#' => return false,
            _ => {}
        }
        if depth <= 0 && bytes.peek().is_some() {
            return false;
        }
    }
    depth == 0
}

/// Lines of a list that aren't yet in a part.
struct List<'text> {
    key: &'text str,
    start: usize,
    end: usize,
    lines: usize,
}

impl<'text> List<'text> {
    fn extend(&mut self, start: usize, end: usize) {
        if self.lines == 0 {
            self.start = start;
        }
        self.end = end;
        self.lines += 1;
    }

    fn take(&mut self, text: &'text str) -> Option<Part<'text>> {
        let is_empty = std::mem::take(&mut self.lines) == 0;
        let items = &text[self.start..self.end];
        (!is_empty).then_some(Part { start: self.start, key: Some(self.key), text: items })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_generated_file_is_cut_between_lines() {
        let lines: String = (0..LINES + 1).map(|id| format!("- {{Id: {id}}}\n")).collect();
        let text = format!(
            "# a comment\nAngleUnit: deg\nEdges: # here\n{lines}\nVertices:\n- {{Id: 1, P: [1, \
             [2]]}}\n"
        );
        let parts = parts(&text).expect("parts");
        let unit = text.find("AngleUnit").expect("a unit");
        assert_eq!(parts[0], Part { start: unit, key: None, text: "AngleUnit: deg\n" });
        for part in &parts {
            assert_eq!(&text[part.start..][..part.text.len()], part.text);
        }
        let keys: Vec<_> = parts[1..].iter().map(|part| part.key).collect();
        assert_eq!(keys, [Some("Edges"), Some("Edges"), Some("Vertices")]);
        assert_eq!(
            (parts[1].text.lines().count(), parts[2].text.trim_end()),
            (LINES, format!("- {{Id: {LINES}}}").as_str())
        );
        assert_eq!(parts[3].text, "- {Id: 1, P: [1, [2]]}\n");
        assert_eq!(parts.len(), 4);
    }

    #[test]
    fn other_files_are_read_as_a_whole() {
        for text in [
            "Edges:\n- Id: 1\n  Origin_ID: 2\n",
            "Edges:\n- {Id: 1,\n   Origin_ID: 2}\n",
            "Edges: &a\n- {Id: 1}\n",
            "Edges:\n- {Name: \"}\"}\n",
            "Edges:\n- {Id: 1} {Id: 2}\n",
            "Edges:\n- {Id: 1}}\n",
            "- {Id: 1}\n",
            "{Edges: [], Vertices: []}",
            "---\nEdges:\n- {Id: 1}\n",
            "\"Edges\":\n- {Id: 1}\n",
            "Edges:\n- {Id: 1}\nEdges:\n- {Id: 2}\n",
            &(0..200).map(|key| format!("k{key}: 1\n")).collect::<String>(),
        ] {
            assert_eq!(parts(text), None, "{text}");
        }
    }
}
