//! The image as it ships on a model of its chip: a program of its own runs the chip, this process is the courier around it.
//!
//! The model stands still between two calls, its time too, and asks for all that is outside the chip ([`protocol`]).

pub mod protocol;

use self::protocol::{Answer, Convst, Done, FlashEnd, Order, Question, Said, receive, send};
use anyhow::{Context, Result, bail, ensure};
use board_link::Wire;
use embedded_io::Write as _;
use embedded_storage::nor_flash::NorFlash;
use hal_sim::board::SharedFlash;
use hal_sim::wire::flash::{FlashError, PAGE_BYTES};
use hal_sim::wire::motion::Line;
use hal_sim::world::World;
use std::io::BufReader;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

/// Virtual time in which an image sets its link up.
const START_UP: Duration = Duration::from_millis(30);

/// A modelled chip that runs an image, with its courier.
pub struct Chip {
    model: Child,
    orders: ChildStdin,
    said: BufReader<ChildStdout>,
    around: Around,
    /// How often bytes had been forced into the flash when the model last looked.
    forced: u64,
}

/// What is around the chip.
struct Around {
    world: World,
    flash: SharedFlash,
    line: Line,
    /// No sampling instant since the start yet.
    fresh: bool,
}

impl Chip {
    /// Starts the program `model` with the image as it ships in `image`, and lets that set its link up.
    ///
    /// # Errors
    /// The program cannot be run, or the image does not run on it.
    pub fn start(model: &Path, image: &Path, world: World, flash: SharedFlash) -> Result<Self> {
        let mut command = Command::new(model);
        #[cfg(target_os = "linux")]
        crate::child::tie(&mut command);
        let mut model = command
            .arg("serve")
            .arg(image)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("--chip: {}", model.display()))?;
        let orders = model.stdin.take().context("--chip: a pipe to the model")?;
        let said = model
            .stdout
            .take()
            .context("--chip: a pipe from the model")?;
        let number = world.number.0;
        let forced = flash.0.borrow().forced();
        let mut chip = Self {
            model,
            orders,
            said: BufReader::new(said),
            around: Around {
                line: world.motion.line(),
                world,
                flash,
                fresh: true,
            },
            forced,
        };
        chip.order(&Order::Start { number })?;
        chip.pass(START_UP)?;
        Ok(chip)
    }

    /// Gives an order and answers what is asked until it is done.
    fn order(&mut self, order: &Order) -> Result<Done> {
        let gone = "--chip: the model has ended";
        send(&mut self.orders, order).context(gone)?;
        loop {
            match receive(&mut self.said).context(gone)? {
                Said::Done(Done::Failed(why)) => bail!("--chip: {why}"),
                Said::Done(done) => return Ok(done),
                Said::Question(question) => {
                    let answer = self.around.answer(question);
                    send(&mut self.orders, &answer).context(gone)?;
                }
            }
        }
    }
}

impl Around {
    fn answer(&mut self, question: Question) -> Answer {
        match question {
            Question::Meet {
                now_ns,
                sent,
                convst,
            } => self.meet(now_ns, &sent, convst),
            Question::Erase(offset) => {
                let end = offset + PAGE_BYTES as u32;
                Answer::Flash(ended(self.flash.erase(offset, end)))
            }
            Question::Program(offset, data) => {
                Answer::Flash(ended(self.flash.write(offset, &data)))
            }
            Question::PowerUp => {
                self.fresh = true;
                self.flash.0.borrow_mut().power_up();
                self.bank()
            }
            Question::Bank => self.bank(),
        }
    }

    fn bank(&self) -> Answer {
        let contents = self.flash.0.borrow().contents();
        Answer::Bank {
            bytes: contents.bytes,
            programmed: contents.programmed,
            torn: contents.torn,
        }
    }

    fn meet(&mut self, now_ns: u64, sent: &[(u64, u8)], convst: Convst) -> Answer {
        for (at_ns, byte) in sent {
            self.world.clock.advance_to_ns(*at_ns);
            // A byte without room is lost, as on the line.
            let _ = self.line.write(&[*byte]);
        }
        self.world.clock.advance_to_ns(now_ns);
        match convst {
            // The self-test of a start: also of one whose supply has not gone.
            Convst::ByHand => self.fresh = true,
            Convst::ByTimer if std::mem::take(&mut self.fresh) => self.world.begin_sampling(),
            Convst::ByTimer | Convst::No => {}
        }
        let inputs = match convst {
            Convst::No => None,
            _ => self.world.converter.inputs_at(now_ns),
        };
        Answer::Met {
            inputs,
            coming: self.line.take_coming(),
            temperature_c: self
                .world
                .with_courier(|courier| courier.sample().temperature_c),
            at_mark: self.world.is_at_mark(),
        }
    }
}

fn ended(result: Result<(), FlashError>) -> FlashEnd {
    match result {
        Ok(()) => FlashEnd::Well,
        Err(FlashError::Off) => FlashEnd::Off,
        Err(FlashError::WrittenTwice) => FlashEnd::WrittenTwice,
        Err(_) => FlashEnd::Failed,
    }
}

impl Wire for Chip {
    fn receive(&mut self, channel: usize, bytes: &mut [u8]) -> Result<usize> {
        let order = Order::Receive {
            channel: channel as u8,
            most: bytes.len() as u32,
        };
        let Done::Bytes(came) = self.order(&order)? else {
            bail!("--chip: the model gave another answer than bytes")
        };
        ensure!(
            came.len() <= bytes.len(),
            "--chip: the model gave more bytes than were asked for"
        );
        bytes[..came.len()].copy_from_slice(&came);
        Ok(came.len())
    }

    fn send(&mut self, bytes: &[u8]) -> Result<usize> {
        let bytes = bytes.to_vec();
        match self.order(&Order::Send { bytes })? {
            Done::Taken(count) => Ok(count as usize),
            _ => bail!("--chip: the model gave another answer than a count"),
        }
    }

    fn pass(&mut self, time: Duration) -> Result<()> {
        let forced = self.around.flash.0.borrow().forced();
        if std::mem::replace(&mut self.forced, forced) != forced {
            self.order(&Order::LookAtBank)?;
        }
        let ns = time.as_nanos() as u64;
        let Done::Ran { broken } = self.order(&Order::Run { ns })? else {
            bail!("--chip: the model gave another answer than that it ran")
        };
        ensure!(
            broken.is_empty(),
            "--chip: the image breaks a rule of the chip's manuals: {}",
            broken.join("; ")
        );
        Ok(())
    }
}

impl Drop for Chip {
    fn drop(&mut self) {
        let _ = self.model.kill();
        let _ = self.model.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::drivers::motion::{Command as Order, FRAME_BYTES, Request};
    use courier_sensor::link::framing;
    use hal_sim::presets;
    use hal_sim::wire::motion::ControllerConfig;

    fn around() -> Around {
        let world = World::new(
            presets::ideal(1),
            ControllerConfig::TYPICAL,
            Default::default(),
            1,
        )
        .expect("monotonic");
        Around {
            line: world.motion.line(),
            world,
            flash: SharedFlash::erased(1),
            fresh: true,
        }
    }

    fn meet(around: &mut Around, now_ns: u64, sent: Vec<(u64, u8)>, convst: Convst) -> Answer {
        around.answer(Question::Meet {
            now_ns,
            sent,
            convst,
        })
    }

    #[test]
    fn conversions_see_the_courier_and_the_timers_first_is_number_zero() {
        let mut around = around();
        for (now_ns, convst, comes) in [
            (1000, Convst::No, false),
            (2000, Convst::ByHand, true),
            (3000, Convst::ByTimer, true),
            (4000, Convst::ByTimer, true),
        ] {
            let Answer::Met { inputs, .. } = meet(&mut around, now_ns, vec![], convst) else {
                panic!("wanted a meeting")
            };
            assert_eq!(inputs.is_some(), comes, "{convst:?}");
        }
        let world = &around.world;
        assert_eq!((world.conversions(), world.first_conversion()), (3, 1));
        assert_eq!(world.sampled_ns()[0], 3000);
    }

    /// A restart begins with conversions by hand again, whatever the supply did.
    #[test]
    fn the_timers_first_conversion_after_a_restart_is_number_zero_again() {
        let mut around = around();
        let by_hand_then_by_timer = [Convst::ByHand, Convst::ByTimer, Convst::ByTimer];
        for (place, convst) in (1..).zip([by_hand_then_by_timer; 2].concat()) {
            meet(&mut around, 1000 * place, vec![], convst);
        }
        let world = &around.world;
        assert_eq!((world.conversions(), world.first_conversion()), (6, 4));
        assert_eq!(world.sampled_ns(), [5000, 6000]);
    }

    #[test]
    fn the_motion_controllers_reply_comes_with_its_instants() {
        let mut around = around();
        let mut buffer = [0; FRAME_BYTES];
        let request = Request {
            number: 7,
            command: Order::WhereAreYou,
        };
        let bytes = framing::encode(&request, &mut buffer).expect("it fits");
        let timed: Vec<_> = (0..).step_by(10_000).zip(bytes.iter().copied()).collect();
        let last_ns = 10_000 * timed.len() as u64;
        meet(&mut around, last_ns - 1, timed, Convst::No);
        let Answer::Met { coming, .. } = meet(&mut around, last_ns + 1, vec![], Convst::No) else {
            panic!("wanted a meeting")
        };
        let (first_ns, _) = coming.first().expect("a reply");
        assert!(
            *first_ns > last_ns + 100_000,
            "{first_ns}: it takes its time"
        );
        assert!(coming.is_sorted(), "{coming:?}");
    }

    #[test]
    fn a_supply_that_goes_while_flash_is_programmed_leaves_a_torn_double_word() {
        let mut around = around();
        around.flash.0.borrow_mut().cut_after(4);
        let program = Question::Program(8, [0; 8]);
        assert_eq!(around.answer(program.clone()), Answer::Flash(FlashEnd::Off));
        assert!(matches!(around.answer(Question::Bank), Answer::Bank { .. }));
        let off = around.answer(program.clone());
        assert_eq!(off, Answer::Flash(FlashEnd::Off), "a look is no power-up");
        let Answer::Bank { torn, .. } = around.answer(Question::PowerUp) else {
            panic!("wanted the bank")
        };
        let torn: Vec<usize> = (0..torn.len()).filter(|word| torn[*word]).collect();
        assert_eq!(torn, [1]);
        assert_eq!(
            around.answer(program),
            Answer::Flash(FlashEnd::WrittenTwice)
        );
        assert_eq!(
            around.answer(Question::Erase(0)),
            Answer::Flash(FlashEnd::Well)
        );
    }
}
