//! The encoding of a file: UTF-8, UTF-16, or the code page that the file declares.
//!
//! A file that declares none and isn't Unicode is read as Windows-1252, with a warning: most of its
//! content is ASCII, and names can be checked by eye.

use std::ops::Deref;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use super::file::line_at;
use crate::model::format::Format;
use crate::model::value::shorten;

/// The number of bytes at the start of a file that are searched for its code page.
const HEAD: usize = 64 << 10;

/// The text of a file, as [`read_file`](crate::read_file) decodes it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileText {
    text: String,
    doubt: Option<Doubt>,
}

/// A warning about the encoding of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Doubt {
    /// The byte offset in the text.
    pub at: u32,
    pub message: String,
}

/// A text to read, with the warning about its encoding if it is that of a file.
#[derive(Clone, Copy, Debug)]
pub struct SourceText<'text> {
    pub(crate) text: &'text str,
    pub(crate) doubt: Option<&'text Doubt>,
}

/// The reason why bytes aren't a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotText {
    /// The line of the first invalid byte, from 1.
    pub line: usize,
    /// The reason, and what to do.
    pub reason: &'static str,
}

impl FileText {
    /// Returns the text.
    pub fn into_string(self) -> String {
        self.text
    }
}

impl Deref for FileText {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl<'text> SourceText<'text> {
    /// Returns the text.
    pub fn as_str(self) -> &'text str {
        self.text
    }

    /// Returns the warning about the encoding, if there is one: its line, from 1, and its message.
    pub fn doubt(self) -> Option<(usize, &'text str)> {
        let Doubt { at, message } = self.doubt?;
        Some((line_at(self.text.as_bytes(), *at as usize), message))
    }
}

impl<'text> From<&'text str> for SourceText<'text> {
    fn from(text: &'text str) -> Self {
        Self { text, doubt: None }
    }
}

impl<'text> From<&'text String> for SourceText<'text> {
    fn from(text: &'text String) -> Self {
        Self { text, doubt: None }
    }
}

impl<'text> From<&'text FileText> for SourceText<'text> {
    fn from(FileText { text, doubt }: &'text FileText) -> Self {
        Self { text, doubt: doubt.as_ref() }
    }
}

/// Decodes the bytes of a file.
///
/// # Errors
/// If they aren't a text of any encoding.
pub(crate) fn decode(bytes: Vec<u8>) -> Result<FileText, NotText> {
    let mut file = decode_lines(bytes)?;
    // Some programs end lines with a carriage return alone.
    if !file.text.contains('\n') && file.text.contains('\r') {
        file.text = file.text.replace('\r', "\n");
    }
    Ok(file)
}

/// Decodes the bytes of a file, whatever the ends of its lines.
fn decode_lines(bytes: Vec<u8>) -> Result<FileText, NotText> {
    if let Some(encoding) = utf_16(&bytes) {
        return Ok(FileText::decoded(&bytes, encoding, None));
    }
    match String::from_utf8(bytes) {
        Ok(text) if !text.contains('\0') => Ok(FileText { text, doubt: None }),
        Ok(text) => decode_code_page(text.as_bytes()),
        Err(error) => decode_code_page(error.as_bytes()),
    }
}

/// Returns the encoding of a text that starts with a byte order mark of UTF-16.
fn utf_16(bytes: &[u8]) -> Option<&'static Encoding> {
    match bytes {
        [0xff, 0xfe, ..] => Some(UTF_16LE),
        [0xfe, 0xff, ..] => Some(UTF_16BE),
        _ => None,
    }
}

/// Decodes bytes that aren't Unicode.
fn decode_code_page(bytes: &[u8]) -> Result<FileText, NotText> {
    if let Some((at, reason)) = binary(bytes) {
        return Err(NotText { line: line_at(bytes, at), reason });
    }
    let at = bytes.iter().position(|byte| !byte.is_ascii()).unwrap_or_default();
    let Some(name) = declared(bytes) else {
        let message = "the file isn't UTF-8 and declares no code page: it is read as \
                       Windows-1252; if names look wrong, save it as UTF-8 (in Excel: `CSV UTF-8`)";
        return Ok(FileText::decoded(bytes, WINDOWS_1252, Some((at, message.to_owned()))));
    };
    match encoding(&name) {
        Some(encoding) if encoding != UTF_8 => Ok(FileText::decoded(bytes, encoding, None)),
        _ => {
            let message = format!(
                "the file isn't in its code page `{}`, or that isn't known: it is read as \
                 Windows-1252; if names look wrong, save it as UTF-8",
                shorten(&name)
            );
            Ok(FileText::decoded(bytes, WINDOWS_1252, Some((at, message))))
        }
    }
}

impl FileText {
    /// Decodes bytes. `doubt` is a warning about the encoding, with the offset of the first byte
    /// that isn't ASCII, which is the same in the text.
    fn decoded(
        bytes: &[u8],
        encoding: &'static Encoding,
        mut doubt: Option<(usize, String)>,
    ) -> Self {
        let (text, has_errors) = encoding.decode_with_bom_removal(bytes);
        if has_errors {
            let message = format!(
                "the file has bytes that aren't text in {}: they are read as `\u{fffd}`; save it \
                 as UTF-8",
                encoding.name()
            );
            doubt = Some((text.find('\u{fffd}').unwrap_or_default(), message));
        }
        let doubt = doubt.map(|(at, message)| Doubt { at: at as u32, message });
        Self { text: text.into_owned(), doubt }
    }
}

/// Returns the place of the first byte that no text has, and what the file is instead.
fn binary(bytes: &[u8]) -> Option<(usize, &'static str)> {
    if bytes.starts_with(b"AutoCAD Binary DXF") {
        return Some((0, "it is a binary drawing, save it as DXF in ASCII"));
    }
    if bytes.starts_with(b"AC10") {
        return Some((0, "it is a drawing in DWG, save it as DXF in ASCII"));
    }
    if bytes.starts_with(b"PK\x03\x04") {
        let reason = "it is a workbook or another archive, save its tables as CSV (`CSV UTF-8`)";
        return Some((0, reason));
    }
    let at = bytes.iter().position(|byte| is_control(*byte))?;
    let reason = match bytes {
        [0, _, ..] | [_, 0, ..] => "it looks like UTF-16, save it as UTF-8",
        _ => "it contains bytes of a binary file; check that this is a route graph file",
    };
    Some((at, reason))
}

/// Whether a byte is a control character that texts don't have. The end of a text in DOS is 0x1a.
fn is_control(byte: u8) -> bool {
    byte < b' ' && !b"\t\n\x0b\x0c\r\x1a".contains(&byte)
}

/// Returns the name of the code page that a drawing or an XML file declares.
fn declared(bytes: &[u8]) -> Option<String> {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]);
    match Format::detect(&head) {
        Format::Dxf => {
            let mut lines = head.lines().map(str::trim);
            lines.find(|line| *line == "$DWGCODEPAGE")?;
            lines.nth(1).map(str::to_owned)
        }
        Format::OpenTcs => {
            let (declaration, _) = head.split_once("?>")?;
            let (_, value) = declaration.split_once("encoding")?;
            value.split(['"', '\'']).nth(1).map(str::to_owned)
        }
        _ => None,
    }
}

/// Returns the encoding with a name, as XML, HTML or drawings give it.
fn encoding(name: &str) -> Option<&'static Encoding> {
    let lowercase = name.to_ascii_lowercase();
    let page = lowercase.trim_start_matches(|letter: char| !letter.is_ascii_digit());
    let label = match page {
        "932" => "shift_jis",
        "936" => "gbk",
        "949" => "euc-kr",
        "950" => "big5",
        "874" | "1250" | "1251" | "1252" | "1253" | "1254" | "1255" | "1256" | "1257" | "1258" => {
            return Encoding::for_label(format!("windows-{page}").as_bytes());
        }
        _ => match lowercase.as_str() {
            "ksc5601" => "euc-kr",
            other => return Encoding::for_label(other.as_bytes()),
        },
    };
    Encoding::for_label(label.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(bytes: &[u8]) -> (String, Option<String>) {
        let FileText { text, doubt } = decode(bytes.to_vec()).expect("a text");
        (text, doubt.map(|doubt| doubt.message))
    }

    #[test]
    fn unicode_is_told_by_its_bytes() {
        assert_eq!(decoded("Südtor".as_bytes()), ("Südtor".to_owned(), None));
        let little: Vec<u8> = "\u{feff}Tür".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = "\u{feff}Tür".encode_utf16().flat_map(u16::to_be_bytes).collect();
        assert_eq!(decoded(&little), ("Tür".to_owned(), None));
        assert_eq!(decoded(&big), ("Tür".to_owned(), None));
    }

    #[test]
    fn lines_may_end_with_a_carriage_return() {
        assert_eq!(decoded(b"id,x,y\r1,0,0\r").0, "id,x,y\n1,0,0\n");
        assert_eq!(decoded(b"id,x,y\r\n1,0,0\r\n").0, "id,x,y\r\n1,0,0\r\n");
    }

    #[test]
    fn a_declared_code_page_is_used() {
        let xml = b"<?xml version='1.0' encoding='ISO-8859-1'?>\n<model name=\"S\xfcd\"/>";
        assert!(decoded(xml).0.contains("Süd"));
        for (page, bytes, text) in [
            ("ANSI_1252", b"S\xfcd".as_slice(), "Süd"),
            ("ansi_936", b"\xb3\xb5\xb5\xc0", "车道"),
            ("ANSI_932", b"\x93\xb9", "道"),
            ("dos949", b"\xb1\xe6", "길"),
            ("KSC5601", b"\xb1\xe6", "길"),
            ("BIG5", b"\xb8\xf4", "路"),
            ("ISO8859-2", b"\xb3", "ł"),
        ] {
            let start = format!(
                "  0\r\nSECTION\r\n  2\r\nHEADER\r\n  9\r\n$DWGCODEPAGE\r\n  3\r\n{page}\r\n"
            );
            let (decoded, doubt) = decoded(&[start.as_bytes(), bytes].concat());
            assert!(decoded.ends_with(text) && doubt.is_none(), "{page}: {decoded} {doubt:?}");
        }
    }

    #[test]
    fn a_guess_is_told() {
        let (text, doubt) = decoded(b"id;x;y;name\r\n1;0;0;S\xfcdtor\r\n");
        assert!(text.contains("Südtor"), "{text}");
        assert!(doubt.expect("a warning").contains("read as Windows-1252"));
        let unknown = b"0\nSECTION\n2\nHEADER\n9\n$DWGCODEPAGE\n3\ndos850\n9\n\xfc\n";
        let (text, doubt) = decoded(unknown);
        assert!(text.ends_with("ü\n") && doubt.expect("a warning").contains("`dos850`"));
        let broken = b"<?xml version=\"1.0\" encoding=\"GBK\"?><model name=\"\xff\xff\"/>";
        assert!(decoded(broken).1.expect("a warning").contains("aren't text in GBK"));
        let lies = b"<?xml version=\"1.0\" encoding=\"UTF-8\"?><model name=\"\xfc\"/>";
        assert!(decoded(lies).1.expect("a warning").contains("isn't in its code page `UTF-8`"));
    }

    #[test]
    fn binary_files_are_no_texts() {
        for (bytes, part) in [
            (b"\x89PNG\r\n\x1a\n\0\0\xff".as_slice(), "binary file"),
            (b"AC1027\0\0\xff", "DWG"),
            (b"PK\x03\x04\x14\0\x06\0\xff", "CSV UTF-8"),
            (b"i\0d\0\xfc\0", "UTF-16"),
        ] {
            let error = decode(bytes.to_vec()).expect_err("binary");
            assert!(error.reason.contains(part), "{error:?}");
        }
    }
}
