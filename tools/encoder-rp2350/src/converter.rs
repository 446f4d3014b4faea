//! The chip's converter, by its registers as `rp-pac` names them, since a whole crate of drivers takes the compiler a minute. Each step is
//! that of embassy's driver (`embassy-rp` 0.10: `clocks::init`, `clocks::configure_pll`, `adc::Adc`), for one clock only: 48 MHz, which the
//! converter wants (RP2350's data sheet, 12.4), from the crystal by one loop; the core has the same.

use rp_pac::clocks::vals::{ClkAdcCtrlAuxsrc, ClkSysCtrlAuxsrc, ClkSysCtrlSrc};
use rp_pac::resets::regs::Peripherals;
use rp_pac::xosc::vals::{CtrlFreqRange, Enable};
use rp_pac::{ADC, CLOCKS, PADS_BANK0, PLL_USB, RESETS, XOSC};

/// What a crystal of 12 MHz gets to start, in 256 of its periods: 128 ms, as by embassy.
const STARTS_IN: u16 = 6_000;
/// Of the loop: 12 MHz times the first is 1,440 MHz (750 to 1,600 are allowed), and that through the two others 48 MHz.
const TIMES: u16 = 120;
const DIVIDED_BY: [u8; 2] = [6, 5];
/// The pin of the converter's first channel.
const FIRST_PIN: usize = 26;

/// The converter, and two of its channels.
pub struct Converter {
    channels: [u8; 2],
}

impl Converter {
    /// Starts clocks and converter, and takes two pins from what is digital.
    pub fn start(channels: [u8; 2]) -> Self {
        let mut before = Peripherals(0);
        before.set_pads_bank0(true);
        before.set_pll_usb(true);
        reset(before);
        clocks();
        let mut clocked = Peripherals(0);
        clocked.set_adc(true);
        reset(clocked);
        for channel in channels {
            PADS_BANK0
                .gpio(FIRST_PIN + usize::from(channel))
                .write(|pad| {
                    pad.set_iso(false);
                    pad.set_ie(false);
                    pad.set_od(true);
                });
        }
        ADC.cs().write(|control| control.set_en(true));
        while !ADC.cs().read().ready() {}
        Self { channels }
    }

    /// One reading of each channel, twelve bits; none if a conversion failed.
    pub fn read(&mut self) -> Option<[u16; 2]> {
        let [first, second] = self.channels.map(|channel| {
            ADC.cs().modify(|control| {
                control.set_ainsel(channel);
                control.set_start_once(true);
            });
            while !ADC.cs().read().ready() {}
            (!ADC.cs().read().err()).then(|| ADC.result().read().result())
        });
        Some([first?, second?])
    }
}

/// Sets these parts of the chip back to what they are after power-on, and waits until they can be used.
fn reset(parts: Peripherals) {
    RESETS.reset().modify(|held| held.0 |= parts.0);
    RESETS.reset().modify(|held| held.0 &= !parts.0);
    while RESETS.reset_done().read().0 & parts.0 != parts.0 {}
}

/// The crystal, the loop that makes 48 MHz of it, and these for the converter and the core.
fn clocks() {
    XOSC.startup().write(|startup| startup.set_delay(STARTS_IN));
    XOSC.ctrl().write(|control| {
        control.set_freq_range(CtrlFreqRange::_1_15MHZ);
        control.set_enable(Enable::ENABLE);
    });
    while !XOSC.status().read().stable() {}

    PLL_USB.cs().write(|control| control.set_refdiv(1));
    PLL_USB
        .fbdiv_int()
        .write(|times| times.set_fbdiv_int(TIMES));
    PLL_USB.pwr().write(|off| {
        off.set_postdivpd(true);
        off.set_dsmpd(true);
    });
    while !PLL_USB.cs().read().lock() {}
    PLL_USB.prim().write(|divided| {
        divided.set_postdiv1(DIVIDED_BY[0]);
        divided.set_postdiv2(DIVIDED_BY[1]);
    });
    PLL_USB.pwr().modify(|off| off.set_postdivpd(false));

    CLOCKS.clk_adc_ctrl().write(|control| {
        control.set_auxsrc(ClkAdcCtrlAuxsrc::CLKSRC_PLL_USB);
        control.set_enable(true);
    });
    // Away from what may be its source now, and only then to the other one: the bits of `selected` say where it is.
    CLOCKS
        .clk_sys_ctrl()
        .modify(|control| control.set_src(ClkSysCtrlSrc::CLK_REF));
    while CLOCKS.clk_sys_selected().read().0 != 1 << ClkSysCtrlSrc::CLK_REF as u32 {}
    CLOCKS
        .clk_sys_ctrl()
        .modify(|control| control.set_auxsrc(ClkSysCtrlAuxsrc::CLKSRC_PLL_USB));
    CLOCKS
        .clk_sys_ctrl()
        .modify(|control| control.set_src(ClkSysCtrlSrc::CLKSRC_CLK_SYS_AUX));
    while CLOCKS.clk_sys_selected().read().0 != 1 << ClkSysCtrlSrc::CLKSRC_CLK_SYS_AUX as u32 {}
}
