//! The table of rules in the docs is that of the judge.

use regatta_vda5050::judge::{RULES, RuleRow};

fn line(row: &RuleRow) -> String {
    let (side, severity): (&str, &str) = (row.side.into(), row.severity.into());
    let RuleRow { clause_2, clause_3, requirement, .. } = row;
    format!("| {} | {side} | {severity} | {clause_2} | {clause_3} | {requirement} |", row.rule.id())
}

#[test]
fn the_docs_list_all_rules_and_no_others() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/vda5050-check.md");
    let text = std::fs::read_to_string(path).expect("the page");
    let (_, rules) = text.split_once("\n## Rules\n").expect("the section");
    let listed: Vec<_> = rules
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| rule "))
        .collect();
    let wanted: Vec<_> = RULES.iter().map(line).collect();
    assert_eq!(listed, wanted);
}
