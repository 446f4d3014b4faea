//! `courier record --until-answers`.

use super::record::{Args, SURVEY_DECIMATION};
use crate::board::Choice;
use crate::capture::{
    Answer, ByHand, Capture, Commanded, Ending, Mover, Order, SimulatedHand, Step,
};
use crate::destination::Destination;
use crate::findings::{self, NOTHING};
use crate::interrupt::{self, EXIT_INTERRUPTED};
use crate::output::Kind;
use crate::recorder::{Recorded, Recorder};
use crate::recordings;
use crate::terminal::{print, progress};
use anyhow::{Result, ensure};
use effects::motion::Pose;
use guided::motion::Area;
use guided::question::Question;
use serde::Serialize;
use std::process::ExitCode;

/// What `--json` writes.
const ANSWER: Kind = Kind::json(
    "an answer of `courier record --until-answers`",
    &["question", "ending"],
);

/// What is told at the end.
#[derive(Serialize)]
struct Told<'a> {
    #[serde(flatten)]
    recorded: Recorded,
    #[serde(flatten)]
    answer: &'a Answer,
}

/// Moves, records and tells.
///
/// # Errors
/// The board cannot be reached or refuses a motion, or the folder cannot be written.
pub fn run(args: &Args, question: Question, choice: &Choice) -> Result<ExitCode> {
    ensure!(
        (5.0..=3600.0).contains(&args.most_seconds),
        "--most-seconds: found {}, wanted 5 to 3600",
        args.most_seconds
    );
    let mut board = choice.open()?;
    let about = Pose {
        x_m: args.about.x_m.into(),
        y_m: args.about.y_m.into(),
        theta_rad: args.about.theta_rad.into(),
    };
    let order = Order {
        question,
        area: Area::of_survey(about),
        most_seconds: args.most_seconds,
    };
    let to = Destination {
        folder: args.folder.clone(),
        force: args.force,
    };
    interrupt::watch()?;
    let decimation = args.decimation.unwrap_or(SURVEY_DECIMATION);
    let mut recorder =
        Recorder::begin(&mut board.link, board.world.as_ref(), &to, decimation, true)?;
    recorder.state_surroundings(&args.platen_id, &args.beacon_id);
    recorder.know_noise(&mut board.link, args.noise_counts)?;
    let printed = args.json.is_printed();
    let mut mover: Box<dyn Mover> = if args.by_hand {
        let hand = board
            .world
            .as_ref()
            .map(|world| SimulatedHand::new(world.truth().pose, choice.seed()));
        Box::new(ByHand::new(hand, printed))
    } else {
        Box::<Commanded>::default()
    };
    let bar = progress(0, "recording: samples");
    let mut tell = |step: &Step| {
        if printed {
            return Ok(());
        }
        bar.suspend(|| print(&step.text()))
    };
    let answer =
        Capture::new(&order, &mut recorder, &mut *mover).run(&mut board.link, &bar, &mut tell)?;
    bar.finish_and_clear();
    let recorded = recorder.finish()?;
    board.close()?;
    let told = Told {
        recorded,
        answer: &answer,
    };
    args.json.tell(ANSWER, &told, || {
        format!(
            "{}\n{} samples in {}, {} could not be taken",
            answer.text(),
            recorded.samples,
            args.folder.display(),
            recorded.lost
        )
    })?;
    let place = args.folder.display().to_string();
    findings::check(&recordings::read(&args.folder)?, &place, NOTHING)?;
    Ok(match answer.ending {
        Ending::Answered | Ending::Partly => ExitCode::SUCCESS,
        Ending::Interrupted => ExitCode::from(EXIT_INTERRUPTED),
        _ => ExitCode::FAILURE,
    })
}
