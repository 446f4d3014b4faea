//! Whether a recording can answer at all: every limit with what was found.

use crate::Insufficient;
use crate::algebra::statistics::{deviation, median};
use crate::data::coverage::{PHASES, TURNED_MRAD, phases};
use crate::data::lacking::motions;
use crate::data::motion::{LOUD_MISFIT, Motion};
use crate::data::observations::{MINIMUM_SAMPLES, Observations};
use crate::linearization::recording::{LinearizedRecording, range};

/// A step in time by more than this many sample intervals within a run of even sampling is a jump, not a pause.
/// A prior: pauses of a log are of some samples, and a clock that is set anew moves by far more.
const JUMP: f64 = 50.0;
/// Share of a run's intervals that must be alike for its sampling to count as even.
/// A prior: of a log that is even some intervals in a hundred are lost or late.
const EVEN: f64 = 0.95;

/// What a reader should know of the recording, though it can be diagnosed.
pub fn remarks(o: &Observations) -> Vec<String> {
    let mut list = Vec::new();
    for (run, name) in o.run_names.iter().enumerate() {
        let mut steps: Vec<(f64, usize)> = (1..o.len())
            .filter(|&i| o.run[i] == run && o.run[i - 1] == run)
            .map(|i| (o.t_s[i] - o.t_s[i - 1], i))
            .collect();
        let mut values: Vec<f64> = steps.iter().map(|s| s.0).collect();
        let Some(typical) = median(&mut values) else {
            continue;
        };
        let alike = steps
            .iter()
            .filter(|s| (s.0 / typical - 1.0).abs() < 0.5)
            .count();
        if (alike as f64) < EVEN * steps.len() as f64 {
            continue;
        }
        steps.retain(|s| s.0 > JUMP * typical);
        if let Some((step, row)) = steps.first() {
            list.push(format!(
                "t_s: jumps by {step:.3} s before sample {row} of run {name} ({} such jumps), steps of {typical:.4} s wanted; each part is taken for itself",
                steps.len()
            ));
        }
    }
    list.extend(frozen_thermometer(o));
    list
}

/// A board that was just switched on warms by a kelvin in the first minute; a room swings by tenths in ten. A prior: shorter
/// recordings say nothing by a temperature that stays, s.
const WARMS_S: f64 = 60.0;

/// A thermometer that never changes.
fn frozen_thermometer(o: &Observations) -> Option<String> {
    let lasts_s = o.t_s.last()? - o.t_s.first()?;
    let known = o.temperature_c.iter().copied().filter(|t| t.is_finite());
    let [low, high] = range(&known.collect::<Vec<f64>>())?;
    (low == high && lasts_s > WARMS_S).then(|| {
        format!("temp_c: {low} °C in all of {lasts_s:.0} s, a change wanted: whether anything follows the temperature is not told")
    })
}

/// Checks motion and channels. One run will do: what is held out are pieces of runs ([`crate::data::folds::folds`]).
///
/// # Errors
/// The first limit that is violated.
pub fn check(o: &Observations) -> Result<(), Insufficient> {
    for segment in (0..4).filter(|s| o.has_segment(*s)) {
        crate::data::channels::pair(o, segment)?;
        let seen = phases(o, segment);
        if seen < PHASES {
            let what = format!(
                "sixteenths of the tooth phase that segment {} passed",
                segment + 1
            );
            let limit = Insufficient::new(&what, seen as f64, PHASES as f64, "");
            return Err(limit.lacking(motions(o)));
        }
        crate::data::channels::tooth_count(o, segment)?;
        crate::data::channels::fresh(o, segment)?;
    }
    Ok(())
}

/// Checks that residuals can be formed at all.
///
/// # Errors
/// Neither all four segments nor a reference, or too few samples that have what is needed at once.
pub fn check_residuals(
    linearized: &LinearizedRecording,
    mask: &[bool],
) -> Result<(), Insufficient> {
    let scope = &linearized.scope;
    let segments = scope.segments.iter().filter(|s| **s).count();
    if !scope.reference && segments < 4 {
        return Err(Insufficient::new(
            "segments recorded without a reference of the same coordinate",
            segments as f64,
            4.0,
            "",
        ));
    }
    let whole = (0..linearized.len())
        .filter(|&i| mask[i] && linearized.rows(i).count > 0)
        .count();
    if whole < MINIMUM_SAMPLES {
        return Err(Insufficient::new(
            "undisturbed samples with all that a residual is formed of",
            whole as f64,
            MINIMUM_SAMPLES as f64,
            "",
        )
        .lacking(motions(linearized.observations)));
    }
    Ok(())
}

/// Noise that is stated may be this much above what the readings show. Derived from filters that are no fault: a mean of two
/// samples leaves 0.76 of the misfit that LOUD_MISFIT is of, a mean of three 0.57, so that white noise or a light filter is never
/// below a half.
const STATED: f64 = 2.0;
/// Noise of fewer counts than this is not seen apart from the rounding to whole ones, nor is that of positions with few digits. A
/// derivation: rounding alone scatters by 0.29 counts, and below one count its error is no longer like noise.
const COUNTS: f64 = 1.0;

/// The stated noise against the scatter of the readings on smooth paths, where it is wrong. Patterns add to the scatter and
/// never take from it, so a statement above it is wrong; one below it may be. Noise that a filter made smooth scatters less:
/// by itself this is no reason to give no answer.
pub fn overstated(linearized: &LinearizedRecording) -> Option<Insufficient> {
    let o = linearized.observations;
    // Against a reference the path is the reference's: the segments' own is looked at here.
    let own = Motion::new(o, &linearized.calibrated_m);
    let quieter = |name: &str, scatter: f64, stated: &[f64]| {
        let mut known: Vec<f64> = stated.iter().copied().filter(|n| n.is_finite()).collect();
        let found = scatter / LOUD_MISFIT / median(&mut known)?.max(1e-30);
        let what = format!("stated noise: scatter of {name} on smooth paths over it");
        (scatter > 0.0 && found < 1.0 / STATED)
            .then(|| Insufficient::new(&what, found, 1.0 / STATED, ""))
    };
    let segments = (0..4).filter(|s| {
        let relinearized = if o.pair_counts[*s].is_empty() {
            o.position_step_m[*s] == 0.0
        } else {
            o.pair_noise_counts > COUNTS
        };
        relinearized && linearized.scope.segments[*s]
    });
    let axes = 0..if linearized.scope.beacon && o.electrode_noise_counts > COUNTS {
        2
    } else {
        0
    };
    segments
        .filter_map(|s| {
            let name = format!("segment {}", s + 1);
            quieter(&name, own.loud_m[s], &o.position_noise_m[s])
        })
        .chain(axes.filter_map(|axis| {
            let name = ["tan psi_x", "tan psi_y"][axis];
            quieter(name, own.loud_tan_psi[axis], &o.tan_psi_noise[axis])
        }))
        .next()
}

/// Checks that the four segments can be told apart.
///
/// # Errors
/// No beacon, no reference, and hardly any turning.
pub fn check_turning(linearized: &LinearizedRecording) -> Result<(), Insufficient> {
    if linearized.scope.reference || linearized.scope.beacon {
        return Ok(());
    }
    let angles: Vec<f64> = (0..linearized.len())
        .filter(|&i| linearized.mask[i])
        .map(|i| 1e3 * linearized.theta_rad(i))
        .filter(|t| t.is_finite())
        .collect();
    let found = deviation(&angles);
    if found < TURNED_MRAD {
        let what = "standard deviation of the angle, without a beacon or a reference";
        let limit = Insufficient::new(what, found, TURNED_MRAD, "mrad");
        return Err(limit.lacking(motions(linearized.observations)));
    }
    Ok(())
}
