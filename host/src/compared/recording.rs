//! A recording as an estimate: fitted as `courier replay` does.

use super::source::{Compared, Device};
use crate::replay::{Certain, Channel, certain};
use anyhow::Result;
use comparison::estimate::{Certainty, Estimate, Unknown, Wave};
use courier_sensor::equations::OWN_ORDERS;
use courier_sensor::frame::SEGMENTS;
use courier_sensor::model::Term;
use nalgebra::{DMatrix, DVector};
use recording::Recording;

/// Coefficients of a segment.
const PER_SEGMENT: usize = 2 * OWN_ORDERS.len();

/// Of a recording that is called `name`.
///
/// # Errors
/// It cannot be replayed.
pub fn estimate(name: &str, recording: &Recording) -> Result<Compared> {
    let (geometry, fits) = certain(recording)?;
    let unknowns: Vec<Unknown> = fits.iter().flat_map(unknowns).collect();
    let values: Vec<f64> = fits
        .iter()
        .flat_map(|fit| fit.coefficients_m[1..].iter().copied())
        .collect();
    let meta = &recording.meta;
    let estimate = Estimate {
        name: name.into(),
        about: format!("recording of {}", meta.device),
        made_s: None,
        geometry,
        certainty: Ok(Certainty {
            covariance: covariance(&fits),
            freedom: fits
                .iter()
                .map(|fit| fit.freedom)
                .fold(f64::INFINITY, f64::min),
            own: 0.0,
            lateral: None,
            source: source(&fits),
        }),
        unknowns,
        values: DVector::from_vec(values),
        parity: parity(&fits),
        amplitude_counts: [meta.electronics.amplitude_counts.unwrap_or(0.0); SEGMENTS],
        looked_for_all: false,
        left_out: vec![
            "offsets: they go with where the tooth counts, or the reference, began (gauge)"
                .to_owned(),
        ],
    };
    Ok(Compared {
        estimate,
        device: device(&meta.device),
        stated: [meta.geometry.span_m, meta.geometry.lateral_m],
    })
}

/// `courier record` names the board by its number (`recorder.rs`); another recording has free text, or none.
fn device(text: &str) -> Option<Device> {
    match text.rsplit_once(" board ") {
        Some((_, number)) if !number.contains(' ') => Some(Device::Board(number.to_owned())),
        _ => (!text.is_empty()).then(|| Device::Recording(text.to_owned())),
    }
}

/// Segments that enter a channel.
fn segments(channel: Channel) -> Vec<usize> {
    let signs = channel.signs();
    (0..SEGMENTS)
        .filter(|segment| signs[*segment] != 0.0)
        .collect()
}

fn unknowns(fit: &Certain) -> Vec<Unknown> {
    let one = |segment: usize| {
        OWN_ORDERS.into_iter().flat_map(move |order| {
            [false, true].map(|cosine| {
                Unknown::of_wave(Wave {
                    segment,
                    term: Term::own(order),
                    cosine,
                    share: 1.0,
                })
            })
        })
    };
    segments(fit.channel).into_iter().flat_map(one).collect()
}

/// Of all channels, which share no sample's noise but a segment's own; offsets left out.
fn covariance(fits: &[Certain]) -> DMatrix<f64> {
    let sizes: Vec<usize> = fits
        .iter()
        .map(|fit| fit.covariance_m2.nrows() - 1)
        .collect();
    let all = sizes.iter().sum();
    let (mut out, mut first) = (DMatrix::zeros(all, all), 0);
    for (fit, size) in fits.iter().zip(sizes) {
        out.view_mut((first, first), (size, size))
            .copy_from(&fit.covariance_m2.view((1, 1), (size, size)));
        first += size;
    }
    out
}

/// The standard deviation that g_p would have by what is left, and its degrees of freedom: of a single segment twice its own.
fn parity(fits: &[Certain]) -> Option<(f64, f64)> {
    let of = |fit: &Certain| match fit.channel {
        Channel::Parity => fit.held_out_rms_m,
        Channel::Segment(_) => 2.0 * fit.held_out_rms_m,
    };
    let largest = fits.iter().max_by(|a, b| of(a).total_cmp(&of(b)))?;
    Some((of(largest), largest.freedom))
}

fn source(fits: &[Certain]) -> String {
    let list = fits.iter().map(|fit| {
        format!(
            "{}: {:.3} µm left, {} coefficients; neighbouring samples agree so that variances are {:.1} times those of independent ones",
            fit.channel.name(),
            1.0e6 * fit.held_out_rms_m,
            PER_SEGMENT * segments(fit.channel).len(),
            fit.factor
        )
    });
    format!(
        "by equation (3) as `replay` fits it; {}",
        list.collect::<Vec<_>>().join("; ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_of_a_board_is_that_board_s() {
        let board = |number: &str| Some(Device::Board(number.into()));
        assert_eq!(
            device("simulated board paper-000001"),
            board("paper-000001")
        );
        assert_eq!(
            device("g474 board 00112233445566778899aabb"),
            board("00112233445566778899aabb")
        );
        assert_eq!(
            device("sensor board of the left arm"),
            Some(Device::Recording("sensor board of the left arm".into()))
        );
        assert_eq!(device(""), None);
    }
}
