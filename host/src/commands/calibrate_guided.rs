//! What `courier calibrate --guided` does beside the session: as many poses as the question needs, and what they have told so far.

use crate::isolability::{Course, Motion, Question, Told, analyse};
use crate::terminal::figure;
use anyhow::{Result, ensure};
use courier_sensor::calibration::record::Method;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::CalibrateOrder;
use serde::Serialize;

/// Noise of a pose's averaged readings, m: the paper's, of every reading (section 3.2.1).
const NOISE_M: f32 = 1.0e-6;
/// Poses of a motion without a choice, by which remedies are compared.
const COMPARED_POSES: u32 = 200;

/// The geometry that a course is foreseen with.
#[derive(Serialize)]
struct Foreseen {
    /// Whether a calibration is in force whose geometry was read. Else it is the firmware's nominal one.
    read: bool,
    #[serde(flatten)]
    geometry: Geometry,
}

/// A calibration's course, foreseen.
#[derive(Serialize)]
pub struct Guide {
    geometry: Foreseen,
    /// Deviation that is wanted, m.
    wanted_m: f64,
    /// Poses after which every group that this motion tells is told to it.
    poses: u32,
    /// What each group is known to then.
    groups: Vec<Told>,
    /// What would tell those that this motion does not.
    remedies: Vec<String>,
    #[serde(skip)]
    course: Course,
    #[serde(skip)]
    said: Vec<String>,
}

impl Guide {
    /// Of an order, which says how many poses there may be at most, and the geometry of the calibration in force, if there is one.
    ///
    /// # Errors
    /// The motion tells no group as well as is wanted.
    pub fn new(
        order: &CalibrateOrder,
        in_force: Option<Geometry>,
        wanted_m: f64,
        least: u16,
    ) -> Result<Self> {
        let geometry = Foreseen {
            read: in_force.is_some(),
            geometry: in_force.unwrap_or(Geometry::PAPER),
        };
        let question = question(order, geometry.geometry);
        let course = Course::new(&question);
        let most = u32::from(order.poses);
        let enough = course.enough(wanted_m).unwrap_or(most);
        let poses = enough.max(least.into()).min(most);
        let groups = course.after(poses).to_vec();
        ensure!(
            groups.iter().any(|told| told.is_within(wanted_m)),
            "--guided: found no group that {most} poses of this motion tell to {} µm, wanted one: a larger --target-um, --turn-deg or --poses",
            figure(1.0e6 * wanted_m)
        );
        Ok(Self {
            geometry,
            remedies: remedies(&question, &course.missed(wanted_m)),
            wanted_m,
            poses,
            groups,
            course,
            said: Vec::new(),
        })
    }

    /// Poses to fit.
    pub fn poses(&self) -> u16 {
        u16::try_from(self.poses).unwrap_or(u16::MAX)
    }

    /// What is planned, before anything moves.
    pub fn plan(&self) -> String {
        let missed = self.course.missed(self.wanted_m);
        let mut lines = vec![
            self.geometry.text(),
            format!(
                "{} poses tell all that this motion tells to ± {} µm",
                self.poses,
                figure(1.0e6 * self.wanted_m)
            ),
        ];
        lines.extend(
            missed
                .iter()
                .map(|told| format!("not so well: {}", text(told))),
        );
        lines.extend(
            self.remedies
                .iter()
                .map(|remedy| format!("what would: {remedy}")),
        );
        lines.join("\n")
    }

    /// A line for each group that is told well since the last look.
    pub fn look(&mut self, done: u32) -> Vec<String> {
        let mut lines = Vec::new();
        for told in self.course.after(done) {
            if told.is_within(self.wanted_m) && !self.said.contains(&told.group) {
                self.said.push(told.group.clone());
                lines.push(format!("{done:4} poses: {}, determined", text(told)));
            }
        }
        lines
    }
}

impl Foreseen {
    fn text(&self) -> String {
        let Geometry {
            span_m,
            lateral_m,
            height_m,
            lever_m,
            ..
        } = self.geometry;
        let [span, lateral, height, lever_x, lever_y] =
            [span_m, lateral_m, height_m, lever_m[0], lever_m[1]]
                .map(|m| figure(1.0e3 * f64::from(m)));
        let whose = if self.read {
            "of the calibration in force"
        } else {
            "of the drawing, since no calibration is in force"
        };
        format!(
            "foreseen with the geometry {whose}: span {span} mm, lateral offset {lateral} mm, height {height} mm, lever arm {lever_x} and {lever_y} mm"
        )
    }
}

fn text(told: &Told) -> String {
    let deviation = told.deviation_m.map_or("undetermined".to_owned(), |m| {
        format!("± {} µm", figure(1.0e6 * m))
    });
    format!("{} {deviation}", told.group)
}

fn question(order: &CalibrateOrder, geometry: Geometry) -> Question {
    Question {
        geometry,
        motion: Motion {
            poses: order.poses.into(),
            travel_m: order.travel_m,
            turn_rad: order.turn_rad,
            beacon: order.method == Method::Joint,
            chosen: true,
            seed: order.seed,
        },
        noise_m: NOISE_M,
        sensor_terms: false,
    }
}

/// What would tell the groups that are missed, where a change of the motion does.
fn remedies(question: &Question, missed: &[Told]) -> Vec<String> {
    if missed.is_empty() {
        return Vec::new();
    }
    let compared = Question {
        motion: Motion {
            poses: COMPARED_POSES,
            chosen: false,
            ..question.motion
        },
        ..question.clone()
    };
    let all = analyse(&compared).remedies;
    let of = |told: &Told| {
        let helps = all.iter().filter(|remedy| remedy.group == told.group);
        let best = helps.min_by(|a, b| {
            let after = |m: Option<f64>| m.unwrap_or(f64::INFINITY);
            after(a.deviation_after).total_cmp(&after(b.deviation_after))
        })?;
        let after_m = best.deviation_after?;
        Some(format!(
            "{}: {}, ± {} µm with {COMPARED_POSES} poses",
            told.group,
            best.change,
            figure(1.0e6 * after_m)
        ))
    };
    missed.iter().filter_map(of).collect()
}
