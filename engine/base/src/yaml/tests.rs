use super::*;

fn node<'a>(root: &'a Node<'a>, key: &str) -> &'a Node<'a> {
    let pairs = root.pairs().expect("a map");
    pairs.into_iter().find(|(name, _)| name == key).expect("the key").1
}

#[test]
fn values_know_their_places() {
    let text = "ä: [1, ü, 0x10]\r\nb:\n  c: 'd'\n";
    let root = parse(text).expect("yaml");
    let list = node(&root, "ä").list().expect("a list");
    let places: Vec<_> = list.iter().map(|item| (item.line, item.offset)).collect();
    assert_eq!(places, [(1, 5), (1, 8), (1, 12)]);
    assert_eq!(list[2].content, Content::Integer(16));
    let text_node = node(node(&root, "b"), "c");
    assert_eq!((text_node.line, &text[text_node.offset..][..3]), (3, "'d'"));
}

#[test]
fn scalars_follow_the_core_schema() {
    let cases = [
        ("~", Content::Null),
        ("True", Content::Bool(true)),
        ("yes", Content::Text("yes".into())),
        ("-7", Content::Integer(-7)),
        ("0o17", Content::Integer(15)),
        ("1e3", Content::Float(1000.0)),
        ("-.inf", Content::Float(f64::NEG_INFINITY)),
        ("inf", Content::Text("inf".into())),
        ("'1'", Content::Text("1".into())),
        ("!!str 1", Content::Text("1".into())),
        ("007", Content::Text("007".into())),
        ("0", Content::Integer(0)),
        ("0.5", Content::Float(0.5)),
        ("1e999", Content::Text("1e999".into())),
        ("!degrees 90", Content::Tagged),
        ("!pair [1, 2]", Content::Tagged),
    ];
    for (text, content) in cases {
        assert_eq!(parse(text).expect(text).content, content, "{text}");
    }
}

#[test]
fn aliases_are_expanded_up_to_a_limit() {
    let root = parse("a: &x [1, 2]\nb: *x\n").expect("yaml");
    assert_eq!(node(&root, "b").content, node(&root, "a").content);
    let mut bomb = String::from("a0: &a0 [x, x, x, x, x, x, x, x]\n");
    for level in 1..12 {
        let items = vec![format!("*a{}", level - 1); 8].join(", ");
        bomb += &format!("a{level}: &a{level} [{items}]\n");
    }
    assert!(parse(&bomb).expect_err("a bomb").reason.contains("aliases included"));
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let nested = format!("a:\n  {}", "[".repeat(MAX_DEPTH + 1));
    for (text, line, reason) in [
        ("a: 1\nb: [\n", 3, ""),
        ("a: 1\n---\nb: 2\n", 1, "2 documents"),
        ("a: &x [1, *x]", 1, "anchor"),
        (&nested, 2, "nested"),
    ] {
        let error = parse(text).expect_err(text);
        assert!(error.line == line && error.reason.contains(reason), "{text}: {error}");
    }
    let root = parse("a: 1\nb: -2\n").expect("yaml");
    assert_eq!(
        node(&root, "b").non_negative(),
        Err(Error { line: 2, reason: "-2 is below 0".into() })
    );
    assert!(root.fields(&["a"]).unwrap_err().reason.contains("unknown field `b`"));
    assert!(
        parse("a: 1\na: 2\n").expect("yaml").fields(&["a"]).unwrap_err().reason.contains("twice")
    );
    assert_eq!(parse("").expect("nothing").content, Content::Null);
}

#[test]
fn a_tab_in_the_indentation_is_named() {
    for (text, line) in
        [("a:\n\t- 1\n", 2), ("a:\n  - {b: 1}\n\t- {b: 2}\n", 3), ("\ta: 1\nb: 2\n", 1)]
    {
        let error = parse(text).expect_err(text);
        assert!(error.line == line && error.reason.contains("a tab"), "{text:?}: {error}");
    }
    assert!(!parse("a: [\n").expect_err("open").reason.contains("tab"));
}
