//! Order and priors of the unknowns.

use super::lattice::{self, FieldKernel};
use super::pose::Setup;
use courier_sensor::equations::OWN_ORDERS;
use courier_sensor::frame::SEGMENTS;
use courier_sensor::teeth::Grid;
use tooth_field::{ApertureKernel, Lattice};

/// Own and lateral orders of the waves. By definition equation (9)'s, which a plain joint calibration has as well, then the
/// products of lowest order that couriers have been seen with (docs/effects.md, lateral dependence).
pub const WAVES: [(u8, i8); 6] = [(0, 1), (0, 2), (1, 1), (1, -1), (2, 1), (2, -1)];
/// Highest degree of the coordination sensor's polynomial: the inverse of a diode that bends by cubes needs some more.
pub const DEGREE: i32 = 9;

/// Standard deviation of a coefficient before the data, m. A prior: the parity of an uncalibrated sensor is 29.3 µm (paper,
/// 3.1.2), twice that; as for the firmware's joint fit.
const OWN_M: f64 = 60.0e-6;
/// The same of a wave. A prior: lateral terms of about 2.7 µm rms bring a simulated courier to the paper's residuals (3.1.2), an
/// amplitude of 3.8 µm.
const WAVE_M: f64 = 5.0e-6;
/// The same of the parity's offset. A prior: half a pitch, which is what whole teeth leave open; as for the firmware's joint fit.
const PARITY_M: f64 = 0.5e-3;
/// The same of the angle's offset. A prior: 10 mrad over the span of 9.7 mm, more than any mounting; as for the firmware's joint
/// fit.
const ANGLE_M: f64 = 0.1e-3;
/// The same of height and lever arms, of themselves. A prior: the paper starts from 5 % (3.2.1), six times that; as for the
/// firmware's joint fit.
const MOUNTING_SHARE: f64 = 0.3;
/// The same of the beacon's place. A prior: twenty pitches about where it was said to be; as for the firmware's joint fit.
const PLACE_M: f64 = 20.0e-3;
/// The same of the diode's misalignment, rad, and of its gains' difference. A prior: a diode is turned in its mount by some
/// degrees at the most, and 13 % of gain is the most that is known (lib_sincos_enc).
const MISALIGNMENT: f64 = 0.1;
/// The same of the diode's terms of third degree, at full scale; they halve from degree to degree beyond. A prior: up to 17 % of
/// the linear term (Golnabi).
const BEND: f64 = 0.2;
/// Of a node by itself, and of a whole line, m: twice the paper's 1.9 µm of tooth variation (section 4).
pub const NODE_M: f64 = 4.0e-6;

/// Where each unknown is.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// Powers of own and other deflection.
    pub powers: Vec<(i32, i32)>,
    /// Lattices of x's and y's field.
    pub grids: [Grid; 2],
    /// What their nodes are.
    field: Lattice<FieldKernel>,
    /// Prior deviations of a node by itself and of a whole line, m.
    field_m: [f64; 2],
}

impl Unknowns {
    /// For fields on these lattices.
    pub fn new(grids: [Grid; 2]) -> Self {
        let powers =
            (2..=DEGREE).flat_map(|degree| (0..=degree).map(move |other| (degree - other, other)));
        Self {
            powers: powers.collect(),
            grids,
            field: Lattice::of_teeth(FieldKernel::Spline),
            field_m: [NODE_M; 2],
        }
    }

    /// For fields of splines half a pitch apart; none over a lattice that is too long for them.
    #[must_use]
    pub fn of_half_splines(grids: [Grid; 2]) -> Option<Self> {
        let grids = [lattice::halved(&grids[0])?, lattice::halved(&grids[1])?];
        Some(Self {
            field: Lattice {
                kernel: FieldKernel::HalfSpline,
                step_pitches: [0.5; 2],
            },
            ..Self::new(grids)
        })
    }

    /// For fields of teeth under an aperture: deviations of a tooth by itself and of a whole line before the data, m.
    #[must_use]
    pub fn under_aperture(
        grids: [Grid; 2],
        aperture: ApertureKernel,
        deviations_m: [f64; 2],
    ) -> Self {
        let kernel = FieldKernel::Aperture(aperture);
        let grids = grids.each_ref().map(|grid| lattice::widened(grid, &kernel));
        Self {
            field: Lattice::of_teeth(kernel),
            field_m: deviations_m,
            ..Self::new(grids)
        }
    }

    /// What the nodes of both fields are.
    #[must_use]
    pub fn lattice(&self) -> Lattice<FieldKernel> {
        self.field
    }

    /// Deviation of a field at a place before the data: its nodes and its lines together, m.
    #[must_use]
    pub fn field_prior_m(&self) -> f64 {
        let [node_m, line_m] = self.field_m;
        (node_m * self.field.deviation_by_nodes()).hypot(line_m * self.field.deviation_by_lines())
    }

    /// Sine of an order of equation (3); the cosine follows.
    pub fn own(&self, segment: usize, order: usize) -> usize {
        (segment * OWN_ORDERS.len() + order) * 2
    }

    /// k1 - k2 - k3 + k4.
    pub fn parity(&self) -> usize {
        self.own(SEGMENTS, 0)
    }

    /// k1 + k2 - k3 - k4.
    pub fn angle(&self) -> usize {
        self.parity() + 1
    }

    /// h, l_x, l_y, beacon's place x, y.
    pub fn mounting(&self) -> usize {
        self.parity() + 2
    }

    /// Half the difference of gains, angle of the diode.
    pub fn misalignment(&self) -> usize {
        self.mounting() + 5
    }

    /// The diode's polynomial of one axis.
    pub fn bend(&self, axis: usize) -> usize {
        self.misalignment() + 2 + axis * self.powers.len()
    }

    /// Sine of a wave: all segments' of one wave together.
    pub fn wave(&self, segment: usize, wave: usize) -> usize {
        self.bend(2) + (wave * SEGMENTS + segment) * 2
    }

    /// First node of a direction's field.
    pub fn field(&self, direction: usize) -> usize {
        let before: usize = self.grids[..direction].iter().map(Grid::count).sum();
        self.wave(0, WAVES.len()) + before
    }

    /// First line of a direction: a node's displacement common to the whole line across.
    pub fn line(&self, direction: usize) -> usize {
        let before: usize = self.grids[..direction]
            .iter()
            .map(|grid| usize::from(grid.nodes[0]))
            .sum();
        self.field(2) + before
    }

    /// A direction's field at a place as a function of the unknowns: nodes, and the lines they lie on. None outside the lattice.
    pub fn field_at(&self, direction: usize, place: [f64; 2]) -> Option<Vec<(usize, f64)>> {
        let grid = &self.grids[direction];
        if self.field.kernel == FieldKernel::Spline {
            lattice::cell(grid, place)?;
        }
        let mut entries = Vec::with_capacity(lattice::SUPPORT * (lattice::SUPPORT + 1));
        for (node, weight) in self.field.nodes(place) {
            let (node, _) = lattice::number(grid, node)?;
            entries.push((self.field(direction) + node, weight));
        }
        for (line, weight) in self.field.lines(place) {
            let (_, line) = lattice::number(grid, [line, grid.first_teeth[1]])?;
            entries.push((self.line(direction) + line, weight));
        }
        Some(entries)
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.line(2)
    }

    /// Whether an unknown belongs to what a plain joint calibration fits.
    pub fn is_plain(&self, index: usize) -> bool {
        index < self.wave(0, 1)
    }

    /// Values to start from.
    pub fn start(&self, setup: &Setup) -> Vec<f64> {
        let mut values = vec![0.0; self.count()];
        let mounting = self.mounting();
        values[mounting] = setup.height_m;
        values[mounting + 1..mounting + 3].copy_from_slice(&setup.lever_m);
        values
    }

    /// Prior deviations.
    pub fn deviations(&self, setup: &Setup) -> Vec<f64> {
        let mut sd = vec![NODE_M; self.count()];
        sd[..self.parity()].fill(OWN_M);
        let mounting = self.mounting();
        let lever_m = setup.lever_m[0].hypot(setup.lever_m[1]);
        sd[self.parity()] = PARITY_M;
        sd[self.angle()] = ANGLE_M;
        sd[mounting] = MOUNTING_SHARE * setup.height_m;
        sd[mounting + 1..mounting + 3].fill(MOUNTING_SHARE * lever_m);
        sd[mounting + 3..mounting + 5].fill(PLACE_M);
        sd[self.misalignment()..self.bend(0)].fill(MISALIGNMENT);
        for axis in 0..2 {
            for (k, (own, other)) in self.powers.iter().enumerate() {
                sd[self.bend(axis) + k] = BEND * 0.5_f64.powi((own + other - 3).max(0));
            }
        }
        sd[self.wave(0, 0)..self.field(0)].fill(WAVE_M);
        sd[self.field(0)..self.line(0)].fill(self.field_m[0]);
        sd[self.line(0)..].fill(self.field_m[1]);
        sd
    }
}
