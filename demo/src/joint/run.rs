//! The steps: synthetic problems, then one courier through platen calibration, joint calibration and fly-bys, all of it ordered over
//! the debug link of a board, simulated or emulated.

use super::mapping::map_teeth;
use super::options::JointOptions;
use super::paper_method::{self, PaperFit};
use super::poses::Poses;
use super::report::{JointReport, Method, WithoutMap};
use super::sensitivity;
use super::session::{TRAVEL_M, Until, joint, joint_order};
use super::steps::Step;
use super::synthetic::{self, PROBLEMS};
use crate::Preset;
use crate::flight::{fly_along, stand_at};
use crate::flyby::{Deviations, Flyby};
use anyhow::{Context, Result, bail};
use board_link::{Simulated, map, session};
use courier_sensor::calibration::Evidence;
use courier_sensor::calibration::joint::{JointConfig, Weighting};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::frame::{Frame, Status};
use courier_sensor::link::message::{Action, CalibrateOrder};
use courier_sensor::link::report::{Ending, Progress};
use courier_sensor::model::ErrorModel;
use courier_sensor::settings::Settings;
use effects::motion::Pose;
use hal_sim::trajectory::{BEACON_SPEED_M_S, BEACON_SWEEP_M};
use indicatif::ProgressBar;

/// Everything of 3.2.1.
///
/// # Errors
/// Options that make no courier, a board that does not start, a motion that never ends. A calibration that the firmware
/// refuses is no error: the report says so.
pub fn run(options: &JointOptions, progress: &ProgressBar) -> Result<JointReport> {
    let mut report = JointReport::new(options);
    synthetic_rows(options, &mut report, progress)?;
    let spec = match (options.platen, options.preset) {
        (Some(platen), Preset::Paper) => hal_sim::presets::paper_on_platen(platen),
        (_, preset) => preset.courier(options.seed, None, hal_sim::presets::DEFAULT_RMS_M)?,
    };
    let places = spec.places;
    let mut board = Simulated::start(options.board, spec, options.seed)?;
    if let Err(refusal) = demonstrate(
        &mut board,
        options,
        [places.beacon, places.beacon_sweep],
        &mut report,
        progress,
    )? {
        report.refusal = Some(refusal);
    }
    report.accepted = report.refusal.is_none();
    progress.finish_and_clear();
    Ok(report)
}

fn synthetic_rows(
    options: &JointOptions,
    report: &mut JointReport,
    progress: &ProgressBar,
) -> Result<()> {
    Step::Synthetic.begin(progress, "synthetic problems");
    progress.set_length(2 * PROBLEMS);
    let poses = options.poses.unwrap_or(JointConfig::default().visits.poses);
    let methods = [
        (Method::Here, Weighting::Covariance),
        (Method::Paper, Weighting::Equal),
    ];
    for (column, (method, weighting)) in methods.into_iter().enumerate() {
        let worst = synthetic::worst(options.seed, poses, weighting, || progress.inc(1))?;
        report.synthetic_place_um[column] = 1.0e6 * worst.place_m;
        report.set(method, "height_um", 1.0e6 * worst.height_m);
        report.set(method, "lever_um", 1.0e6 * worst.lever_m);
        report.set(method, "other_um", 1.0e6 * worst.other_m);
    }
    Ok(())
}

/// The courier's part; the inner error is the firmware's refusal.
fn demonstrate(
    board: &mut Simulated,
    options: &JointOptions,
    [beacon, sweep]: [Pose; 2],
    report: &mut JointReport,
    progress: &ProgressBar,
) -> Result<Result<(), String>> {
    let mut platen = CalibrateOrder {
        seed: options.seed,
        ..CalibrateOrder::default()
    };
    platen.poses = options.poses.map_or(platen.poses, |poses| poses as u16); // at most 1000
    Step::Platen.begin(progress, "platen sensor: poses");
    let ended = session::run(board, &platen, session::LOOK, progress, |_, _| Ok(()))?;
    if let Err(refusal) = evidence(&ended)? {
        return Ok(Err(format!("platen sensor: {refusal}")));
    }
    let flight = fly(board, sweep, Step::FlybyBefore, progress)?;
    let [before, separate] = judged(&flight)?;
    let frames: Vec<Frame> = flight.iter().map(|(frame, _)| *frame).collect();
    let calibration = map::in_force(&mut board.link)?;
    let answer = sensitivity::of_pair(&calibration, &frames, 0);
    report.theta_x_answer_uncalibrated = Some(answer);
    for method in [Method::Here, Method::Paper] {
        flight_rows(report, method, Calibrated::Not, &before);
    }
    flight_rows(report, Method::Here, Calibrated::Separately, &separate);

    Step::Joint.begin(progress, "going under the beacon");
    stand_at(board, beacon)?;
    let turn_rad = JointConfig::default().visits.range.turn_rad;
    let order = joint_order(options, TRAVEL_M, turn_rad);
    let (poses, ended) = joint(board, &order, Until::Solved, progress)?;
    report.steps = ended.steps.into_iter().flatten().collect();
    match evidence(&ended)? {
        Ok(evidence) => report.poses = evidence.poses,
        Err(refusal) => return Ok(Err(format!("joint: {refusal}"))),
    }
    let [_, flown] = judged(&fly(board, sweep, Step::FlybyJoint, progress)?)?;
    report.without_map = Some(WithoutMap {
        position_um: 1.0e6 * flown.position_m,
        theta_x_mrad: 1.0e3 * flown.theta_x_rad,
        theta_y_mrad: 1.0e3 * flown.theta_y_rad,
    });
    map_teeth(board, options, poses.teeth, beacon, report, progress)?;
    joint_rows(board, sweep, report, progress)?;
    // The paper's motion, for its method: the map out of force leaves the processor its time for session and stream at once.
    Step::PaperMethod.begin(progress, "the paper's method");
    board.link.ask(Action::MapDrop)?;
    stand_at(board, beacon)?;
    let travel_m = JointConfig::default().visits.range.travel_m;
    let order = joint_order(options, travel_m, turn_rad);
    let (poses, _) = joint(board, &order, Until::Visited, progress)?;
    paper_rows(board, &poses, sweep, report, progress)?;
    Ok(Ok(()))
}

/// This system's rows: residuals and flight by the calibration and the tooth map now in force.
fn joint_rows(
    board: &mut Simulated,
    sweep: Pose,
    report: &mut JointReport,
    progress: &ProgressBar,
) -> Result<()> {
    let step = report
        .steps
        .iter()
        .rfind(|step| step.accepted)
        .context("an accepted calibration without a step")?;
    let without_map_m = step.after.rms_m.map(f64::from);
    let residuals_m = report.map.map_or(without_map_m, |map| map.after_m);
    residual_rows(report, Method::Here, residuals_m);
    let flight = fly(board, sweep, Step::FlybyMap, progress)?;
    let is_outside = |(frame, _): &&(Frame, Pose)| frame.status.contains(Status::OUTSIDE_MAP);
    let outside = flight.iter().filter(is_outside).count();
    report.outside_map = Some(outside as f64 / flight.len().max(1) as f64);
    let [_, here] = judged(&flight)?;
    flight_rows(report, Method::Here, Calibrated::Jointly, &here);
    Ok(())
}

/// The paper's method on the same poses, loaded into the same board.
fn paper_rows(
    board: &mut Simulated,
    poses: &Poses,
    sweep: Pose,
    report: &mut JointReport,
    progress: &ProgressBar,
) -> Result<()> {
    progress.set_message("the paper's method");
    let PaperFit {
        separate,
        joint,
        geometry,
        residuals_m,
    } = paper_method::fit(&poses.buffer, &Settings::default().geometry)?;
    residual_rows(report, Method::Paper, residuals_m);
    let here = map::in_force(&mut board.link)?;
    let mut with = |model: ErrorModel| -> Result<Deviations> {
        let calibration = Calibration {
            model,
            geometry,
            ..here.clone()
        };
        map::load(&mut board.link, calibration)?;
        let [_, calibrated] = judged(&fly(board, sweep, Step::PaperMethod, progress)?)?;
        Ok(calibrated)
    };
    let separate = with(separate)?;
    flight_rows(report, Method::Paper, Calibrated::Separately, &separate);
    let joint = with(joint)?;
    flight_rows(report, Method::Paper, Calibrated::Jointly, &joint);
    Ok(())
}

fn residual_rows(report: &mut JointReport, method: Method, [g_p, g_x, g_y]: [f64; 3]) {
    for (name, residual_m) in [
        ("g_x_residual_um", g_x),
        ("g_y_residual_um", g_y),
        ("g_p_residual_um", g_p),
    ] {
        report.set(method, name, 1.0e6 * residual_m);
    }
}

/// Which calibration a flight is flown with.
#[derive(Clone, Copy)]
enum Calibrated {
    /// None.
    Not,
    /// Each sensor by itself.
    Separately,
    /// Both together; this system's method with the tooth map, where one is in force.
    Jointly,
}

fn flight_rows(report: &mut JointReport, method: Method, how: Calibrated, flown: &Deviations) {
    let [position, theta_x, theta_y] = match how {
        Calibrated::Not => [
            "position_uncalibrated_um",
            "theta_x_uncalibrated_mrad",
            "theta_y_uncalibrated_mrad",
        ],
        Calibrated::Separately => [
            "position_separate_um",
            "theta_x_separate_mrad",
            "theta_y_separate_mrad",
        ],
        Calibrated::Jointly => [
            "position_joint_um",
            "theta_x_joint_mrad",
            "theta_y_joint_mrad",
        ],
    };
    report.set(method, position, 1.0e6 * flown.position_m);
    report.set(method, theta_x, 1.0e3 * flown.theta_x_rad);
    report.set(method, theta_y, 1.0e3 * flown.theta_y_rad);
}

/// What the board rests its result on; the inner error says why it has none that it keeps.
fn evidence(ended: &Progress) -> Result<Result<Evidence, String>> {
    Ok(match ended.ending {
        Some(Ending::Accepted { evidence, .. }) => Ok(evidence),
        Some(Ending::Refused { refusal, .. }) => Err(refusal.to_string()),
        Some(Ending::NotKept { refusal, .. }) => Err(format!("accepted, but not kept: {refusal}")),
        None => bail!("the session has ended without a result"),
    })
}

/// 8 mm along y at 20 mm/s through the place under the beacon.
fn fly(
    board: &mut Simulated,
    sweep: Pose,
    step: Step,
    progress: &ProgressBar,
) -> Result<Vec<(Frame, Pose)>> {
    step.begin(progress, "flying by under the beacon");
    let flight = fly_along(board, sweep, BEACON_SWEEP_M, BEACON_SPEED_M_S as f32)?;
    Ok(flight
        .into_iter()
        .map(|(frame, witness)| (frame, witness.reference))
        .collect())
}

/// By the platen sensor's outputs, unmodified and calibrated.
fn judged(flight: &[(Frame, Pose)]) -> Result<[Deviations; 2]> {
    let geometry = Settings::default().geometry;
    let mut flyby = Flyby::new(f64::from(geometry.pitch_m), f64::from(geometry.span_m));
    flight
        .iter()
        .for_each(|(frame, reference)| flyby.add(frame, reference));
    flyby.deviations().with_context(|| {
        format!(
            "the fly-by gave {} places, wanted 2 or more",
            flyby.places()
        )
    })
}
