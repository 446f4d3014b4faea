//! The cost table's rows.

use crate::counter::{Statistics, measure};
use crate::{estimator, peers};
use cases::encoder::{RingTurns, SAMPLES, TURN, Table, Turning};
use cases::inputs::Inputs;
use cases::rows::Rows;
use cases::setups::Setup;
use cases::{PACKED, UNKNOWNS};
use core::hint::black_box;
use courier_sensor::encoder::{Circle, Learner};
use courier_sensor::frame::{Frame, RawFrame, Status};
use courier_sensor::lsq::Estimator;
use courier_sensor::step::{StepConfig, StepState, isr_step, isr_step_mapped};
use courier_sensor::teeth::ToothMap;

/// Inputs of the interrupt.
const FRAMES: u32 = 120_000;
/// Inputs of the slower peers.
const PEER_FRAMES: u32 = 2_000;
/// Equations.
const ROWS: u32 = 1_000;

/// Prints the rows of our own work.
pub fn run() {
    interrupt("interrupt", Setup::Own);
    interrupt("interrupt_lateral", Setup::Lateral);
    interrupt("interrupt_extended", Setup::Extended);
    interrupt("interrupt_dearest_row", Setup::DearestRow);
    interrupt("interrupt_dearest", Setup::Dearest);
    mapped("interrupt_mapped");
    estimation(estimator::take());
    encoder();
}

/// Prints the rows of the peers.
pub fn run_peers() {
    peer("libm", PEER_FRAMES, peers::libm::step);
    peer("libm_products", PEER_FRAMES, peers::libm::step_products);
    #[cfg(feature = "cmsis")]
    peer("cmsis", PEER_FRAMES, peers::cmsis::step);
    peers::qr::run();
}

/// The interrupt's computation as the image calls it: counts in the state, frame in the state.
type Sample = for<'s> fn(&StepConfig, &'s mut StepState) -> &'s Frame;

fn interrupt(name: &str, setup: Setup) {
    let (config, mut state, mut inputs) = (setup.config(), StepState::new(), Inputs::new(99));
    let (mut statistics, sample): (_, Sample) = (Statistics::default(), black_box(isr_step));
    for _ in 0..FRAMES {
        *state.raw_mut() = inputs.frame();
        state.skip(inputs.missed());
        let (taken, ()) = measure(|| {
            sample(&config, &mut state);
        });
        statistics.add(taken);
    }
    statistics.print(name);
}

/// Equation (9) and a tooth map with the waves that a map has; of the inputs, those that lie on the map.
fn mapped(name: &str) {
    let map = cortex_m::singleton!(: ToothMap = ToothMap::new()).expect("called once");
    cases::setups::fill_map(map);
    let config = Setup::Lateral.config();
    let (mut state, mut inputs) = (StepState::new(), Inputs::new(99));
    let mut statistics = Statistics::default();
    for _ in 0..FRAMES {
        *state.raw_mut() = inputs.frame();
        state.skip(inputs.missed());
        let (taken, outside) = measure(|| {
            let frame = isr_step_mapped(&config, &mut state, map);
            frame.status.contains(Status::OUTSIDE_MAP)
        });
        if !outside {
            statistics.add(taken);
        }
    }
    statistics.print(name);
}

fn peer(name: &str, count: u32, work: fn(&peers::Coefficients, &RawFrame, &mut peers::Outcome)) {
    let (coefficients, mut inputs) = (peers::Coefficients::new(), Inputs::new(99));
    let (mut statistics, mut outcome) = (Statistics::default(), peers::Outcome::default());
    for _ in 0..count {
        let raw = inputs.frame();
        let (taken, ()) = measure(|| work(black_box(&coefficients), black_box(&raw), &mut outcome));
        black_box(&outcome);
        statistics.add(taken);
    }
    statistics.print(name);
}

/// Rows, predictions and a solution. The first as many rows as unknowns fill the factor and count apart.
fn estimation(estimator: &mut Estimator<UNKNOWNS, PACKED>) {
    let mut rows = Rows::new(3, false);
    let [mut filling, mut entering, mut predicting] = [Statistics::default(); 3];
    for n in 0..ROWS {
        let row = rows.row();
        if n > 2 * UNKNOWNS as u32 {
            predicting
                .add(measure(|| black_box(estimator.rows.predict(black_box(&row.entries)))).0);
        }
        let (taken, entered) = measure(|| estimator.rows.enter(black_box(&row.entries), row.rhs));
        assert!(entered.is_ok());
        if n < UNKNOWNS as u32 {
            filling.add(taken);
        } else {
            entering.add(taken);
        }
    }
    entering.print("givens_row_33");
    filling.print("givens_row_33_start");
    predicting.print("predict_row_33");
    let mut solving = Statistics::default();
    let (taken, solved) = measure(|| estimator.solve().is_ok());
    assert!(solved);
    solving.add(taken);
    solving.print("solve_33");
}

/// One pair by itself: a sample, a row of its circle (9 unknowns), and all that a reading teaches (that row and one of 20 unknowns; at the
/// end of a stretch its 16 equations).
fn encoder() {
    let mut turning = Turning::new(99).expect("constants in range");
    let circle = cortex_m::singleton!(: Circle = Circle::new()).expect("called once");
    let learner = cortex_m::singleton!(: Learner = Learner::new()).expect("called once");
    let [mut sample, mut row, mut learning] = [Statistics::default(); 3];
    for n in 0..SAMPLES {
        let counts = black_box(turning.counts());
        let (taken, reading) = measure(|| turning.read(counts));
        sample.add(taken);
        let (taken, entered) = measure(|| circle.enter(black_box(&reading)));
        assert!(entered.is_ok());
        // The first rows fill the factor.
        if n > 100 {
            row.add(taken);
        }
        learning.add(measure(|| learner.enter(black_box(&reading))).0);
    }
    sample.print("encoder_sample");
    row.print("encoder_row_9");
    learning.print("encoder_learn");
    turn();
}

/// Fifty orders of the turn: what the table adds, what a reading teaches (a row of 106 unknowns, at times), and the answer.
fn turn() {
    let mut turning = Turning::new(99).expect("constants in range");
    let turns = cortex_m::singleton!(: RingTurns = RingTurns::new(TURN)).expect("called once");
    let [mut adding, mut learning, mut solving] = [Statistics::default(); 3];
    let mut table = None;
    for n in 0..SAMPLES + 1000 {
        let counts = turning.counts();
        let reading = turning.read(counts);
        learning.add(measure(|| turns.enter(black_box(&reading), 0)).0);
        if n == SAMPLES {
            let (taken, learned) = measure(|| turns.solve());
            solving.add(taken);
            table = learned.ok().map(|learned| Table::new(&learned));
        }
        if let Some(table) = &table {
            adding.add(measure(|| black_box(table.at(black_box(&reading), 0))).0);
        }
    }
    adding.print("encoder_turn");
    learning.print("encoder_turn_learn");
    solving.print("encoder_turn_solve");
}
