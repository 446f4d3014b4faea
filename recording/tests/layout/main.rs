//! The layout to the letter: what is read, what is refused and in which words, what is written.

mod reading;
mod refusal;
mod writing;

use recording::Recording;
use tempfile::TempDir;

const META: &str = "schema = 1\n[geometry]\npitch_m = 1.0e-3\nspan_m = 9.7e-3\nlateral_m = 3e-3\n\
    [electronics]\nadc_bits = 16\namplitude_counts = 20000\nquadrature_noise_counts = 3\nposition_noise_m = 1e-8\n";

fn folder(meta: &[u8], samples: &[u8]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("recording.toml"), meta).unwrap();
    std::fs::write(folder.path().join("samples.csv"), samples).unwrap();
    folder
}

fn read(meta: &str, samples: &[u8]) -> Result<Recording, String> {
    let folder = folder(meta.as_bytes(), samples);
    Recording::read(folder.path()).map_err(|error| {
        let line = error.to_string();
        assert!(
            !line.contains('\n') && line.len() < 400,
            "one short line: {line}"
        );
        line.replace(&format!("{}/", folder.path().display()), "")
    })
}

fn refused(meta: &str, samples: &[u8], line: &str) {
    assert_eq!(read(meta, samples).unwrap_err(), line);
}
