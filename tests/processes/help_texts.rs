//! All texts of `--help`, in one file to read, and the rules that they follow.

use crate::fleet::regatta;
use crate::texts;

/// The largest width of a line, as clap wraps texts.
const WIDTH: usize = 100;

/// A page of help: the arguments before `--help`, and its text.
struct Page {
    command: Vec<String>,
    text: String,
}

/// Returns the pages of a command and of all its subcommands and plugins.
fn pages(command: &[String]) -> Vec<Page> {
    let output = regatta().args(command).arg("--help").output().expect("regatta starts");
    assert!(output.status.success(), "{command:?}");
    let text = String::from_utf8(output.stdout).expect("a text");
    let mut pages = Vec::new();
    for name in subcommands(&text) {
        pages.extend(self::pages(&[command, &[name]].concat()));
    }
    pages.insert(0, Page { command: command.to_vec(), text });
    pages
}

/// The names that a page lists under `Commands:` or `Plugins:`.
fn subcommands(text: &str) -> Vec<String> {
    let lists = ["Commands:", "Plugins:"];
    let list = text.lines().skip_while(|line| !lists.contains(line)).skip(1);
    let list = list.take_while(|line| !line.is_empty());
    // Descriptions that are continued are indented further than names.
    let names = list.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "help").map(str::to_owned).collect()
}

/// The descriptions of a page's options: the texts behind their names.
fn descriptions(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut is_option = false;
    for line in text.lines() {
        let word = line.trim_start();
        let indent = line.len() - word.len();
        if (2..=6).contains(&indent) && word.starts_with('-') {
            is_option = true;
            found.push(word.split_once("  ").map_or("", |(_, text)| text).trim().to_owned());
        } else if is_option && indent > 6 && found.last().is_some_and(String::is_empty) {
            found.last_mut().expect("an option").push_str(word);
        } else if indent <= 6 {
            is_option = false;
        }
    }
    found
}

#[test]
fn options_for_files_of_orders_name_all_formats() {
    let pages = pages(&[]);
    let texts = pages.iter().filter(|page| page.text.contains("XLSX"));
    let texts: Vec<&Page> = texts.collect();
    assert!(texts.len() >= 6, "run, master, study, fleet-manager, orders check and import");
    for page in texts {
        assert!(page.text.contains("Parquet"), "{:?}", page.command);
    }
}

/// Writes the texts into the file of all texts, for a person to read.
#[test]
fn help_is_written_in_one_style() {
    let pages = pages(&[]);
    assert!(pages.len() > 40, "{} pages", pages.len());
    let mut all = String::new();
    for Page { command, text } in &pages {
        let about = text.lines().next().unwrap_or_default();
        assert!(!about.ends_with('.'), "{command:?}: {about}");
        for line in text.lines() {
            assert!(line.chars().count() <= WIDTH, "{command:?}: {line}");
        }
        for text in std::iter::once(about.to_owned()).chain(descriptions(text)) {
            let first = text.chars().next();
            assert!(first.is_some_and(char::is_uppercase), "{command:?}: '{text}'");
            assert!(!text.starts_with("The "), "{command:?}: '{text}' begins with an article");
        }
        all += &format!("=== regatta {}\n{text}\n", command.join(" "));
    }
    println!("{}", texts::write("Help", &all));
}
