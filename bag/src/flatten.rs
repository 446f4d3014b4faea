//! Messages as columns: `position[0]`, `pose.position.x`, and `position[elbow]` where the message names its values.

use crate::cdr::Unpacker;
use crate::definition::{Definition, Field, Kind, Length};
use std::collections::HashMap;

/// Values of one message, by the names of their columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flattened {
    /// Numbers in order.
    pub numbers: Vec<(String, f64)>,
    /// Texts in order.
    pub words: Vec<(String, String)>,
    /// Nanoseconds of the stamp in its header.
    pub stamp_ns: Option<i64>,
    /// Fields with more values than are columns.
    pub long: Vec<String>,
}

/// A list of more values than these is an image or a scan, and no columns.
const MOST_VALUES: usize = 64;
/// Types within types: none in use goes deeper than ten.
const DEEPEST: usize = 32;
/// Values of one message: more are no columns, and keep a spoilt length from filling the memory.
const MOST_IN_ALL: usize = 1 << 20;
/// A point in time.
const TIME: &str = "builtin_interfaces/Time";

/// The values of a message; none where its bytes end too early.
#[must_use]
pub fn flatten(definition: &Definition, bytes: &[u8]) -> Option<Flattened> {
    let mut walk = Walk {
        definition,
        from: Unpacker::new(bytes)?,
        into: Flattened::default(),
        left: MOST_IN_ALL,
    };
    walk.fields(0, "", 0)?;
    Some(walk.into)
}

struct Walk<'a> {
    definition: &'a Definition,
    from: Unpacker<'a>,
    into: Flattened,
    left: usize,
}

impl Walk<'_> {
    fn fields(&mut self, place: usize, prefix: &str, depth: usize) -> Option<()> {
        let definition = self.definition;
        let fields = &definition.fields[place];
        if depth > DEEPEST {
            return None;
        }
        if fields.is_empty() {
            // DDS has no empty types: ROS 2 puts a byte there.
            return self.from.word(1).map(drop);
        }
        if definition.names[place] == TIME {
            return self.time(prefix);
        }
        // Of JointState and its like: the names of the values that follow.
        let mut names: HashMap<usize, Vec<String>> = HashMap::new();
        for field in fields {
            let name = if prefix.is_empty() {
                field.name.clone()
            } else {
                format!("{prefix}.{}", field.name)
            };
            let count = match field.length {
                Length::One => {
                    self.value(field.kind, &name, depth, true)?;
                    continue;
                }
                Length::Fixed(count) => count,
                Length::Told => self.from.word(4)? as usize,
            };
            if field.kind == Kind::Text && field.name == "name" {
                let list = (0..count.min(self.from.left()))
                    .map(|_| self.from.string())
                    .collect::<Option<Vec<_>>>()?;
                names.insert(list.len(), list);
                continue;
            }
            self.list(field, &name, count, names.get(&count), depth)?;
        }
        Some(())
    }

    fn list(
        &mut self,
        field: &Field,
        name: &str,
        count: usize,
        names: Option<&Vec<String>>,
        depth: usize,
    ) -> Option<()> {
        // Each value has a byte at least.
        if count > self.from.left() {
            return None;
        }
        let told = count <= MOST_VALUES;
        if !told && !self.into.long.iter().any(|known| known == name) {
            self.into.long.push(name.to_owned());
        }
        for index in 0..count {
            let index = names.map_or_else(|| index.to_string(), |names| names[index].clone());
            let name = if told {
                format!("{name}[{index}]")
            } else {
                String::new()
            };
            self.value(field.kind, &name, depth, told)?;
        }
        Some(())
    }

    fn value(&mut self, kind: Kind, name: &str, depth: usize, told: bool) -> Option<()> {
        self.left = self.left.checked_sub(1)?;
        let number = match kind {
            Kind::Type(place) => {
                let kept = if told {
                    None
                } else {
                    Some((self.into.numbers.len(), self.into.words.len()))
                };
                self.fields(place, name, depth + 1)?;
                if let Some((numbers, words)) = kept {
                    self.into.numbers.truncate(numbers);
                    self.into.words.truncate(words);
                }
                return Some(());
            }
            Kind::Text => {
                let text = self.from.string()?;
                if told {
                    self.into.words.push((name.to_owned(), text));
                }
                return Some(());
            }
            Kind::Real(4) => f64::from(f32::from_bits(self.from.word(4)? as u32)),
            Kind::Real(size) => f64::from_bits(self.from.word(size)?),
            Kind::Unsigned(size) => self.from.word(size)? as f64,
            Kind::Signed(size) => {
                let unused = 64 - 8 * size as u32;
                ((self.from.word(size)? << unused) as i64 >> unused) as f64
            }
        };
        if told {
            self.into.numbers.push((name.to_owned(), number));
        }
        Some(())
    }

    /// Seconds, and nanoseconds of them.
    fn time(&mut self, name: &str) -> Option<()> {
        let seconds = self.from.word(4)? as u32 as i32;
        let nanoseconds = self.from.word(4)? as u32;
        if name == "header.stamp" {
            self.into.stamp_ns = Some(i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds));
        }
        self.into.numbers.push((
            name.to_owned(),
            f64::from(seconds) + 1e-9 * f64::from(nanoseconds),
        ));
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cdr::Packer;

    const JOINTS: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n====\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

    #[test]
    fn values_are_named_by_the_message_where_it_does() {
        let mut packer = Packer::default();
        packer.int32(-1);
        packer.uint32(5);
        packer.string("base");
        packer.uint32(2);
        packer.string("wrist");
        packer.string("elbow");
        packer.uint32(2);
        packer.float64(1.0);
        packer.float64(2.0);
        packer.uint32(0);
        let definition = Definition::parse("sensor_msgs/msg/JointState", JOINTS).unwrap();
        let found = flatten(&definition, packer.bytes()).unwrap();
        let told: Vec<(&str, f64)> = found
            .numbers
            .iter()
            .map(|(name, number)| (name.as_str(), *number))
            .collect();
        assert_eq!(
            told,
            [
                ("header.stamp", -1.0 + 5e-9),
                ("position[wrist]", 1.0),
                ("position[elbow]", 2.0)
            ]
        );
        assert_eq!(found.stamp_ns, Some(-999_999_995));
        assert_eq!(
            found.words,
            [("header.frame_id".to_owned(), "base".to_owned())]
        );
        for cut in 0..packer.bytes().len() {
            assert_eq!(flatten(&definition, &packer.bytes()[..cut]), None, "{cut}");
        }
    }

    #[test]
    fn lists_that_are_no_columns_are_passed_over() {
        let definition = Definition::parse(
            "a/B",
            "uint8[] data\nint16 x\nEmpty[2] e\n====\nMSG: a/Empty\n",
        )
        .unwrap();
        let mut packer = Packer::default();
        packer.uint32(100);
        let mut bytes = packer.bytes().to_vec();
        bytes.extend([7; 100]);
        bytes.extend([0xfe, 0xff, 0, 0]);
        let found = flatten(&definition, &bytes).unwrap();
        assert_eq!(
            (found.numbers, found.long),
            (vec![("x".to_owned(), -2.0)], vec!["data".to_owned()])
        );
        // A length that the bytes cannot hold.
        assert_eq!(
            flatten(&definition, &[0, 1, 0, 0, 255, 255, 255, 255]),
            None
        );
    }
}
