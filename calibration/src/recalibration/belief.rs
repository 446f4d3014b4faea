//! What is believed of the changes: the windows' rows with the reference, the priors, and what the rows' variance leaves out.

use super::config::{APART, RecalibrationConfig};
use super::gain::{ANY_ANGLE, AS_CALIBRATED, weighted};
use crate::joint::{JOINT_UNKNOWNS, JointRows};
use crate::math::sqrt;
use crate::watch::{AMOUNTS, Amounts};

/// By so much a change must be larger than the prior was made for, to be solved for anew.
const MUCH_LARGER: f32 = 1.5;
/// Of what changes leave outside all columns of a window, what goes together with a function of equation (3), over the slope of
/// the corrections. A derivation: half of the power of what looking up beside the places makes has orders that equation (3) lacks
/// (0.7), and the functions, which are taken beside their places too, have a quarter of the slope in one order.
const TOGETHER: f32 = 0.7 * 0.25;

/// Deviations by which the position must gain where every window draws them anew. Derived from the normal tail: one in three
/// million that does not.
const WANTED_RANDOM: f32 = 5.0;
/// The same where they are drawn once, for a courier and what happens to it. Derived from the normal tail: one in 3,000, for
/// both axes in a thousand couriers and half as many again.
const WANTED_ONCE: f32 = 3.4;

/// Unknowns: what the calibration left of each amount, and what has changed since.
const BOTH: usize = 2 * AMOUNTS;
const _: () = assert!(BOTH <= JOINT_UNKNOWNS);
/// What windows tell of the amounts. Of the joint calibration's size: one size is one copy of the code.
pub type Rows = JointRows;

/// Estimate and covariance of what was left and what has changed.
#[derive(Clone, Debug)]
pub struct Belief {
    rows: Rows,
    config: RecalibrationConfig,
    /// What the calibration left, metres.
    left_m: Amounts,
    /// What has changed since, metres.
    changes_m: Amounts,
    /// Changes that have come in force since it began, metres: the outputs are rid of them, not of what they leave.
    amended_m: Amounts,
    /// Prior deviation of a change, metres.
    changed_m: f32,
}

impl Belief {
    /// Nothing.
    pub const fn new() -> Self {
        Self {
            rows: Rows::new(0),
            config: RecalibrationConfig::NONE,
            left_m: [0.0; AMOUNTS],
            changes_m: [0.0; AMOUNTS],
            amended_m: [0.0; AMOUNTS],
            changed_m: 0.0,
        }
    }

    /// Begins for a calibration, or with nothing for none.
    pub fn start(&mut self, config: Option<RecalibrationConfig>) {
        self.config = config.unwrap_or(RecalibrationConfig::NONE);
        self.left_m = [0.0; AMOUNTS];
        self.changes_m = [0.0; AMOUNTS];
        self.amended_m = [0.0; AMOUNTS];
    }

    /// These changes come in force.
    pub fn amend(&mut self, changes_m: &Amounts) {
        add(&mut self.amended_m, changes_m, 1.0);
    }

    /// By how much the calibration has been amended in all, metres rms.
    pub fn amended_m(&self) -> f32 {
        let square: f32 = self.amended_m.iter().map(|a| 0.5 * a * a).sum();
        self.config.amended_m + sqrt(square)
    }

    /// Whether it is for a calibration.
    pub fn has_begun(&self) -> bool {
        self.config.changed_m > 0.0
    }

    /// What the calibration left, metres.
    pub fn left_m(&self) -> &Amounts {
        &self.left_m
    }

    /// What has changed since, metres.
    pub fn changes_m(&self) -> &Amounts {
        &self.changes_m
    }

    /// Solves for what the calibration left and what has changed, by rows of unit variance that tell their sum and are to count as `now` says,
    /// by the reference, which tells the first alone and counts as the same rows do by `then`, and by the priors.
    pub fn solve(&mut self, rows: &Rows, [now, then]: [f32; 2], reference_m: &Amounts) {
        self.changed_m = self.config.changed_m;
        let changes_m = self.solve_once(rows, [now, then], reference_m);
        let wanted_m = self.prior_m(&changes_m);
        if wanted_m > MUCH_LARGER * self.changed_m {
            // A prior that is too narrow for one change lets others take its part.
            self.changed_m = wanted_m;
        }
        let now = now / sqrt(1.0 + now * now * self.together(rows, &changes_m));
        self.changes_m = self.solve_once(rows, [now, then], reference_m);
    }

    fn solve_once(&mut self, rows: &Rows, [now, then]: [f32; 2], reference_m: &Amounts) -> Amounts {
        self.rows.reset(BOTH);
        let RecalibrationConfig {
            left_m, shape_m, ..
        } = self.config;
        let left_m = if then > 0.0 {
            left_m
        } else {
            sqrt(left_m * left_m + shape_m * shape_m)
        };
        for i in 0..AMOUNTS {
            let row: Amounts = core::array::from_fn(|j| rows.entry(i, j));
            let rhs = rows.right_hand_side(i);
            self.believe(&row, [then, 0.0], then * dot(&row, reference_m));
            self.believe(&row, [now, now], now * rhs);
            let mut row = [0.0; AMOUNTS];
            row[i] = 1.0;
            self.believe(&row, [1.0 / left_m, 0.0], 0.0);
            self.believe(&row, [0.0, 1.0 / self.changed_m], 0.0);
        }
        let mut both = [0.0; BOTH];
        for i in (0..BOTH).rev() {
            let known: f32 = (i + 1..BOTH).map(|j| self.rows.entry(i, j) * both[j]).sum();
            let amount = (self.rows.right_hand_side(i) - known) / self.rows.entry(i, i);
            both[i] = if amount.is_finite() { amount } else { 0.0 };
        }
        let (left, changed) = both.split_at(AMOUNTS);
        self.left_m.copy_from_slice(left);
        core::array::from_fn(|i| changed[i])
    }

    /// Prior deviation of changes of which the largest is this one's: by what the segments of a pair differ in, since a motion that does not
    /// tell them apart shows this alone.
    fn prior_m(&self, changes_m: &Amounts) -> f32 {
        let (firsts, seconds) = changes_m.split_at(AMOUNTS / 2);
        let apart = firsts.iter().zip(seconds).map(|(a, b)| (a - b).abs());
        apart.fold(self.config.changed_m, f32::max)
    }

    /// What changes leave in the rows and no number of windows averages out, since it goes together with their functions: its variance over
    /// that of an amount by all rows, if the others were known.
    fn together(&self, rows: &Rows, changes_m: &Amounts) -> f32 {
        let entries = (0..AMOUNTS).flat_map(|i| (i..AMOUNTS).map(move |j| rows.entry(i, j)));
        // Information on an amount, 1/m^2.
        let information = entries.map(|entry| entry * entry).sum::<f32>() / AMOUNTS as f32;
        // A change of order n and a correction of order k make orders n + k and n - k. Windows have columns of orders 1 to 6: what is left are
        // corrections of order 6 for changes of orders 1 and 2, of orders 4 and 6 for those of order 4, all for those of order 6.
        let [sixth, fourth, all] = self.config.slopes;
        let by_order = [sixth, sixth, fourth, all];
        let changes = self.amended_m.iter().zip(changes_m).zip(0_usize..);
        let left = changes.map(|((before, change), i)| {
            let slope = by_order.get(i % 8 / 2).copied().unwrap_or(all);
            let left = slope * (before + change);
            0.5 * left * left
        });
        let left_m = sqrt(left.sum()) + sixth * self.config.amended_m;
        let together_m = TOGETHER * all * left_m;
        // Of an amplitude, twice the mean square.
        2.0 * together_m * together_m * information
    }

    /// Enters a row, times these, for what was left and what has changed.
    #[inline(never)]
    fn believe(&mut self, row: &Amounts, by: [f32; 2], rhs: f32) {
        let mut both = [0.0; BOTH];
        for (half, by) in both.as_chunks_mut::<AMOUNTS>().0.iter_mut().zip(by) {
            *half = row.map(|entry| by * entry);
        }
        // Not finite where nothing is known: left out.
        let _ = self.rows.enter(&both, rhs);
    }

    /// Deviations by which the position must gain by amounts. What every window draws anew is what these rows, which are to count as `now`
    /// says, leave open by themselves.
    pub fn wanted_gain(&self, rows: &Rows, now: f32, amounts_m: &Amounts) -> f32 {
        let weighted_m = weighted(amounts_m, &AS_CALIBRATED);
        let all = self.deviation(&weighted_m);
        let anew = rows
            .predict(&weighted_m)
            .map_or(f32::INFINITY, |of| of.leverage);
        let share = anew / (now * now * all * all);
        // Not a number is all of it.
        let share = if share < 1.0 { share } else { 1.0 };
        let [random, once] = [WANTED_RANDOM, WANTED_ONCE].map(|wanted| wanted * wanted);
        sqrt(once + share * (random - once))
    }

    /// Deviations by which the mean square of the position's error becomes smaller by amounts, on the motion that tells least.
    #[inline(never)] // one copy in the images
    pub fn gain(&self, amounts_m: &Amounts) -> f32 {
        let mut least = f32::INFINITY;
        for agree in [&AS_CALIBRATED, &ANY_ANGLE] {
            let weighted_m = weighted(amounts_m, agree);
            let gain = dot(amounts_m, &weighted_m) / (2.0 * self.deviation(&weighted_m));
            // Not a number is no gain.
            least = if gain < least { gain } else { least };
        }
        if least < f32::INFINITY { least } else { 0.0 }
    }

    /// Deviation of a functional of the changes.
    #[inline(never)]
    pub fn deviation(&self, functional: &Amounts) -> f32 {
        let mut both = [0.0; BOTH];
        both[AMOUNTS..].copy_from_slice(functional);
        let prediction = self.rows.predict(&both);
        let apart_m = APART * self.config.residual_m;
        let apart = apart_m * apart_m * dot(functional, functional);
        prediction.map_or(f32::INFINITY, |of| sqrt(of.leverage + apart))
    }
}

/// Adds amounts, times a share.
#[inline(never)] // one copy in the images
pub fn add(sum: &mut Amounts, of: &Amounts, share: f32) {
    sum.iter_mut()
        .zip(of)
        .for_each(|(sum, of)| *sum += share * of);
}

/// Sum of products.
#[inline(never)]
pub fn dot(a: &Amounts, b: &Amounts) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
