//! Raw frames: motions, noise, and everything a converter can say.

use courier_sensor::frame::{RawFrame, SEGMENTS, Status};
use courier_sensor::math::sincos_turns;

/// SplitMix64 (Steele, Lea and Flood 2014): small, and the same everywhere.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (1.0 / 8_388_608.0) - 1.0
    }

    /// One of a list.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.bits() % of.len() as u64) as usize]
    }
}

/// Counts at which arithmetic may go wrong.
const EDGES: [i16; 12] = [
    i16::MIN,
    i16::MIN + 1,
    -32_760,
    -20_000,
    -1,
    0,
    1,
    2,
    999,
    20_000,
    32_760,
    i16::MAX,
];
/// Temperatures likewise.
const TEMPERATURES: [f32; 8] = [
    0.0,
    -0.0,
    25.0,
    1000.0,
    1001.0,
    f32::INFINITY,
    f32::NAN,
    1.0e-40,
];

/// An endless sequence of frames: stretches of motion with noise, of random counts, of edges, of faults.
#[derive(Clone, Debug)]
pub struct Inputs {
    random: Random,
    left: u32,
    kind: u64,
    turns: [f32; SEGMENTS],
    speed: [f32; SEGMENTS],
    amplitude: f32,
    missed: u32,
}

impl Inputs {
    /// From a seed.
    pub const fn new(seed: u64) -> Self {
        let zero = [0.0; SEGMENTS];
        Self {
            random: Random::new(seed),
            left: 0,
            kind: 0,
            turns: zero,
            speed: zero,
            amplitude: 20_000.0,
            missed: 0,
        }
    }

    /// Sampling instants missed before the frame that came last: fewer than the tooth counters bridge, or more.
    pub const fn missed(&self) -> u32 {
        self.missed
    }

    /// The next frame.
    pub fn frame(&mut self) -> RawFrame {
        if self.left == 0 {
            self.stretch();
        }
        self.left -= 1;
        self.missed = 0;
        let mut raw = RawFrame {
            electrode_counts: self.electrodes(),
            ..RawFrame::default()
        };
        raw.temperature_delta_k = 20.0 * self.random.signed();
        match self.kind {
            0..=4 => raw.quadrature_counts = self.motion(),
            5 => raw
                .quadrature_counts
                .as_flattened_mut()
                .fill_with(|| self.random.bits() as i16),
            6 => {
                raw.quadrature_counts
                    .as_flattened_mut()
                    .fill_with(|| self.random.pick(&EDGES));
                raw.electrode_counts.fill_with(|| self.random.pick(&EDGES));
                raw.temperature_delta_k = self.random.pick(&TEMPERATURES);
            }
            _ => {
                raw.quadrature_counts = self.motion();
                let faults = [
                    Status::CONVERTER_CRC,
                    Status::CONVERTER_TIMEOUT,
                    Status::OVERRUN,
                    Status::empty(),
                ];
                raw.fault = self.random.pick(&faults);
                if raw.fault == Status::OVERRUN {
                    self.missed = self.random.pick(&[1, 3, 32, 33, 100_000]);
                }
            }
        }
        raw
    }

    /// 64 frames of one kind, with speeds up to 1.5 m/s at 20 kHz and any amplitude.
    fn stretch(&mut self) {
        self.left = 64;
        self.kind = self.random.bits() % 8;
        self.amplitude = 16_500.0 + 16_000.0 * self.random.signed();
        let fast = self.random.pick(&[0.0, 1.0e-4, 0.01, 0.074]);
        let random = &mut self.random;
        self.speed = core::array::from_fn(|_| fast * random.signed());
    }

    fn motion(&mut self) -> [[i16; 2]; SEGMENTS] {
        core::array::from_fn(|i| {
            let turns = self.turns[i] + self.speed[i];
            self.turns[i] = turns - (turns as i32) as f32;
            let (sine, cosine) = sincos_turns(self.turns[i]);
            [sine, cosine].map(|x| (self.amplitude * x + 2.0 * self.random.signed()) as i16)
        })
    }

    fn electrodes(&mut self) -> [i16; 4] {
        let level = self.random.pick(&[0.0, 600.0, 12_000.0, 30_000.0]);
        core::array::from_fn(|_| (level * (1.0 + 0.3 * self.random.signed())) as i16)
    }
}
