//! Derivatives of the constraints by the unknowns.

use super::{Constraints, Instant, Layout, Values};
use crate::diode;
use crate::equations::{ANGLE_SIGN, Angle, PARITY_SIGN};
use crate::frame::SEGMENTS;

impl Constraints {
    /// Writes the rows, which must be zero.
    pub(super) fn fill_jacobian(
        &self,
        values: &Values,
        instant: &Instant,
        jacobian: &mut [Values; 3],
    ) {
        let layout = &self.layout;
        let by_outputs = self.by_outputs(instant);
        for i in 0..SEGMENTS {
            let functions = instant.basis.segment(i, Layout::ORDERS.0, Layout::ORDERS.1);
            for (k, (_, term)) in layout.terms.iter().enumerate() {
                let pair = functions.term(term);
                let at = i * layout.columns() + 2 * k;
                for (row, by_output) in jacobian.iter_mut().zip(&by_outputs) {
                    row[at] = by_output[i] * pair[0];
                    row[at + 1] = by_output[i] * pair[1];
                }
            }
            for (row, by_output) in jacobian.iter_mut().zip(&by_outputs) {
                row[layout.parity_offset()] += by_output[i] * PARITY_SIGN[i] / 4.0;
                row[layout.angle_offset()] += by_output[i] * ANGLE_SIGN[i] / 4.0;
            }
        }
        self.fill_mounting(values, instant, jacobian);
        self.fill_sensor(values, instant, jacobian);
    }

    fn fill_mounting(&self, values: &Values, instant: &Instant, jacobian: &mut [Values; 3]) {
        let layout = &self.layout;
        let (s, c) = (instant.sine, instant.cosine);
        let angle = Angle {
            sine: s,
            cosine: c,
            cosine_rest: s * s / (1.0 + c),
        };
        let per_height = 1.0 / values[layout.height()];
        let [x, y] = angle.turn(instant.displacement_m);
        let [by_lever_x, by_lever_y] = angle.by_lever();
        let columns = [
            [x * per_height, y * per_height],
            by_lever_x,
            by_lever_y,
            [1.0, 0.0],
            [0.0, 1.0],
        ];
        for (k, column) in columns.iter().enumerate() {
            jacobian[1][layout.height() + k] = column[0];
            jacobian[2][layout.height() + k] = column[1];
        }
    }

    fn fill_sensor(&self, values: &Values, instant: &Instant, jacobian: &mut [Values; 3]) {
        let layout = &self.layout;
        let scale = values[layout.height()] * self.geometry.tan_full_scale;
        let (s, c, [u, v]) = (
            instant.sine * scale,
            instant.cosine * scale,
            instant.deflection,
        );
        let mut put = |index: usize, [x, y]: [f32; 2]| {
            jacobian[1][index] = c * x - s * y;
            jacobian[2][index] = s * x + c * y;
        };
        put(layout.gain_difference(), [u, -v]);
        put(layout.turn(), [-v, u]);
        let at = layout.nonlinearity();
        for (k, (x, y)) in diode::functions(u, v)
            .into_iter()
            .zip(diode::functions(v, u))
            .enumerate()
        {
            put(at + k, [x, 0.0]);
            put(at + diode::AXIS_TERMS + k, [0.0, y]);
        }
    }
}
