//! Rust sources as far as paths go: their words, without comments, texts and tests.

use std::fs;
use std::path::PathBuf;

/// Every Rust file below a folder, sorted.
pub(crate) fn sources(folder: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::from(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|found| found == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The path of modules that a file is: `src/film/exr/mod.rs` is film, exr.
pub(crate) fn module_path(path: &std::path::Path) -> Vec<String> {
    let mut parts: Vec<String> = path
        .with_extension("")
        .components()
        .skip(1)
        .map(|part| part.as_os_str().to_string_lossy().into_owned())
        .collect();
    parts.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
    parts
}

fn is_of_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || !byte.is_ascii()
}

/// Where the text ends that begins with a quotation mark at `start`.
fn end_of_text(bytes: &[u8], start: usize) -> usize {
    let mut place = start + 1;
    while place < bytes.len() && bytes[place] != b'"' {
        place += if bytes[place] == b'\\' { 2 } else { 1 };
    }
    place + 1
}

/// Where the raw text ends whose hashes begin at `start`, or `None` if there is none.
fn end_of_raw(bytes: &[u8], start: usize) -> Option<usize> {
    let hashes = bytes[start..].iter().take_while(|&&byte| byte == b'#');
    let hashes = hashes.count();
    if bytes.get(start + hashes) != Some(&b'"') {
        return None;
    }
    let mut end = vec![b'"'];
    end.resize(1 + hashes, b'#');
    let body = start + hashes + 1;
    let length = bytes[body..]
        .windows(end.len())
        .position(|found| found == end);
    Some(length.map_or(bytes.len(), |length| body + length + end.len()))
}

/// Where the comment ends that begins with `/*` at `start`; comments nest.
fn end_of_block(bytes: &[u8], start: usize) -> usize {
    let (mut depth, mut place) = (0, start);
    while place < bytes.len() {
        match bytes[place..] {
            [b'/', b'*', ..] => (depth, place) = (depth + 1, place + 2),
            [b'*', b'/', ..] => (depth, place) = (depth - 1, place + 2),
            _ => place += 1,
        }
        if depth == 0 {
            break;
        }
    }
    place
}

/// Where the character or lifetime ends that begins with a tick at `start`.
fn end_of_tick(bytes: &[u8], start: usize) -> usize {
    if bytes.get(start + 1) == Some(&b'\\') {
        let rest = bytes.iter().skip(start + 3);
        return start + 4 + rest.take_while(|&&byte| byte != b'\'').count();
    }
    let word = bytes.iter().skip(start + 1);
    let word = word.take_while(|&&byte| is_of_word(byte)).count().max(1);
    // A lifetime has no second tick.
    start + 1 + word + usize::from(bytes.get(start + 1 + word) == Some(&b'\''))
}

/// The words of a source, `::`, and every other character; without comments and texts.
pub(crate) fn words(text: &str) -> Vec<&str> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut place = 0;
    while place < bytes.len() {
        let start = place;
        place = match bytes[place..] {
            [b'/', b'/', ..] => {
                let rest = bytes[place..].iter();
                place + rest.take_while(|&&byte| byte != b'\n').count()
            }
            [b'/', b'*', ..] => end_of_block(bytes, place),
            [b'"', ..] => end_of_text(bytes, place),
            [b'\'', ..] => end_of_tick(bytes, place),
            [b':', b':', ..] => {
                found.push("::");
                place + 2
            }
            [byte, ..] if is_of_word(byte) => {
                let length = bytes[place..]
                    .iter()
                    .take_while(|&&byte| is_of_word(byte))
                    .count();
                let word = &text[start..start + length];
                let raw = ["r", "br"].contains(&word);
                if let Some(end) = end_of_raw(bytes, start + length).filter(|_| raw) {
                    end
                } else {
                    found.push(word);
                    start + length
                }
            }
            [byte, ..] => {
                if !byte.is_ascii_whitespace() {
                    found.push(&text[start..=start]);
                }
                place + 1
            }
            [] => break,
        };
    }
    found
}

/// How many words an item has: to its semicolon, or to the end of its braces.
fn item_length(words: &[&str]) -> usize {
    let is_use = words.iter().take_while(|word| **word != "{");
    let is_use = is_use.clone().any(|word| *word == "use");
    let mut depth = 0;
    for (place, word) in words.iter().enumerate() {
        match *word {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => {
                depth -= 1;
                if depth == 0 && *word == "}" && !is_use {
                    return place + 1;
                }
            }
            ";" if depth == 0 => return place + 1,
            _ => {}
        }
    }
    words.len()
}

/// The words of a source without the items that are for tests alone.
pub(crate) fn without_tests<'text>(words: &[&'text str]) -> Vec<&'text str> {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut kept = Vec::new();
    let mut rest = words;
    while let Some(first) = rest.first() {
        if let Some(item) = rest.strip_prefix(&MARK) {
            rest = &item[item_length(item)..];
        } else {
            kept.push(*first);
            rest = &rest[1..];
        }
    }
    kept
}

fn is_word(word: &str) -> bool {
    word.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// A path of several parts, or one that is imported.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Path<'text> {
    /// Its parts; of an import of all there is the last one is `*`.
    pub(crate) parts: Vec<&'text str>,
    /// The name that an import gives to it.
    pub(crate) name: Option<&'text str>,
}

/// Parts what follows `use` into paths, groups in braces opened. Ends with the words that are left.
fn use_tree<'words, 'text>(
    mut rest: &'words [&'text str],
    stem: &[&'text str],
    found: &mut Vec<Path<'text>>,
) -> &'words [&'text str] {
    let mut parts = stem.to_vec();
    loop {
        match rest {
            ["::", after @ ..] => rest = after,
            ["{", after @ ..] => {
                rest = after;
                while let [first, ..] = rest
                    && *first != "}"
                {
                    rest = use_tree(rest, &parts, found);
                    // A comma, or what is no path.
                    rest = &rest[usize::from(rest.first() != Some(&"}")).min(rest.len())..];
                }
                return &rest[rest.len().min(1)..];
            }
            ["as", name, after @ ..] => {
                let name = Some(*name);
                found.push(Path { parts, name });
                return after;
            }
            [word, after @ ..] if is_word(word) || *word == "*" => {
                parts.push(word);
                rest = after;
            }
            _ => {
                // `a::{self}` is called a.
                let named = parts.iter().rev().find(|part| **part != "self");
                let name = named.copied();
                found.push(Path { parts, name });
                return rest;
            }
        }
    }
}

/// All paths in a source's words.
pub(crate) fn paths<'text>(words: &[&'text str]) -> Vec<Path<'text>> {
    let mut found = Vec::new();
    let mut rest = words;
    while let [first, after @ ..] = rest {
        rest = after;
        if *first == "use" && after.first() != Some(&"<") {
            rest = use_tree(after, &[], &mut found);
        } else if is_word(first) {
            let mut parts = vec![*first];
            while let ["::", word, after @ ..] = rest
                && is_word(word)
            {
                parts.push(word);
                rest = after;
            }
            if parts.len() > 1 {
                found.push(Path { parts, name: None });
            }
        }
    }
    found
}

/// Where a path is looked up: the first `super`s and such made a module, and what is left.
pub(crate) fn anchored<'path, Part: AsRef<str>>(
    from: &[String],
    path: &'path [Part],
) -> (Vec<String>, &'path [Part]) {
    let mut module = from.to_vec();
    let mut rest = path;
    while let [first, after @ ..] = rest {
        match first.as_ref() {
            "crate" => module.clear(),
            "self" => {}
            "super" => drop(module.pop()),
            _ => break,
        }
        rest = after;
    }
    (module, rest)
}

#[test]
fn words_are_found() {
    let text = "use a::b; // c\n/* d /* e */ f */ let x = \"g \\\" h\"; i('j', '\\'', '\\u{41}');\n\
                k::<'l>(r#\"m \" n\"#, b\"o\", '\"'); p";
    let expected = "use a :: b ; let x = ; i ( , , ) ; k :: < > ( , b , ) ; p";
    assert_eq!(words(text).join(" "), expected);
}

#[test]
fn tests_are_left_out() {
    let text = "use a; #[cfg(test)] use b::{c, d}; e { f } #[cfg(test)] #[g] fn h() { i {} } j;\n\
                #[cfg(test)] mod tests; #[cfg(feature)] k { } #[cfg(test)] mod tests { use super::*; l }";
    let expected = "use a ; e { f } j ; # [ cfg ( feature ) ] k { }";
    assert_eq!(without_tests(&words(text)).join(" "), expected);
}
