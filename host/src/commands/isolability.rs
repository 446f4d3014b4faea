//! `courier isolability`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::isolability::{Isolability, Motion, Question, analyse};
use crate::terminal::table;
use anyhow::{Result, ensure};
use courier_sensor::geometry::Geometry;
use std::process::ExitCode;

/// Tell, before anything moves, what a planned self-motion can identify and what not.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  courier isolability                                   lateral terms from g_p alone: the paper's failure\n  courier isolability --beacon --turn-deg 1.5 --json    both sensors together"
)]
pub struct Args {
    /// How poses are chosen.
    #[arg(long, value_enum, default_value = "random")]
    plan: PlanName,
    /// Number of poses.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=20_000))]
    poses: u32,
    /// Turn about the coordination sensor under a beacon; without, only the parity is there.
    #[arg(long)]
    beacon: bool,
    /// Largest angle to either side, degrees [default: 0.5, under a beacon 1.5].
    #[arg(long, value_name = "DEGREES")]
    turn_deg: Option<f32>,
    /// Range in x and y, tooth pitches [default: 10, under a beacon 2].
    #[arg(long, value_name = "PITCHES")]
    travel: Option<f32>,
    /// Noise of a pose's averaged readings, micrometres.
    #[arg(long, value_name = "MICROMETRES", default_value_t = 1.0)]
    noise_um: f32,
    /// Lateral offset l_o of the segments, millimetres.
    #[arg(long, value_name = "MILLIMETRES", default_value_t = 1.0e3 * Geometry::PAPER.lateral_m)]
    lateral_mm: f32,
    /// Count the diode's own errors among the unknowns.
    #[arg(long)]
    sensor_terms: bool,
    /// Seed of the pose generator.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier isolability`", &["parameters", "angles"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum PlanName {
    Random,
    Optimal,
}

/// Analyses and prints.
///
/// # Errors
/// A number out of range.
pub fn run(args: &Args) -> Result<ExitCode> {
    let answer = answer(args)?;
    args.json.tell(ANSWER, &answer, || report(&answer))?;
    Ok(ExitCode::SUCCESS)
}

/// Analyses.
///
/// # Errors
/// As [`run`].
pub fn answer(args: &Args) -> Result<Isolability> {
    Ok(analyse(&args.question()?))
}

impl Args {
    fn question(&self) -> Result<Question> {
        let (turn_deg, travel) = if self.beacon { (1.5, 2.0) } else { (0.5, 10.0) };
        let turn_deg = within("--turn-deg", self.turn_deg.unwrap_or(turn_deg), 0.0, 2.8)?;
        let travel = within("--travel", self.travel.unwrap_or(travel), 1.0, 100.0)?;
        let noise_um = within("--noise-um", self.noise_um, 1.0e-4, 1.0e3)?;
        let lateral_mm = within("--lateral-mm", self.lateral_mm, -1000.0, 1000.0)?;
        let geometry = Geometry {
            lateral_m: 1.0e-3 * lateral_mm,
            ..Geometry::PAPER
        };
        let motion = Motion {
            poses: self.poses,
            travel_m: travel * geometry.pitch_m,
            turn_rad: turn_deg.to_radians(),
            beacon: self.beacon,
            chosen: self.plan == PlanName::Optimal,
            seed: self.seed,
        };
        Ok(Question {
            geometry,
            motion,
            noise_m: 1.0e-6 * noise_um,
            sensor_terms: self.sensor_terms,
        })
    }
}

fn within(name: &str, value: f32, low: f32, high: f32) -> Result<f32> {
    ensure!(
        (low..=high).contains(&value),
        "{name}: found {value}, wanted {low} to {high}"
    );
    Ok(value)
}

/// The answer in words.
pub fn report(answer: &Isolability) -> String {
    let parameters: Vec<Vec<String>> = answer
        .parameters
        .iter()
        .map(|p| {
            let alone = p
                .deviation
                .map_or("undetermined".to_owned(), |d| quantity(d, p.unit));
            vec![
                p.name.clone(),
                alone,
                quantity(p.deviation_with_prior, p.unit),
                p.rests_on.to_owned(),
            ]
        })
        .collect();
    let angles: Vec<Vec<String>> = answer
        .angles
        .iter()
        .map(|a| {
            vec![
                a.group.clone(),
                a.other.clone(),
                format!("{:.2}°", a.angle_deg),
            ]
        })
        .collect();
    let condition = answer
        .condition_number
        .map_or("none: some directions are undetermined".to_owned(), |c| {
            format!("{c:.1}")
        });
    let mut text = format!(
        "{}\n\ncondition number (columns equally long): {condition}\nundetermined directions: {}\n",
        table(
            &["unknown", "by the poses", "with prior", "rests on"],
            &parameters
        ),
        answer.undetermined_directions
    );
    text.push_str("\nno motion tells, chosen by convention:\n");
    for line in &answer.gauge {
        text.push_str(&format!("  {line}\n"));
    }
    text.push_str(&format!(
        "\nsmallest angle between groups (0° is the same)\n{}\n",
        table(&["group", "from", "angle"], &angles)
    ));
    text.push_str(&remedies(answer));
    text.push_str(&needed(answer));
    text.push_str("\nanother speed: no unknown of this model depends on it, so none would help\n");
    text
}

fn needed(answer: &Isolability) -> String {
    let Some(needed) = answer.needed else {
        return "\nnot every coefficient is determined: no number of poses of this kind is enough\n".into();
    };
    let poses = needed
        .poses
        .map_or("more than a million".to_owned(), |poses| poses.to_string());
    format!(
        "\ncoefficients: {} rms; {poses} poses of this kind do what 1000 random ones within 2 pitches and ±1.5° under a beacon do ({} rms);\nno motion does it with fewer than {} poses of this noise: fewer need more frames averaged at each\n",
        quantity(needed.coefficients_m, "m"),
        quantity(needed.reference_m, "m"),
        needed.least_of_any_motion
    )
}

fn remedies(answer: &Isolability) -> String {
    if answer.remedies.is_empty() {
        return "\nno group is closer than 3° to the others: this motion tells all apart\n".into();
    }
    let rows: Vec<Vec<String>> = answer
        .remedies
        .iter()
        .map(|r| {
            let deviation =
                |d: Option<f64>| d.map_or("undetermined".to_owned(), |d| quantity(d, "m"));
            vec![
                r.group.clone(),
                r.change.clone(),
                format!("{:.2}° -> {:.2}°", r.angle_deg, r.angle_after_deg),
                format!(
                    "{} -> {}",
                    deviation(r.deviation),
                    deviation(r.deviation_after)
                ),
            ]
        })
        .collect();
    format!(
        "\ncannot be told apart on this motion, and what would part them\n{}\n",
        table(&["group", "change", "angle", "worst deviation"], &rows)
    )
}

fn quantity(value: f64, unit: &str) -> String {
    match unit {
        "m" => format!("{:.3} µm", value * 1e6),
        "rad" => format!("{:.3} mrad", value * 1e3),
        // Of the gain, or of the deflection at full scale.
        _ => format!("{:.3} %", value * 1e2),
    }
}
