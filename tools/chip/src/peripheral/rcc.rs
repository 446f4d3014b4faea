//! Reset and clock control: oscillators, PLL, dividers, enable bits, causes of reset.

use super::clocks::{Clocks, HSI_HZ};
use super::{Access, Peripheral, Words};
use crate::registers::Register;
use crate::rule::Rule;
use crate::time::{NEVER, Ticks, from_us};
use stm32_metapac::rcc::regs::{Ccipr, Cfgr, Cr, Crrcr, Csr, Pllcfgr};
use stm32_metapac::rcc::vals::{Hpre, Pllsrc, Ppre, Sw, Usart1sel};

/// The PLL's lock time (DS12288, PLL characteristics: 15 us typical, 40 us at most).
const LOCK: Ticks = from_us(40);
/// Above this speed the step of the clock matters (RM0440, 7.2.7).
const STEP_HZ: u32 = 80_000_000;
/// So long at half the speed (RM0440, 7.2.7).
const STEP: Ticks = from_us(1);
/// What the PLL can do: its input, its oscillator and its output to the processor (DS12288, PLL characteristics).
const PLL_IN_HZ: std::ops::RangeInclusive<u32> = 2_660_000..=16_000_000;
const PLL_VCO_HZ: std::ops::RangeInclusive<u32> = 96_000_000..=344_000_000;

const CR: u32 = 0x00;
const CFGR: u32 = 0x08;
const PLLCFGR: u32 = 0x0C;
const AHB1ENR: u32 = 0x48;
const CSR: u32 = 0x94;

/// Why the chip was reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The supply came, or broke in.
    Supply,
    /// The processor asked for it.
    Software,
    /// The watchdog.
    Watchdog,
    /// A load of the option bytes.
    Options,
}

/// The peripheral.
#[derive(Debug)]
pub struct Rcc {
    words: Words,
    locked_at: Ticks,
    clocks: Clocks,
    /// Since when the bus has run at half of a speed that matters.
    half_since: Option<Ticks>,
    /// The watchdog runs: what must be so before anything is waited for.
    pub watchdog_runs: bool,
}

impl Rcc {
    /// After a reset; flags of earlier causes stay until the firmware clears them.
    pub fn after(cause: Cause, before: Option<&Self>) -> Self {
        let mut flags = Csr(before.map_or(0, |rcc| rcc.words.at(CSR)) & 0xFE00_0000);
        flags.set_pinrstf(true);
        match cause {
            Cause::Supply => flags.set_borrstf(true),
            Cause::Software => flags.set_sftrstf(true),
            Cause::Watchdog => flags.set_iwdgrstf(true),
            Cause::Options => flags.set_oblrstf(true),
        }
        // RM0440, 7.4: HSI on and ready, HSI chosen, flash's clock on, PLL factors 0x1000.
        let reset = [
            (CR, 0x0500),
            (0x04, 0x4000_0000),
            (CFGR, 0x0001),
            (PLLCFGR, 0x1000),
            (AHB1ENR, 0x0100),
            (0x68, 0x0130_1F1F),
            (0x6C, 0x050F_667F),
            (0x70, 0x0101),
            (0x78, 0xD2FE_CD3F),
            (0x7C, 0x0103),
            (0x80, 0x0437_7801),
            (CSR, flags.0),
        ];
        Self {
            words: Words::after_reset(&reset),
            locked_at: NEVER,
            clocks: Clocks::RESET,
            half_since: None,
            watchdog_runs: false,
        }
    }

    /// The clocks as they are.
    pub fn clocks(&self) -> Clocks {
        self.clocks
    }

    /// Whether a bit of an enable register, named as in the chip's tables, is set.
    pub fn enabled(&self, register: &str, bit: u32) -> bool {
        let offset = match register {
            "AHB1ENR" => AHB1ENR,
            "AHB2ENR" => 0x4C,
            "AHB3ENR" => 0x50,
            "APB1ENR1" => 0x58,
            "APB1ENR2" => 0x5C,
            "APB2ENR" => 0x60,
            _ => return true,
        };
        self.words.at(offset) >> bit & 1 == 1
    }

    fn cr(&self) -> Cr {
        Cr(self.words.at(CR))
    }

    fn write_cr(&mut self, value: u32, access: &mut Access) {
        let (before, mut now) = (self.cr(), Cr(value));
        now.set_hsirdy(now.hsion());
        if now.hseon() {
            access.broken(
                Rule::Unmodelled,
                "RCC.cr: HSE is switched on; the board has no crystal",
            );
        }
        if now.pllon() && !before.pllon() {
            self.locked_at = access.now + LOCK;
            self.check_pll(access);
            if !self.watchdog_runs {
                access.broken(
                    Rule::WatchdogFirst,
                    "the PLL is started, and waited for, before the watchdog",
                );
            }
        }
        now.set_pllrdy(before.pllrdy() && now.pllon());
        if !now.pllon() {
            self.locked_at = NEVER;
        }
        self.words.put(CR, now.0);
    }

    /// Input and output of the PLL: oscillator and processor's output, hertz.
    fn pll(&self) -> (u32, u32, u32) {
        let factors = Pllcfgr(self.words.at(PLLCFGR));
        let source = match factors.pllsrc() {
            Pllsrc::HSI => HSI_HZ,
            _ => 0,
        };
        let input = source / (u32::from(factors.pllm().to_bits()) + 1);
        let vco = input * u32::from(factors.plln().to_bits());
        let output = vco / (2 * (u32::from(factors.pllr().to_bits()) + 1));
        (input, vco, if factors.pllren() { output } else { 0 })
    }

    fn check_pll(&self, access: &mut Access) {
        let (input, vco, output) = self.pll();
        if !PLL_IN_HZ.contains(&input) || !PLL_VCO_HZ.contains(&vco) {
            let detail = format!("input {input} Hz, oscillator {vco} Hz, output {output} Hz");
            access.broken(Rule::Pll, detail);
        }
    }

    fn write_cfgr(&mut self, value: u32, access: &mut Access) {
        let (before, mut now) = (Cfgr(self.words.at(CFGR)), Cfgr(value));
        let switched = before.sw() != now.sw();
        if switched && before.hpre() != now.hpre() {
            access.broken(
                Rule::PrescalerFirst,
                "RCC.cfgr: source and prescaler change in one write",
            );
        }
        if now.sw() == Sw::PLL1_R && !self.cr().pllrdy() {
            access.broken(Rule::Pll, "chosen before it is ready");
        }
        now.0 = now.0 & !0xC | u32::from(now.sw().to_bits()) << 2;
        self.words.put(CFGR, now.0);
        self.update_clocks(access);
    }

    fn update_clocks(&mut self, access: &mut Access) {
        let cfgr = Cfgr(self.words.at(CFGR));
        let system_hz = match cfgr.sw() {
            Sw::PLL1_R => self.pll().2.max(1),
            _ => HSI_HZ,
        };
        let hclk_hz = system_hz / divider(cfgr.hpre());
        let before = self.clocks;
        self.clocks = Clocks {
            system_hz,
            hclk_hz,
            pclk1_hz: hclk_hz / bus_divider(cfgr.ppre1()),
            pclk2_hz: hclk_hz / bus_divider(cfgr.ppre2()),
        };
        self.check_step(before, access);
    }

    fn check_step(&mut self, before: Clocks, access: &mut Access) {
        let now = self.clocks;
        let fast = |clocks: Clocks| clocks.system_hz > STEP_HZ;
        let since = self.half_since.map_or(0, |since| access.now - since);
        if !fast(before) && fast(now) && now.hclk_hz == now.system_hz {
            let detail = format!("from {} Hz straight to {} Hz", before.hclk_hz, now.hclk_hz);
            access.broken(Rule::ClockStep, detail);
        } else if fast(before) && fast(now) && now.hclk_hz > before.hclk_hz && since < STEP {
            let detail = format!("{} ns at half the speed", crate::time::to_ns(since));
            access.broken(Rule::ClockStep, detail);
        }
        let half = now.system_hz > STEP_HZ && now.hclk_hz < now.system_hz;
        self.half_since = half.then(|| self.half_since.unwrap_or(access.now));
    }
}

fn divider(hpre: Hpre) -> u32 {
    match hpre {
        Hpre::DIV2 => 2,
        Hpre::DIV4 => 4,
        Hpre::DIV8 => 8,
        Hpre::DIV16 => 16,
        Hpre::DIV64 => 64,
        Hpre::DIV128 => 128,
        Hpre::DIV256 => 256,
        Hpre::DIV512 => 512,
        _ => 1,
    }
}

fn bus_divider(ppre: Ppre) -> u32 {
    match ppre {
        Ppre::DIV2 => 2,
        Ppre::DIV4 => 4,
        Ppre::DIV8 => 8,
        Ppre::DIV16 => 16,
        _ => 1,
    }
}

impl Peripheral for Rcc {
    fn peek(&self, register: &Register) -> u32 {
        self.words.get(register)
    }

    fn write(&mut self, register: &Register, value: u32, access: &mut Access) {
        match register.name {
            "cr" => self.write_cr(value, access),
            "cfgr" => self.write_cfgr(value, access),
            "pllcfgr" => {
                if self.cr().pllon() {
                    access.broken(Rule::Pll, "its factors change while it runs");
                }
                self.words.set(register, value);
            }
            "csr" => {
                let mut now = Csr(value);
                let before = Csr(self.words.at(CSR));
                now.set_lsirdy(now.lsion());
                // The flags go all together, by RMVF, which reads as zero afterwards.
                let flags = if now.rmvf() {
                    0
                } else {
                    before.0 & 0xFE00_0000
                };
                now.set_rmvf(false);
                self.words.put(CSR, now.0 & 0x00FF_FFFF | flags);
            }
            // The low-speed clocks and the peripherals' sources: nothing that is modelled runs from them but by its first choice.
            "crrcr" if Crrcr(value).hsi48on() => {
                access.broken(Rule::Unmodelled, "RCC.crrcr: HSI48 is switched on");
            }
            "ccipr" if Ccipr(value).usart1sel() != Usart1sel::PCLK2 => {
                access.broken(Rule::Unmodelled, "RCC.ccipr: another clock for USART1");
            }
            "crrcr" | "bdcr" | "ccipr" | "ccipr2" => self.words.set(register, value),
            // What a reset does is the chip's: the peripherals are not here.
            "ahb1rstr" | "ahb2rstr" | "ahb3rstr" | "apb1rstr1" | "apb1rstr2" | "apb2rstr" => {
                self.words.set(register, value);
            }
            "icscr" | "ahb1enr" | "ahb2enr" | "ahb3enr" | "apb1enr1" | "apb1enr2" | "apb2enr"
            | "ahb1smenr" | "ahb2smenr" | "ahb3smenr" | "apb1smenr1" | "apb1smenr2"
            | "apb2smenr" => {
                self.words.set(register, value);
            }
            other => access.broken(Rule::Unmodelled, format!("RCC.{other} is written")),
        }
    }

    fn next(&self) -> Ticks {
        self.locked_at
    }

    fn advance(&mut self, access: &mut Access) {
        if access.now >= self.locked_at {
            self.locked_at = NEVER;
            let mut cr = self.cr();
            cr.set_pllrdy(true);
            self.words.put(CR, cr.0);
        }
    }
}
