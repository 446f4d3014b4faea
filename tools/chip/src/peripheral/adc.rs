//! The converter of the temperature sensor: ADC1 and what it shares with ADC2.

use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, Ticks, from_us};
use stm32_metapac::adc::regs::{Cfgr, Cr, Isr, Smpr2, Sqr1};
use stm32_metapac::adc::vals::Ovrmod;
use stm32_metapac::adccommon::regs::Ccr;
use stm32_metapac::adccommon::vals::Ckmode;

/// The sensor's channel (RM0440, 21.4.11).
const SENSOR: u8 = 16;
/// Readings at 30 and 110 degrees with a reference of 3.0 V: 0.76 V and 2.5 mV a degree (DS12288, typical).
pub const CALIBRATION: [u16; 2] = [1037, 1310];
/// Supply against the reference of the factory's readings.
const REFERENCE_RATIO: f64 = 3.0 / 3.3;
/// The regulator's start (DS12288, ADC characteristics).
const REGULATOR: Ticks = from_us(20);
/// A conversion that begins later than this after the one before may be wrong (ES0430, 2.7.7).
const FRESH: Ticks = from_us(1000);
/// Cycles of the converter that calibration takes at most (DS12288), and how soon it may be enabled after it.
const CALIBRATION_CYCLES: u64 = 116;
const ENABLE_CYCLES: u64 = 4;
/// Half cycles of the converter that sampling takes, by its setting, and those of the conversion after it (RM0440, 21.4.16).
const SAMPLING_HALVES: [u64; 8] = [5, 13, 25, 49, 95, 185, 495, 1281];
const CONVERSION_HALVES: u64 = 25;

const ISR: u32 = 0x00;
const CR: u32 = 0x08;
const CFGR: u32 = 0x0C;
const SMPR2: u32 = 0x18;
const SQR1: u32 = 0x30;

/// ADC1.
#[derive(Debug)]
pub struct Adc {
    words: Words,
    regulator_since: Option<Ticks>,
    calibrates_until: Ticks,
    calibrated_at: Option<Ticks>,
    ready_at: Ticks,
    converts_until: Ticks,
    /// End of the conversion before, and how long after it the last one began.
    ended_at: Option<Ticks>,
    gap: Ticks,
    /// Conversions of the running sequence that are still to come after this one.
    left: u8,
    data: u32,
    /// How long after the conversion before that of the reading began.
    data_gap: Ticks,
    /// A reading of a conversion that began too late was taken.
    stale: bool,
    /// Temperature of the chip, degrees Celsius.
    pub temperature_c: f64,
    /// Settings shared with ADC2.
    pub common: Ccr,
}

impl Adc {
    /// After reset: in deep power-down (RM0440, 21.6).
    pub fn after_reset() -> Self {
        Self {
            words: Words::after_reset(&[(CR, 0x2000_0000), (0x0C, 0x8000_0000)]),
            regulator_since: None,
            calibrates_until: NEVER,
            calibrated_at: None,
            ready_at: NEVER,
            converts_until: NEVER,
            ended_at: None,
            gap: NEVER,
            left: 0,
            data: 0,
            data_gap: NEVER,
            stale: false,
            temperature_c: 25.0,
            common: Ccr(0),
        }
    }

    fn cycle(&self, access: &Access) -> Ticks {
        let divider = match self.common.ckmode() {
            Ckmode::SYNC_DIV2 => 2,
            Ckmode::SYNC_DIV4 => 4,
            _ => 1,
        };
        divider * access.clocks.cycle()
    }

    fn cr(&self) -> Cr {
        Cr(self.words.at(CR))
    }

    fn write_cr(&mut self, value: u32, access: &mut Access) {
        let (before, mut now) = (self.cr(), Cr(value));
        let mut wrong = |what: &str| access.broken(Rule::AdcSequence, format!("ADC1: {what}"));
        if now.advregen() && now.deeppwd() {
            wrong("the regulator is switched on in deep power-down");
        }
        self.regulator_since = match now.advregen() {
            true => self.regulator_since.or(Some(access.now)),
            false => None,
        };
        let regulated = self
            .regulator_since
            .is_some_and(|since| access.now >= since + REGULATOR);
        if now.adcal() && !before.adcal() {
            if !regulated || before.aden() {
                access.broken(
                    Rule::AdcSequence,
                    "ADC1: calibrated before the regulator is up, or while it is enabled",
                );
            }
            self.calibrates_until = access.now + CALIBRATION_CYCLES * self.cycle(access);
        }
        if now.aden() && !before.aden() {
            let rest = ENABLE_CYCLES * self.cycle(access);
            if before.adcal() || self.calibrated_at.is_none_or(|at| access.now < at + rest) {
                access.broken(
                    Rule::AdcSequence,
                    "ADC1: enabled without a calibration, or less than four cycles after it",
                );
            }
            self.ready_at = access.now + from_us(1);
        }
        if now.adstart() && !before.adstart() {
            self.start(access);
        }
        now.set_adcal(now.adcal() || before.adcal());
        now.set_aden(now.aden() || before.aden());
        now.set_adstart(now.adstart() || before.adstart());
        self.words.put(CR, now.0);
    }

    fn start(&mut self, access: &mut Access) {
        if !Isr(self.words.at(ISR)).adrdy() {
            access.broken(Rule::AdcSequence, "ADC1: started before it is ready");
        }
        let sequence = Sqr1(self.words.at(SQR1));
        // The register of the first four has all that a sequence of the sensor alone needs.
        let first_four = sequence.l() < 4;
        let others = (0..4).any(|k| k <= sequence.l() && sequence.sq(usize::from(k)) != SENSOR);
        if !first_four || others || !self.common.vsenseen() {
            access.broken(
                Rule::Unmodelled,
                "ADC1: the model knows up to four conversions of the temperature sensor",
            );
        }
        self.left = sequence.l();
        self.gap = self.ended_at.map_or(NEVER, |end| access.now - end);
        if self.gap > FRESH && self.stale {
            let detail = "ADC1: a reading begun more than 1 ms after the one before is used";
            access.broken(Rule::AdcStale, detail);
        }
        self.stale = false;
        self.converts_until = access.now + self.duration(access);
    }

    fn duration(&self, access: &Access) -> Ticks {
        let sampling = Smpr2(self.words.at(SMPR2)).smp(usize::from(SENSOR) - 10);
        let halves = SAMPLING_HALVES[usize::from(sampling.to_bits()) & 7] + CONVERSION_HALVES;
        halves * self.cycle(access) / 2
    }

    /// A conversion has ended; the next of its sequence begins at once.
    fn convert(&mut self, access: &Access) -> bool {
        let mut isr = Isr(self.words.at(ISR));
        let overwrites = Cfgr(self.words.at(CFGR)).ovrmod() == Ovrmod::OVERWRITE;
        if !isr.eoc() || overwrites {
            self.data = self.reading();
            self.data_gap = self.gap;
        }
        isr.set_ovr(isr.ovr() || isr.eoc() && !overwrites);
        isr.set_eoc(true);
        self.ended_at = Some(access.now);
        let last = self.left == 0;
        if last {
            isr.set_eos(true);
            self.converts_until = NEVER;
        } else {
            self.left -= 1;
            self.gap = 0;
            self.converts_until = access.now + self.duration(access);
        }
        self.words.put(ISR, isr.0);
        last
    }

    fn reading(&self) -> u32 {
        let [low, high] = CALIBRATION.map(f64::from);
        let at_reference = low + (self.temperature_c - 30.0) * (high - low) / 80.0;
        (at_reference * REFERENCE_RATIO).round().clamp(0.0, 4095.0) as u32
    }
}

impl Peripheral for Adc {
    fn peek(&self, register: &Register) -> u32 {
        match register.name {
            "dr" => self.data,
            _ => self.words.get(register),
        }
    }

    fn read(&mut self, register: &Register, access: &mut Access) -> u32 {
        if register.name == "dr" {
            let mut isr = Isr(self.words.at(ISR));
            if !isr.eoc() {
                access.broken(Rule::AdcSequence, "ADC1: read without a conversion");
            }
            isr.set_eoc(false);
            self.words.put(ISR, isr.0);
            self.stale = self.data_gap > FRESH;
        }
        self.peek(register)
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "cr" => self.write_cr(value, access),
            "isr" => {
                let flags = self.words.at(ISR) & !value;
                self.words.put(ISR, flags);
            }
            "smpr" | "smpr2" | "sqr1" | "cfgr" | "cfgr2" => self.words.set(register, value),
            other => access.broken(Rule::Unmodelled, format!("ADC1.{other} is written")),
        }
    }

    fn next(&self) -> Ticks {
        self.calibrates_until
            .min(self.ready_at)
            .min(self.converts_until)
    }

    fn advance(&mut self, access: &mut Access) {
        let (mut cr, mut isr) = (self.cr(), Isr(self.words.at(ISR)));
        if access.now >= self.calibrates_until {
            self.calibrates_until = NEVER;
            self.calibrated_at = Some(access.now);
            cr.set_adcal(false);
        }
        if access.now >= self.ready_at {
            self.ready_at = NEVER;
            isr.set_adrdy(true);
        }
        self.words.put(ISR, isr.0);
        if access.now >= self.converts_until && self.convert(access) {
            cr.set_adstart(false);
        }
        self.words.put(CR, cr.0);
    }
}

/// What ADC1 and ADC2 share.
pub fn write_common(adc: &mut Adc, register: &Register, value: u32, access: &mut Access) {
    match register.name {
        "ccr" => {
            if adc.cr().aden() && adc.common.ckmode() != Ccr(value).ckmode() {
                access.broken(
                    Rule::AdcSequence,
                    "ADC12: the clock changes while ADC1 is enabled",
                );
            }
            adc.common = Ccr(value);
        }
        other => access.broken(Rule::Unmodelled, format!("ADC12.{other} is written")),
    }
}
