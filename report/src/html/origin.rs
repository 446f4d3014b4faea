//! Where a report came from: what the library cannot know by itself, as values from whoever calls it.

use super::svg::short;
use maud::{Markup, html};
use recording::Meta;

/// Where a report came from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    /// When it was made, as text.
    pub made: String,
    /// The program that made it, with its version.
    pub program: String,
    /// The command line.
    pub command: String,
    /// What was read, and the SHA-256 of its bytes in hexadecimal.
    pub hashes: Vec<(String, String)>,
    /// Where the model was written to, if it was.
    pub model: Option<String>,
    /// Device and source that the recording names, and the noise that it states.
    pub stated: Vec<(String, String)>,
}

/// What a recording says about itself: device, source, and its stated noise with units. The floor is what that noise gives.
#[must_use]
pub fn stated(meta: &Meta) -> Vec<(String, String)> {
    let electronics = &meta.electronics;
    let counts =
        |value: Option<f64>| value.map(|v| format!("{} counts rms in each channel", short(v)));
    let list = [
        ("device", Some(meta.device.clone())),
        ("source", Some(meta.source.clone())),
        (
            "tooth pitch",
            Some(format!("{} mm", 1.0e3 * meta.geometry.pitch_m)),
        ),
        (
            "stated noise of sine and cosine",
            counts(electronics.quadrature_noise_counts),
        ),
        (
            "stated amplitude of sine and cosine",
            electronics
                .amplitude_counts
                .map(|v| format!("{} counts", short(v))),
        ),
        (
            "stated noise of the electrodes",
            counts(electronics.psd_noise_counts),
        ),
        (
            "stated noise of positions",
            electronics
                .position_noise_m
                .map(|v| format!("{} µm rms", short(1.0e6 * v))),
        ),
    ];
    let known = list
        .into_iter()
        .filter_map(|(name, value)| Some((name.to_owned(), value?)));
    known.filter(|(_, value)| !value.is_empty()).collect()
}

/// The part of the page that tells it; nothing where nothing is known.
pub fn section(origin: &Origin) -> Markup {
    let one =
        |name: &str, value: &String| (!value.is_empty()).then(|| (name.to_owned(), value.clone()));
    let mut rows: Vec<(String, String)> = [
        one("made", &origin.made),
        one("by", &origin.program),
        one("command", &origin.command),
    ]
    .into_iter()
    .flatten()
    .collect();
    rows.extend(
        origin
            .hashes
            .iter()
            .map(|(name, hash)| (format!("SHA-256 of {name}"), hash.clone())),
    );
    rows.extend(origin.stated.iter().cloned());
    if rows.is_empty() {
        return html! {};
    }
    html! {
        section aria-labelledby="origin" {
            h2 id="origin" { "Where this came from" }
            dl.pairs { @for (name, value) in &rows { div { dt { (name) } dd { code { (value) } } } } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_states_only_what_it_has() {
        let mut meta = Meta::default();
        meta.geometry.pitch_m = 1.016e-3;
        meta.electronics.position_noise_m = Some(0.1e-6);
        let told = stated(&meta);
        let names: Vec<&str> = told.iter().map(|t| t.0.as_str()).collect();
        assert_eq!(names, ["tooth pitch", "stated noise of positions"]);
        assert_eq!(told[1].1, "0.1 µm rms");
        assert!(section(&Origin::default()).into_string().is_empty());
    }
}
