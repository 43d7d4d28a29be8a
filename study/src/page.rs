//! The page of a study: the same content as HTML with its pictures in it, and as Markdown with
//! pictures beside it.

mod assumptions;
mod caveats;
mod chart;
mod content;
mod cost;
mod heat_map;
mod hint;
mod least;
mod master;
mod method;
mod part;
mod peaks;
mod plan;
mod reliefs;
mod stack;
mod stall_map;
mod time;
mod timeline;
mod verdict;

use std::fmt::Write as _;

pub use chart::COLOURS;
pub use content::{content, title};
pub use master::{master_content, master_title, vehicles_in_words};
use regatta_base::svg::escape;

/// A part of a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A heading of a level from 1.
    Heading(u8, String),
    /// A paragraph.
    Text(String),
    /// The answer to the reader's question.
    Answer(String),
    /// A further finding.
    Finding(String),
    /// A restriction of the answer.
    Caveat(String),
    /// A table: the first row is its head.
    Table(Vec<Vec<String>>),
    /// A picture.
    Picture(Picture),
}

/// A picture of a page.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The name of its file, without the ending.
    pub name: &'static str,
    /// The text below it.
    pub caption: String,
    /// The picture as SVG.
    pub svg: String,
}

/// Returns the page as Markdown, which refers to its pictures as files beside it.
pub fn markdown(blocks: &[Block]) -> String {
    let blocks: Vec<String> = blocks.iter().map(markdown_block).collect();
    blocks.join("\n\n") + "\n"
}

fn markdown_block(block: &Block) -> String {
    match block {
        Block::Heading(level, heading) => format!("{} {heading}", "#".repeat(usize::from(*level))),
        Block::Text(paragraph) | Block::Finding(paragraph) | Block::Caveat(paragraph) => {
            paragraph.clone()
        }
        Block::Answer(answer) => format!("> {answer}"),
        Block::Table(rows) => markdown_table(rows),
        Block::Picture(picture) => format!("![{}]({}.svg)", picture.caption, picture.name),
    }
}

fn markdown_table(rows: &[Vec<String>]) -> String {
    let mut lines = Vec::new();
    for row in rows {
        let cells: Vec<String> =
            row.iter().map(|cell| cell.replace('|', "\\|").replace('\n', " ")).collect();
        lines.push(format!("| {} |", cells.join(" | ")));
    }
    let columns = rows.first().map_or(0, Vec::len);
    lines.insert(1.min(lines.len()), format!("|{}", "---|".repeat(columns)));
    lines.join("\n")
}

/// The style of the page, on a screen and on paper, and what makes its tables sortable.
const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = include_str!("page/page.js");
/// The most letters of a cell that isn't broken into lines.
const SHORT_CELL: usize = 28;

/// Returns the page as one HTML file that has its pictures in it and needs no network.
pub fn html(title: &str, blocks: &[Block]) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\">\n<title>{}</title>\n\
         <style>\n{STYLE}</style>\n",
        escape(title)
    );
    for block in blocks {
        // Writing to a String never fails.
        let _ = match block {
            Block::Heading(level, heading) => {
                writeln!(text, "<h{level}>{}</h{level}>", inline(heading))
            }
            Block::Text(paragraph) => writeln!(text, "<p>{}</p>", inline(paragraph)),
            Block::Finding(finding) => {
                writeln!(text, "<p class=\"finding\">{}</p>", inline(finding))
            }
            Block::Answer(answer) => writeln!(text, "<p class=\"answer\">{}</p>", inline(answer)),
            Block::Caveat(caveat) => writeln!(text, "<p class=\"caveat\">{}</p>", inline(caveat)),
            Block::Table(rows) => writeln!(text, "{}", html_table(rows)),
            Block::Picture(Picture { caption, svg, .. }) => writeln!(
                text,
                "<figure>\n{svg}\n<figcaption>{}</figcaption>\n</figure>",
                inline(caption)
            ),
        };
    }
    text + "<script>\n" + SCRIPT + "</script>\n</html>\n"
}

fn html_table(rows: &[Vec<String>]) -> String {
    let Some((head, body)) = rows.split_first() else { return String::new() };
    // Two columns are a list of words and what they mean.
    let class = if head.len() == 2 { " class=\"words\"" } else { "" };
    let head = html_row(head, "th");
    let body: String = body.iter().map(|row| html_row(row, "td")).collect();
    format!(
        "<div class=\"scroll\"><table{class}>\n<thead>\n{head}</thead>\n<tbody>\n{body}</tbody>\n\
         </table></div>"
    )
}

fn html_row(cells: &[String], tag: &str) -> String {
    let mut text = "<tr>".to_owned();
    for cell in cells {
        let is_short = tag == "td" && cell.chars().count() <= SHORT_CELL;
        let class = if is_short { " class=\"short\"" } else { "" };
        text += &format!("<{tag}{class}>{}</{tag}>", inline(cell));
    }
    text + "</tr>\n"
}

/// Returns a text with `**strong**` and `` `code` `` as elements.
fn inline(text: &str) -> String {
    marked(&marked(&escape(text), "**", "strong"), "`", "code")
}

/// Returns a text with the parts between pairs of a mark as elements.
fn marked(text: &str, mark: &str, tag: &str) -> String {
    let parts: Vec<&str> = text.split(mark).collect();
    let mut marked = String::new();
    for (index, part) in parts.iter().enumerate() {
        if index % 2 == 1 && index + 1 < parts.len() {
            marked += &format!("<{tag}>{part}</{tag}>");
        } else {
            marked += part;
        }
    }
    marked
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

    #[test]
    fn texts_are_escaped_and_marks_become_elements() {
        let blocks = [
            Block::Heading(1, "a < b & \"c\"".to_owned()),
            Block::Table(vec![vec!["robots".to_owned()], vec!["**7**".to_owned()]]),
            Block::Text("see `runs`".to_owned()),
        ];
        let page = html("<t>", &blocks);
        assert!(
            page.contains("<h1>a &lt; b &amp; &quot;c&quot;</h1>")
                && page.contains("<title>&lt;t&gt;</title>"),
            "{page}"
        );
        assert!(
            page.contains("<th>robots</th>")
                && page.contains("<td class=\"short\"><strong>7</strong></td>"),
            "{page}"
        );
        assert!(page.contains("see <code>runs</code>"), "{page}");
        assert!(!page.contains("http"), "the page needs no network: {page}");
    }
}
