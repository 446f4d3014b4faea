//! The constants in other programs' forms.

use crate::answer::{Answer, Turn};
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Entries of moteus' compensation table, and the largest number of one. By definition of its format (fw/motor_position.h: 256 of
/// int8, a scale over 127).
const MOTEUS_ENTRIES: usize = 256;
/// See [`MOTEUS_ENTRIES`].
const MOTEUS_LARGEST: f64 = 127.0;
/// Largest common offset, by definition of moteus' configuration: 16 bits without sign (fw/aux_common.h).
const MOTEUS_COMMON: f64 = 65_535.0;
/// Entries of SimpleFOC's table where none are stated, by definition of its driver (SimpleFOCDrivers, CalibratedSensor.h).
const SIMPLEFOC_ENTRIES: usize = 200;
/// Entries that a period needs. Derived from a wave of order 2, which has eight each: straight lines between them miss a tenth of
/// it.
const SIMPLEFOC_PER_PERIOD: usize = 16;
/// Places at which a table is computed before it is read at its own. Derived from straight lines between them: sixteen for each
/// of moteus' entries, so that the error is 256 times smaller than its own.
const GRID: usize = 4096;

/// C, for any compiler: constants, and a function that applies them.
#[must_use]
pub fn c(answer: &Answer) -> String {
    let channels = answer.channels.as_ref();
    let [s, c] = answer.offsets().unwrap_or_default();
    let (gain, angle) = channels.map_or((1.0, 0.0), |channels| (channels.gain, channels.angle_rad));
    let pair = |[a, b]: &[f64; 2]| format!("{{{:.7e}f, {:.7e}f}}", TAU * a, TAU * b);
    let list = |pairs: &[[f64; 2]]| pairs.iter().map(pair).collect::<Vec<_>>().join(",\n    ");
    let applied = answer.applied();
    let mut text = format!(
        "/* One encoder, learned without a reference by `courier encoder`. Angles in rad of the signal's period. */\n#include <math.h>\n\n\
         static const float encoder_offset[2] = {{{s:.6}f, {c:.6}f}}; /* of sine and cosine, in the log's unit */\n\
         static const float encoder_gain = {gain:.7}f; /* cosine's amplitude over the sine's */\n\
         static const float encoder_angle_rad = {angle:.7}f; /* from a right angle */\n\
         /* of orders 1 to {}: what is added to the phase is a sin(n phase) + b cos(n phase) */\n\
         static const float encoder_harmonics_rad[{0}][2] = {{\n    {}}};\n\n",
        applied.len(),
        list(&applied)
    );
    text += "static float encoder_phase_rad(float sine, float cosine) {\n\
             \x20   float s = sine - encoder_offset[0];\n\
             \x20   float c = (cosine - encoder_offset[1]) / (encoder_gain * cosf(encoder_angle_rad)) + s * tanf(encoder_angle_rad);\n\
             \x20   float phase = atan2f(s, c), sum = 0.0f;\n";
    let _ = write!(
        text,
        "    for (int n = 0; n < {}; n++)\n        sum += encoder_harmonics_rad[n][0] * sinf((n + 1) * phase) + encoder_harmonics_rad[n][1] * cosf((n + 1) * phase);\n    return phase + sum;\n}}\n",
        applied.len()
    );
    if let Some(turn) = &answer.turn {
        let _ = write!(
            text,
            "\n/* of orders 1 to {} of the turn, {} periods; turn_rad is counted from {} */\nstatic const float encoder_turn_rad[{0}][2] = {{\n    {}}};\n\n\
             static float encoder_of_turn_rad(float turn_rad) {{\n    float sum = 0.0f;\n    for (int n = 0; n < {0}; n++)\n        \
             sum += encoder_turn_rad[n][0] * sinf((n + 1) * turn_rad) + encoder_turn_rad[n][1] * cosf((n + 1) * turn_rad);\n    return sum;\n}}\n",
            turn.orders.len(),
            turn.periods,
            beginning(turn),
            list(&turn.orders)
        );
    }
    text
}

/// Where a turn begins, in words.
fn beginning(turn: &Turn) -> String {
    match &turn.index {
        Some(index) => format!(
            "the phase zero {:.2} periods {} the index",
            index.after_periods.abs(),
            if index.after_periods < 0.0 {
                "after"
            } else {
                "before"
            }
        ),
        None => "the count's zero".to_owned(),
    }
}

/// Commands for moteus: the common offset of a sine/cosine source, and the compensation table of source 0, with cpr 65536, offset 0 and
/// sign 1.
#[must_use]
pub fn moteus(answer: &Answer) -> String {
    let mut text = String::new();
    let common = answer.offsets().map(|[sine, cosine]| 0.5 * (sine + cosine));
    if answer.turn.is_some() {
        text +=
            "# orders of the turn are left out: a source of moteus is one period of the signal\n";
    }
    let half_turn = if let Some(common) = common {
        let _ = match common.round() {
            whole if (0.0..=MOTEUS_COMMON).contains(&whole) => {
                writeln!(text, "conf set aux1.sine_cosine.common {whole}")
            }
            whole => writeln!(
                text,
                "# aux1.sine_cosine.common is left out: {whole} is no count of a converter without sign, as moteus has"
            ),
        };
        // The value of a sine/cosine source is the phase and half a turn (fw/aux_port.h).
        0.5
    } else {
        0.0
    };
    let table = Table::new(answer, common.map(|common| [common.round(); 2]), 0);
    // Entry i is read at i / 256 of a turn (`lerp` in fw/motor_position.h; the comment there says half an entry later).
    let values: Vec<f64> = (0..MOTEUS_ENTRIES)
        .map(|entry| table.at(entry as f64 / MOTEUS_ENTRIES as f64 - half_turn))
        .collect();
    let scale = values
        .iter()
        .fold(0.0_f64, |largest, value| largest.max(value.abs()));
    for (entry, value) in values.iter().enumerate() {
        let whole = if scale > 0.0 {
            // Zero has no sign there.
            (MOTEUS_LARGEST * value / scale).round() + 0.0
        } else {
            0.0
        };
        let _ = writeln!(
            text,
            "conf set motor_position.sources.0.compensation_table.{entry} {whole}"
        );
    }
    let _ = writeln!(
        text,
        "conf set motor_position.sources.0.compensation_scale {scale:.7}"
    );
    text
}

/// Constants for SimpleFOC: centres of the channels, and the table of a `CalibratedSensor` over a turn of the shaft.
#[must_use]
pub fn simplefoc(answer: &Answer, periods_per_turn: u32) -> String {
    let periods = periods_per_turn.max(1) as usize;
    let mut text =
        String::from("// One encoder, learned without a reference by `courier encoder`.\n");
    let centres = answer.offsets();
    if let Some([sine, cosine]) = centres {
        let _ = writeln!(
            text,
            "float encoder_centres[2] = {{{sine:.6}f, {cosine:.6}f}}; // sine, cosine: taken off before the angle is formed"
        );
    }
    let entries = SIMPLEFOC_ENTRIES.max(SIMPLEFOC_PER_PERIOD * periods);
    let tables: Vec<Table> = (0..periods)
        .map(|period| Table::new(answer, centres, period))
        .collect();
    let value = |entry: usize| {
        let place = (entry * periods) as f64 / entries as f64;
        // The sensor takes it off.
        -TAU * tables[place as usize].at(place) / periods as f64
    };
    let values: Vec<String> = (0..entries)
        .map(|entry| format!("{:.6}f", value(entry)))
        .collect();
    let _ = writeln!(
        text,
        "float calibration_lut[{entries}] = {{{}}};",
        values.join(", ")
    );
    if let Some(turn) = &answer.turn {
        let _ = writeln!(
            text,
            "// the shaft's angle is counted from {}",
            beginning(turn)
        );
    }
    let _ = writeln!(
        text,
        "// CalibratedSensor calibrated(sensor, {entries}, calibration_lut);"
    );
    text
}

/// What is to be added to the phase that another program forms, by that phase.
struct Table {
    /// Phase (0 to 1, rising) and what is added, periods.
    nodes: Vec<[f64; 2]>,
}

impl Table {
    /// `base` is what the other program takes off the channels; none where it forms the phase as the log has it.
    fn new(answer: &Answer, base: Option<[f64; 2]>, period: usize) -> Self {
        let of = |k: usize| {
            let phase = k as f64 / GRID as f64;
            let read = base.map_or(phase, |base| answer.raw_phase(phase, base));
            let place = period as f64 + phase;
            let truth = place + crate::input::error(&answer.applied(), place);
            let added = truth + answer.turn.as_ref().map_or(0.0, |turn| turn.at(truth))
                - period as f64
                - read;
            [read - read.floor(), added - added.round()]
        };
        let mut nodes: Vec<[f64; 2]> = (0..GRID).map(of).collect();
        nodes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Self { nodes }
    }

    fn at(&self, phase: f64) -> f64 {
        let phase = phase - phase.floor();
        let count = self.nodes.len();
        let after = self.nodes.partition_point(|node| node[0] <= phase);
        let [before, after] = [(after + count - 1) % count, after % count].map(|at| self.nodes[at]);
        let gap = (after[0] - before[0]).rem_euclid(1.0);
        let share = if gap > 0.0 {
            (phase - before[0]).rem_euclid(1.0) / gap
        } else {
            0.0
        };
        before[1] + share * (after[1] - before[1])
    }
}

impl Answer {
    /// The phase, periods, that a program reads which takes `base` off the channels, where the phase of the round pair is `phase`.
    fn raw_phase(&self, phase: f64, base: [f64; 2]) -> f64 {
        let Some(channels) = &self.channels else {
            return phase;
        };
        let base = [0, 1].map(|k| (base[k] - self.unit.centre[k]) * self.unit.scale);
        let sine =
            channels.offset_counts[0] + channels.amplitude_counts * (TAU * phase).sin() - base[0];
        let cosine = channels.offset_counts[1]
            + channels.amplitude_counts * channels.gain * (TAU * phase + channels.angle_rad).cos()
            - base[1];
        sine.atan2(cosine) / TAU
    }
}
