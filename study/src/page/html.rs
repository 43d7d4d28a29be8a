//! The page as one HTML file, with its pictures in it: it needs nothing else, and no network.

use std::fmt::Write as _;

use super::content::Block;

/// How the page looks, on a screen and on paper.
const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;color:#1d2733;background:#fff;max-width:72rem;margin:2rem auto;\
padding:0 1.5rem}h1{font-size:1.8rem;line-height:1.2}h2{margin-top:2.5rem}.answer{font-size:1.35rem;line-height:1.4;\
border-left:.35rem solid #0072b2;padding:.2rem 0 .2rem 1rem;margin:1rem 0}table{border-collapse:collapse;\
font-variant-numeric:tabular-nums;margin:1rem 0;font-size:.9rem}th,td{padding:.3rem .8rem .3rem 0;text-align:right;\
border-bottom:1px solid #dde3ea;vertical-align:top}th{font-weight:600}\
figure{margin:1.5rem 0}figure svg{max-width:100%;height:auto}figcaption{color:#5a6875;font-size:.9rem}\
code{font-size:.9em}.scroll{overflow-x:auto}";

/// Returns the text of a page with a title.
pub fn html(title: &str, blocks: &[Block]) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\">\n<title>{}</title>\n<style>{STYLE}</style>\n",
        escaped(title)
    );
    for block in blocks {
        // Writing to a String never fails.
        let _ = match block {
            Block::Heading(level, heading) => {
                writeln!(text, "<h{level}>{}</h{level}>", inline(heading))
            }
            Block::Text(paragraph) => writeln!(text, "<p>{}</p>", inline(paragraph)),
            Block::Answer(answer) => writeln!(text, "<p class=\"answer\">{}</p>", inline(answer)),
            Block::Table(rows) => writeln!(text, "{}", table(rows)),
            Block::Picture(_, caption, svg) => {
                writeln!(
                    text,
                    "<figure>\n{svg}\n<figcaption>{}</figcaption>\n</figure>",
                    inline(caption)
                )
            }
        };
    }
    text + "</html>\n"
}

fn table(rows: &[Vec<String>]) -> String {
    let row = |(index, row): (usize, &Vec<String>)| {
        let tag = if index == 0 { "th" } else { "td" };
        let cells: String =
            row.iter().map(|cell| format!("<{tag}>{}</{tag}>", inline(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows: String = rows.iter().enumerate().map(row).collect();
    format!("<div class=\"scroll\"><table>\n{rows}</table></div>")
}

/// Returns a text with `**strong**` and `` `code` `` as elements.
fn inline(text: &str) -> String {
    let text = escaped(text);
    let pairs = |text: &str, mark: &str, tag: &str| -> String {
        let parts: Vec<&str> = text.split(mark).collect();
        let part = |(index, part): (usize, &&str)| match index % 2 == 1 && index + 1 < parts.len() {
            true => format!("<{tag}>{part}</{tag}>"),
            false => (*part).to_owned(),
        };
        parts.iter().enumerate().map(part).collect()
    };
    pairs(&pairs(&text, "**", "strong"), "`", "code")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

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
