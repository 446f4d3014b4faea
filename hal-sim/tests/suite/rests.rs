//! A courier on the simulated board that goes from rest to rest.

use crate::bench::Bench;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Status;
use courier_sensor::link::message::{Action, BoardStatus, Reply};
use effects::random::{ChaCha8Rng, uniform};

/// Samples of a rest: 60 ms, of which 32 are wanted.
const REST_SAMPLES: u32 = 1200;

/// Sends the courier from place to place within `half_m` either way, resting at each, for so many seconds, or until `seen` says so of the
/// status; whether it has.
pub fn work(
    bench: &mut Bench,
    rng: &mut ChaCha8Rng,
    (half_m, for_s): (f64, u32),
    seen: impl Fn(&BoardStatus) -> bool,
) -> bool {
    let until_s = bench.status().time.uptime_s + for_s;
    loop {
        let status = bench.status();
        if seen(&status) || status.time.uptime_s >= until_s {
            return seen(&status);
        }
        let mut within = |half: f64| uniform(rng, -half, half) as f32;
        let order = Action::GoTo {
            target: Target {
                x_m: within(half_m),
                y_m: within(half_m),
                theta_rad: within(8.727e-3),
            },
            speed_m_per_s: 0.2,
        };
        assert_eq!(bench.ask(order), Reply::Done);
        while bench.status().moving {
            bench.run(200);
        }
        bench.run(REST_SAMPLES);
    }
}

/// Whether the next frame's status says that the calibration has drifted.
pub fn drift_is_told(bench: &mut Bench) -> bool {
    bench.run(50);
    let status = bench.board.sample().status;
    status.contains(Status::CALIBRATION_DRIFT)
}
