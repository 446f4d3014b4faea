//! The search: which faults, if any, make the readings agree with one another and with what is stated.

mod otherwise;

use crate::diode::{Diode, RELATIVE_ERROR};
use crate::fault::{Fault, LENGTHS, Source};
use crate::fitted::Fitted;
use crate::poses::Poses;
use crate::products::Products;
use crate::quadrature::Reading;
use crate::readings::Readings;
use crate::view::{CLOSURE_RATIO, CLOSURE_TOLERANCE, View};
use crate::wiring::Wiring;
use nalgebra::DVector;
use recording::Recording;

/// Up to this share a parity is right if no other wiring's is far smaller. A prior: the parity of an uncalibrated sensor is 29.3
/// µm (paper, 3.1.2), 0.03 of the pitch, and three times that may still be one.
const LARGEST_PARITY: f64 = 0.1;
/// A pair's angle beyond this, rms, rad, is no angle. A prior: "a rotation capability of a few degrees" (paper, section 1), of
/// which this is 3.4, and no teeth are seen at more than a pitch over a segment's length (some six teeth: 0.15 rad).
const ANGLE_RAD: f64 = 0.06;
/// Nothing on a platen is faster, m/s. A prior: ten times a planar motor's speed, so that only a wrong unit is beyond.
const SPEED_M_S: f64 = 20.0;
/// No segment is more exact than this, m: what is left of a calibrated one (paper, table of 3.2.1).
const ERROR_FLOOR_M: f64 = 2.0e-6;
/// What a response that nothing explains costs: more than one fault, less than two. Derived from the costs of faults
/// (`Fault::cost`), which are 0.9 to 1.4.
const UNEXPLAINED_COST: f64 = 1.5;
/// Explanations whose costs differ by less are equally good: below the least cost of a fault.
const COST_TOLERANCE: f64 = 0.15;

/// Faults that together make the readings agree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Explanation {
    /// The faults; none if all is as stated.
    pub faults: Vec<Fault>,
    /// Their cost, with what stays unexplained.
    pub cost: f64,
    /// Responses of the reference or the diode that stay unexplained.
    pub unexplained: usize,
    /// Responses that move enough to be looked at.
    pub told: usize,
    /// Those that are explained.
    pub explained: usize,
}

/// All relations of one way to read the recording.
pub(crate) struct Relations {
    readings: Readings,
    parity: Option<Products>,
    smallest_parity_m: f64,
    /// Another way to read sine and cosine leaves far less against the reference.
    misread: bool,
    speed_m_s: f64,
    reference: Option<Poses>,
    commanded: Option<Poses>,
    diode: Option<Diode>,
}

impl Relations {
    pub fn new(recording: &Recording, reading: Reading) -> Self {
        let first = Self::of(Readings::new(recording, reading));
        if first.has() != [true; 4] {
            return first;
        }
        let all: Vec<&Vec<f64>> = first.readings.position_m.iter().collect();
        let rows = first.readings.rows_with(&all);
        let best = Wiring::all()
            .into_iter()
            .min_by(|a, b| first.parity_m(a).total_cmp(&first.parity_m(b)));
        let weights = best.unwrap_or_else(Wiring::stated).parity();
        let residual = first.readings.residual(&rows, weights);
        Self::of(first.readings.without_outliers(&residual))
    }

    fn of(readings: Readings) -> Self {
        let all: Vec<&Vec<f64>> = readings.position_m.iter().collect();
        let parity = readings.products(&readings.rows_with(&all), &all);
        let mut relations = Self {
            speed_m_s: speed(&readings),
            reference: Poses::new(&readings, Source::Reference),
            commanded: Poses::new(&readings, Source::Commanded),
            diode: Diode::new(&readings),
            readings,
            parity,
            smallest_parity_m: 0.0,
            misread: false,
        };
        let parities = Wiring::all().into_iter().map(|w| relations.parity_m(&w));
        relations.smallest_parity_m = parities.fold(f64::INFINITY, f64::min);
        relations
    }

    fn has(&self) -> [bool; 4] {
        [0, 1, 2, 3].map(|s| self.readings.has(s))
    }

    /// Parity of a wiring, rms, m; zero where it is not told.
    fn parity_m(&self, wiring: &Wiring) -> f64 {
        let Some(products) = self.parity.as_ref().filter(|_| self.has() == [true; 4]) else {
            return 0.0;
        };
        parity_m(products, wiring)
    }

    /// What periodic errors that were taken out make of a wiring's parity, rms, m.
    fn periodic_m(&self, wiring: &Wiring) -> f64 {
        let Some(products) = self.parity.as_ref().filter(|_| self.has() == [true; 4]) else {
            return 0.0;
        };
        let weights = DVector::from_row_slice(&wiring.parity());
        let removed = &products.centred - &products.projected;
        (removed * &weights).dot(&weights).max(0.0).sqrt()
    }

    /// What periodic errors may do to the parity where there were too few rows to take them out, m: over few phases the rms may be as much
    /// as the peak, which of orders that add up is twice the rms over all.
    fn left_in_m(&self) -> f64 {
        2.0 * self.parity.as_ref().map_or(0.0, |p| p.periodic_m)
    }

    fn possible(&self, view: &View) -> bool {
        if self.misread {
            return false;
        }
        let logged = self.readings.logged.iter().any(|l| *l);
        let longer = if logged { view.lengths.max(1.0) } else { 1.0 };
        let parity_m = self.parity_m(view.wiring);
        let pitch_m = self.readings.pitch_m * longer;
        let least = parity_m <= CLOSURE_RATIO * self.smallest_parity_m
            && parity_m <= LARGEST_PARITY * pitch_m;
        if parity_m > CLOSURE_TOLERANCE * pitch_m + self.left_in_m() && !least {
            return false;
        }
        // A sine in the place of its cosine makes an error as wide as the tooth, which follows the tooth phase as well.
        if self.periodic_m(view.wiring) > LARGEST_PARITY * pitch_m {
            return false;
        }
        if self.speed_m_s / view.lengths > SPEED_M_S {
            return false;
        }
        let angle = view.response(2, 4).zip(self.parity.as_ref());
        angle.is_none_or(|(weights, products)| {
            (&products.centred * &weights).dot(&weights) <= ANGLE_RAD * ANGLE_RAD
        })
    }

    /// What a view of the segments costs, with the scales that its relations suggest; no explanation if the segments contradict one another.
    fn explain(&self, view: &View, faults: &[Fault]) -> (Option<Explanation>, Suggested) {
        let mut suggested = Suggested::default();
        let mut all: Vec<Fault> = view.wiring.faults.clone();
        all.extend_from_slice(faults);
        let (mut unexplained, mut told, mut explained) = (0, 0, 0);
        if let Some(poses) = &self.reference {
            let judged = poses.judge(view);
            unexplained += judged.unexplained;
            told += judged.told;
            explained += judged.explained;
            suggested.add(judged.scales);
            all.extend(judged.faults);
        }
        if let Some(poses) = &self.commanded {
            let judged = poses.judge(view);
            // Commands that follow nothing are left aside.
            if judged.unexplained == 0 {
                suggested.add(judged.scales);
                all.extend(judged.faults);
            }
        }
        if let Some(diode) = &self.diode {
            let judged = diode.judge(view);
            unexplained += judged.unexplained;
            told += judged.told;
            explained += judged.explained;
            suggested
                .lengths
                .extend(judged.height.map(|[scale, _]| scale));
            let stated = self.readings.coordination.map_or(0.0, |c| c.lever_x_m);
            if let Some([lever_m, error_m]) = judged.lever_m[0]
                && error_m < RELATIVE_ERROR * lever_m.abs()
            {
                // A span u times too short makes every angle u times too large and the arm u times too short.
                suggested.span.push(stated / lever_m);
            }
            all.extend(judged.faults);
        }
        let cost = all.iter().map(Fault::cost).sum::<f64>() + UNEXPLAINED_COST * unexplained as f64;
        let explanation = Explanation {
            faults: all,
            cost,
            unexplained,
            told,
            explained,
        };
        (self.possible(view).then_some(explanation), suggested)
    }

    /// The segments by a wiring, with outputs so many times too long and a span so many times the stated one.
    fn view<'a>(&self, wiring: &'a Wiring, lengths: f64, span: f64) -> View<'a> {
        let logged = self.readings.logged.iter().any(|l| *l);
        View {
            wiring,
            has: self.has(),
            inexact_m: self.parity_m(wiring).max(ERROR_FLOOR_M * lengths),
            logged,
            span_m: self.readings.span_m,
            tooth_m: self.readings.pitch_m / if logged { 1.0 } else { lengths },
            lengths,
            span,
        }
    }

    /// What the readings say of the stated geometry, with the wires as stated.
    pub fn geometry(&self) -> Vec<Fitted> {
        let wiring = Wiring::stated();
        let view = self.view(&wiring, 1.0, 1.0);
        let mut list = Vec::new();
        if let (Some(diode), Some(stated)) = (&self.diode, self.readings.coordination) {
            let judged = diode.judge(&view);
            if judged.unexplained == 0 {
                let height = |told| Fitted::scaled("height_m", stated.height_m, told);
                list.extend(judged.height.map(height));
                let levers = [
                    ("lever_x_m", stated.lever_x_m),
                    ("lever_y_m", stated.lever_y_m),
                ];
                for ((name, stated_m), told) in levers.into_iter().zip(judged.lever_m) {
                    list.extend(told.map(|[found_m, error_m]| Fitted {
                        name: name.into(),
                        stated_m,
                        found_m,
                        error_m,
                    }));
                }
            }
        }
        if let Some(poses) = &self.reference {
            let judged = poses.judge(&view);
            if judged.unexplained == 0 {
                let [lengths, angle] = judged.scales;
                let inverse = |[scale, error]: [f64; 2]| [1.0 / scale, error / scale / scale];
                let pitch = |told| Fitted::scaled("pitch_m", self.readings.pitch_m, inverse(told));
                list.extend(lengths.map(pitch));
                let span = |told| Some(Fitted::scaled("span_m", self.readings.span_m?, told));
                list.extend(angle.and_then(span));
            }
        }
        list
    }

    /// Explanations with the span and the lengths as stated, then with those that the relations suggest.
    fn search(&self, wirings: &[Wiring]) -> Vec<Explanation> {
        let mut list = Vec::new();
        let units = LENGTHS.map(|unit| unit.factor);
        let logged = self.readings.logged.iter().any(|l| *l);
        for wiring in wirings {
            let view = |lengths: f64, span: f64| self.view(wiring, lengths, span);
            let (plain, suggested) = self.explain(&view(1.0, 1.0), &[]);
            list.extend(plain);
            if wiring.faults.len() > 1 {
                continue;
            }
            let units = units.into_iter().filter(|_| logged);
            for length in suggested.lengths.into_iter().chain(units) {
                let fault = match LENGTHS
                    .into_iter()
                    .find(|u| (u.factor / length - 1.0).abs() < 0.02)
                {
                    Some(unit) if logged => Fault::Positions(unit),
                    _ => Fault::Pitch(length),
                };
                list.extend(self.explain(&view(length, 1.0), &[fault]).0);
            }
            for span in suggested.span {
                let faults = [Fault::Span(span)];
                list.extend(self.explain(&view(1.0, span), &faults).0);
            }
        }
        list
    }
}

/// Parity of a wiring by the products of all four segments, rms, m.
fn parity_m(products: &Products, wiring: &Wiring) -> f64 {
    let weights = DVector::from_row_slice(&wiring.parity());
    let square = (&products.projected * &weights).dot(&weights);
    square.max(0.0).sqrt()
}

/// Scales that would make relations agree.
#[derive(Clone, Debug, Default)]
struct Suggested {
    lengths: Vec<f64>,
    span: Vec<f64>,
}

impl Suggested {
    fn add(&mut self, [lengths, angle]: [Option<[f64; 2]>; 2]) {
        let lengths = lengths.map(|[scale, _]| scale);
        self.lengths.extend(lengths);
        let told = angle.map(|[a, _]| a / lengths.unwrap_or(1.0));
        self.span.extend(told);
    }
}

/// 99 of 100 rows are slower, m/s: the largest over the segments.
fn speed(readings: &Readings) -> f64 {
    let of = |positions: &Vec<f64>| {
        let mut speeds: Vec<f64> = (1..positions.len())
            .filter(|&i| readings.group[i] == readings.group[i - 1])
            .map(|i| {
                let time_s = readings.time_s[i] - readings.time_s[i - 1];
                (positions[i] - positions[i - 1]).abs() / time_s.max(1e-9)
            })
            .filter(|v| v.is_finite())
            .collect();
        speeds.sort_unstable_by(f64::total_cmp);
        let place = speeds.len() * 99 / 100;
        speeds.get(place).copied().unwrap_or(0.0)
    };
    readings.position_m.iter().map(of).fold(0.0, f64::max)
}

/// The best explanations, equally good ones side by side, best first. Empty if all is as stated, or if nothing explains what is not.
pub(crate) fn explanations(recording: &Recording, relations: &Relations) -> Vec<Explanation> {
    let wirings = Wiring::all();
    let stated = relations.search(&wirings[..1]);
    let clean = |e: &&Explanation| e.unexplained == 0;
    if stated
        .iter()
        .any(|e| e.faults.iter().all(Fault::of_commands) && e.unexplained == 0)
    {
        return Vec::new();
    }
    let mut list = relations.search(&wirings);
    if !list.iter().any(|e| clean(&e)) {
        for reading in
            Reading::others(|s| relations.readings.has(s) && !relations.readings.logged[s])
        {
            let other = Relations::new(recording, reading);
            let found = other.search(&wirings[..1]);
            list.extend(found.into_iter().map(|mut e| {
                let fault = Fault::Quadrature(reading);
                e.cost += fault.cost();
                e.faults.insert(0, fault);
                e
            }));
        }
    }
    best(list)
}

/// The cheapest of all. What one wiring looks at and another makes too small to look at costs the other as much as what it does not explain;
/// another scale of all lengths has to explain something.
fn best(mut list: Vec<Explanation>) -> Vec<Explanation> {
    let scaled = |e: &Explanation| {
        let scale = |f: &Fault| matches!(f, Fault::Pitch(_) | Fault::Positions(_));
        e.faults.iter().any(scale)
    };
    let most = list.iter().map(|e| e.told).max().unwrap_or(0);
    for e in &mut list {
        let nothing = usize::from(scaled(e) && e.explained == 0 && most > 0);
        let untold = most - e.told;
        e.unexplained += nothing;
        e.cost += UNEXPLAINED_COST * (untold + nothing) as f64;
    }
    list.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let Some(first) = list.first() else {
        return Vec::new();
    };
    let limit = first.cost + COST_TOLERANCE;
    let mut kept: Vec<Explanation> = Vec::new();
    for e in list.into_iter().filter(|e| e.cost < limit) {
        // What is unexplained is no wire's or unit's doing.
        if e.unexplained > 0 || e.faults.iter().all(Fault::of_commands) {
            return Vec::new();
        }
        if !kept.iter().any(|k| same(&k.faults, &e.faults)) {
            kept.push(e);
        }
    }
    kept
}

/// The same faults, whatever their order and the last digits of their values.
fn same(a: &[Fault], b: &[Fault]) -> bool {
    a.len() == b.len()
        && a.iter()
            .all(|fault| b.iter().any(|other| fault.alike(other)))
}
