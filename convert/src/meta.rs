//! recording.toml of a converted log: what was stated, else what was measured, and what was assumed is told.

use crate::order::Order;
use crate::segments::Segment;
use crate::told::{Told, figures};
use recording::noise::{ROUNDING_VARIANCE, in_motion::scatter};
use recording::{Coordination, Electronics, Error, Geometry, Meta, Names};
use std::path::Path;

/// Electrodes x+, x-, y+, y- of every sample, where they were logged.
pub type Electrodes<'a> = Option<[&'a [f64]; 4]>;

/// Makes it.
///
/// # Errors
/// Something is needed that is neither stated nor measured.
pub fn meta(
    file: &Path,
    order: &Order,
    pitch_m: f64,
    (segments, bits): (&[Segment], Option<u32>),
    (electrodes, follows): (Electrodes, &[bool]),
    told: &mut Told,
) -> Result<Meta, Error> {
    let stated = &order.stated;
    let name = file
        .file_name()
        .map_or_else(|| "log".into(), |name| name.to_string_lossy().into_owned());
    let device = stated.device.clone().unwrap_or_else(|| {
        file.file_stem()
            .map_or_else(|| "log".into(), |stem| stem.to_string_lossy().into_owned())
    });
    let counted = segments.iter().any(|segment| segment.counts.is_some());
    let positioned = segments.iter().any(|segment| segment.position_m.is_some());
    let mut electronics = Electronics {
        adc_bits: bits,
        ..Electronics::default()
    };
    if counted {
        electronics.amplitude_counts = Some(amplitude(order, segments, told));
        electronics.quadrature_noise_counts = Some(counts_noise(file, order, segments, told)?);
    }
    if positioned {
        electronics.position_noise_m = Some(position_noise(file, order, segments, told)?);
    }
    let coordination = match electrodes {
        Some(electrodes) => {
            electronics.psd_sum_counts = Some(electrode_sum(order, electrodes, told));
            electronics.psd_noise_counts =
                Some(electrode_noise(file, order, electrodes, follows, told)?);
            Some(coordination(file, order)?)
        }
        None => None,
    };
    Ok(Meta {
        device,
        source: stated
            .source
            .clone()
            .unwrap_or_else(|| format!("courier convert {name}")),
        geometry: geometry(file, order, pitch_m, segments)?,
        names: Names {
            courier_id: stated.courier_id.clone().unwrap_or_default(),
            platen_id: stated.platen_id.clone().unwrap_or_default(),
            ..Names::default()
        },
        coordination,
        electronics,
    })
}

fn geometry(
    file: &Path,
    order: &Order,
    pitch_m: f64,
    segments: &[Segment],
) -> Result<Geometry, Error> {
    let has = |number: usize| segments.iter().any(|segment| segment.number == number);
    let stated = &order.stated;
    let missing = |what: &str, wanted: &str| Error::new(file, format!("no {what}"), wanted);
    if stated.span_m.is_none() && ((has(0) && has(2)) || (has(1) && has(3))) {
        return Err(missing(
            "distance between the segments of a pair",
            "--span LENGTH, as in --span 9.7mm",
        ));
    }
    if stated.lateral_m.is_none() && (0..4).all(has) {
        return Err(missing(
            "lateral offset of the segments",
            "--lateral LENGTH, as in --lateral 3mm",
        ));
    }
    Ok(Geometry {
        pitch_m,
        span_m: stated.span_m,
        lateral_m: stated.lateral_m,
    })
}

fn amplitude(order: &Order, segments: &[Segment], told: &mut Told) -> f64 {
    if let Some(amplitude) = order.stated.amplitude_counts {
        return amplitude;
    }
    let counted = || segments.iter().filter(|segment| segment.counts.is_some());
    let amplitude = (counted()
        .map(|segment| segment.amplitude_counts)
        .sum::<f64>()
        / counted().count().max(1) as f64)
        .round()
        .max(1.0);
    told.assume(
        format!(
            "amplitude {} counts, the median distance from the centre",
            figures(amplitude)
        ),
        "--amplitude-counts N",
    );
    amplitude
}

/// Where no noise can be measured, it must be stated.
fn unmeasured(file: &Path, option: &str) -> Error {
    Error::new(
        file,
        "too few rows in even steps of time to measure noise from",
        format!("{option}, the noise of one reading"),
    )
}

/// Noise of some segments, rms, and whether motion is among it; none where one tells none.
fn pooled<'a>(segments: impl Iterator<Item = &'a Segment>) -> Option<(f64, bool)> {
    let measured: Option<Vec<_>> = segments.map(|segment| segment.noise).collect();
    let measured = measured?;
    let squares: f64 = measured.iter().map(|noise| noise.rms * noise.rms).sum();
    let rms = (squares / measured.len().max(1) as f64).sqrt();
    Some((rms, measured.iter().any(|noise| noise.holds_motion)))
}

fn counts_noise(
    file: &Path,
    order: &Order,
    segments: &[Segment],
    told: &mut Told,
) -> Result<f64, Error> {
    let option = "--noise-counts N";
    if let Some(noise) = order.stated.noise_counts {
        return Ok(noise);
    }
    let counted = segments.iter().filter(|segment| segment.counts.is_some());
    let (rms, holds_motion) = pooled(counted).ok_or_else(|| unmeasured(file, option))?;
    let noise = hundredths(rms);
    tell(
        told,
        &format!("noise {} counts rms a channel", figures(noise)),
        holds_motion,
        option,
    );
    Ok(noise)
}

fn position_noise(
    file: &Path,
    order: &Order,
    segments: &[Segment],
    told: &mut Told,
) -> Result<f64, Error> {
    let option = "--position-noise LENGTH";
    if let Some(noise_m) = order.stated.position_noise_m {
        return Ok(noise_m);
    }
    let positioned = segments
        .iter()
        .filter(|segment| segment.position_m.is_some() && segment.counts.is_none());
    let (rms_m, holds_motion) = pooled(positioned).ok_or_else(|| unmeasured(file, option))?;
    /// Nothing is without noise: the smallest that a position in double precision may be told with, a tenth of a picometre.
    const LEAST_M: f64 = 1.0e-13;
    let noise_m = four_figures(rms_m.max(LEAST_M));
    tell(
        told,
        &format!("noise {} µm rms a position", figures(1.0e6 * noise_m)),
        holds_motion,
        option,
    );
    Ok(noise_m)
}

fn tell(told: &mut Told, what: &str, holds_motion: bool, option: &str) {
    let how = "measured from sample to sample (third differences of the slowest quarter)";
    told.assume(format!("{what}, {how}"), option);
    if holds_motion {
        told.warn(
            format!("{what} may be motion: between samples it is too quick to be told apart"),
            format!("{option}, or log a second of rest"),
        );
    }
}

fn electrode_sum(order: &Order, [xp, xn, yp, yn]: [&[f64]; 4], told: &mut Told) -> f64 {
    if let Some(sum) = order.stated.psd_sum_counts {
        return sum;
    }
    let mut sums: Vec<f64> = (0..xp.len())
        .flat_map(|i| [xp[i] + xn[i], yp[i] + yn[i]])
        .filter(|sum| *sum > 0.0)
        .collect();
    sums.sort_by(f64::total_cmp);
    let sum = sums
        .get(sums.len() / 2)
        .copied()
        .unwrap_or(1.0)
        .round()
        .max(1.0);
    told.assume(
        format!(
            "two electrodes together {} counts, their median",
            figures(sum)
        ),
        "--psd-sum-counts N",
    );
    sum
}

fn electrode_noise(
    file: &Path,
    order: &Order,
    electrodes: [&[f64]; 4],
    follows: &[bool],
    told: &mut Told,
) -> Result<f64, Error> {
    let option = "--psd-noise-counts N";
    if let Some(noise) = order.stated.psd_noise_counts {
        return Ok(noise);
    }
    // Where there is no beacon all are zero, which tells no noise.
    let dark = |i: usize| electrodes.iter().all(|electrode| electrode[i] == 0.0);
    let seen = electrodes.map(|electrode| -> Vec<f64> {
        (0..electrode.len())
            .map(|i| if dark(i) { f64::NAN } else { electrode[i] })
            .collect()
    });
    let channels: Vec<&[f64]> = seen.iter().map(Vec::as_slice).collect();
    let noise = scatter(&channels, &seen[0], follows).ok_or_else(|| unmeasured(file, option))?;
    let noise_counts = hundredths((noise.rms.powi(2) - ROUNDING_VARIANCE).max(0.0).sqrt());
    tell(
        told,
        &format!("noise {} counts rms an electrode", figures(noise_counts)),
        noise.holds_motion,
        option,
    );
    Ok(noise_counts)
}

fn coordination(file: &Path, order: &Order) -> Result<Coordination, Error> {
    let stated = &order.stated;
    let need = |value: Option<f64>, wanted: &str| {
        value.ok_or_else(|| Error::new(file, "electrodes without their geometry", wanted))
    };
    Ok(Coordination {
        height_m: need(
            stated.height_m,
            "--height LENGTH, the beacon's over the diode",
        )?,
        lever_x_m: need(
            stated.lever_m[0],
            "--lever-x LENGTH, from the sensor's centre to the diode",
        )?,
        lever_y_m: need(
            stated.lever_m[1],
            "--lever-y LENGTH, from the sensor's centre to the diode",
        )?,
        tan_full_scale: need(
            stated.tan_full_scale,
            "--tan-full-scale N, tan(psi) at a normalised deflection of 1",
        )?,
    })
}

fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn four_figures(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::noise::in_motion::Scatter;

    #[test]
    fn the_noise_of_segments_is_their_root_mean_square_and_one_that_moves_is_told() {
        let segment = |rms: f64, holds_motion: bool| Segment {
            noise: Some(Scatter {
                rms,
                differences: 100,
                holds_motion,
            }),
            ..Segment::default()
        };
        let two = [segment(3.0, false), segment(4.0, false)];
        assert_eq!(pooled(two.iter()), Some((12.5_f64.sqrt(), false)));
        let one_moves = [segment(3.0, false), segment(3.0, true)];
        assert_eq!(pooled(one_moves.iter()), Some((3.0, true)));
        let one_unknown = [segment(3.0, false), Segment::default()];
        assert_eq!(pooled(one_unknown.iter()), None);
    }
}
