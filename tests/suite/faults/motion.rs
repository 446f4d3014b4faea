//! The line to the motion controller.

use courier_sensor::drivers::motion::{Command, MotionPort, PortError, Reply};
use effects::motion::Pose;
use hal_sim::wire::clock::Clock;
use hal_sim::wire::fault::{FaultySerial, SerialFault, Switch, When};
use hal_sim::wire::motion::{ControllerConfig, Line, MotionWire};

fn motion() -> (Clock, Switch<SerialFault>, MotionPort<FaultySerial<Line>>) {
    let clock = Clock::new();
    let wire = MotionWire::new(clock.clone(), ControllerConfig::TYPICAL, Pose::default(), 1);
    let switch = Switch::new(9);
    let port = MotionPort::new(FaultySerial::new(wire.line(), switch.clone()));
    (clock, switch, port)
}

fn ask(
    clock: &Clock,
    port: &mut MotionPort<FaultySerial<Line>>,
) -> Result<Option<Reply>, PortError> {
    port.send(Command::WhereAreYou)?;
    for _ in 0..100 {
        clock.advance_ns(50_000);
        if let Some(reply) = port.poll()? {
            return Ok(Some(reply));
        }
    }
    Ok(None)
}

#[test]
fn a_bad_motion_line_loses_replies_and_invents_none() {
    let faults = [
        SerialFault::Flips(0.1),
        SerialFault::Dropped,
        SerialFault::Noise,
    ];
    for fault in faults {
        let (clock, switch, mut port) = motion();
        switch.set(fault, When::Sometimes(0.02));
        let replies = (0..1000).filter_map(|_| ask(&clock, &mut port).unwrap());
        let good = replies
            .inspect(|reply| assert!(matches!(reply, Reply::State { .. })))
            .count();
        assert!((100..990).contains(&good), "{fault:?}: {good} of 1000");
        switch.clear();
        ask(&clock, &mut port).unwrap();
        assert!(
            ask(&clock, &mut port).unwrap().is_some(),
            "{fault:?}: as before afterwards"
        );
    }
    let (clock, switch, mut port) = motion();
    switch.set(SerialFault::Line, When::Next(1));
    assert!(matches!(ask(&clock, &mut port), Err(PortError::Line(_))));
}
