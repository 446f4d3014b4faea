//! The two AD7606C-16 that sample all 12 channels at the same instant: one SPI bus or two, common CONVST and RESET.
//!
//! Chip 0 holds the sine and cosine of segments 1 to 4 on its channels 1 to 8, chip 1 the electrodes x+, x-, y+, y- on channels 1 to 4.
//! Channels 5 to 8 of chip 1 are grounded; an offset of [`WITNESS_COUNTS`] in the chip keeps channel 8 away from zero, so that a frame of
//! zeros only is a dead line on either chip. BUSY is chip 0's: chip 1 gets the same settings and edge and is read 6 us or more later.
//!
//! Runs in the sampling interrupt. Chips that stop answering are reset and set again, a piece at each instant (`revival`). A board that
//! starts conversions by a timer and reads on BUSY's falling edge calls [`Converter::read`] alone, or, if something else than the
//! processor fetches the frames (DMA), [`Converter::receive`]; one that does all itself calls [`Converter::convert`].

mod error;
mod revival;
mod settings;
pub mod timing;

pub use error::ConverterError;
pub use settings::{Settings, WITNESS_COUNTS, scripts};

use super::ad7606c::{
    Ad7606c, CHANNELS, COMMAND_BYTES, ChipError, Command, FrameBytes, Oversampling, Step,
    check_frame, pairs,
};
use crate::frame::{RawFrame, Status};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use revival::{Revival, Stage};

/// Counts of one instant, `[chip][channel]`.
pub type Counts = [[i16; CHANNELS]; 2];

/// Full reset needs more than 3 us (no-OS driver: 3).
const RESET_PULSE_US: u32 = 5;
/// Set-up after a full reset (no-OS driver: 253).
const DEVICE_SETUP_US: u32 = 300;
/// Oversampling of the self-test: 20 us of BUSY, which no processor can miss.
const SELF_TEST_RATIO: Oversampling = Oversampling::X16;
/// BUSY rises within 25 ns of CONVST (data sheet, t_D_CNV_BSY); polls that the self-test gives it.
const RISE_POLLS: u32 = 16;
/// CONVST stays high so long in the self-test: the data sheet asks for 10 ns, and a pin's slow edges take 25 ns.
const CONVST_PULSE_US: u32 = 1;

/// A chip-select frame to be exchanged with a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// 0 or 1.
    pub chip: u8,
    /// What is sent.
    pub command: Command,
    is_judged: bool,
}

/// Both chips and their lines.
#[derive(Debug)]
pub struct Converter<A, B, Convst, Reset, Busy> {
    quadrature: Ad7606c<A>,
    electrodes: Ad7606c<B>,
    convst: Convst,
    reset: Reset,
    busy: Busy,
    settings: Settings,
    revival: Revival,
    /// What came back in [`Stage::Set`], for [`Stage::Judge`].
    reply: [u8; COMMAND_BYTES],
}

impl<A, B, Convst, Reset, Busy> Converter<A, B, Convst, Reset, Busy>
where
    A: SpiDevice,
    B: SpiDevice,
    Convst: OutputPin,
    Reset: OutputPin,
    Busy: InputPin,
{
    /// Takes the SPI devices of chip 0 and chip 1 and the common pins; nothing is sent.
    pub fn new(
        chips: (A, B),
        convst: Convst,
        reset: Reset,
        busy: Busy,
        settings: Settings,
    ) -> Self {
        let (quadrature, electrodes) = (Ad7606c::new(chips.0), Ad7606c::new(chips.1));
        Self {
            quadrature,
            electrodes,
            convst,
            reset,
            busy,
            settings,
            revival: Revival::new(),
            reply: [0; COMMAND_BYTES],
        }
    }

    /// Resets both chips, sets everything and reads it back, tries one conversion, and leaves them ready. About 0.6 ms.
    /// To be called again after a fault: a chip that lost its supply forgets its settings. After an error the readings that
    /// follow reset and set the chips first: some of their settings are the self-test's.
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn initialise(&mut self, delay: &mut impl DelayNs) -> Result<(), ConverterError> {
        let result = self.set_up(delay);
        if let Err(error) = result {
            self.revival = Revival::from_reset(error);
        }
        result
    }

    fn set_up(&mut self, delay: &mut impl DelayNs) -> Result<(), ConverterError> {
        self.convst.set_low().map_err(pin)?;
        self.reset.set_high().map_err(pin)?;
        delay.delay_us(RESET_PULSE_US);
        self.reset.set_low().map_err(pin)?;
        delay.delay_us(DEVICE_SETUP_US);
        self.quadrature.after_reset();
        self.electrodes.after_reset();
        self.revival = Revival::new();
        let [first, second] = self.settings.scripts;
        self.quadrature.configure(first).map_err(chip(0))?;
        self.electrodes.configure(second).map_err(chip(1))?;
        self.set_oversampling(SELF_TEST_RATIO)?;
        self.self_test(delay)?;
        self.set_oversampling(self.settings.oversampling)?;
        self.enter_conversion_mode()
    }

    /// Starts a conversion of all channels by an edge of CONVST.
    ///
    /// # Errors
    /// [`ConverterError::Pin`].
    pub fn start(&mut self) -> Result<(), ConverterError> {
        self.convst.set_high().map_err(pin)?;
        self.convst.set_low().map_err(pin)
    }

    /// Whether the conversion is under way.
    ///
    /// # Errors
    /// [`ConverterError::Pin`].
    pub fn is_busy(&mut self) -> Result<bool, ConverterError> {
        self.busy.is_high().map_err(pin)
    }

    /// Reads both chips' last conversion, 288 clocks. `counts` is untouched on error. After some failures in a row the
    /// chips are reset and set again at the calls that follow.
    ///
    /// # Errors
    /// [`ConverterError::Chip`]; while the chips are set again, the error that began it.
    pub fn read(&mut self, counts: &mut Counts) -> Result<(), ConverterError> {
        if !self.revival.in_service() {
            return Err(self.revive());
        }
        match self.read_both() {
            Ok(fresh) => {
                self.revival.moved(Ok(()));
                *counts = fresh;
                Ok(())
            }
            Err(error) => Err(self.fail(error)),
        }
    }

    /// Whether readings are tried; else [`Converter::silent`] sets the chips again, a piece at each call.
    #[inline(always)]
    pub fn in_service(&self) -> bool {
        self.revival.in_service()
    }

    /// Takes both chips' frames of one conversion, which something else has fetched, straight into a raw frame: counts and no
    /// fault, or the previous counts and the fault's bit. Returns whether they are what the chips have sent. `checksum` computes [`CRC16`](super::ad7606c::CRC16) over the data's
    /// [`words`](super::ad7606c::words). After some failures in a row the chips are out of service.
    #[inline(always)]
    pub fn receive(
        &mut self,
        frames: [&FrameBytes; 2],
        checksum: impl Fn([u32; CHANNELS / 2]) -> u16,
        raw: &mut RawFrame,
    ) -> bool {
        let [first, second] = frames;
        let checked = check_frame(first, &checksum)
            .map_err(chip(0))
            .and_then(|()| check_frame(second, &checksum).map_err(chip(1)));
        match checked {
            Ok(()) => {
                self.revival.serve();
                raw.fault = Status::empty();
                raw.quadrature_counts = pairs(first);
                let [[x_plus, x_minus], [y_plus, y_minus], ..] = pairs(second);
                raw.electrode_counts = [x_plus, x_minus, y_plus, y_minus];
                true
            }
            Err(error) => {
                self.refuse(error, raw);
                false
            }
        }
    }

    /// A conversion whose frames could not be fetched, or were not what the chips have sent: the previous counts and the fault's bit.
    #[cold]
    #[inline(never)]
    pub fn refuse(&mut self, error: ConverterError, raw: &mut RawFrame) {
        raw.fault = error.status();
        self.revival.failed(error);
    }

    /// Start, wait for BUSY with a bound, read.
    ///
    /// # Errors
    /// All of the above; [`ConverterError::BusyStuck`] after [`Settings::busy_polls`] readings.
    pub fn convert(&mut self, counts: &mut Counts) -> Result<(), ConverterError> {
        if self.revival.in_service() {
            let ready = self.start().and_then(|()| self.wait_idle());
            ready.map_err(|error| self.fail(error))?;
        }
        self.read(counts)
    }

    /// To be called in place of [`Converter::read`] at an instant that went by without BUSY's edge: counts as a failed reading.
    pub fn silent(&mut self) -> ConverterError {
        if self.revival.in_service() {
            self.fail(ConverterError::BusyStuck { polls: 0 })
        } else {
            self.revive()
        }
    }

    /// [`Converter::convert`] into a raw frame: on error the previous counts stay and `raw.fault` says why.
    pub fn sample(&mut self, raw: &mut RawFrame) -> Result<(), ConverterError> {
        let mut counts = Counts::default();
        let result = self.convert(&mut counts);
        store(result.map(|()| counts), raw);
        result
    }

    fn read_both(&mut self) -> Result<Counts, ConverterError> {
        let mut fresh = Counts::default();
        let [first, second] = &mut fresh;
        self.quadrature.read_frame(first).map_err(chip(0))?;
        self.electrodes.read_frame(second).map_err(chip(1))?;
        Ok(fresh)
    }

    fn fail(&mut self, error: ConverterError) -> ConverterError {
        self.revival.failed(error);
        error
    }

    /// One instant's piece of setting the chips again; tells why.
    fn revive(&mut self) -> ConverterError {
        if let Some(exchange) = self.begin_piece() {
            let reply = match exchange.chip {
                0 => self.quadrature.exchange(&exchange.command),
                _ => self.electrodes.exchange(&exchange.command),
            };
            self.end_piece(&exchange, reply);
        }
        self.revival.error
    }

    /// Begins an instant's piece of setting the chips again, for a board whose bus works beside the processor: a chip-select frame that it is
    /// to exchange with a chip, whose reply is for [`Converter::end_piece`]; none if there is nothing to exchange at this instant.
    #[inline(always)]
    pub fn begin_piece(&mut self) -> Option<Exchange> {
        let Stage::Set { chip, step } = self.revival.stage else {
            self.piece_without_exchange();
            return None;
        };
        let step = self.step(chip, step);
        if step.is_none() {
            self.set_chip(chip);
        }
        step.map(|step| Exchange {
            chip,
            command: step.command,
            is_judged: step.is_judged(),
        })
    }

    /// Ends the piece with what came back for [`Converter::begin_piece`]'s frame: as long as that, zeros after it. What counts of it is looked
    /// at with the next piece.
    #[inline(always)]
    pub fn end_piece(&mut self, of: &Exchange, reply: Result<[u8; COMMAND_BYTES], ChipError>) {
        match reply {
            Ok(reply) => {
                self.reply = reply;
                self.revival.exchanged(of.is_judged);
            }
            Err(error) => self.revival.moved(Err(chip(of.chip)(error))),
        }
    }

    #[cold]
    #[inline(never)]
    fn piece_without_exchange(&mut self) {
        let result = match self.revival.stage {
            Stage::Reset { high: true } => self.reset.set_high().map_err(pin),
            Stage::Reset { high: false } => {
                self.quadrature.after_reset();
                self.electrodes.after_reset();
                self.reset.set_low().map_err(pin)
            }
            Stage::Judge { chip: index, step } => self
                .step(index, step)
                .map_or(Ok(()), |step| step.judge(self.reply))
                .map_err(chip(index)),
            _ => Ok(()),
        };
        self.revival.moved(result);
    }

    /// A frame of a chip's script; none after the last one.
    #[inline(always)]
    fn step(&self, chip: u8, step: u8) -> Option<&'static Step> {
        self.settings.scripts[usize::from(chip & 1)].step(step)
    }

    /// A chip's script is at its end.
    #[cold]
    #[inline(never)]
    fn set_chip(&mut self, chip: u8) {
        match chip {
            0 => self.quadrature.after_script(),
            _ => self.electrodes.after_script(),
        }
        self.revival.set(chip);
    }

    /// Why the chips are set again.
    #[inline(always)]
    pub const fn error(&self) -> ConverterError {
        self.revival.error
    }

    fn wait_idle(&mut self) -> Result<(), ConverterError> {
        for _ in 0..self.settings.busy_polls {
            if !self.is_busy()? {
                return Ok(());
            }
        }
        Err(ConverterError::BusyStuck {
            polls: self.settings.busy_polls,
        })
    }

    /// One slow conversion: BUSY must rise and fall, and both frames must hold. The first frame after register mode is thrown away:
    /// users saw a word of zeros lead it (EngineerZone, question 575145).
    fn self_test(&mut self, delay: &mut impl DelayNs) -> Result<(), ConverterError> {
        self.enter_conversion_mode()?;
        self.pulse(delay)?;
        self.wait_busy()?;
        self.wait_idle()?;
        let _ = self.read(&mut Counts::default());
        self.pulse(delay)?;
        self.wait_idle()?;
        self.read(&mut Counts::default())
    }

    /// [`Converter::start`] with a pulse that the slowest pin can make.
    fn pulse(&mut self, delay: &mut impl DelayNs) -> Result<(), ConverterError> {
        self.convst.set_high().map_err(pin)?;
        delay.delay_us(CONVST_PULSE_US);
        self.convst.set_low().map_err(pin)
    }

    fn wait_busy(&mut self) -> Result<(), ConverterError> {
        for _ in 0..RISE_POLLS {
            if self.is_busy()? {
                return Ok(());
            }
        }
        Err(ConverterError::BusyNeverRose { polls: RISE_POLLS })
    }

    fn set_oversampling(&mut self, ratio: Oversampling) -> Result<(), ConverterError> {
        self.quadrature.set_oversampling(ratio).map_err(chip(0))?;
        self.electrodes.set_oversampling(ratio).map_err(chip(1))
    }

    fn enter_conversion_mode(&mut self) -> Result<(), ConverterError> {
        self.quadrature.leave_register_mode().map_err(chip(0))?;
        self.electrodes.leave_register_mode().map_err(chip(1))
    }
}

/// Puts a reading into a raw frame: counts and no fault, or the previous counts and the fault's bit alone.
pub fn store(reading: Result<Counts, ConverterError>, raw: &mut RawFrame) {
    raw.fault = Status::empty();
    match reading {
        Ok([quadrature, [x_plus, x_minus, y_plus, y_minus, ..]]) => {
            for (pair, words) in raw
                .quadrature_counts
                .iter_mut()
                .zip(quadrature.as_chunks::<2>().0)
            {
                *pair = *words;
            }
            raw.electrode_counts = [x_plus, x_minus, y_plus, y_minus];
        }
        Err(error) => raw.fault = error.status(),
    }
}

const fn chip(index: u8) -> impl Fn(ChipError) -> ConverterError {
    move |error| ConverterError::Chip { index, error }
}

fn pin(error: impl digital::Error) -> ConverterError {
    ConverterError::Pin(error.kind())
}
