//! Reading a recording.

use crate::definition::{Definition, Kind};
use crate::flatten::flatten;
use crate::open::{open, walk};
use crate::{META_NAME, SAMPLES};
use recording::{Error, Recording, Table};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Bytes of a file that are looked at for the attachment: the writer puts it first, and it is some kilobytes long.
const LOOKED_AT: u64 = 1 << 20;

/// True of a file that holds a recording, by what it says of itself in its first bytes.
#[must_use]
pub fn is_recording(path: &Path) -> bool {
    let mut found = false;
    let mut look = |name: &str, _: &[u8]| {
        found |= name == META_NAME;
        Ok(())
    };
    let read = open(path)
        .is_ok_and(|file| walk(path, file.take(LOOKED_AT), &mut look, |_| Ok(())).is_ok());
    read && found
}

/// Reads and checks the recording in a file; the first sample is row 1.
///
/// # Errors
/// One [`Error`] for the first thing that is wrong, naming file, row and column.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let mut meta = None;
    let mut rows = Rows::default();
    let mut said = |name: &str, data: &[u8]| {
        if name == META_NAME {
            meta = Some(String::from_utf8_lossy(data).into_owned());
        }
        Ok(())
    };
    let whole = walk(path, open(path)?, &mut said, |message| {
        match message.channel.topic == SAMPLES {
            true => rows.push(path, &message.channel, message.data),
            false => Ok(()),
        }
    })?;
    let meta = meta.ok_or_else(|| {
        let wanted = "a recording; `courier convert` makes one of a log: `courier convert FILE` lists the columns";
        Error::new(path, format!("no attachment {META_NAME}"), wanted)
    })?;
    if !whole {
        return Err(Error::new(
            path,
            "a recording whose end is missing",
            "a whole file: the copy was cut, or the disk was full",
        ));
    }
    Recording::of_table(path, Table { meta, ..rows.table })
}

#[derive(Default)]
struct Rows {
    definition: Option<(u16, Definition, Vec<Option<usize>>)>,
    table: Table,
    count: u64,
}

impl Rows {
    fn push(
        &mut self,
        path: &Path,
        channel: &Arc<mcap::Channel>,
        data: &[u8],
    ) -> Result<(), Error> {
        self.count += 1;
        let row = self.count;
        let refuse = |found: String| {
            Error::new(
                path,
                found,
                format!("messages of {SAMPLES} as courier writes them"),
            )
            .row(row)
        };
        let (id, definition, places) = match &self.definition {
            Some(known) => known,
            None => {
                let schema = channel
                    .schema
                    .as_deref()
                    .ok_or_else(|| refuse("messages without a definition".into()))?;
                let definition =
                    Definition::parse(&schema.name, &String::from_utf8_lossy(&schema.data))
                        .map_err(refuse)?;
                let places = self.columns(&definition);
                self.definition.insert((channel.id, definition, places))
            }
        };
        if *id != channel.id {
            return Err(refuse(format!("a second {SAMPLES}")));
        }
        let values = flatten(definition, data)
            .ok_or_else(|| refuse("a message that does not fit its definition".into()))?;
        for ((_, number), place) in values.numbers.iter().zip(places) {
            if let Some(place) = place {
                self.table.columns[*place].1.push(*number);
            }
        }
        if let Some((_, name)) = values.words.first() {
            match self.table.runs.last_mut() {
                Some((last, count)) if last == name => *count += 1,
                _ => self.table.runs.push((name.clone(), 1)),
            }
        }
        Ok(())
    }

    /// Columns of the table for the numbers of a message; none for those that follow from others.
    fn columns(&mut self, definition: &Definition) -> Vec<Option<usize>> {
        let mut places = Vec::new();
        for field in definition.fields[0]
            .iter()
            .filter(|field| field.kind != Kind::Text)
        {
            let derived = (1..=4).any(|segment| field.name == format!("output{segment}_m"));
            places.push(match (derived, Table::takes(&field.name)) {
                (true, _) => None,
                (false, true) => {
                    self.table.columns.push((field.name.clone(), Vec::new()));
                    Some(self.table.columns.len() - 1)
                }
                (false, false) => {
                    self.table.left_aside.push(field.name.clone());
                    None
                }
            });
        }
        places
    }
}
