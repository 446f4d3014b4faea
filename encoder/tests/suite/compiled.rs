//! The constants in C and in SimpleFOC's form, compiled by the system's compilers and run beside the signal path that a board runs.

use crate::forms::answer;
use courier_signal::encoder::{Encoder, EncoderConfig, Harmonics};
use courier_signal::quadrature::PairCorrection;
use encoder::{Answer, Turn, forms};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::process::{Command, ExitStatus};

/// Readings over a turn.
const READINGS: i16 = 2000;
/// The pair of an example, counts: amplitude, and centre of a converter without sign.
const AMPLITUDE: f64 = 1500.0;
const CENTRE: f64 = 2048.0;
/// Largest difference of two results in f32, turns: ten roundings of a phase of half a turn, the arctangent's own few and those of eight
/// orders of a hundredth of it.
const ROUNDED_TURNS: f64 = 10.0 * 0.5 * f32::EPSILON as f64;

/// Counts as the signal path takes them.
fn readings() -> impl Iterator<Item = [i16; 2]> {
    (0..READINGS).map(|k| {
        let phase = TAU * f64::from(k) / f64::from(READINGS);
        [phase.sin(), phase.cos()].map(|of| (AMPLITUDE * of).round() as i16)
    })
}

/// A compiler of this system.
struct Compiler {
    /// What names another one.
    variable: &'static str,
    usual: &'static str,
    standard: &'static str,
    /// Name of a source.
    source: &'static str,
}

const C: Compiler = Compiler {
    variable: "CC",
    usual: "cc",
    standard: "-std=c99",
    source: "encoder.c",
};
const CPP: Compiler = Compiler {
    variable: "CXX",
    usual: "c++",
    standard: "-std=c++11",
    source: "encoder.cpp",
};

impl Compiler {
    /// What a program of the constants and `main` prints; none, and said so, where there is no compiler.
    fn printed(&self, constants: &str, main: &str) -> Option<Vec<f64>> {
        let folder = tempfile::tempdir().unwrap();
        let [source, program] = [self.source, "encoder"].map(|name| folder.path().join(name));
        let text = format!(
            "{constants}\n#include <stdio.h>\n\nint main(void) {{\n{main}    return 0;\n}}\n"
        );
        std::fs::write(&source, text).unwrap();
        let compiler = std::env::var_os(self.variable).unwrap_or_else(|| self.usual.into());
        // No fused operations, which the signal path on this machine has not either.
        let options = [
            self.standard,
            "-O1",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-pedantic",
            "-ffp-contract=off",
            "-o",
        ];
        let Ok(compiled) = Command::new(compiler)
            .args(options)
            .args([&program, &source])
            .arg("-lm")
            .output()
        else {
            eprintln!("SKIPPED: no compiler; {} names one", self.variable);
            return None;
        };
        let told = String::from_utf8_lossy(&compiled.stderr);
        assert!(ExitStatus::success(&compiled.status), "{told}");
        let output = Command::new(program).output().unwrap();
        let numbers = String::from_utf8(output.stdout).unwrap();
        Some(numbers.lines().map(|line| line.parse().unwrap()).collect())
    }
}

/// The constants of an answer on a board.
fn on_a_board(answer: &Answer) -> Encoder {
    let channels = answer.channels.as_ref().unwrap();
    let pair = PairCorrection {
        offset_counts: channels.offset_counts.map(|counts| counts as f32),
        gain: channels.gain as f32,
        angle_rad: channels.angle_rad as f32,
    };
    let mut harmonics = Harmonics::default();
    for (turns, order) in harmonics.turns.iter_mut().zip(answer.applied()) {
        *turns = order.map(|k| k as f32);
    }
    Encoder::new(EncoderConfig::new(&pair, &harmonics, 0.4, 0.25).unwrap())
}

#[test]
fn the_form_in_c_does_what_a_board_does() {
    let answer = answer();
    let mut main = String::new();
    for counts in readings() {
        let [sine, cosine] = counts.map(|count| f64::from(count) + CENTRE);
        let _ = writeln!(
            main,
            "    printf(\"%.9g\\n\", encoder_phase_rad({sine:.1}f, {cosine:.1}f));"
        );
    }
    let Some(found) = C.printed(&forms::c(&answer), &main) else {
        return;
    };
    assert_eq!(found.len(), usize::try_from(READINGS).unwrap());
    let mut board = on_a_board(&answer);
    let mut largest = 0.0_f64;
    for (counts, found) in readings().zip(found) {
        let wanted = f64::from(board.step(counts).calibrated_turns);
        let off = found / TAU - wanted;
        largest = largest.max((off - off.round()).abs());
    }
    println!("{largest:.2e} turns");
    assert!(largest <= ROUNDED_TURNS, "{largest}");
}

#[test]
fn orders_of_the_turn_in_c_are_those_of_the_answer() {
    let mut answer = answer();
    answer.turn = Some(Turn {
        periods: 25,
        orders: vec![[0.01, -0.02], [0.003, 0.0], [0.0, 0.004]],
        before_turns: 0.0,
        after_turns: 0.0,
        stretches: 1,
        index: None,
    });
    let turns = |k: i16| f64::from(k) / f64::from(READINGS);
    let mut main = String::from("    (void)encoder_phase_rad;\n");
    for k in 0..READINGS {
        let _ = writeln!(
            main,
            "    printf(\"%.9g\\n\", encoder_of_turn_rad({:.7e}f));",
            TAU * turns(k)
        );
    }
    let Some(found) = C.printed(&forms::c(&answer), &main) else {
        return;
    };
    for (k, found) in (0..READINGS).zip(found) {
        let wanted = answer.of_turn(25.0 * turns(k));
        // A whole turn in f32, three times its order, and the sum's own: of a fiftieth of a turn.
        assert!(
            (found / TAU - wanted).abs() < 3.0 * 0.05 * f64::from(f32::EPSILON) * TAU,
            "{k}: {found} {wanted}"
        );
    }
}

/// What the form names of SimpleFOC, with the signatures of its drivers' `CalibratedSensor.h`: a sensor that is told its angle, and one that takes a
/// table off it, linear between two entries.
const SIMPLEFOC_NAMES: &str = r"
#include <math.h>

static const float TURN = 6.28318530718f;

struct Sensor {
    virtual ~Sensor() {}
    virtual float getMechanicalAngle() = 0;
};

class CalibratedSensor {
public:
    CalibratedSensor(Sensor &wrapped, int n_lut, float *lut) : sensor(wrapped), count(n_lut), table(lut) {}
    float getSensorAngle() {
        const float angle = sensor.getMechanicalAngle(), place = angle / TURN * (float)count;
        const int entry = (int)place;
        const float share = place - (float)entry;
        return angle - ((1.0f - share) * table[entry % count] + share * table[(entry + 1) % count]);
    }

private:
    Sensor &sensor;
    int count;
    float *table;
};
";

/// The phase of the channels about the form's centres, on a shaft of so many periods.
const A_SHAFT: &str = r"
struct Shaft : public Sensor {
    float angle = 0.0f;
    float getMechanicalAngle() override { return angle; }
    void read(float sine, float cosine, int period, int periods) {
        float phase = atan2f(sine - encoder_centres[0], cosine - encoder_centres[1]);
        if (phase < 0.0f) phase += TURN;
        angle = (phase + TURN * (float)period) / (float)periods;
    }
};
";

/// The form's own lines, its last one uncommented as a user does, give the angle that the form in C gives. Six digits, a table that is linear between
/// its places: as in `simplefoc_reads_its_table_right`.
#[test]
fn the_form_for_simplefoc_compiles_and_gives_the_same_angle() {
    const PERIODS: u32 = 20;
    let answer = answer();
    let form = forms::simplefoc(&answer, PERIODS);
    let last = "// CalibratedSensor calibrated(sensor, ";
    assert_eq!(form.matches(last).count(), 1, "{form}");
    let own = form.replace(
        last,
        "static Shaft sensor; CalibratedSensor calibrated(sensor, ",
    );
    // The sensor is declared behind the centres, which it takes.
    let (centres, rest) = own.split_at(own.find("float calibration_lut").unwrap());
    let constants = format!("{SIMPLEFOC_NAMES}\n{centres}{A_SHAFT}\n{rest}");
    let mut main = String::new();
    let mut wanted = Vec::new();
    let mut board = on_a_board(&answer);
    for (k, counts) in readings().enumerate() {
        let period = k as u32 % PERIODS;
        let [sine, cosine] = counts.map(|count| f64::from(count) + CENTRE);
        let _ = writeln!(
            main,
            "    sensor.read({sine:.1}f, {cosine:.1}f, {period}, {PERIODS}); printf(\"%.9g\\n\", calibrated.getSensorAngle());"
        );
        wanted.push(f64::from(board.step(counts).calibrated_turns));
    }
    let Some(found) = CPP.printed(&constants, &main) else {
        return;
    };
    assert_eq!(found.len(), wanted.len());
    for (k, (found, wanted)) in found.into_iter().zip(wanted).enumerate() {
        let off = f64::from(PERIODS) * found / TAU - wanted;
        assert!((off - off.round()).abs() < 1.0e-3, "{k}: {found} {wanted}");
    }
}
