//! Compares lines and angles with the standard library, and checks that written lines are read
//! back.

use proptest::prelude::*;

use super::*;

fn parsed(text: &str) -> Result<PoseLine, LineFault> {
    PoseLine::parse(text.as_bytes(), Separator::Comma)
}

#[test]
fn lines_of_the_dissertation_are_parsed() {
    let pose = PoseLine { id: 7, x: 28.99, y: -15.54, theta: -90.0 };
    for text in ["7,28.99,-15.54,-90", " 7 , 28.99 , -15.54 , -90.00 ", "+7,2.899e1,-15.54,-90."] {
        assert_eq!(parsed(text), Ok(pose), "{text}");
    }
    for text in ["7 28.99 -15.54 -90", "7  28.99\t-15.54 -90.000"] {
        assert_eq!(PoseLine::parse(text.as_bytes(), Separator::Space), Ok(pose), "{text}");
    }
}

#[test]
fn each_invalid_line_has_its_fault() {
    use LineFault::{IdTooLarge, Malformed, NegativeId, NotFinite};
    for (text, fault) in [
        ("", Malformed),
        ("1,2,3", Malformed),
        ("1,2,3,4,5", Malformed),
        ("1,2,3,", Malformed),
        ("1 2 3 4", Malformed),
        ("1.5,2,3,4", Malformed),
        ("-,2,3,4", Malformed),
        ("1,2,x,4", Malformed),
        ("-1,2,x,4", Malformed),
        ("-1,2,3,4", NegativeId),
        ("-99999999999999999999,2,3,4", NegativeId),
        ("4294967296,2,3,4", IdTooLarge),
        ("99999999999999999999,2,3,4", IdTooLarge),
        ("1,nan,3,4", NotFinite),
        ("1,2,inf,4", NotFinite),
        ("1,2,3,1e39", NotFinite),
    ] {
        assert_eq!(parsed(text), Err(fault), "{text}");
    }
    assert_eq!(parsed("-0,1,2,3").map(|line| line.id), Ok(0));
    assert_eq!(PoseLine::parse(b"1,\xff,3,4", Separator::Comma), Err(Malformed));
}

#[test]
fn a_datagram_is_split_into_its_lines() {
    let all: Vec<_> = lines(b"1,2,3,4\r\n\n  \n5,6,7,8\n9").collect();
    assert_eq!(all, [&b"1,2,3,4"[..], b"5,6,7,8", b"9"]);
    assert_eq!(lines(b"").count(), 0);
}

#[test]
fn angles_are_wrapped() {
    let degrees = |angle| AngleUnit::Degrees.to_radians(angle);
    assert_eq!((degrees(180.0), degrees(-180.0), degrees(540.0)), (PI, PI, PI));
    assert_eq!(degrees(360.0), 0.0);
    assert!((degrees(-450.0) + PI / 2.0).abs() < 1e-6);
    assert_eq!(AngleUnit::Radians.to_radians(-PI), PI);
    assert_eq!(AngleUnit::Degrees.from_radians(PI), 180.0);
}

fn format() -> impl Strategy<Value = LineFormat> {
    let separator = prop_oneof![Just(Separator::Comma), Just(Separator::Space)];
    let unit = prop_oneof![Just(AngleUnit::Degrees), Just(AngleUnit::Radians)];
    (separator, 1..=fixed::MAX_DECIMALS, unit)
        .prop_map(|(separator, d, unit)| LineFormat::new(separator, d, unit))
}

proptest! {
    #[test]
    fn written_lines_are_read_back(
        id: u32, x in -1e6_f32..1e6, y in -1e6_f32..1e6, theta in -400.0_f32..400.0, format in format()
    ) {
        let line = PoseLine { id, x, y, theta };
        let mut text = Vec::new();
        line.write(&mut text, format);
        prop_assert_eq!(text.pop(), Some(b'\n'));
        let read = PoseLine::parse(&text, format.separator).expect("a line");
        prop_assert_eq!(read.id, id);
        for (read, written, decimals) in
            [(read.x, x, format.decimals), (read.y, y, format.decimals), (read.theta, theta, format.theta_decimals)]
        {
            let half_a_unit = 0.5 * 10_f64.powi(-(decimals as i32));
            let rounding = f64::from(written.abs()) * f64::from(f32::EPSILON);
            prop_assert!((f64::from(read) - f64::from(written)).abs() <= half_a_unit + rounding);
        }
    }

    #[test]
    fn no_written_line_exceeds_the_maximum_length(id: u32, x: u32, y: u32, theta: u32, format in format()) {
        let [x, y, theta] = [x, y, theta].map(f32::from_bits);
        let mut text = Vec::new();
        PoseLine { id, x, y, theta }.write(&mut text, format);
        prop_assert!(text.len() <= MAX_LINE_BYTES);
    }

    #[test]
    fn the_parser_never_panics(bytes: Vec<u8>) {
        for line in lines(&bytes) {
            for separator in [Separator::Comma, Separator::Space] {
                if let Ok(line) = PoseLine::parse(line, separator) {
                    prop_assert!(line.x.is_finite() && line.y.is_finite() && line.theta.is_finite());
                }
            }
        }
    }

    #[test]
    fn lines_are_split_like_the_standard_library_does(text in "[a,é ]{0,20}") {
        prop_assert!(at_commas(&text).eq(text.split(',')));
    }

    #[test]
    fn nearly_valid_lines_are_finite_or_rejected(text in "[-+0-9a-z.e]{0,12}(,[-+0-9a-z. ]{0,9}){2,4}") {
        if let Ok(line) = parsed(&text) {
            prop_assert!(line.x.is_finite() && line.y.is_finite() && line.theta.is_finite());
        }
    }

    #[test]
    fn any_angle_is_wrapped_into_range(angle: f32) {
        prop_assume!(angle.is_finite());
        for unit in [AngleUnit::Degrees, AngleUnit::Radians] {
            let radians = unit.to_radians(angle);
            prop_assert!(-PI < radians && radians <= PI, "{angle} becomes {radians}");
        }
    }
}
