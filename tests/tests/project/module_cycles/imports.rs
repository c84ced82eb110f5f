//! What a source file imports from its own crate: every path that begins with `crate::` or
//! `super::`, in `use` or elsewhere.

/// The paths, from the crate's root, that `text`, the file of module `module`, names. Tests within
/// the file and comments do not count.
pub fn imports(text: &str, module: &[String]) -> Vec<Vec<String>> {
    let text = without_tests(&without_comments(text));
    let mut found = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        let begins = !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '$');
        if begins && (rest.starts_with("crate::") || rest.starts_with("super::")) {
            let mut reader = Reader { text: &text, at };
            reader.tree(module, &[], &mut found);
            at = reader.at.max(at + 1);
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
        }
    }
    found
}

/// Reads a tree of paths: `a::b::{c, d::e as f, *}`.
struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl Reader<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn blank(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start().len();
    }

    fn takes(&mut self, token: &str) -> bool {
        self.blank();
        let there = self.rest().starts_with(token);
        self.at += if there { token.len() } else { 0 };
        there
    }

    fn word(&mut self) -> Option<String> {
        self.blank();
        let length =
            self.rest().find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(self.rest().len());
        let word = self.rest()[..length].to_owned();
        self.at += length;
        (!word.is_empty()).then_some(word)
    }

    /// One path or group behind `before`, in the file of `module`.
    fn tree(&mut self, module: &[String], before: &[String], found: &mut Vec<Vec<String>>) {
        let mut path = before.to_vec();
        let mut absolute = !before.is_empty();
        loop {
            if self.takes("{") {
                while !self.takes("}") && self.at < self.text.len() {
                    self.tree(module, &path, found);
                    if self.takes("as ") {
                        self.word();
                    }
                    if !self.takes(",") && !self.rest().starts_with('}') {
                        // No list of paths.
                        return;
                    }
                }
                return;
            }
            match self.word().as_deref() {
                Some("crate") => path = vec!["crate".to_owned()],
                Some("super") => {
                    if !absolute {
                        path = std::iter::once("crate".to_owned()).chain(module.iter().cloned()).collect();
                    }
                    path.pop();
                }
                Some("self") => {}
                Some(word) => path.push(word.to_owned()),
                None => {
                    self.takes("*");
                    break;
                }
            }
            absolute = true;
            // A path in an expression may end in a type's parameters.
            if !self.rest().starts_with("::") || self.rest().starts_with("::<") {
                break;
            }
            self.at += 2;
        }
        found.push(path.split_off(1.min(path.len())));
    }
}

fn without_comments(text: &str) -> String {
    let code = |line: &str| match line.find("//") {
        Some(at) => line[..at].to_owned(),
        None => line.to_owned(),
    };
    text.lines().map(code).collect::<Vec<_>>().join("\n")
}

/// Without modules that are compiled for tests only: they may look anywhere.
fn without_tests(text: &str) -> String {
    const MARK: &str = "#[cfg(test)]\nmod ";
    let Some(start) = text.find(MARK) else {
        return text.to_owned();
    };
    let behind = &text[start + MARK.len()..];
    let end = match (behind.find('{'), behind.find(';')) {
        (Some(open), semicolon) if semicolon.is_none_or(|s| open < s) => {
            let mut depth = 0;
            let closes = |(_, c): &(usize, char)| {
                depth += i32::from(*c == '{') - i32::from(*c == '}');
                depth == 0
            };
            behind[open..].char_indices().find(closes).map_or(behind.len(), |(k, _)| open + k + 1)
        }
        (_, Some(semicolon)) => semicolon + 1,
        _ => behind.len(),
    };
    format!("{}{}", &text[..start], without_tests(&behind[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Vec<String> {
        let module = ["fit".to_owned(), "run".to_owned()];
        imports(text, &module).iter().map(|path| path.join("::")).collect()
    }

    #[test]
    fn paths_groups_and_parents_are_resolved() {
        assert_eq!(of("use crate::data::Row;"), ["data::Row"]);
        assert_eq!(of("pub use crate::{a::B, c::{D as E, f::*}, g};"), ["a::B", "c::D", "c::f", "g"]);
        assert_eq!(of("use super::Space;"), ["fit::Space"]);
        assert_eq!(of("use super::{super::data, x::{self, Y}};"), ["data", "fit::x", "fit::x::Y"]);
        assert_eq!(
            of("let x = f(crate::model::psi::<f64>(1), super::super::rig::Y);"),
            ["model::psi", "rig::Y"]
        );
    }

    #[test]
    fn other_crates_comments_and_tests_do_not_count() {
        assert_eq!(of("use std::fmt; use other_crate::x; my::crate_name();"), Vec::<String>::new());
        assert_eq!(of("/// [`crate::data`]\n//! crate::x\nfn f() {} // super::y"), Vec::<String>::new());
        let tests =
            "use crate::a;\n#[cfg(test)]\nmod tests {\n use crate::b; fn f() { if x {} }\n}\nuse crate::c;";
        assert_eq!(of(tests), ["a", "c"]);
        assert_eq!(of("#[cfg(test)]\nmod testing;\nuse crate::c;"), ["c"]);
    }
}
