//! The page as Markdown, with its pictures in files beside it.

use super::content::Block;

/// Returns the text of the page.
pub fn markdown(blocks: &[Block]) -> String {
    let blocks: Vec<String> = blocks.iter().map(block).collect();
    blocks.join("\n\n") + "\n"
}

fn block(block: &Block) -> String {
    match block {
        Block::Heading(level, heading) => format!("{} {heading}", "#".repeat(usize::from(*level))),
        Block::Text(paragraph) => paragraph.clone(),
        Block::Answer(answer) => format!("> {answer}"),
        Block::Table(rows) => table(rows),
        Block::Picture(name, caption, _) => format!("![{caption}]({name}.svg)"),
    }
}

fn table(rows: &[Vec<String>]) -> String {
    let line = |row: &Vec<String>| {
        format!("| {} |", row.iter().map(|cell| escaped(cell)).collect::<Vec<_>>().join(" | "))
    };
    let columns = rows.first().map_or(0, Vec::len);
    let rule = format!("|{}", "---|".repeat(columns));
    let mut lines: Vec<String> = rows.iter().map(line).collect();
    lines.insert(1.min(lines.len()), rule);
    lines.join("\n")
}

fn escaped(cell: &str) -> String {
    cell.replace('|', "\\|").replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_a_rule_below_its_head() {
        let rows = [["a", "b|c"], ["1", "2"]].map(|row| row.map(str::to_owned).to_vec());
        let text = markdown(&[Block::Heading(2, "T".to_owned()), Block::Table(rows.to_vec())]);
        assert_eq!(text, "## T\n\n| a | b\\|c |\n|---|---|\n| 1 | 2 |\n");
    }
}
