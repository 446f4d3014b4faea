//! What a message is made of: definitions of ROS 2 (`ros2msg`), each type's after a line of `=` and its name.

/// How many values a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// One.
    One,
    /// So many.
    Fixed(usize),
    /// A number that stands before them.
    Told,
}

/// What a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `float32`, `float64`: bytes.
    Real(usize),
    /// `int8` to `int64`.
    Signed(usize),
    /// `uint8` to `uint64`, `byte`, `char`, `bool`.
    Unsigned(usize),
    /// `string`
    Text,
    /// Another type, by its place in the list of all.
    Type(usize),
}

/// A field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// What its values are.
    pub kind: Kind,
    /// How many they are.
    pub length: Length,
}

/// All types that a message is made of.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Definition {
    /// Names with the package, without `msg/`; the message's own is the first.
    pub names: Vec<String>,
    /// Their fields.
    pub fields: Vec<Vec<Field>>,
}

impl Definition {
    /// Reads the definition of the message `name`, as `sensor_msgs/msg/JointState`.
    ///
    /// # Errors
    /// What cannot be read, in words.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        let mut parts: Vec<(String, Vec<&str>)> = vec![(short(name), Vec::new())];
        let mut lines = text.lines().map(str::trim);
        while let Some(line) = lines.next() {
            if line.len() > 2 && line.chars().all(|letter| letter == '=') {
                let head = lines
                    .find(|line| !line.is_empty())
                    .and_then(|line| line.strip_prefix("MSG:"));
                let name = head.ok_or("a definition without a line MSG: after ===")?;
                parts.push((short(name.trim()), Vec::new()));
            } else if let Some((_, own)) = parts.last_mut() {
                own.push(line);
            }
        }
        let names: Vec<String> = parts.iter().map(|(name, _)| name.clone()).collect();
        let fields = parts
            .iter()
            .map(|(name, lines)| fields(name, lines, &names))
            .collect::<Result<Vec<_>, String>>()?;
        Ok(Self { names, fields })
    }
}

/// `sensor_msgs/msg/JointState` and `sensor_msgs/JointState` are one.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

fn fields(owner: &str, lines: &[&str], names: &[String]) -> Result<Vec<Field>, String> {
    let mut fields = Vec::new();
    for line in lines {
        let line = line.split('#').next().unwrap_or_default().trim();
        let Some((kind, rest)) = line.split_once(char::is_whitespace) else {
            continue;
        };
        let name = rest.split_whitespace().next().unwrap_or_default();
        // A constant, `int32 A=1` or `int32 A = 1`, takes no place.
        if name.contains('=')
            || rest
                .split_whitespace()
                .nth(1)
                .is_some_and(|next| next.starts_with('='))
        {
            continue;
        }
        let (kind, length) = match kind.split_once('[') {
            None => (kind, Length::One),
            Some((kind, length)) => match length.strip_suffix(']') {
                Some(length) => match length.parse() {
                    Ok(length) => (kind, Length::Fixed(length)),
                    // `[]` and `[<=9]`
                    Err(_) => (kind, Length::Told),
                },
                None => return Err(format!("the field \"{line}\" of {owner}")),
            },
        };
        // `string<=9`
        let plain = kind.split('<').next().unwrap_or_default();
        let kind = primitive(plain)
            .or_else(|| named(plain, owner, names))
            .ok_or_else(|| format!("the type {plain} of {owner}, without its definition"))?;
        fields.push(Field {
            name: name.to_owned(),
            kind,
            length,
        });
    }
    Ok(fields)
}

fn primitive(name: &str) -> Option<Kind> {
    Some(match name {
        "float32" => Kind::Real(4),
        "float64" => Kind::Real(8),
        "int8" => Kind::Signed(1),
        "int16" => Kind::Signed(2),
        "int32" => Kind::Signed(4),
        "int64" => Kind::Signed(8),
        "uint8" | "byte" | "char" | "bool" => Kind::Unsigned(1),
        "uint16" => Kind::Unsigned(2),
        "uint32" => Kind::Unsigned(4),
        "uint64" => Kind::Unsigned(8),
        "string" => Kind::Text,
        _ => return None,
    })
}

/// A type by its whole name, or by its own of the same package; `Header` is of `std_msgs`.
fn named(name: &str, owner: &str, names: &[String]) -> Option<Kind> {
    let name = short(name);
    let package = owner.split('/').next().unwrap_or_default();
    let ways = [
        name.clone(),
        format!("{package}/{name}"),
        format!("std_msgs/{name}"),
    ];
    // The message itself holds none of its kind.
    let place = |wanted: &String| names.iter().skip(1).position(|known| known == wanted);
    ways.iter()
        .find_map(place)
        .map(|place| Kind::Type(place + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# a comment\nint32 LIMIT=3\nint32 OTHER = 3\nHeader header   # when\nstring<=9 name\nfloat64[<=3] list\nPoint[2] way\nuint8 x 5\n\
                        ====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n====\nMSG: own/msg/Point\nfloat32 x\n====\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

    #[test]
    fn fields_of_all_types() {
        let found = Definition::parse("own/msg/Thing", TEXT).unwrap();
        assert_eq!(
            found.names,
            [
                "own/Thing",
                "std_msgs/Header",
                "own/Point",
                "builtin_interfaces/Time"
            ]
        );
        let told: Vec<(&str, Kind, Length)> = found.fields[0]
            .iter()
            .map(|field| (field.name.as_str(), field.kind, field.length))
            .collect();
        assert_eq!(
            told,
            [
                ("header", Kind::Type(1), Length::One),
                ("name", Kind::Text, Length::One),
                ("list", Kind::Real(8), Length::Told),
                ("way", Kind::Type(2), Length::Fixed(2)),
                ("x", Kind::Unsigned(1), Length::One),
            ]
        );
    }

    #[test]
    fn what_is_not_defined_is_told() {
        assert_eq!(
            Definition::parse("a/B", "C c\n").unwrap_err(),
            "the type C of a/B, without its definition"
        );
        // A type that holds itself would have no end.
        assert!(Definition::parse("a/B", "B b\n").is_err());
        assert!(
            Definition::parse("a/B", "int32[ x\n").is_err()
                && Definition::parse("a/B", "====\n").is_err()
        );
    }
}
