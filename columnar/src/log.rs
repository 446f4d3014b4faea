//! A file of another program's as a log, of which `convert` makes a recording.

use crate::guard::guarded;
use crate::values::{Content, Meaning, Opened};
use convert::{Log, LogColumn};
use recording::Error;
use std::path::Path;

/// The columns of a file: numbers as they are, points in time as seconds since the first, texts as words. Lists, dates and other
/// values are left out.
///
/// # Errors
/// It is no whole Parquet file, or has no samples.
pub fn log(path: &Path) -> Result<Log, Error> {
    guarded(path, || {
        let file = Opened::open(path)?;
        let mut columns = Vec::new();
        for (place, (name, meaning)) in file.columns().into_iter().enumerate() {
            if meaning == Meaning::Other {
                continue;
            }
            let unit = matches!(meaning, Meaning::Instant(_)).then(|| "s".to_owned());
            let (numbers, words) = match file.content(place)? {
                Content::Numbers(numbers) => (numbers, Vec::new()),
                Content::Texts(texts) => {
                    let word = |(row, text): (usize, &Option<_>)| {
                        let text: &parquet::data_type::ByteArray = text.as_ref()?;
                        Some((row, String::from_utf8_lossy(text.data()).into_owned()))
                    };
                    let words = texts.iter().enumerate().filter_map(word).collect();
                    (vec![f64::NAN; texts.len()], words)
                }
            };
            columns.push(LogColumn {
                name,
                unit,
                numbers,
                words,
                ..LogColumn::default()
            });
        }
        Log::of_columns(columns).with_rows(path)
    })
}
