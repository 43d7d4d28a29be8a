//! The page of a study: the same content as HTML with its pictures in it, and as Markdown with
//! pictures beside it.

mod caveats;
mod chart;
mod content;
mod heat_map;
mod least;
mod master;
mod method;
mod plan;
mod stack;
mod stall_map;
mod time;
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
        Block::Text(paragraph) | Block::Caveat(paragraph) => paragraph.clone(),
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

/// The style of the page, on a screen and on paper.
const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;color:#1d2733;background:#fff;max-width:72rem;margin:2rem auto;\
padding:0 1.5rem}h1{font-size:1.8rem;line-height:1.2}h2{margin-top:2.5rem}.answer{font-size:1.35rem;line-height:1.4;\
border-left:.35rem solid #0072b2;padding:.2rem 0 .2rem 1rem;margin:1rem 0}\
.caveat{border-left:.35rem solid #d55e00;padding-left:1rem}\
table{border-collapse:collapse;\
font-variant-numeric:tabular-nums;margin:1rem 0;font-size:.9rem}th,td{padding:.3rem .8rem .3rem 0;text-align:right;\
border-bottom:1px solid #dde3ea;vertical-align:top}th{font-weight:600}\
figure{margin:1.5rem 0}figure svg{max-width:100%;height:auto}figcaption{color:#5a6875;font-size:.9rem}\
code{font-size:.9em}.scroll{overflow-x:auto}";

/// Returns the page as one HTML file that has its pictures in it and needs no network.
pub fn html(title: &str, blocks: &[Block]) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\">\n<title>{}</title>\n<style>{STYLE}</style>\n",
        escape(title)
    );
    for block in blocks {
        // Writing to a String never fails.
        let _ = match block {
            Block::Heading(level, heading) => {
                writeln!(text, "<h{level}>{}</h{level}>", inline(heading))
            }
            Block::Text(paragraph) => writeln!(text, "<p>{}</p>", inline(paragraph)),
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
    text + "</html>\n"
}

fn html_table(rows: &[Vec<String>]) -> String {
    let mut text = "<div class=\"scroll\"><table>\n".to_owned();
    for (index, row) in rows.iter().enumerate() {
        let tag = if index == 0 { "th" } else { "td" };
        text += "<tr>";
        for cell in row {
            text += &format!("<{tag}>{}</{tag}>", inline(cell));
        }
        text += "</tr>\n";
    }
    text + "</table></div>"
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
            page.contains("<th>robots</th>") && page.contains("<td><strong>7</strong></td>"),
            "{page}"
        );
        assert!(page.contains("see <code>runs</code>"), "{page}");
        assert!(!page.contains("http"), "the page needs no network: {page}");
    }
}
