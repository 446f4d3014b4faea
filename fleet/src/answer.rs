//! What many recordings tell together, and what each told by itself.

use crate::connected::groups;
use crate::functions::{Cells, Function, own_functions_of, value, visited, visited_by_segments};
use crate::homogeneity::{Fits, fits};
use crate::judge::held_out_m;
use crate::key::{Key, Name, Platen, SPAN, SPANS_APART};
use crate::lines::{Lines, share_of_mean, straight_of};
use crate::member::Member;
use crate::passes::Fitted;
use crate::separated::{self, CellAnswer, WaveAnswer};
use crate::shown::Spent;
use crate::solve::{Posterior, solve};
use crate::state::State;
use crate::sums::noise_in_force;
use crate::told::Told;
use anyhow::Result;
use courier_sensor::frame::SEGMENTS;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordingAnswer {
    /// Its name.
    pub recording: Name,
    /// Its courier.
    pub courier: Name,
    /// Its platen.
    pub platen: Platen,
    /// Poses fitted.
    pub poses: usize,
    /// Poses held out.
    pub held_out_poses: usize,
    /// Teeth along x and y by which the platen's count is ahead.
    pub shift_teeth: [i32; 2],
    /// Rms of g_p, g_x, g_y at held-out poses without a field, m.
    pub plain_m: [f64; 3],
    /// The same with the field that this recording alone tells.
    pub alone_m: [f64; 3],
    /// The same with what all of them tell.
    pub fleet_m: [f64; 3],
    /// Noise of a segment and of a displacement that the poses show, m.
    pub noise_m: [f64; 2],
}

/// A courier.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CourierAnswer {
    /// Its name.
    pub courier: Name,
    /// Its recordings.
    pub recordings: usize,
    /// How well it fits the fields that it shares with other couriers.
    pub fits: Fits,
    /// Predicted deviation of its own waves, equations (3) and (9), rms over a tooth and the segments, m: the value is the waves' own rms.
    pub waves_m: Told,
    /// Each of these waves.
    pub waves: Vec<WaveAnswer>,
    /// Predicted covariance of the waves' amplitudes, m²: by wave, the sine before the cosine.
    pub covariance_m2: Vec<Vec<f64>>,
    /// What both spans are longer by than stated, less the mean of all couriers that are connected with it, m.
    pub span_m: Told,
    /// What the span of segments 1 and 3 is longer by than the other, less that mean, m.
    pub spans_apart_m: Told,
}

/// A platen under a beacon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlatenAnswer {
    /// Its name and the beacon's.
    pub platen: Platen,
    /// Recordings over it.
    pub recordings: usize,
    /// Couriers that crossed it.
    pub couriers: usize,
    /// Cells of both fields over which a segment was.
    pub cells: usize,
    /// The most of them that one recording has.
    pub cells_alone: usize,
    /// Displacement of the teeth, rms over these cells and less its plane, m; deviations are rms as well, alone over that recording's own cells.
    pub field_m: Told,
    /// The same cell by cell.
    pub field: Vec<CellAnswer>,
    /// Pitch of x over that of y, less one, over the cells and less the mean of all platens that are connected. By itself a platen is not told: a
    /// diode's axes that differ so look the same. The deviation before the data is that of rulings alone, and the deviation by one recording that of
    /// the platen's own number.
    pub pitch_difference: Told,
    /// By how much the lines of x and those of y meet at less than a right angle, rad; the same.
    pub out_of_square_rad: Told,
}

/// All of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// By courier.
    pub couriers: Vec<CourierAnswer>,
    /// By platen and beacon.
    pub platens: Vec<PlatenAnswer>,
    /// By recording.
    pub recordings: Vec<RecordingAnswer>,
    /// Unknowns of the whole.
    pub unknowns: usize,
    /// Steps until it settled.
    pub steps: u32,
    /// Whether it settled.
    pub is_settled: bool,
    /// What no recording of this kind tells.
    pub gauge: Vec<&'static str>,
}

/// What the equations leave open whatever is recorded.
const GAUGE: &[&str] = &[
    "a field's mean and the beacon's place",
    "the common pitch of both rulings, the beacon's height and the lever arms: a known length tells it",
    "the mean of a pair's offsets and the beacon's place",
    "the mean of the platens' angles between their lines, and of their pitches of x over y: diodes whose axes are so look the same",
    "the mean of the couriers' spans over a platen, of the difference of both, and the bow of its lines: lines seem bent where the angle is off in scale",
];

/// One recording by itself.
struct Alone {
    state: State,
    posterior: Posterior,
    cells: [Cells; 2],
}

/// Judges a fit.
///
/// # Errors
/// A recording by itself makes no positive matrix.
pub fn answer(members: &[Member], fitted: &Fitted) -> Result<Answer> {
    let one = |(member, sums): (&Member, &crate::Sums)| -> Result<Alone> {
        let of_it = BTreeMap::from([(member.platen.clone(), sums.clone())]);
        let solution = solve(&of_it, &fitted.state, 0.0)?;
        Ok(Alone {
            state: solution.stepped(&fitted.state),
            posterior: solution.posterior,
            cells: visited(member, &fitted.state),
        })
    };
    let pairs: Vec<_> = members.iter().zip(&fitted.sums).collect();
    let alone: Vec<Alone> = pairs.into_par_iter().map(one).collect::<Result<_>>()?;
    let view = View {
        members,
        fitted,
        alone: &alone,
        groups: groups(members),
        lines: Lines::of(members, fitted),
    };
    let unknowns: usize = fitted.solution.steps.len();
    Ok(Answer {
        couriers: view.couriers(),
        platens: view.platens(),
        recordings: (0..members.len()).map(|i| view.recording(i)).collect(),
        unknowns,
        steps: fitted.state.steps,
        is_settled: fitted.is_settled(),
        gauge: GAUGE.to_vec(),
    })
}

struct View<'a> {
    members: &'a [Member],
    fitted: &'a Fitted,
    alone: &'a [Alone],
    /// A number for each member, the same for those that are connected.
    groups: Vec<usize>,
    /// What is asked of each platen's lines.
    lines: Lines,
}

impl View<'_> {
    fn posterior(&self) -> &Posterior {
        &self.fitted.solution.posterior
    }

    fn recording(&self, i: usize) -> RecordingAnswer {
        let member = &self.members[i];
        let noise = noise_in_force(member, &self.fitted.state);
        RecordingAnswer {
            recording: member.recording.clone(),
            courier: member.courier.clone(),
            platen: member.platen.clone(),
            poses: member.poses.len(),
            held_out_poses: member.held_out.len(),
            shift_teeth: self.fitted.state.shift_teeth(&member.recording),
            plain_m: held_out_m(member, &self.fitted.beginnings[i].plain),
            alone_m: held_out_m(member, &self.alone[i].state),
            fleet_m: held_out_m(member, &self.fitted.state),
            noise_m: [noise.segment_m, noise.displacement_m],
        }
    }

    /// Numbers of the members that a test holds of.
    fn those(&self, is_one: impl Fn(&Member) -> bool) -> Vec<usize> {
        (0..self.members.len())
            .filter(|i| is_one(&self.members[*i]))
            .collect()
    }

    fn couriers(&self) -> Vec<CourierAnswer> {
        let names: BTreeSet<&Name> = self.members.iter().map(|m| &m.courier).collect();
        let spent = Spent::of(self.posterior().shares_left());
        let of_one = |name: &Name| {
            let of = self.those(|member| member.courier == *name);
            let first = &self.members[of[0]];
            let [_, _, _, _, (_, span_m), (_, apart_m), _] = crate::state::further(first);
            let (waves, covariance_m2) =
                separated::waves(&self.fitted.state, self.posterior(), first);
            CourierAnswer {
                courier: name.clone(),
                recordings: of.len(),
                fits: fits(self.members, self.fitted, &spent, &of),
                waves_m: self.waves(&of),
                waves,
                covariance_m2,
                span_m: self.less_mean(&of, SPAN, span_m),
                spans_apart_m: self.less_mean(&of, SPANS_APART, apart_m),
            }
        };
        names.into_iter().map(of_one).collect()
    }

    /// Numbers of the members that are connected with one.
    fn connected(&self, with: usize) -> impl Iterator<Item = &Member> {
        let pairs = self.members.iter().zip(&self.groups);
        let group = self.groups[with];
        pairs
            .filter(move |(_, of)| **of == group)
            .map(|(member, _)| member)
    }

    /// One of a courier's unknowns less the mean of all that are connected with it.
    fn less_mean(&self, of: &[usize], which: u16, prior: f64) -> Told {
        let names: BTreeSet<&Name> = self.connected(of[0]).map(|m| &m.courier).collect();
        let own = &self.members[of[0]];
        let share = share_of_mean(names.len());
        let function: Function = names
            .into_iter()
            .map(|name| {
                let own = f64::from(u8::from(*name == own.courier));
                (Key::Courier(name.clone(), which), own - share)
            })
            .collect();
        let alone = [(Key::Courier(own.courier.clone(), which), 1.0)];
        let alone = of.iter().map(|i| {
            let posterior = &self.alone[*i].posterior;
            posterior.deviation(&self.members[*i].platen, &alone)
        });
        Told {
            value: value(&self.fitted.state, &own.platen, &function),
            deviation: self.posterior().deviation(&own.platen, &function),
            alone: alone.fold(f64::INFINITY, f64::min),
            prior,
        }
    }

    fn waves(&self, of: &[usize]) -> Told {
        let functions = own_functions_of(&self.members[of[0]]);
        // A wave's mean square is half that of its amplitude.
        let rms = |deviation: &dyn Fn(&Function) -> f64| {
            let squares: f64 = functions.iter().map(|f| deviation(f).powi(2)).sum();
            (0.5 * squares / SEGMENTS as f64).sqrt()
        };
        let by = |i: usize, posterior: &Posterior| {
            rms(&|f| posterior.deviation(&self.members[i].platen, f))
        };
        let alone = of.iter().map(|i| by(*i, &self.alone[*i].posterior));
        let state = &self.fitted.state;
        let prior = |f: &Function| {
            state
                .sensors
                .get(&f[0].0)
                .map_or(0.0, |(_, prior)| prior.deviation)
        };
        Told {
            value: rms(&|f| value(state, &Platen::default(), f)),
            deviation: by(of[0], self.posterior()),
            alone: alone.fold(f64::INFINITY, f64::min),
            prior: rms(&prior),
        }
    }

    fn platens(&self) -> Vec<PlatenAnswer> {
        let names: BTreeSet<&Platen> = self.members.iter().map(|m| &m.platen).collect();
        names.into_iter().map(|name| self.platen(name)).collect()
    }

    fn platen(&self, name: &Platen) -> PlatenAnswer {
        let of = self.those(|member| member.platen == *name);
        let couriers: BTreeSet<&Name> = of.iter().map(|i| &self.members[*i].courier).collect();
        let count = |cells: &[Cells; 2]| cells[0].len() + cells[1].len();
        let mut all = [Cells::new(), Cells::new()];
        for i in &of {
            all.iter_mut()
                .zip(&self.alone[*i].cells)
                .for_each(|(all, own)| all.extend(own));
        }
        let state = &self.fitted.state;
        let lattice = state.unknowns(&self.members[of[0]]).lattice();
        let field = separated::cells(state, self.posterior(), name, lattice, &all);
        PlatenAnswer {
            platen: name.clone(),
            recordings: of.len(),
            couriers: couriers.len(),
            cells: count(&all),
            cells_alone: of
                .iter()
                .map(|i| count(&self.alone[*i].cells))
                .max()
                .unwrap_or(0),
            field_m: self.field(name, &of, &field),
            field,
            pitch_difference: self.straight(name, &of, 0),
            out_of_square_rad: self.straight(name, &of, 1),
        }
    }

    /// One of the straight parts of a platen's lines, less the mean of all platens that are connected with it.
    fn straight(&self, name: &Platen, of: &[usize], which: usize) -> Told {
        let names: BTreeSet<&Platen> = self.connected(of[0]).map(|m| &m.platen).collect();
        let alone = of.iter().filter_map(|i| {
            let (member, alone) = (&self.members[*i], &self.alone[*i]);
            let cells = visited_by_segments(member, &self.fitted.state);
            let functions = straight_of(member, &self.fitted.state, &cells)?;
            Some(alone.posterior.deviation(name, &functions[which]))
        });
        Told {
            alone: alone.fold(f64::INFINITY, f64::min),
            ..self.lines.less_mean(self.fitted, name, &names, which)
        }
    }

    /// The rms of a field's cells, all recordings together, and by the best of some alone over its own cells.
    fn field(&self, name: &Platen, of: &[usize], together: &[CellAnswer]) -> Told {
        let unknowns = self.fitted.state.unknowns(&self.members[of[0]]);
        let rms = |cells: &[CellAnswer], of_one: &dyn Fn(&CellAnswer) -> f64| {
            let squares: f64 = cells.iter().map(|cell| of_one(cell).powi(2)).sum();
            (squares / cells.len().max(1) as f64).sqrt()
        };
        let deviation = |cells: &[CellAnswer]| rms(cells, &|cell| cell.deviation_m);
        let alone = of.iter().map(|i| {
            let Alone {
                state,
                posterior,
                cells,
            } = &self.alone[*i];
            let lattice = unknowns.lattice();
            deviation(&separated::cells(state, posterior, name, lattice, cells))
        });
        Told {
            value: rms(together, &|cell| cell.displacement_m),
            deviation: deviation(together),
            alone: alone.fold(f64::INFINITY, f64::min),
            prior: unknowns.field_prior_m(),
        }
    }
}
