//! Image for QEMU's mps2-an386 with the counting plugin. Its command line says what to run: `costs`, `joint`, `peers`,
//! `parity`, or `frames FILE` (raw frames of a recording, as `cargo xtask test` writes them). Results go to standard output.
#![no_std]
#![no_main]

mod costs;
mod counter;
mod estimator;
mod joint;
mod peers;
mod recorded;

use cases::encoder::{TURN, Turns};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use courier_sensor::encoder::Learner;
use panic_semihosting as _;

#[entry]
fn main() -> ! {
    let mut line = [0; 512];
    let mut words = recorded::command_line(&mut line).split(' ').skip(1);
    match (words.next(), words.next()) {
        (Some("costs"), _) => costs::run(),
        (Some("joint"), _) => joint::run(),
        (Some("peers"), _) => costs::run_peers(),
        (Some("parity"), _) => parity(),
        (Some("frames"), Some(file)) => recorded::run(file),
        other => hprintln!(
            "found {:?}, wanted costs, joint, peers, parity or frames FILE",
            other
        ),
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}

fn parity() {
    for setup in cases::setups::Setup::ALL {
        hprintln!("signal {:?} {:016x}", setup, cases::parity::signal(setup));
    }
    hprintln!("rows {:016x}", cases::parity::rows(estimator::take()));
    let learner = cortex_m::singleton!(: Learner = Learner::new()).expect("called once");
    let turns = cortex_m::singleton!(: Turns = Turns::new(TURN)).expect("called once");
    hprintln!("encoder {:016x}", cases::encoder::digest(learner, turns));
}
