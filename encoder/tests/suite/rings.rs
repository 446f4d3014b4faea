//! Magnetic rings of 25 pole pairs: learned on three turns without the reference, judged by it on the fourth.

use crate::shared::shared;
use crate::spun::rms_about_mean;
use courier_signal::encoder::{
    Encoder, EncoderConfig, Harmonics, Learner, Reading, TURN_DRIFT, TurnLearner, TurnTable,
};
use courier_signal::lsq::packed_len;
use courier_signal::quadrature::PairCorrection;
use encoder::{Input, Question, learn};
use recording::{Column, Recording};

const PERIODS: f64 = 25.0;
/// What is asked of them, m.
const WANTED_M: f64 = 7.0e-6;
/// Unknowns on the device: two orders of the turn for each pole.
const UNKNOWNS: usize = TURN_DRIFT + 4 * PERIODS as usize;

/// A ring's recording of which the first three turns may be learned from.
struct Ring {
    name: &'static str,
    whole: Input,
    reference_m: Vec<f64>,
    /// Samples of three turns, and of four.
    until: [usize; 2],
}

impl Ring {
    /// All of them, none without the shared data.
    fn all() -> Vec<Self> {
        let names = ["magnetic-ring-1", "magnetic-ring-2", "magnetic-ring-3"];
        names.into_iter().filter_map(Self::read).collect()
    }

    fn read(name: &'static str) -> Option<Self> {
        let recording = Recording::read(shared(name)?).unwrap();
        let whole = Input::of(&recording, 0).unwrap();
        let reference_m = recording.samples.column(Column::Reference(0)).to_vec();
        let turn = |place: &f64| (place - whole.place[0]) / PERIODS;
        let until = [3.0, 4.0].map(|turns| {
            let reached = whole.place.iter().position(|place| turn(place) >= turns);
            reached.unwrap_or(whole.place.len())
        });
        Some(Self {
            name,
            whole,
            reference_m,
            until,
        })
    }

    /// What the fourth turn's places are wrong by, rms m.
    fn error_m(&self, mut place: impl FnMut(usize) -> f64) -> f64 {
        let pitch_m = self.whole.pitch_m;
        let errors: Vec<f64> = (self.until[0]..self.until[1])
            .map(|row| place(row) - self.reference_m[row] / pitch_m)
            .collect();
        rms_about_mean(&errors) * pitch_m
    }
}

#[test]
fn rings_learned_on_three_turns_are_right_on_the_fourth() {
    for ring in Ring::all() {
        let (whole, until) = (&ring.whole, ring.until[0]);
        let learned = Input {
            t_s: whole.t_s[..until].to_vec(),
            place: whole.place[..until].to_vec(),
            counts: whole.counts[..until].to_vec(),
            ..whole.clone()
        };
        let question = Question {
            periods_per_turn: Some(PERIODS as u32),
        };
        let answer = learn(&learned, &question).unwrap();
        let before = ring.error_m(|row| whole.place[row]);
        let after =
            ring.error_m(|row| answer.calibrated(whole.place[row], Some(whole.counts[row])));
        println!(
            "{}: {:.2} -> {:.2} µm, {} orders of the turn",
            ring.name,
            1e6 * before,
            1e6 * after,
            answer.turn.as_ref().map_or(0, |turn| turn.orders.len())
        );
        assert!(after <= WANTED_M, "{}: {after}", ring.name);
    }
}

/// What an encoder on a device knows of itself.
#[derive(Default)]
struct Device {
    pair: PairCorrection,
    harmonics: Harmonics,
    table: Option<TurnTable<800>>,
}

impl Device {
    /// Its readings of a ring's first samples.
    fn readings(&self, ring: &Ring, until: usize, mut each: impl FnMut(&Reading)) {
        let mut encoder =
            Encoder::new(EncoderConfig::new(&self.pair, &self.harmonics, 0.4, 0.25).unwrap());
        let scale = ring.whole.scale();
        for counts in &ring.whole.counts[..until] {
            each(&encoder.step(counts.map(|count| (count / scale).round() as i16)));
        }
    }

    /// The circle in four rounds over the three turns, then the orders of the period, then those of the turn.
    fn learned(ring: &Ring) -> Self {
        let (mut device, until) = (Self::default(), ring.until[0]);
        for _ in 0..4 {
            let mut learner = Learner::new();
            device.readings(ring, until, |reading| learner.enter(reading));
            device.pair = learner.circle.solve().unwrap().correction(&device.pair);
        }
        let mut learner = Learner::new();
        device.readings(ring, until, |reading| learner.enter(reading));
        device.harmonics = learner.solve().unwrap().harmonics;
        let mut turns = TurnLearner::<UNKNOWNS, { packed_len(UNKNOWNS) }>::new(PERIODS as u32);
        device.readings(ring, until, |reading| turns.enter(reading, 0));
        device.table = Some(TurnTable::new(&turns.solve().unwrap()));
        device
    }

    /// Places of four turns, periods.
    fn places(&self, ring: &Ring) -> Vec<f64> {
        let mut places = Vec::new();
        self.readings(ring, ring.until[1], |reading| {
            let of_turn = self.table.map_or(0.0, |table| table.at(reading, 0));
            places.push(f64::from(reading.periods) + f64::from(reading.calibrated_turns + of_turn));
        });
        places
    }
}

#[test]
fn a_device_learns_rings_by_itself() {
    for ring in Ring::all() {
        let places = Device::learned(&ring).places(&ring);
        let after = ring.error_m(|row| places[row]);
        println!("{}: {:.2} µm on the device", ring.name, 1e6 * after);
        assert!(after <= WANTED_M, "{}: {after}", ring.name);
    }
}
