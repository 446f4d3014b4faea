//! What looks wrong about a replay's figures, told by the figures alone.

use command_line::terminal::micrometres;
use serde::Serialize;

/// What scatters by more than this share of a pitch is neither noise nor an error of the sensor: the readings belong to another
/// segment, sign or tooth. The paper's parity without calibration, of four segments, is 0.03 of it (29.3 µm, 3.1.2). The
/// diagnosis judges by the same share.
const TOOTH: f64 = 0.05;
/// Calibration takes nothing away if what remains is this share of what was there: a fit of nine unknowns on a thousand samples
/// of noise leaves half a percent more on others. Derived from chi-square: 9 over 1000, half of that in rms.
const NOTHING: f64 = 0.995;
/// Two instruments never agree to this share of the pitch. A prior: the best interpolation of a period shows noise of a hundred
/// thousandth, ten times that.
const THE_SAME: f64 = 1.0e-6;

/// A remark on a channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remark {
    /// The channel.
    pub channel: String,
    /// Whether what remains is of the size of the pitch: then it is not the sensor's error.
    pub of_the_pitch: bool,
    /// What looks wrong, and what is likely to be behind it.
    pub text: String,
}

/// Remarks on channels: name, and held-out residual before and after calibration, m rms.
pub fn remarks(
    channels: impl IntoIterator<Item = (String, [f64; 2])>,
    pitch_m: f64,
) -> Vec<Remark> {
    channels
        .into_iter()
        .filter_map(|(channel, rms_m)| remark(channel, rms_m, pitch_m))
        .collect()
}

fn remark(channel: String, [raw_m, calibrated_m]: [f64; 2], pitch_m: f64) -> Option<Remark> {
    let of_the_pitch = !(calibrated_m < TOOTH * pitch_m);
    let told = if of_the_pitch {
        format!(
            "{} µm remains, {:.0} % of the pitch of {} µm, wanted far less than {:.0} %: this is no error of a sensor. Likely causes: \
             segments, sine and cosine, x and y, or a sign exchanged in the wiring or the columns; another pitch or unit; tooth counts \
             that were lost",
            micrometres(calibrated_m),
            100.0 * calibrated_m / pitch_m,
            micrometres(pitch_m),
            100.0 * TOOTH
        )
    } else if raw_m < THE_SAME * pitch_m {
        format!(
            "{} µm before any calibration, wanted more than a millionth of the pitch: two instruments never agree so well. Likely cause: \
             the reference, or another segment, holds the same readings as the segment itself",
            micrometres(raw_m)
        )
    } else if calibrated_m > NOTHING * raw_m {
        format!(
            "calibration makes the held-out residual no smaller, {} -> {} µm. Likely causes: the readings are calibrated already, or \
             equation (3) has nothing to take up and what is there is noise or another effect, which `courier diagnose` tells; or the \
             calibration belongs to another courier",
            micrometres(raw_m),
            micrometres(calibrated_m)
        )
    } else {
        return None;
    };
    Some(Remark {
        text: format!("{channel}: {told}"),
        channel,
        of_the_pitch,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PITCH_M: f64 = 1.0e-3;

    fn told(raw_m: f64, calibrated_m: f64) -> Option<Remark> {
        remarks([("g_p".to_owned(), [raw_m, calibrated_m])], PITCH_M).pop()
    }

    #[test]
    fn a_residual_of_the_size_of_the_pitch_is_no_error_of_a_sensor() {
        for calibrated_m in [15.0e-3, 0.3e-3, 0.051e-3, f64::NAN] {
            let remark = told(15.0e-3, calibrated_m).unwrap();
            assert!(
                remark.of_the_pitch && remark.text.contains("of the pitch"),
                "{remark:?}"
            );
        }
        let sound = told(15.0e-6, 2.0e-6);
        assert_eq!(sound, None);
    }

    #[test]
    fn readings_that_are_compared_with_themselves_are_remarked_on() {
        for raw_m in [0.0, 1.0e-18, 0.9e-9] {
            let remark = told(raw_m, raw_m).unwrap();
            assert!(
                !remark.of_the_pitch && remark.text.contains("the same readings"),
                "{remark:?}"
            );
        }
        assert_eq!(told(1.1e-9, 1.0e-9), None);
    }

    #[test]
    fn a_calibration_that_takes_nothing_away_is_remarked_on() {
        for (raw_m, calibrated_m) in [(1.0e-6, 1.0e-6), (1.0e-6, 1.2e-6), (0.3e-6, 0.2999e-6)] {
            let remark = told(raw_m, calibrated_m).unwrap();
            assert!(
                !remark.of_the_pitch && remark.text.contains("no smaller"),
                "{remark:?}"
            );
        }
        assert_eq!(told(1.0e-6, 0.9e-6), None);
    }
}
