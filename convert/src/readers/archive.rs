//! NumPy's `.npz`: a ZIP archive with a `.npy` a column.

use super::numpy::Array;
use crate::table::Log;
use miniz_oxide::inflate::decompress_to_vec_with_limit;
use rawzip::{CompressionMethod, ZipArchive};
use recording::Error;
use std::path::Path;

const WANTED: &str = "arrays of one length: numpy.savez(FILE, t=…, sin=…, cos=…)";
/// No array of a log is larger, bytes: a gigabyte is a hundred million samples.
const LARGEST: usize = 1 << 30;

/// True of a ZIP archive.
pub fn is_it(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// The columns of an archive: of arrays of several lengths those of the commonest one.
///
/// # Errors
/// It is cut short, or holds no arrays.
pub fn read(file: &Path, bytes: &[u8]) -> Result<Log, Error> {
    let refuse = |found: String| Error::new(file, found, WANTED);
    let (mut entries, mut notes) = (Vec::new(), Vec::new());
    for (name, data) in contents(bytes).map_err(refuse)? {
        match name.strip_suffix(".npy") {
            Some(name) => entries.push((name.to_owned(), data)),
            None => notes.push(format!("{name} is no array and was left aside")),
        }
    }
    let mut arrays = Vec::new();
    for (name, data) in &entries {
        arrays.push((
            name,
            Array::parse(data).map_err(|found| refuse(format!("{found}, in {name}.npy")))?,
        ));
    }
    let rows: Vec<usize> = arrays
        .iter()
        .filter_map(|(_, array)| array.rows())
        .collect();
    let often = |length: &&usize| (rows.iter().filter(|one| one == length).count(), **length);
    let length = rows
        .iter()
        .max_by_key(often)
        .copied()
        .ok_or_else(|| refuse("an archive without arrays of numbers".into()))?;
    let mut columns = Vec::new();
    for (name, array) in &arrays {
        match array.columns(name) {
            Ok((more, said)) if more.iter().all(|column| column.numbers.len() == length) => {
                columns.extend(more);
                notes.extend(said);
            }
            _ => notes.push(format!(
                "{name} has not {length} rows of numbers and was left aside"
            )),
        }
    }
    let mut log = Log::of_columns(columns);
    log.form = "a NumPy archive";
    log.notes = notes;
    Ok(log)
}

/// Names and bytes of all entries.
fn contents(bytes: &[u8]) -> Result<Vec<(String, Vec<u8>)>, String> {
    let spoilt = |error: rawzip::Error| format!("a ZIP archive that cannot be read ({error})");
    let archive = ZipArchive::from_slice(bytes).map_err(spoilt)?;
    let mut all = Vec::new();
    let mut entries = archive.entries();
    while let Some(entry) = entries.next_entry().map_err(spoilt)? {
        let name = String::from_utf8_lossy(entry.file_path().as_ref()).into_owned();
        let within = archive.get_entry(entry.wayfinder()).map_err(spoilt)?;
        let data = match entry.compression_method() {
            CompressionMethod::STORE => within.data().to_vec(),
            CompressionMethod::DEFLATE => {
                let limit =
                    LARGEST.min(usize::try_from(entry.uncompressed_size_hint()).unwrap_or(LARGEST));
                decompress_to_vec_with_limit(within.data(), limit)
                    .map_err(|_| format!("spoilt bytes in {name}"))?
            }
            _ => {
                return Err(format!(
                    "{name} compressed in a way that NumPy does not use"
                ));
            }
        };
        all.push((name, data));
    }
    Ok(all)
}
