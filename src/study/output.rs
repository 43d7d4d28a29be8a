//! The files that a study leaves for its reader: the page, its pictures and a recording.

use std::path::Path;
use std::process::Command;

use regatta_study::answer::{Answer, VariantAnswer};
use regatta_study::page::{Block, Picture, content, html, markdown, title};
use regatta_study::plan::{Plan, Question, Variant};
use regatta_study::store::Store;
use serde_json::Value;

use super::pdf::Browser;
use crate::failure::Failure;
use crate::output::{quoted, show, write_inside};

/// Writes the answer into the folder of the study, and prints it.
pub fn write(
    answer: &Answer,
    base: &Variant,
    folder: &Path,
    browser: Option<&Browser>,
) -> Result<(), Failure> {
    let blocks = content(answer, base, &command_line());
    write_page(&serde_json::to_value(answer)?, &title(answer), &blocks, folder, browser)
}

/// Returns the command line of this process, for a shell.
fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| quoted(&word.to_string_lossy()));
    std::iter::once("regatta".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Writes an answer as JSON and as a page into the folder of the study, also as PDF if there is a
/// browser for it, and prints what the page says first.
pub fn write_page(
    answer: &Value,
    title: &str,
    blocks: &[Block],
    folder: &Path,
    browser: Option<&Browser>,
) -> Result<(), Failure> {
    let mut files = vec![
        ("study.json".to_owned(), format!("{answer:#}\n").into_bytes()),
        ("study.md".to_owned(), markdown(blocks).into_bytes()),
        ("index.html".to_owned(), html(title, blocks).into_bytes()),
    ];
    for block in blocks {
        if let Block::Picture(Picture { name, svg, .. }) = block {
            files.push((format!("{name}.svg"), svg.clone().into_bytes()));
            files.push((format!("{name}.png"), regatta_record::png(svg)?));
        }
    }
    for (name, bytes) in files {
        write_inside(&folder.join(name), &bytes)?;
    }
    for block in blocks {
        if let Block::Answer(text) | Block::Finding(text) | Block::Caveat(text) = block {
            show(text.replace("**", "") + "\n");
        }
    }
    println!("{}", folder.join("index.html").display());
    if let Some(browser) = browser {
        println!("{}", browser.print(folder)?.display());
    }
    Ok(())
}

/// Does the first run with the number of robots of the answer again, and records it.
pub fn record(plan: &Plan, store: &Store, answer: &Answer) -> Result<(), Failure> {
    let Some(robots) = answer.variants.first().and_then(VariantAnswer::robots) else {
        return Ok(());
    };
    let variant = &plan.variants[0];
    let layout = store.keep_layout(&variant.layout_text())?;
    let job = variant.job(&layout, robots, 1, plan.time, &plan.program);
    let name = if plan.question == Question::Knee { "knee" } else { "least" };
    let file = store.folder().join(format!("{name}-{robots}-robots.mcap"));
    if file.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
        return Err(format!("{}: no regular file: remove it", file.display()).into());
    }
    store.keep_job(&job)?;
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("study-run").arg("--trust").arg(store.job_file(&job.id()));
    command.arg("--record").arg(&file);
    let status = command.status()?;
    if !status.success() {
        return Err(format!("{}: the recording failed", file.display()).into());
    }
    println!("{}", file.display());
    Ok(())
}
