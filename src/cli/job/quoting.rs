//! Words in YAML.

/// A text as a scalar of YAML 1.2 in double quotes (section 7.3.1), on one line; with the escapes of section 5.7 for
/// what is not printable by section 5.1, and for what might be taken for the end of a line.
pub(super) fn yaml(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            ' '..='~'
            | '\u{a0}'..='\u{2027}'
            | '\u{202f}'..='\u{d7ff}'
            | '\u{e000}'..='\u{fefe}'
            | '\u{ff00}'..='\u{fffd}'
            | '\u{10000}'..='\u{10ffff}' => quoted.push(c),
            c if u32::from(c) <= 0xff => quoted.push_str(&format!("\\x{:02x}", u32::from(c))),
            c => quoted.push_str(&format!("\\u{:04x}", u32::from(c))),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use candela::internal::shell_word;

    use super::*;

    #[test]
    fn words_are_quoted() {
        for (text, in_yaml, in_shell) in [
            ("a.toml", r#""a.toml""#, "a.toml"),
            ("", r#""""#, "''"),
            ("it's 1", r#""it's 1""#, r"'it'\''s 1'"),
            (r#"a"\b"#, r#""a\"\\b""#, r#"'a"\b'"#),
            ("ä€😀", "\"ä€😀\"", "'ä€😀'"),
            (
                "a\nb\u{1b}\u{85}\u{2028}\u{feff}",
                r#""a\x0ab\x1b\x85\u2028\ufeff""#,
                "'a\nb\u{1b}\u{85}\u{2028}\u{feff}'",
            ),
            ("$(x)", r#""$(x)""#, "'$(x)'"),
            ("####", "\"####\"", "'####'"),
        ] {
            assert_eq!(yaml(text), in_yaml);
            assert_eq!(shell_word(text), in_shell);
        }
    }
}
