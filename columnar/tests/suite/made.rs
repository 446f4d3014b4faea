//! Recordings that the tests make.

use recording::{
    Coordination, Electronics, Geometry, Logged, Meta, Names, Recording, Row, Samples,
};

/// What a recording of every column states.
pub fn meta() -> Meta {
    Meta {
        device: "board \"7\"\nsecond line".into(),
        source: "ünïcode, commas".into(),
        names: Names {
            courier_id: "7".into(),
            platen_id: "west".into(),
            firmware: "0.1.0".into(),
            ..Names::default()
        },
        geometry: Geometry {
            pitch_m: 1.016e-3,
            span_m: Some(9.7e-3),
            lateral_m: Some(3.0e-3),
        },
        coordination: Some(Coordination {
            height_m: 0.05,
            lever_x_m: 0.09,
            lever_y_m: 0.005,
            tan_full_scale: 0.1,
        }),
        electronics: Electronics {
            adc_bits: Some(16),
            amplitude_counts: Some(20_000.0),
            quadrature_noise_counts: Some(20.0),
            psd_sum_counts: Some(30_000.0),
            psd_noise_counts: Some(2.0),
            position_noise_m: Some(1.0e-8),
        },
    }
}

/// The next of a row of numbers that look random, 0 to 1. The generator of Numerical Recipes, chapter 7.1.
pub fn next(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// A motion past teeth: four segments with noise, a beacon now and then, a reference in every third row.
pub fn motion(rows: usize) -> Recording {
    let mut samples = Samples::default();
    let mut state = 1;
    let mut drive_a = Vec::new();
    for index in 0..rows {
        let turns = index as f64 * 1.0e-3;
        // Minus zero, which no converter gives, becomes zero.
        let mut noisy = |value: f64| (value + 40.0 * (next(&mut state) - 0.5)).round() + 0.0;
        let phase = std::f64::consts::TAU * turns;
        let pair = Some([noisy(20_000.0 * phase.sin()), noisy(20_000.0 * phase.cos())]);
        samples.push(&Row {
            t_s: index as f64 / 20_000.0,
            run: if index < rows / 2 {
                "there"
            } else {
                "back, again"
            },
            quadrature_counts: [pair; 4],
            teeth: [Some(turns as i32); 4],
            electrode_counts: (index % 7 < 3).then(|| [noisy(15_000.0); 4]),
            temperature_c: Some(22.0 + (index / 1000) as f64 * 0.1),
            reference: [(index % 3 == 0).then_some(turns * 1.016e-3), None, None],
            ..Row::default()
        });
        drive_a.push(if index % 2 == 0 {
            0.1 * index as f64
        } else {
            f64::NAN
        });
    }
    samples.log(Logged {
        name: "aux_drive_a".into(),
        values: drive_a,
    });
    Recording {
        meta: meta(),
        samples,
        warnings: Vec::new(),
    }
}
