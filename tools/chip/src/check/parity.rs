//! The shipped image's signal path against this machine's: the same raw counts give the same bits, sample for sample, while the courier moves.

use super::fixture::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::wire::Board;
use anyhow::{Context, Result, ensure};
use board_link::Link;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::{Coordinate, Frame, RawFrame, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, Reply};
use courier_sensor::link::telemetry::{Channels, Sample};
use courier_sensor::model::{ErrorModel, Multiplier, Term, TermTable};
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use std::time::Duration;

/// So long is listened to, while the courier is on a way of two seconds and turns meanwhile.
const LISTEN_MS: u64 = 250;
const TARGET: Target = Target {
    x_m: 0.2,
    y_m: -0.1,
    theta_rad: 2.0e-3,
};
/// So fast that a tooth passes in some milliseconds, and every phase is met many times.
const SPEED_M_PER_S: f32 = 0.2;
/// Samples that must have been compared, of 20 a millisecond.
const LEAST: usize = 1_000;
/// Some micrometres for every coefficient, another for each.
const COEFFICIENT_M: f32 = 1.0e-6;
/// What is compared of a sample.
const CHANNELS: Channels = Channels::all();

pub fn run(image: &Image) -> Result<String> {
    let mut said = vec![];
    let further = Term {
        own_order: 1,
        lateral_order: 1,
        theta_power: 1,
        multiplier: Multiplier::None,
    };
    let mut extended = TermTable::equation_9();
    ensure!(extended.push(further).is_ok(), "no room for a further term");
    for (name, terms) in [
        ("no model", None),
        ("equation (3)", Some(TermTable::equation_3())),
        ("equation (9)", Some(TermTable::equation_9())),
        ("a further term", Some(extended)),
    ] {
        let board = Board::new(start(image, 17, Start::default())?);
        let result = compared(&board, terms.map(model)).with_context(|| name.to_owned());
        let result = result.map(|samples| format!("{samples} samples with {name}"));
        said.push(judge(&mut board.processor.borrow_mut(), result)?);
    }
    Ok(format!("the same bits here and there: {}", said.join(", ")))
}

fn model(terms: TermTable) -> ErrorModel {
    let mut model = ErrorModel::zero(terms);
    let coefficients = model.coefficients.iter_mut().flatten().flatten();
    let places = model.constants_m.iter_mut().chain(coefficients);
    for (number, place) in places.enumerate() {
        *place = COEFFICIENT_M * (number % 7) as f32;
    }
    model
}

/// How many samples of the board's are as they are here.
fn compared(board: &Board, model: Option<ErrorModel>) -> Result<usize> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let mut settings = Settings::default();
    if let Some(model) = model {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        calibration.model = model.clone();
        settings.pairs = calibration.pairs;
        settings.model = Some(model);
        done(&link.ask(Action::take_over(calibration))?)?;
    }
    let config = StepConfig::build(&settings)?;
    let speed_m_per_s = SPEED_M_PER_S;
    let target = TARGET;
    done(&link.ask(Action::GoTo {
        target,
        speed_m_per_s,
    })?)?;
    link.stream(CHANNELS, 1)?;
    link.drop_samples()?;
    let mut here = Here::default();
    for _ in 0..LISTEN_MS {
        link.pass(Duration::from_millis(1))?;
        link.listen(|sample| here.compare(&config, sample))?;
    }
    ensure!(
        here.compared >= LEAST,
        "found {} samples, wanted {LEAST} or more",
        here.compared
    );
    Ok(here.compared)
}

fn done(reply: &Reply) -> Result<()> {
    ensure!(*reply == Reply::Done, "a strange reply to an order");
    Ok(())
}

/// The signal path here, which goes on from the board's first sample and from each before which others were left out.
#[derive(Default)]
struct Here {
    state: StepState,
    before: Option<u32>,
    compared: usize,
}

impl Here {
    fn compare(&mut self, config: &StepConfig, sample: &Sample) -> Result<()> {
        // All channels of every sample are more than the board has time to send: what was left out begins anew.
        let follows = self.before.replace(sample.sequence) == Some(sample.sequence.wrapping_sub(1));
        if !follows {
            self.state.begin();
        }
        let frame = step(config, &mut self.state, &raw(sample)?);
        if !follows {
            let teeth = sample.unmodified.map(|all| all.map(|one| one.teeth));
            self.state.set_teeth(teeth.context("no tooth counts")?);
            return Ok(());
        }
        self.compared += 1;
        let (there, here) = (bits_there(sample)?, bits_here(&frame));
        ensure!(
            there == here,
            "sample {}: found {sample:?} on the board, and here {frame:?}",
            sample.sequence
        );
        Ok(())
    }
}

fn raw(sample: &Sample) -> Result<RawFrame> {
    let (quadrature_counts, electrode_counts) = sample.raw.context("no raw counts")?;
    Ok(RawFrame {
        quadrature_counts,
        electrode_counts,
        temperature_delta_k: sample.temperature_delta_k.context("no temperature")?,
        fault: Status::empty(),
    })
}

fn bits_there(sample: &Sample) -> Result<Vec<u32>> {
    let all = || {
        let pose = sample.pose?;
        let mut bits = vec![sample.status?.bits(), sample.parity_m?.to_bits()];
        bits.extend(coordinates(&sample.unmodified?));
        bits.extend(coordinates(&sample.calibrated?));
        bits.extend(coordinates(&[pose.x, pose.y]));
        let angles = [pose.theta_x_rad, pose.theta_y_rad, pose.theta_rad];
        bits.extend(angles.map(f32::to_bits));
        bits.extend(sample.amplitude_counts?.map(f32::to_bits));
        bits.extend(sample.tan_psi?.map(f32::to_bits));
        Some(bits)
    };
    all().context("a channel was not sent")
}

fn bits_here(frame: &Frame) -> Vec<u32> {
    let (pose, segments) = (frame.pose, frame.segments);
    let mut bits = vec![frame.status.bits(), frame.parity_m.to_bits()];
    bits.extend(coordinates(&segments.map(|segment| segment.unmodified)));
    bits.extend(coordinates(&segments.map(|segment| segment.calibrated)));
    bits.extend(coordinates(&[pose.x, pose.y]));
    let angles = [pose.theta_x_rad, pose.theta_y_rad, pose.theta_rad];
    bits.extend(angles.map(f32::to_bits));
    bits.extend(segments.map(|segment| segment.amplitude_counts.to_bits()));
    bits.extend(frame.tan_psi.map(f32::to_bits));
    bits
}

fn coordinates(all: &[Coordinate]) -> impl Iterator<Item = u32> + '_ {
    all.iter()
        .flat_map(|one| [one.teeth.cast_unsigned(), one.fraction_turns.to_bits()])
}
