//! The part of Python's literals that the head of a NumPy file is made of.

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// `'<f8'`
    Text(String),
    /// `240`
    Number(usize),
    /// `True`
    Truth(bool),
    /// A list or a tuple.
    Row(Vec<Literal>),
    /// Keys and values.
    Names(Vec<(String, Literal)>),
}

impl Literal {
    /// Of a dictionary the value with this key.
    pub fn get(&self, key: &str) -> Option<&Literal> {
        let Self::Names(names) = self else {
            return None;
        };
        names
            .iter()
            .find(|(name, _)| name == key)
            .map(|(_, value)| value)
    }

    /// The value that a text holds from its first letter on; none where it is no such value.
    pub fn parse(text: &str) -> Option<Self> {
        value(&mut text.trim_start(), 0)
    }
}

/// Heads hold rows in rows, four deep at most.
const DEEPEST: usize = 16;

fn value(rest: &mut &str, depth: usize) -> Option<Literal> {
    let first = rest.chars().next()?;
    if depth > DEEPEST {
        return None;
    }
    match first {
        '\'' | '"' => {
            let end = rest[1..].find(first)?;
            let text = rest[1..=end].to_owned();
            *rest = rest[end + 2..].trim_start();
            // No name of a column has one, and what it would mean is not read here.
            (!text.contains('\\')).then_some(Literal::Text(text))
        }
        '(' | '[' => {
            let close = if first == '(' { ')' } else { ']' };
            *rest = rest[1..].trim_start();
            let mut row = Vec::new();
            while !take(rest, close) {
                row.push(value(rest, depth + 1)?);
                take(rest, ',');
            }
            Some(Literal::Row(row))
        }
        '{' => {
            *rest = rest[1..].trim_start();
            let mut names = Vec::new();
            while !take(rest, '}') {
                let Literal::Text(name) = value(rest, depth + 1)? else {
                    return None;
                };
                take(rest, ':').then_some(())?;
                names.push((name, value(rest, depth + 1)?));
                take(rest, ',');
            }
            Some(Literal::Names(names))
        }
        _ => {
            let end = rest
                .find(|letter: char| !letter.is_ascii_alphanumeric())
                .unwrap_or(rest.len());
            let word = &rest[..end];
            *rest = rest[end..].trim_start();
            match word {
                "True" => Some(Literal::Truth(true)),
                "False" => Some(Literal::Truth(false)),
                // Python 2 wrote `240L`.
                _ => word.trim_end_matches('L').parse().ok().map(Literal::Number),
            }
        }
    }
}

fn take(rest: &mut &str, letter: char) -> bool {
    match rest.strip_prefix(letter) {
        Some(after) => {
            *rest = after.trim_start();
            true
        }
        None => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_of_a_file_and_what_is_none() {
        let head = Literal::parse("{'descr': [('t', '<f8'), (\"a\", '<i2', (3,))], 'fortran_order': False, 'shape': (240L,), }  \n").unwrap();
        assert_eq!(
            head.get("shape"),
            Some(&Literal::Row(vec![Literal::Number(240)]))
        );
        assert_eq!(head.get("fortran_order"), Some(&Literal::Truth(false)));
        let Some(Literal::Row(fields)) = head.get("descr") else {
            panic!()
        };
        assert_eq!(
            fields[0],
            Literal::Row(vec![Literal::Text("t".into()), Literal::Text("<f8".into())])
        );
        for text in [
            "",
            "{",
            "{'a'",
            "{'a': ",
            "(1, ",
            "'a",
            "(-1,)",
            "{1: 2}",
            "'\\n'",
            &"(".repeat(100),
        ] {
            assert_eq!(Literal::parse(text), None, "{text}");
        }
    }
}
