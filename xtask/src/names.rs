//! Effects' names stand in the effects' own files, and nowhere else in the crates that judge, tell and apply them: these ask an
//! effect's card for a property. So an effect is one file and one line.
//!
//! A name is found in text literals and among identifiers, which modules are. Documentation, attributes (a command's help is one)
//! and tests may speak of effects: what they say is for readers, and no code follows it.

use crate::arm::root;
use crate::source::files_below;
use anyhow::{Context, Result, ensure};
use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// Folders in which no effect is named.
const FOLDERS: &[&str] = &[
    "effects/src",
    "diagnosis/src",
    "report/src",
    "blind/src",
    "host/src",
];

/// Files that may name any effect, each with its reason.
const EXCEPTED: &[(&str, &str)] = &[(
    "effects/src/lib.rs",
    "the list of the effects: the one line of each",
)];

/// Fields of a card by which an effect speaks of another: what it is confused with, found as, completed by, or holds.
const RELATIONS: &[&str] = &["with", "other", "found_as", "completed_by"];

/// Refuses the name of an effect outside its own file.
///
/// # Errors
/// Each place where one stands.
pub fn check() -> Result<()> {
    let names: Vec<&str> = effects::CATALOGUE.iter().map(|entry| entry.name).collect();
    let mut found = Vec::new();
    for folder in FOLDERS {
        for file in files_below(&root().join(folder))? {
            let path = file.strip_prefix(root())?.display().to_string();
            if EXCEPTED.iter().any(|(excepted, _)| *excepted == path) {
                continue;
            }
            let text = std::fs::read_to_string(&file).with_context(|| path.clone())?;
            let own = own_name(&path, &names);
            let others: Vec<&str> = names.iter().copied().filter(|n| Some(*n) != own).collect();
            let relations = if own.is_some() { RELATIONS } else { &[] };
            let places = named(&text, &others, relations).with_context(|| path.clone())?;
            found.extend(
                places
                    .into_iter()
                    .map(|(line, name)| format!("{path}:{line}: {name}")),
            );
        }
    }
    ensure!(
        found.is_empty(),
        "effects are named outside their own files ({}); ask the card in effects/src/effect.rs for a property instead:\n{}",
        found.len(),
        found.join("\n")
    );
    Ok(())
}

/// The effect that a file is of.
fn own_name<'a>(path: &str, names: &[&'a str]) -> Option<&'a str> {
    let file = path.strip_prefix("effects/src/")?.strip_suffix(".rs")?;
    names.iter().copied().find(|name| *name == file)
}

/// Lines at which a source names an effect, but for what stands in some fields.
fn named(text: &str, names: &[&str], but_in: &[&str]) -> Result<Vec<(usize, String)>> {
    let tokens: TokenStream = text
        .parse()
        .map_err(|error| anyhow::anyhow!("found no Rust, {error}"))?;
    let mut found = Vec::new();
    walk(tokens, names, but_in, &mut found);
    Ok(found)
}

fn walk(tokens: TokenStream, names: &[&str], but_in: &[&str], found: &mut Vec<(usize, String)>) {
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Punct(sign) if sign.as_char() == '#' => {
                // `#![…]` of a file, `#[…]` of an item.
                tokens.next_if(|t| matches!(t, TokenTree::Punct(p) if p.as_char() == '!'));
                if let Some(TokenTree::Group(attribute)) = tokens.next()
                    && attribute.stream().to_string().replace(' ', "") == "cfg(test)"
                {
                    skip_item(&mut tokens);
                }
            }
            TokenTree::Ident(word) if but_in.iter().any(|field| word == field) => {
                skip_field(&mut tokens);
            }
            TokenTree::Group(group) => walk(group.stream(), names, but_in, found),
            TokenTree::Ident(_) | TokenTree::Literal(_) => {
                let line = token.span().start().line;
                let text = token.to_string();
                let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
                let known = words.filter(|word| names.contains(word));
                found.extend(known.map(|word| (line, word.to_owned())));
            }
            TokenTree::Punct(_) => {}
        }
    }
}

type Tokens = std::iter::Peekable<proc_macro2::token_stream::IntoIter>;

/// Passes over an item: up to its braces or its semicolon.
fn skip_item(tokens: &mut Tokens) {
    for token in tokens {
        match token {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => return,
            TokenTree::Punct(sign) if sign.as_char() == ';' => return,
            _ => {}
        }
    }
}

/// Passes over the value of a field, up to its comma, if a field it is.
fn skip_field(tokens: &mut Tokens) {
    let is_colon = |t: &TokenTree| matches!(t, TokenTree::Punct(p) if p.as_char() == ':');
    if tokens.next_if(is_colon).is_none() {
        return;
    }
    for token in tokens {
        if matches!(&token, TokenTree::Punct(sign) if sign.as_char() == ',') {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str, but_in: &[&str]) -> Vec<usize> {
        let found = named(text, &["span_error"], but_in).expect("Rust");
        found.into_iter().map(|(line, _)| line).collect()
    }

    #[test]
    fn a_name_in_code_is_found() {
        assert_eq!(lines("const A: &str = \"span_error\";", &[]), [1]);
        assert_eq!(lines("fn a() {\n  f(\"a span_error, b\")\n}", &[]), [2]);
        assert_eq!(lines("use effects::span_error::Known;", &[]), [1]);
        assert_eq!(lines("fn a() { log!(\"{}: span_error\", 1) }", &[]), [1]);
    }

    #[test]
    fn what_is_for_readers_is_not() {
        assert!(lines("//! span_error\n/// span_error\nfn a() {}", &[]).is_empty());
        assert!(lines("#[arg(help = \"span_error\")]\nfn a() {}", &[]).is_empty());
        let tests = "#[cfg(test)]\nmod tests { const A: &str = \"span_error\"; }\nfn b() {}";
        assert!(lines(tests, &[]).is_empty());
        assert!(lines("const A: &str = \"span_errors\";", &[]).is_empty());
        assert_eq!(
            lines("#[cfg(test)]\nuse a;\nuse effects::span_error;", &[]),
            [3]
        );
    }

    #[test]
    fn an_effect_speaks_of_another_in_its_relations_alone() {
        let card = "const C: A = A { with: \"span_error\", text: \"span_error\" };";
        assert_eq!(lines(card, RELATIONS).len(), 1);
        assert_eq!(lines(card, &[]).len(), 2);
        assert_eq!(
            lines(
                "const C: A = A { found_as: Some(\"span_error\") };",
                RELATIONS
            ),
            [0; 0]
        );
    }
}
