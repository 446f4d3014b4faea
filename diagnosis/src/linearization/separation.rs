//! How far two recordings of one motion lie apart, beyond what a calibration can take.

use crate::Insufficient;
use crate::data::observations::Observations;
use crate::data::tooth_counts::align_pairs;
use crate::linearization::calibrate::calibrate;
use crate::linearization::recording::{LinearizedRecording, ROWS};
use effects::sensor::CHANNELS;
use recording::Recording;

/// The difference between two recordings in one residual channel at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    sample: usize,
    channel: usize,
    /// Over the stated noise.
    white: f64,
}

/// What one residual channel shows of the difference between two recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Separation {
    /// Sum of the squared differences of the residuals, over the variance of the stated noise; a little below 0 by chance where they do not
    /// differ.
    pub squares: f64,
    /// Rows that were compared.
    pub rows: usize,
}

/// How far two recordings of the same motion lie apart in each residual channel. Each is calibrated by itself: what equations (3), (10) and
/// (11) can take of the difference is no part of it. The two are given twice, with other draws of noise, those of one time the same for both:
/// the product of both differences holds no rounding, which one difference alone would show as a difference of a count here and there.
/// Cost: four calibrations.
///
/// # Errors
/// [`Insufficient`] where one of them gives no residual.
pub fn separation(
    first: [&Recording; 2],
    again: [&Recording; 2],
) -> Result<[Separation; CHANNELS], Insufficient> {
    let (first, again) = (difference(first)?, difference(again)?);
    let mut out = [Separation::default(); CHANNELS];
    let mut again = again.iter().peekable();
    for row in first {
        let place = (row.sample, row.channel);
        while again.next_if(|a| (a.sample, a.channel) < place).is_some() {}
        if let Some(second) = again.next_if(|a| (a.sample, a.channel) == place) {
            let channel = &mut out[row.channel];
            channel.squares += row.white * second.white;
            channel.rows += 1;
        }
    }
    Ok(out)
}

/// The difference between the residuals of two recordings, in the order of samples and channels.
fn difference([one, other]: [&Recording; 2]) -> Result<Vec<Row>, Insufficient> {
    let [one, other] = [aligned(one)?, aligned(other)?];
    let [one, other] = [linearized(&one), linearized(&other)];
    let mut out = Vec::new();
    for sample in 0..one.len().min(other.len()) {
        let (rows, others) = (one.rows(sample), other.rows(sample));
        if rows.channel[..rows.count] != others.channel[..others.count] {
            continue;
        }
        let mut apart_m = [0.0; ROWS];
        for (row, apart_m) in apart_m.iter_mut().enumerate().take(rows.count) {
            *apart_m = rows.residual_m[row] - others.residual_m[row];
        }
        let white = others.whitened(&apart_m);
        let finite = (0..rows.count).filter(|row| white[*row].is_finite());
        out.extend(finite.map(|row| Row {
            sample,
            channel: rows.channel[row],
            white: white[row],
        }));
    }
    Ok(out)
}

/// The readings of a recording, with each pair's tooth counts on one zero.
fn aligned(recording: &Recording) -> Result<Observations, Insufficient> {
    let mut observations = Observations::new(recording)?;
    align_pairs(&mut observations);
    Ok(observations)
}

/// Calibrated on all samples.
fn linearized(observations: &Observations) -> LinearizedRecording<'_> {
    let all = vec![true; observations.len()];
    let baseline = calibrate(observations, &all);
    LinearizedRecording::new(observations, baseline, all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};
    use recording::Samples;
    use specimens::{Case, Conditions, Kind};

    /// A courier without an effect, by a short recording.
    fn recorded() -> Recording {
        let case = Case {
            number: 0,
            seed: 52,
            kind: Kind::None,
            effects: Vec::new(),
            conditions: Conditions::Drawn,
        };
        case.recorded(0)
    }

    /// The same with something done to the counts of segment 1's cosine, which no count of teeth rests on.
    fn changed(of: &Recording, mut by: impl FnMut(f64, f64) -> f64) -> Recording {
        let mut samples = Samples::default();
        for i in 0..of.samples.len() {
            let mut row = of.samples.row(i);
            if let Some([sine, cosine]) = row.quadrature_counts[0] {
                row.quadrature_counts[0] = Some([sine, by(sine, cosine)]);
            }
            samples.push(&row);
        }
        Recording {
            samples,
            ..of.clone()
        }
    }

    /// An offset of the cosine is an error of order 1 of equation (3), which a calibration takes; a product of sine and cosine is one of order 3
    /// as well, which it does not.
    #[test]
    fn what_a_calibration_takes_is_no_part_of_it() {
        let recording = recorded();
        let offset = changed(&recording, |_, cosine| cosine + 200.0);
        let product = changed(&recording, |sine, cosine| {
            sine + 200.0 * sine * cosine / 4.0e8
        });
        let squares = |other: &Recording| {
            let each = separation([other, &recording], [other, &recording]).unwrap();
            each.iter().map(|channel| channel.squares).sum::<f64>()
        };
        let (taken, stays) = (squares(&offset), squares(&product));
        assert_eq!(squares(&recording), 0.0);
        assert!(stays > 1.0e3 && taken < 0.01 * stays, "{taken} {stays}");
    }
    /// Counts that are one too high or too low by chance are a difference, of which two draws of that chance have nothing in common.
    #[test]
    fn what_two_draws_do_not_share_is_no_separation() {
        let recording = recorded();
        let drawn = |seed: u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            changed(&recording, |_, cosine| cosine + normal(&mut rng).signum())
        };
        let [first, again] = [1, 2].map(drawn);
        let squares = |again: &Recording| {
            let each = separation([&first, &recording], [again, &recording]).unwrap();
            each.iter().map(|channel| channel.squares).sum::<f64>()
        };
        let (same, shared) = (squares(&first), squares(&again));
        assert!(shared.abs() < 0.1 * same, "{shared} {same}");
    }
}
