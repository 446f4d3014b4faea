//! A header row in another program's dialect: what is foreign about it, so that the refusal can say it; and columns that are not known.

use crate::column::Column;

/// What takes a file that this reader refuses.
const WAY_OUT: &str = "`courier convert` makes a recording of such a file";

/// More unknown columns than these are only counted.
const NAMED_UNKNOWN: usize = 10;

/// What was found and what was wanted, where the header row would be the layout's in another dialect; none where it would not.
///
/// `fields` are the header's fields as separated by commas.
pub(crate) fn foreign_header(fields: &[&str]) -> Option<(String, String)> {
    let first = fields.first().copied().unwrap_or_default().trim_start();
    if let Some(rest) = first.strip_prefix('#')
        && (rest.split([';', '\t', ',']).any(is_name) || fields.iter().any(is_known))
    {
        return Some((
            "a \"#\" before the header".into(),
            format!("the names of the columns alone; {WAY_OUT}"),
        ));
    }
    for (separator, name) in [(';', "semicolons"), ('\t', "tabs")] {
        let separated = |field: &&str| field.contains(separator);
        let named = |field: &&str| field.split(separator).any(is_name);
        if fields.iter().any(|field| separated(field) && named(field)) {
            return Some((
                format!("columns separated by {name}"),
                format!("commas; {WAY_OUT}"),
            ));
        }
    }
    let other_case = |field: &&&str| !is_known(field) && is_name(field);
    let field = fields.iter().find(other_case)?.trim();
    let small = field.to_ascii_lowercase();
    let absent = !fields.iter().any(|other| other.trim() == small);
    absent.then(|| {
        (
            format!("the column \"{field}\""),
            format!("it in small letters, \"{small}\"; {WAY_OUT}"),
        )
    })
}

/// A line for each unknown column of `file`; many are counted.
pub(crate) fn warn_of_unknown(file: &str, unknown: &[String], warnings: &mut Vec<String>) {
    for name in unknown.iter().take(NAMED_UNKNOWN) {
        warnings.push(format!(
            "{file}: column \"{name}\" is not known and is left aside"
        ));
    }
    if unknown.len() > NAMED_UNKNOWN {
        warnings.push(format!(
            "{file}: {} more columns are not known",
            unknown.len() - NAMED_UNKNOWN
        ));
    }
}

/// True if the layout has a column of this name, letter by letter.
fn is_known(field: &&str) -> bool {
    let name = field.trim();
    name == "run" || Column::by_name(name).is_some()
}

/// True if the layout has a column of this name, capitals or not.
fn is_name(field: &str) -> bool {
    let name = field.trim().trim_matches('"').to_ascii_lowercase();
    is_known(&name.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dialects_are_told_apart_from_headers_that_are_merely_wrong() {
        let found = |header: &str| {
            let fields: Vec<&str> = header.split(',').collect();
            foreign_header(&fields).map(|(found, _)| found)
        };
        for (header, told) in [
            ("t_s;p1_m", "columns separated by semicolons"),
            ("\"t_s\";\"p1_m\"", "columns separated by semicolons"),
            ("T_S\tP1_M", "columns separated by tabs"),
            ("# t_s,p1_m", "a \"#\" before the header"),
            ("#t_s;p1_m", "a \"#\" before the header"),
            ("t_s,P1_m", "the column \"P1_m\""),
        ] {
            assert_eq!(found(header).as_deref(), Some(told), "{header}");
        }
        for header in [
            "t_s,p1_m",
            "t_s,p1_m,note",
            "t_s,p1_m,P1_M",
            "time,a;b",
            "",
            "#",
        ] {
            assert_eq!(found(header), None, "{header}");
        }
    }
}
