//! Supply, reset causes, temperature, identity.
#![allow(unsafe_code)] // calibration values of the factory lie in system memory

use crate::device::Device;
use crate::link::message::ResetCause;
use core::ptr::read_volatile;
use stm32_metapac::adc::vals::{Ovrmod, SampleTime};
use stm32_metapac::adccommon::vals::Ckmode;
use stm32_metapac::{ADC1, ADC12_COMMON, PWR, RCC, UID};

/// Supply detector's level 6: 2.9 V falling (data sheet DS12288), above the 2.8 V at which brown-out reset level 4 acts.
const SUPPLY_LEVEL: u8 = 6;
/// Temperature sensor's channel of ADC1.
const SENSOR_CHANNEL: u8 = 16;
/// Factory readings at 30 and 110 °C, taken at 3.0 V (data sheet DS12288).
const CALIBRATION: [(*const u16, f32); 2] = [
    (0x1FFF_75A8 as *const u16, 30.0),
    (0x1FFF_75CA as *const u16, 110.0),
];
const CALIBRATION_V: f32 = 3.0;
const SUPPLY_V: f32 = 3.3;

/// Starts the supply detector; the flash refuses to write while it says low.
pub fn start_supply_detector() {
    PWR.cr2().modify(|w| {
        w.set_pls(SUPPLY_LEVEL);
        w.set_pvde(true);
    });
}

/// Why the processor was reset; the cause is forgotten then. A supply that came sets the brown-out's flag as well.
pub fn take_reset_cause() -> ResetCause {
    let csr = RCC.csr().read();
    RCC.csr().modify(|w| w.set_rmvf(true));
    match () {
        () if csr.iwdgrstf() || csr.wwdgrstf() => ResetCause::Watchdog,
        () if csr.borrstf() => ResetCause::BrownOut,
        () if csr.pinrstf() && !csr.sftrstf() => ResetCause::Pin,
        () if csr.sftrstf() => ResetCause::Requested,
        () => ResetCause::PowerOn,
    }
}

/// Switches the converter of the temperature sensor on.
pub fn start_thermometer() {
    RCC.ahb2enr().modify(|w| w.set_adc12en(true));
    ADC12_COMMON.ccr().modify(|w| {
        w.set_ckmode(Ckmode::SYNC_DIV4);
        w.set_vsenseen(true);
    });
    ADC1.cr().modify(|w| w.set_deeppwd(false));
    ADC1.cr().modify(|w| w.set_advregen(true));
    // Regulator and sensor: 20 and 120 us.
    cortex_m::asm::delay(super::clocks::CLOCK_HZ / 5000);
    ADC1.cr().modify(|w| w.set_adcal(true));
    for _ in 0..1_000_000 {
        if !ADC1.cr().read().adcal() {
            break;
        }
    }
    cortex_m::asm::delay(64);
    ADC1.smpr2()
        .modify(|w| w.set_smp(usize::from(SENSOR_CHANNEL) - 10, SampleTime::CYCLES640_5));
    // Two conversions at each start, of which the second is kept: one that comes more than 1 ms after the one before may be wrong
    // (erratum ES0430 2.7.7), and here they are 100 ms apart.
    ADC1.cfgr().modify(|w| w.set_ovrmod(Ovrmod::OVERWRITE));
    ADC1.sqr1().write(|w| {
        w.set_l(1);
        w.set_sq(0, SENSOR_CHANNEL);
        w.set_sq(1, SENSOR_CHANNEL);
    });
    ADC1.cr().modify(|w| w.set_aden(true));
    for _ in 0..1_000_000 {
        if ADC1.isr().read().adrdy() {
            break;
        }
    }
    ADC1.cr().modify(|w| w.set_adstart(true));
}

/// Temperature by the last pair of conversions, and starts the next; none while one is under way.
pub fn temperature_c() -> Option<f32> {
    if !ADC1.isr().read().eos() {
        return None;
    }
    ADC1.isr().write(|w| w.set_eos(true));
    let reading = f32::from(ADC1.dr().read().rdata()) * (SUPPLY_V / CALIBRATION_V);
    ADC1.cr().modify(|w| w.set_adstart(true));
    // SAFETY: readable addresses of the system memory.
    let [(low, low_c), (high, high_c)] =
        CALIBRATION.map(|(place, c)| (f32::from(unsafe { read_volatile(place) }), c));
    (high > low).then(|| low_c + (reading - low) * (high_c - low_c) / (high - low))
}

/// The chip's own number.
pub fn device() -> Device {
    let mut bytes = [0; 12];
    for (index, place) in bytes.chunks_exact_mut(4).enumerate() {
        place.copy_from_slice(&UID.uid(index).read().to_le_bytes());
    }
    Device(bytes)
}
