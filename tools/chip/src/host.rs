//! The host that started this program: it gives orders, and all that is outside the chip is there (`link_host::chip::protocol`).

use crate::beyond::Beyond;
use hal_sim::wire::converter::AnalogInputs;
use hal_sim::wire::fault::{InputFault, Switch, When};
use hal_sim::wire::flash::Contents;
use link_host::chip::protocol::{
    self, Answer, CHANNELS, Convst, Done, Order, Question, Said, Timed,
};
use std::cell::{OnceCell, RefCell};
use std::collections::VecDeque;
use std::fmt;
use std::io::{BufReader, Read, Write};
use std::rc::Rc;

/// So long the chip goes on before it meets the host again if nothing else makes it, ns: less than what the motion controller takes
/// before it replies.
const APART_NS: u64 = 50_000;

/// The way to the host. Clones are the same.
#[derive(Clone)]
pub struct Host(Rc<RefCell<Line>>);

struct Line {
    orders: Box<dyn Read>,
    said: Box<dyn Write>,
    sent: Timed,
    coming: VecDeque<(u64, u8)>,
    temperature_c: f64,
    at_mark: bool,
    met_ns: u64,
    by_timer: bool,
}

impl fmt::Debug for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Host")
    }
}

impl Host {
    /// A host that gives its orders here and is told there.
    pub fn new(orders: impl Read + 'static, said: impl Write + 'static) -> Self {
        Self(Rc::new(RefCell::new(Line {
            orders: Box::new(BufReader::new(orders)),
            said: Box::new(said),
            sent: vec![],
            coming: VecDeque::new(),
            temperature_c: 25.0,
            at_mark: false,
            met_ns: 0,
            by_timer: false,
        })))
    }

    /// The next order; none if the host has gone.
    pub fn order(&self) -> Option<Order> {
        protocol::receive(&mut self.0.borrow_mut().orders).ok()
    }

    /// Tells the end of an order.
    ///
    /// # Errors
    /// The host has gone.
    pub fn done(&self, done: Done) -> anyhow::Result<()> {
        protocol::send(&mut self.0.borrow_mut().said, &Said::Done(done))
    }

    /// Asks, and waits for the answer. If the host has gone this program ends: there is nobody left to run for.
    pub fn ask(&self, question: Question) -> Answer {
        let line = &mut *self.0.borrow_mut();
        let asked = protocol::send(&mut line.said, &Said::Question(question));
        match asked.and_then(|()| protocol::receive(&mut line.orders)) {
            Ok(answer) => answer,
            Err(_) => std::process::exit(1),
        }
    }

    /// What bank 2 holds, the supply having come.
    pub fn power_up(&self) -> Contents {
        self.contents(Question::PowerUp)
    }

    /// What bank 2 holds now.
    pub fn bank(&self) -> Contents {
        self.contents(Question::Bank)
    }

    fn contents(&self, question: Question) -> Contents {
        match self.ask(question) {
            Answer::Bank {
                bytes,
                programmed,
                torn,
            } => Contents {
                bytes,
                programmed,
                torn,
            },
            _ => std::process::exit(1),
        }
    }

    /// Meets the host at this instant; the converters' inputs, if a conversion begins and they have a supply.
    fn meet(&self, now_ns: u64, convst: Convst) -> Option<protocol::Inputs> {
        let sent = std::mem::take(&mut self.0.borrow_mut().sent);
        let met = self.ask(Question::Meet {
            now_ns,
            sent,
            convst,
        });
        let Answer::Met {
            inputs,
            coming,
            temperature_c,
            at_mark,
        } = met
        else {
            std::process::exit(1)
        };
        let line = &mut *self.0.borrow_mut();
        line.coming.extend(coming);
        (line.temperature_c, line.at_mark, line.met_ns) = (temperature_c, at_mark, now_ns);
        inputs
    }
}

impl Beyond for Host {
    fn send(&mut self, byte: u8, now_ns: u64) {
        self.0.borrow_mut().sent.push((now_ns, byte));
    }

    fn receive(&mut self, now_ns: u64) -> Option<u8> {
        if now_ns >= self.0.borrow().met_ns + APART_NS {
            self.meet(now_ns, Convst::No);
        }
        let coming = &mut self.0.borrow_mut().coming;
        coming.front().filter(|(at_ns, _)| *at_ns <= now_ns)?;
        coming.pop_front().map(|(_, byte)| byte)
    }

    fn temperature_c(&self) -> f64 {
        self.0.borrow().temperature_c
    }

    fn at_mark(&self) -> bool {
        self.0.borrow().at_mark
    }

    fn conversion(&mut self, by_timer: bool) {
        self.0.borrow_mut().by_timer = by_timer;
    }
}

/// The host's courier at the inputs of the converters here.
pub struct Inputs {
    host: Host,
    supply: Rc<OnceCell<Switch<InputFault>>>,
    last: protocol::Inputs,
}

impl Inputs {
    /// At the inputs of converters that are still to be made.
    pub fn new(host: Host) -> Self {
        Self {
            host,
            supply: Rc::default(),
            last: [[0; CHANNELS]; 2],
        }
    }

    /// Where those converters put the switch that takes their supply away.
    pub fn supply(&self) -> Rc<OnceCell<Switch<InputFault>>> {
        self.supply.clone()
    }
}

impl AnalogInputs for Inputs {
    fn sample(&mut self, now_ns: u64) -> protocol::Inputs {
        let convst = match self.host.0.borrow().by_timer {
            true => Convst::ByTimer,
            false => Convst::ByHand,
        };
        let met = self.host.meet(now_ns, convst);
        if let Some(supply) = self.supply.get() {
            match met {
                Some(_) => supply.clear(),
                None => supply.set(InputFault::Off, When::Always),
            }
        }
        self.last = met.unwrap_or(self.last);
        self.last
    }
}
