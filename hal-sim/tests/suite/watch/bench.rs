//! A courier that was calibrated and works on, and the watch over it, at the rate of its readings alone.

use super::kalman::Kalman;
use super::traffic::{Traffic, Work};
use crate::figures::{POSES, fits, scatter};
use core::f64::consts::TAU;
use courier_sensor::calibration::recalibration::{Learner, RecalibrationConfig, amend};
use courier_sensor::calibration::record::Quality;
use courier_sensor::calibration::watch::{
    Follower, Kept, Reading, Verdict, Watch, WatchConfig, Whole, Window,
};
use courier_sensor::calibration::{PlatenEstimator, Regression, Sample};
use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::{Coordinate, SEGMENTS};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{Basis, ErrorModel, Observation, TermTable};
use effects::motion::Motion;
use effects::plant::PlantEffect;
use hal_sim::courier::Courier;
use hal_sim::spec::CourierSpec;

/// A kind of courier and its calibration.
pub struct Calibrated {
    spec: Box<dyn Fn() -> CourierSpec>,
    pub model: ErrorModel,
    pub quality: Quality,
}

/// Poses that judge a calibration.
const HELD_OUT: usize = 200;

impl Calibrated {
    /// By random poses, as the board does it, and judged by others.
    pub fn new(spec: impl Fn() -> CourierSpec + 'static, seed: u64) -> Self {
        let geometry = Geometry::PAPER;
        let zero = ErrorModel::zero(TermTable::equation_3());
        let regression = Regression::new(&geometry, &zero).expect("equation (3) can be fitted");
        let fitted = scatter(spec(), POSES, seed);
        let (values, _) = fits(&regression, &fitted);
        let values: Vec<f32> = values.iter().map(|v| *v as f32).collect();
        let residual = |sample: &Sample| {
            let (row, rhs) = regression.row(sample);
            let fitted: f32 = row.iter().zip(&values).map(|(r, k)| r * k).sum();
            f64::from(rhs - fitted)
        };
        let held_out = scatter(spec(), HELD_OUT, seed + 1);
        let residuals: Vec<f64> = held_out.iter().map(residual).collect();
        let mean = residuals.iter().sum::<f64>() / HELD_OUT as f64;
        let square: f64 = residuals.iter().map(|r| (r - mean).powi(2)).sum();
        let residual_m = (square / HELD_OUT as f64).sqrt() as f32;
        let quality = Quality {
            residual_after_m: residual_m,
            predicted_worst_m: residual_m * worst_deviation(&regression, &fitted),
            ..Quality::default()
        };
        Self {
            spec: Box::new(spec),
            model: regression.model(&values),
            quality,
        }
    }

    fn config(&self) -> WatchConfig {
        WatchConfig::of(&self.quality, &self.model, &Geometry::PAPER)
    }

    /// A filter of the same windows, which knows at what rate amounts walk from a time on, m^2/s.
    pub fn kalman(&self, rate_m2_per_s: f64, from_s: f64) -> Kalman {
        Kalman::new(self.config().uncertainty_m.into(), rate_m2_per_s, from_s)
    }

    fn learner(&self) -> Box<Learner> {
        let mut learner = Box::new(Learner::new());
        learner.start(Some(RecalibrationConfig::of(&self.config(), 0.0)));
        learner
    }

    /// The courier with these changes, for a look from outside.
    pub fn spec(&self, changes: Vec<Box<dyn PlantEffect>>) -> CourierSpec {
        let mut spec = (self.spec)();
        spec.effects.extend(changes);
        spec
    }

    /// Such a courier at work. `changes`: what happens to it.
    pub fn serve(&self, changes: Vec<Box<dyn PlantEffect>>, work: Work, seed: u64) -> Service {
        let mut spec = (self.spec)();
        spec.effects.extend(changes);
        Service {
            start_c: spec.temperature.start_c,
            courier: Courier::new(spec, seed).expect("a sensor of unique phase"),
            traffic: Traffic::new(work, seed + 1),
            watch: Watch::new(self.config()),
            window: Box::new(Window::new()),
            learner: self.learner(),
            model: self.model.clone(),
            time_s: 0.0,
            is_automatic: false,
            adopted: 0,
            judge: None,
            kalman: None,
        }
    }
}

/// Largest deviation of a correction over the pitch, of one pose's.
fn worst_deviation(regression: &Regression, samples: &[Sample]) -> f32 {
    let unknowns = regression.unknowns();
    let mut estimator = PlatenEstimator::new(unknowns);
    for sample in samples {
        let (row, rhs) = regression.row(sample);
        estimator.rows.enter(&row[..unknowns], rhs).expect("finite");
    }
    let places = (0..SEGMENTS).flat_map(|segment| (0..24).map(move |step| (segment, step)));
    let leverages = places.map(|(segment, step)| {
        let functional = regression.correction(segment, step as f32 / 24.0);
        let prediction = estimator.rows.predict(&functional[..unknowns]);
        prediction.expect("determined").leverage
    });
    leverages.fold(0.0, f32::max).sqrt()
}

/// Who looks at what comes in force.
pub type Judge = Box<dyn FnMut(f64, &ErrorModel, &ErrorModel)>;

/// A courier at work.
pub struct Service {
    pub traffic: Traffic,
    courier: Courier,
    start_c: f64,
    watch: Watch,
    window: Box<Window>,
    pub learner: Box<Learner>,
    pub model: ErrorModel,
    pub time_s: f64,
    /// A candidate that is believed comes in force.
    pub is_automatic: bool,
    /// How often that was.
    pub adopted: u32,
    /// Is told when, the model before and the one after.
    pub judge: Option<Judge>,
    /// Sees the same windows, beside the learner.
    pub kalman: Option<Kalman>,
}

/// Both learn from a window, of which the learner alone says what follows.
struct Both<'a> {
    learner: &'a mut Learner,
    kalman: Option<&'a mut Kalman>,
    time_s: f64,
}

impl Follower for Both<'_> {
    fn window(&mut self, window: &Whole<'_>) -> bool {
        if let Some(kalman) = &mut self.kalman {
            kalman.enter(self.time_s, window);
        }
        self.learner.window(window)
    }

    fn forget(&mut self) {
        self.learner.forget();
    }
}

/// The firmware looks at a frame so often.
const LOOK_S: f64 = 1.0e-3;
/// The first of a rest is looked at; then nothing new is to be seen.
const FIRST_OF_REST_S: f64 = 0.02;

impl Service {
    pub fn verdict(&self) -> Verdict {
        self.watch.verdict()
    }

    /// Another configuration of the watch, before the first reading.
    pub fn configure(&mut self, change: impl FnOnce(&mut WatchConfig)) {
        let mut config = *self.watch.config();
        change(&mut config);
        self.watch = Watch::new(config);
    }

    /// Works until a time; whether `seen` says so after a window, which ends the work.
    pub fn run(&mut self, until_s: f64, mut seen: impl FnMut(&Verdict) -> bool) -> bool {
        self.run_watched(until_s, |watch| seen(&watch.verdict()))
    }

    pub fn run_watched(&mut self, until_s: f64, mut seen: impl FnMut(&Watch) -> bool) -> bool {
        while self.time_s < until_s {
            self.time_s += LOOK_S;
            let time_ms = (self.time_s * 1.0e3).round() as u64;
            if !self.window.is_due(time_ms) {
                continue;
            }
            self.traffic.advance(self.time_s);
            if let Some(end_s) = self.traffic.rests_until_s(self.time_s - FIRST_OF_REST_S) {
                self.time_s = (end_s / LOOK_S).ceil() * LOOK_S;
                continue;
            }
            let reading = reading(
                &mut self.courier,
                &self.traffic,
                self.start_c,
                &self.model,
                time_ms,
            );
            let mut both = Both {
                learner: &mut self.learner,
                kalman: self.kalman.as_mut(),
                time_s: self.time_s,
            };
            let is_new = self.watch.take(&mut self.window, &reading, &mut both);
            if is_new && self.is_automatic {
                self.adopt();
            }
            if is_new && seen(&self.watch) {
                return true;
            }
        }
        false
    }

    /// As the board starts again, with what it has kept as bytes.
    pub fn restart(&mut self) {
        let kept = self.watch.kept().expect("there is a reference");
        let kept = Kept::from_bytes(&kept.bytes(false), false).expect("whole");
        let config = *self.watch.config();
        self.watch.start(config);
        self.watch.restore(&kept);
        self.window.forget();
        self.learner
            .start(Some(RecalibrationConfig::of(&config, kept.amended_m)));
    }

    /// As the background does it.
    fn adopt(&mut self) {
        if !self.learner.proposal().is_some_and(|of| of.is_believed()) {
            return;
        }
        let before = self.model.clone();
        assert!(amend(&mut self.model, self.learner.candidate_m()));
        if let Some(kalman) = &mut self.kalman {
            kalman.amend(self.learner.candidate_m());
        }
        let kept = self.watch.kept().filter(|kept| kept.is_measure);
        self.watch.start(*self.watch.config());
        let amended_m = self.learner.adopt();
        if let Some(kept) = kept {
            self.watch.restore(&kept.amended(amended_m));
        } else {
            self.learner
                .start(Some(RecalibrationConfig::of(self.watch.config(), 0.0)));
        }
        self.window.forget();
        self.adopted += 1;
        if let Some(judge) = &mut self.judge {
            judge(self.time_s, &before, &self.model);
        }
    }
}

/// As the signal path makes it: tooth counts, phases and the calibrated parity. `start_c`: the calibration's temperature.
pub fn reading(
    courier: &mut Courier,
    motion: &dyn Motion,
    start_c: f64,
    model: &ErrorModel,
    time_ms: u64,
) -> Reading {
    let sample = courier.counts_at(motion, time_ms as f64 / 1.0e3);
    let teeth = courier.teeth();
    let unmodified: [Coordinate; SEGMENTS] = core::array::from_fn(|s| {
        let [sine, cosine] = sample.quadrature[s].map(f64::from);
        Coordinate {
            teeth: teeth[s],
            fraction_turns: (sine.atan2(cosine) / TAU) as f32,
        }
    });
    let geometry = Geometry::PAPER;
    let observation = Observation {
        unmodified,
        ..Observation::default()
    };
    let basis = Basis::new(&geometry, &observation);
    let seen = Sample {
        unmodified,
        ..Sample::default()
    };
    let errors = PARITY_SIGN.iter().zip(0..);
    let added_m: f32 = errors
        .map(|(sign, s)| sign * model.error_m(&basis, s))
        .sum();
    Reading {
        time_ms,
        unmodified,
        parity_m: seen.parity_m(geometry.pitch_m) + added_m,
        temperature_delta_k: (sample.temperature_c - start_c) as f32,
    }
}
