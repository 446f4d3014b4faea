//! The motion controller: what it is told, what it answers, and where the courier then goes.

use crate::trajectory::PlaceError;
use crate::wire::clock::Clock;
use crate::wire::trajectory::{Leg, Trajectory};
use courier_sensor::drivers::motion::{
    Command, FRAME_BYTES, FaultCode, HEARTBEAT_LIMIT_MS, Phase, Refusal, Reply, Request, Response,
    Target,
};
use courier_sensor::link::framing::{self, Decoder};
use effects::motion::{Motion, Pose};
use effects::random::{ChaCha8Rng, normal, uniform};
use std::collections::VecDeque;

/// How the courier moves. Every size is a standard deviation or a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerConfig {
    /// Where it ends, beside where it was told, as the place decides: the motors' and the platen's field, unknown to the
    /// controller; smooth over half a metre, so that a fly-by drifts by a few micrometres and not by the whole of it.
    pub error_m: f64,
    /// The same of the angle, radians.
    pub error_rad: f64,
    /// What each stop adds at random, metres: friction and cable drag; angle in proportion by [`LEVER_M`].
    pub stop_error_m: f64,
    /// Swing after a move with the highest acceleration, metres; angle in proportion by [`LEVER_M`].
    pub swing_m: f64,
    /// Frequency of the magnetic spring between courier and platen, hertz.
    pub swing_hz: f64,
    /// Its time constant, seconds.
    pub decay_s: f64,
    /// Time from the end of a move to the word «settled», seconds.
    pub settle_s: f64,
    /// Highest acceleration, m/s^2.
    pub acceleration_m_per_s2: f64,
    /// Half the side of the square it may go to, metres.
    pub reach_m: f64,
    /// Largest angle, radians.
    pub reach_rad: f64,
}

impl ControllerConfig {
    /// A Sawyer-motor courier of plausible build: tens of micrometres off, at rest to 0.03 um when it says settled.
    pub const TYPICAL: Self = Self {
        error_m: 30.0e-6,
        error_rad: 2.0e-4,
        stop_error_m: 2.0e-6,
        swing_m: 20.0e-6,
        swing_hz: 60.0,
        decay_s: 12.0e-3,
        settle_s: 80.0e-3,
        acceleration_m_per_s2: 5.0,
        reach_m: 0.6,
        reach_rad: 0.06,
    };
}

/// Arm over which an angle counts as a length when times and swings are chosen.
pub const LEVER_M: f64 = 0.1;
/// A start and stop bit and eight bits at 1 Mbaud.
pub(super) const BYTE_NS: u64 = 10_000;
/// From a request's last byte to the reply's first.
const LATENCY_NS: u64 = 300_000;
/// Bytes that the firmware's transmitter holds.
pub(super) const TRANSMITTER_BYTES: usize = 64;
/// A motion is braked so long after the last command that keeps it going.
const HEARTBEAT_LIMIT_NS: u64 = HEARTBEAT_LIMIT_MS as u64 * 1_000_000;
/// Shortest move, and the time of a stop.
const SHORTEST_S: f64 = 0.02;

/// Ways in which the controller itself is at fault; the line's faults are [`crate::wire::fault`]'s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Misbehaviour {
    /// None.
    #[default]
    None,
    /// Takes everything, answers nothing, does not move.
    Silent,
    /// Answers with noise between good delimiters.
    Nonsense,
    /// Moves, but never says settled.
    NeverSettles,
    /// Says settled while the courier sways by this amplitude at 3 Hz, metres.
    Sways(f64),
    /// A fault stands.
    Faulted(FaultCode),
}

/// The controller, its two lines and where the courier is.
pub(super) struct Controller {
    pub(super) config: ControllerConfig,
    pub(super) clock: Clock,
    pub(super) rng: ChaCha8Rng,
    pub(super) place_error: PlaceError,
    pub(super) told: Trajectory,
    pub(super) truth: Trajectory,
    pub(super) to_controller: VecDeque<(u64, u8)>,
    pub(super) to_sensor: VecDeque<(u64, u8)>,
    pub(super) decoder: Decoder<FRAME_BYTES>,
    /// When the motion under way is braked, unless a heartbeat comes before.
    pub(super) brakes_ns: Option<u64>,
    pub(super) misbehaviour: Misbehaviour,
}

impl Controller {
    /// Handles what has arrived by this time.
    pub(super) fn run_until(&mut self, now_ns: u64) {
        while let Some((arrived_ns, byte)) = self.to_controller.front().copied()
            && arrived_ns <= now_ns
        {
            self.to_controller.pop_front();
            self.brake_if_due(arrived_ns);
            if let Some(Ok(request)) = self.decoder.feed::<Request>(byte) {
                self.handle(&request, arrived_ns);
            }
        }
        self.brake_if_due(now_ns);
    }

    /// Brakes a motion that is no longer kept going.
    fn brake_if_due(&mut self, now_ns: u64) {
        if let Some(at_ns) = self.brakes_ns.take_if(|at_ns| *at_ns <= now_ns) {
            self.brake(at_ns as f64 * 1e-9);
        }
    }

    fn handle(&mut self, request: &Request, now_ns: u64) {
        let now_s = now_ns as f64 * 1e-9;
        let reply = match self.misbehaviour {
            Misbehaviour::Silent => return,
            Misbehaviour::Faulted(code) => {
                self.brake(now_s);
                Reply::Fault(code)
            }
            _ => self.obey(&request.command, now_s),
        };
        let mut buffer = [0; FRAME_BYTES];
        let response = Response {
            number: request.number,
            reply,
        };
        let mut bytes = framing::encode(&response, &mut buffer)
            .expect("a reply fits its frame")
            .to_vec();
        if self.misbehaviour == Misbehaviour::Nonsense {
            let inside = 1..bytes.len() - 1;
            bytes[inside]
                .iter_mut()
                .for_each(|byte| *byte = uniform(&mut self.rng, 0.0, 256.0) as u8);
        }
        let mut at_ns = self
            .to_sensor
            .back()
            .map_or(0, |(at_ns, _)| *at_ns)
            .max(now_ns + LATENCY_NS);
        for byte in bytes {
            at_ns += BYTE_NS;
            self.to_sensor.push_back((at_ns, byte));
        }
    }

    fn obey(&mut self, command: &Command, now_s: f64) -> Reply {
        match *command {
            Command::GoTo {
                target,
                speed_m_per_s,
            } => {
                if let Some(refusal) = self.refuse(&target, speed_m_per_s) {
                    return Reply::Refused(refusal);
                }
                let to = Pose::new(
                    target.x_m.into(),
                    target.y_m.into(),
                    target.theta_rad.into(),
                );
                self.go(to, f64::from(speed_m_per_s), now_s);
                self.keep_going(now_s);
            }
            Command::GoOn => {
                if self.brakes_ns.is_some() {
                    self.keep_going(now_s);
                }
            }
            Command::WhereAreYou => {}
            Command::Stop => self.brake(now_s),
        }
        self.state(now_s)
    }

    fn refuse(&self, target: &Target, speed_m_per_s: f32) -> Option<Refusal> {
        let reach_m = self.config.reach_m as f32;
        let inside = target.x_m.abs() <= reach_m
            && target.y_m.abs() <= reach_m
            && target.theta_rad.abs() <= self.config.reach_rad as f32;
        if !inside {
            Some(Refusal::OutOfReach)
        } else if speed_m_per_s.is_finite() && speed_m_per_s > 0.0 {
            None
        } else {
            Some(Refusal::BadSpeed)
        }
    }

    fn state(&self, now_s: f64) -> Reply {
        let at = self.told.pose(now_s);
        let since_end_s = now_s - self.told.last().end_s();
        let phase = if since_end_s < 0.0 {
            Phase::Moving
        } else if since_end_s < self.config.settle_s
            || self.misbehaviour == Misbehaviour::NeverSettles
        {
            Phase::Settling
        } else {
            Phase::Settled
        };
        Reply::State {
            at: Target {
                x_m: at.x_m as f32,
                y_m: at.y_m as f32,
                theta_rad: at.theta_rad as f32,
            },
            phase,
        }
    }

    /// Chooses the time so that a rest-to-rest quintic keeps to both limits: peak speed 1.875 d/T, peak acceleration 5.7735 d/T^2.
    fn go(&mut self, to: Pose, speed_m_per_s: f64, now_s: f64) {
        let way = to.plus(self.told.pose(now_s), -1.0);
        let way_m = way.x_m.hypot(way.y_m).max(way.theta_rad.abs() * LEVER_M);
        let by_speed_s = 1.875 * way_m / speed_m_per_s;
        let by_acceleration_s = (5.7735 * way_m / self.config.acceleration_m_per_s2).sqrt();
        let duration_s = by_speed_s.max(by_acceleration_s).max(SHORTEST_S);
        let hardness =
            5.7735 * way_m / (duration_s * duration_s) / self.config.acceleration_m_per_s2;
        self.start_leg(to, duration_s, hardness, now_s);
    }

    /// The motion under way goes on, for as long as the next heartbeat may take.
    fn keep_going(&mut self, now_s: f64) {
        self.brakes_ns = Some((now_s * 1e9) as u64 + HEARTBEAT_LIMIT_NS);
    }

    /// Comes to rest ahead of where it is, as far as it rolls when braking evenly.
    fn brake(&mut self, now_s: f64) {
        self.brakes_ns = None;
        let [at, velocity, _] = self.told.course_state(now_s);
        if self.told.last().end_s() > now_s {
            let speed = velocity
                .x_m
                .hypot(velocity.y_m)
                .max(velocity.theta_rad.abs() * LEVER_M);
            let duration_s = (2.0 * speed / self.config.acceleration_m_per_s2).max(SHORTEST_S);
            self.start_leg(at.plus(velocity, 0.5 * duration_s), duration_s, 1.0, now_s);
        }
    }

    fn start_leg(&mut self, to: Pose, duration_s: f64, hardness: f64, now_s: f64) {
        let config = self.config;
        let draws: [f64; 6] = std::array::from_fn(|_| normal(&mut self.rng));
        let place = self.place_error.at(to);
        let stop_m = config.stop_error_m;
        let error = Pose::new(
            config.error_m * place[0] + stop_m * draws[0],
            config.error_m * place[1] + stop_m * draws[1],
            config.error_rad * place[2] + stop_m / LEVER_M * draws[2],
        );
        let swing_m = config.swing_m * hardness;
        let swing = Pose::new(
            swing_m * draws[3],
            swing_m * draws[4],
            swing_m / LEVER_M * draws[5],
        );
        let (swing_hz, decay_s) = (config.swing_hz, config.decay_s);
        let told = Leg {
            start_s: now_s,
            duration_s,
            from: self.told.course_state(now_s),
            to,
            swing: Pose::default(),
            swing_hz,
            decay_s,
        };
        let truth = Leg {
            from: self.truth.course_state(now_s),
            to: to.plus(error, 1.0),
            swing,
            ..told
        };
        self.told.push(told);
        self.truth.push(truth);
    }
}
