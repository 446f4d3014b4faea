//! Each rule is tripped by what it forbids, and by nothing in a start that keeps them all.

use chip::chip::Chip;
use chip::peripheral::flash::Start;
use chip::rule::Rule;
use chip::surroundings::Surroundings;
use chip::time::from_us;
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::flash::Flash;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;
use std::cell::RefCell;
use std::rc::Rc;
use stm32_metapac as pac;

fn chip(start: Start) -> Chip {
    let world = World::new(
        presets::ideal(1),
        ControllerConfig::TYPICAL,
        Default::default(),
        1,
    );
    let flash = SharedFlash(Rc::new(RefCell::new(Flash::new(128, 1))));
    Chip::new(Surroundings::new(world.expect("monotonic"), flash), start)
}

/// Address of a register.
macro_rules! at {
    ($($register:tt)+) => { (pac::$($register)+.as_ptr() as usize) as u32 };
}

fn set(chip: &mut Chip, address: u32, bits: u32) {
    let value = chip.read(address, 4);
    chip.write(address, 4, value | bits);
}

fn wait_us(chip: &mut Chip, us: u64) {
    let until = chip.now + from_us(us);
    chip.advance_to(until);
}

/// Clocks of everything that the tests touch.
fn clocks(chip: &mut Chip) {
    set(chip, at!(RCC.apb1enr1()), 1 << 28 | 3);
    set(chip, at!(RCC.apb2enr()), 1 << 14 | 1 << 12 | 1);
    set(chip, at!(RCC.ahb2enr()), 1 << 13 | 7);
}

fn watchdog(chip: &mut Chip) {
    chip.write(at!(IWDG.kr()), 4, 0xCCCC);
}

/// 170 MHz as the manual wants it; `skip` leaves a step out.
fn full_speed(chip: &mut Chip, skip: Option<Rule>) {
    let skips = |rule| skip == Some(rule);
    clocks(chip);
    if !skips(Rule::WatchdogFirst) {
        watchdog(chip);
    }
    if !skips(Rule::VoltageRange) {
        chip.write(at!(PWR.cr5()), 4, 0);
    }
    if !skips(Rule::FlashLatency) {
        set(chip, at!(FLASH.acr()), 4);
    }
    // HSI / 4 * 85 / 2; or HSI / 8, which is below the least input.
    let factors = if skips(Rule::Pll) {
        0x7 << 4 | 85 << 8
    } else {
        3 << 4 | 85 << 8
    };
    chip.write(at!(RCC.pllcfgr()), 4, 2 | factors | 1 << 24);
    set(chip, at!(RCC.cr()), 1 << 24);
    wait_us(chip, 50);
    let (half, pll) = (8 << 4, 3);
    if skips(Rule::PrescalerFirst) {
        chip.write(at!(RCC.cfgr()), 4, half | pll);
    } else if skips(Rule::ClockStep) {
        chip.write(at!(RCC.cfgr()), 4, pll);
    } else {
        chip.write(at!(RCC.cfgr()), 4, 1 | half);
        chip.write(at!(RCC.cfgr()), 4, half | pll);
    }
    wait_us(chip, 2);
    chip.write(at!(RCC.cfgr()), 4, pll);
}

/// Pins as the board's.
fn pins(chip: &mut Chip) {
    chip.write(at!(GPIOA.bsrr()), 4, 1 << 4);
    chip.write(at!(GPIOB.bsrr()), 4, 1);
    chip.write(at!(GPIOA.afr(0)), 4, 0x5550_0000);
    chip.write(at!(GPIOA.afr(1)), 4, 0x0000_0770);
    let moder = chip.read(at!(GPIOA.moder()), 4) & !0x003C_FF00;
    chip.write(at!(GPIOA.moder()), 4, moder | 0x0028_A900);
    let moder = chip.read(at!(GPIOB.moder()), 4) & !0x3;
    chip.write(at!(GPIOB.moder()), 4, moder | 1);
    // CONVST and RESET are outputs of the highest speed.
    chip.write(at!(GPIOC.ospeedr()), 4, 0xF << 12);
    chip.write(at!(GPIOC.moder()), 4, 0xFFFF_5FFF);
}

const SPI_MODE: u32 = 1 << 1 | 1 << 2 | 2 << 3 | 1 << 6 | 1 << 8 | 1 << 9;

fn spi(chip: &mut Chip) {
    full_speed(chip, None);
    pins(chip);
    chip.write(at!(SPI1.cr2()), 4, 7 << 8 | 1 << 12);
    chip.write(at!(SPI1.cr1()), 4, SPI_MODE);
}

fn select(chip: &mut Chip, low: bool) {
    chip.write(at!(GPIOA.bsrr()), 4, if low { 1 << 20 } else { 1 << 4 });
}

fn send(chip: &mut Chip) {
    chip.write(at!(SPI1.dr8()), 1, 0);
}

fn pulse(chip: &mut Chip, us: u64) {
    chip.write(at!(GPIOC.bsrr()), 4, 1 << 6);
    wait_us(chip, us);
    chip.write(at!(GPIOC.bsrr()), 4, 1 << 22);
}

/// ADC1 ready for the temperature.
fn adc(chip: &mut Chip) {
    full_speed(chip, None);
    set(chip, at!(ADC12_COMMON.ccr()), 3 << 16 | 1 << 23);
    chip.write(at!(ADC1.cr()), 4, 0);
    set(chip, at!(ADC1.cr()), 1 << 28);
    wait_us(chip, 25);
    set(chip, at!(ADC1.cr()), 1 << 31);
    wait_us(chip, 25);
    set(chip, at!(ADC1.smpr2()), 7 << 18);
    chip.write(at!(ADC1.sqr1()), 4, 16 << 6);
    set(chip, at!(ADC1.cr()), 1);
    wait_us(chip, 25);
}

fn convert(chip: &mut Chip) {
    set(chip, at!(ADC1.cr()), 1 << 2);
    wait_us(chip, 50);
    let _ = chip.read(at!(ADC1.dr()), 4);
}

const DMA_ON: u32 = 1;
/// Memory counts up, in a circle.
const DMA_RECEIVES: u32 = 1 << 5 | 1 << 7;

/// SPI1 and channel 1 of DMA1 with this request, memory and count, to be switched on.
fn dma(chip: &mut Chip, request: u32, memory: u32, count: u32) {
    spi(chip);
    // DMA1, DMAMUX1 and the CRC unit.
    set(chip, at!(RCC.ahb1enr()), 1 << 12 | 1 << 2 | 1);
    chip.write(at!(DMAMUX1.ccr(0)), 4, request);
    chip.write(at!(DMA1.ch(0).par()), 4, at!(SPI1.dr8()));
    chip.write(at!(DMA1.ch(0).mar()), 4, memory);
    chip.write(at!(DMA1.ch(0).ndtr()), 4, count);
}

/// Switches channel 1 on, and a byte comes.
fn receive(chip: &mut Chip) {
    set(chip, at!(SPI1.cr2()), 1);
    chip.write(at!(DMA1.ch(0).cr()), 4, DMA_RECEIVES | DMA_ON);
    send(chip);
    wait_us(chip, 1);
}

fn unlock(chip: &mut Chip) {
    for key in [0x4567_0123, 0xCDEF_89AB] {
        chip.write(at!(FLASH.keyr()), 4, key);
    }
}

/// Data cache off and reset, controller unlocked, programming.
fn program(chip: &mut Chip, data_cache: bool) {
    if !data_cache {
        let acr = chip.read(at!(FLASH.acr()), 4) & !(1 << 10);
        chip.write(at!(FLASH.acr()), 4, acr);
    }
    unlock(chip);
    chip.write(at!(FLASH.cr()), 4, 1);
}

fn double_word(chip: &mut Chip) {
    chip.write_far(0, 4, 1);
    chip.write_far(4, 4, 2);
    wait_us(chip, 100);
}

const ERASE: u32 = 1 << 1 | 1 << 11;

/// What trips a rule.
type Fault = (Rule, fn(&mut Chip));

const FAULTS: &[Fault] = &[
    (Rule::Unmodelled, |chip| chip.write(0x4000_4400, 4, 0)),
    (Rule::Unmodelled, |chip| chip.write(0x4002_1FFC, 4, 0)),
    (Rule::ReservedBit, |chip| set(chip, at!(RCC.cr()), 1 << 1)),
    (Rule::ReadOnly, |chip| {
        clocks(chip);
        chip.write(at!(GPIOA.idr()), 4, 1);
    }),
    (Rule::AccessWidth, |chip| chip.write(at!(RCC.cr()), 1, 0)),
    (Rule::AccessWidth, |chip| {
        spi(chip);
        chip.write(at!(SPI1.dr16()), 2, 0);
    }),
    (Rule::PeripheralClock, |chip| {
        chip.write(at!(SPI1.cr1()), 4, 0)
    }),
    (Rule::Pll, |chip| full_speed(chip, Some(Rule::Pll))),
    (Rule::VoltageRange, |chip| {
        full_speed(chip, Some(Rule::VoltageRange))
    }),
    (Rule::FlashLatency, |chip| {
        full_speed(chip, Some(Rule::FlashLatency))
    }),
    (Rule::ClockStep, |chip| {
        full_speed(chip, Some(Rule::ClockStep))
    }),
    (Rule::PrescalerFirst, |chip| {
        full_speed(chip, Some(Rule::PrescalerFirst))
    }),
    (Rule::WatchdogFirst, |chip| {
        full_speed(chip, Some(Rule::WatchdogFirst))
    }),
    (Rule::AlternateFunction, |chip| {
        clocks(chip);
        // PA9 has no function 0.
        let moder = chip.read(at!(GPIOA.moder()), 4) & !(3 << 18);
        chip.write(at!(GPIOA.moder()), 4, moder | 2 << 18);
    }),
    (Rule::AlternateFunction, |chip| {
        spi(chip);
        // PA5 is TIM2's instead of SPI1's.
        chip.write(at!(GPIOA.afr(0)), 4, 0x5510_0000);
        select(chip, true);
    }),
    (Rule::FloatingLine, |chip| {
        clocks(chip);
        pins(chip);
        chip.write(at!(GPIOC.moder()), 4, 0xFFFF_7FFF);
    }),
    (Rule::ConvstWidth, |chip| {
        clocks(chip);
        pins(chip);
        chip.write(at!(GPIOC.ospeedr()), 4, 0);
        pulse(chip, 0);
    }),
    (Rule::SpiMode, |chip| {
        spi(chip);
        chip.write(at!(SPI1.cr1()), 4, 0);
        chip.write(at!(SPI1.cr1()), 4, SPI_MODE & !2);
    }),
    (Rule::SpiMode, |chip| {
        spi(chip);
        chip.write(at!(SPI1.cr1()), 4, 0);
        // 85 MHz.
        chip.write(at!(SPI1.cr1()), 4, SPI_MODE & !(7 << 3));
    }),
    (Rule::SpiFifo, |chip| {
        spi(chip);
        let _ = chip.read(at!(SPI1.dr8()), 1);
    }),
    (Rule::SpiFifo, |chip| {
        spi(chip);
        for _ in 0..6 {
            send(chip);
        }
    }),
    (Rule::SpiFifo, |chip| {
        spi(chip);
        for _ in 0..5 {
            send(chip);
            wait_us(chip, 1);
        }
    }),
    (Rule::SpiStale, |chip| {
        spi(chip);
        send(chip);
        wait_us(chip, 1);
        select(chip, true);
    }),
    (Rule::SpiSelect, |chip| {
        spi(chip);
        select(chip, true);
        send(chip);
        select(chip, false);
    }),
    (Rule::DmaSetup, |chip| {
        dma(chip, 10, 0x2000_0000, 0);
        receive(chip);
    }),
    (Rule::DmaWhileOn, |chip| {
        dma(chip, 10, 0x2000_0000, 2);
        receive(chip);
        chip.write(at!(DMA1.ch(0).ndtr()), 4, 2);
    }),
    (Rule::DmaAddress, |chip| {
        // The CCM RAM as the processor sees it.
        dma(chip, 10, 0x1000_0000, 2);
        receive(chip);
    }),
    (Rule::DmaRequest, |chip| {
        // SPI2's request for SPI1's register.
        dma(chip, 12, 0x2000_0000, 2);
        receive(chip);
    }),
    (Rule::DmaRequest, |chip| {
        // To the peripheral at the request of what has come.
        dma(chip, 10, 0x0800_0000, 2);
        chip.write(at!(DMA1.ch(0).cr()), 4, 1 << 4 | DMA_ON);
    }),
    (Rule::CrcSetup, |chip| {
        dma(chip, 10, 0x2000_0000, 2);
        chip.write(at!(CRC.pol()), 4, 0x755A);
        chip.write(at!(CRC.cr()), 4, 1 << 3 | 1);
        chip.write(at!(CRC.dr32()), 4, 1);
    }),
    (Rule::BaudRate, |chip| {
        full_speed(chip, None);
        chip.write(at!(USART1.brr()), 4, 85);
        chip.write(at!(USART1.cr1()), 4, 1);
    }),
    (Rule::AdcSequence, |chip| {
        full_speed(chip, None);
        chip.write(at!(ADC1.cr()), 4, 1);
    }),
    (Rule::AdcStale, |chip| {
        adc(chip);
        convert(chip);
        wait_us(chip, 100_000);
        convert(chip);
    }),
    (Rule::Watchdog, |chip| {
        watchdog(chip);
        // The longest it can be after reset: 4096 cycles of 4 / 32 kHz.
        wait_us(chip, 513_000);
    }),
    (Rule::WatchdogKey, |chip| chip.write(at!(IWDG.pr()), 4, 3)),
    (Rule::SupplyWarning, |chip| {
        clocks(chip);
        chip.write(at!(PWR.cr2()), 4, 5 << 1 | 1);
    }),
    (Rule::FlashKey, |chip| chip.write(at!(FLASH.keyr()), 4, 1)),
    (Rule::FlashLocked, |chip| {
        chip.write(at!(FLASH.cr()), 4, ERASE)
    }),
    (Rule::FlashLocked, |chip| {
        program(chip, false);
        chip.write(at!(FLASH.cr()), 4, ERASE);
        chip.write(at!(FLASH.cr()), 4, ERASE | 1 << 16);
        chip.write(at!(FLASH.cr()), 4, 1);
    }),
    (Rule::FlashErased, |chip| {
        program(chip, false);
        double_word(chip);
        double_word(chip);
    }),
    (Rule::FlashDoubleWord, |chip| {
        program(chip, false);
        chip.write_far(4, 4, 1);
    }),
    (Rule::FlashDoubleWord, |chip| {
        unlock(chip);
        chip.write_far(0, 4, 1);
    }),
    (Rule::FlashDataCache, |chip| {
        program(chip, true);
        double_word(chip);
    }),
    (Rule::FlashStaleCache, |chip| {
        program(chip, false);
        double_word(chip);
        set(chip, at!(FLASH.acr()), 1 << 10);
    }),
    (Rule::OptionBytes, |chip| {
        unlock(chip);
        let options = chip.read(at!(FLASH.optr()), 4);
        chip.write(at!(FLASH.optr()), 4, options);
    }),
    (Rule::OptionBytes, |chip| {
        unlock(chip);
        chip.write(at!(FLASH.optkeyr()), 4, 0x4567_0123);
    }),
    (Rule::OptionBytes, |chip| {
        unlock(chip);
        chip.write(at!(FLASH.cr()), 4, 1 << 30 | 1 << 17);
    }),
    (Rule::FlashSameBank, |chip| {
        program(chip, false);
        chip.write(at!(FLASH.cr()), 4, 2);
        chip.write(at!(FLASH.cr()), 4, 2 | 1 << 16);
    }),
    // The same page number of bank 2, once that is where code runs from.
    (Rule::FlashSameBank, |chip| {
        swapped(chip);
        program(chip, false);
        chip.write(at!(FLASH.cr()), 4, ERASE);
        chip.write(at!(FLASH.cr()), 4, ERASE | 1 << 16);
    }),
    (Rule::BankSwap, |chip| {
        clocks(chip);
        chip.running_at = RAM;
        chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
    }),
    (Rule::BankSwap, |chip| {
        without_caches(chip);
        chip.running_at = 0x0800_0100;
        chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
    }),
    (Rule::BankSwap, |chip| {
        program(chip, false);
        without_caches(chip);
        chip.write_far(0, 4, 1);
        chip.write_far(4, 4, 2);
        chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
    }),
    // Each cache, on again without having been emptied.
    (Rule::FlashStaleCache, |chip| stale_after_swap(chip, 1 << 9)),
    (Rule::FlashStaleCache, |chip| {
        stale_after_swap(chip, 1 << 10)
    }),
];

/// FB_MODE, and a place from which code runs while it is set.
const SWAPPED: u32 = 1 << 8;
const RAM: u32 = 0x2000_0000;
/// Prefetch and caches on, and the bits that empty these.
const CACHES: u32 = 7 << 8;
const CACHE_RESETS: u32 = 3 << 11;

/// Prefetch and caches off and empty, code in RAM.
fn without_caches(chip: &mut Chip) {
    clocks(chip);
    chip.running_at = RAM;
    let off = chip.read(at!(FLASH.acr()), 4) & !CACHES;
    for acr in [off, off | CACHE_RESETS, off] {
        chip.write(at!(FLASH.acr()), 4, acr);
    }
}

/// The banks have changed places, as they should.
fn swapped(chip: &mut Chip) {
    without_caches(chip);
    chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
}

fn stale_after_swap(chip: &mut Chip, cache: u32) {
    clocks(chip);
    chip.running_at = RAM;
    let off = chip.read(at!(FLASH.acr()), 4) & !CACHES;
    chip.write(at!(FLASH.acr()), 4, off);
    chip.write(at!(SYSCFG.memrmp()), 4, SWAPPED);
    chip.write(at!(FLASH.acr()), 4, off | cache);
}

/// Rules that a test of their own trips: with flags at start, and those of the processor (`processor.rs`).
const ELSEWHERE: [Rule; 3] = [Rule::FlashSticky, Rule::Fault, Rule::Reset];

#[test]
fn each_fault_trips_its_rule() {
    for (number, (rule, fault)) in FAULTS.iter().enumerate() {
        let mut chip = chip(Start::default());
        fault(&mut chip);
        let found: Vec<String> = chip
            .findings
            .list()
            .iter()
            .map(ToString::to_string)
            .collect();
        let tripped = chip
            .findings
            .list()
            .iter()
            .any(|violation| violation.rule == *rule);
        assert!(tripped, "fault {number}, {}: found {found:?}", rule.name());
    }
}

#[test]
fn no_rule_is_without_a_fault() {
    for rule in Rule::ALL {
        let known = FAULTS.iter().any(|(tripped, _)| tripped == rule) || ELSEWHERE.contains(rule);
        assert!(known, "{}", rule.name());
    }
}

/// Nothing broken so far.
fn assert_kept(chip: &Chip) {
    assert!(
        chip.findings.list().is_empty(),
        "{:?}",
        chip.findings.list()
    );
}

#[test]
fn a_start_that_keeps_the_rules_trips_none() {
    let mut chip = chip(Start::default());
    spi(&mut chip);
    pulse(&mut chip, 1);
    select(&mut chip, true);
    for _ in 0..3 {
        send(&mut chip);
        wait_us(&mut chip, 1);
        let _ = chip.read(at!(SPI1.dr8()), 1);
    }
    select(&mut chip, false);
    chip.write(at!(USART1.brr()), 4, 170);
    chip.write(at!(USART1.cr1()), 4, 1 << 29 | 1 << 3 | 1 << 2 | 1);
    chip.write(at!(USART1.tdr()), 4, 0);
    chip.write(at!(PWR.cr2()), 4, 6 << 1 | 1);
    wait_us(&mut chip, 100);
    assert_kept(&chip);
}

#[test]
fn bytes_that_come_go_to_memory_in_a_circle_and_their_end_is_told() {
    let mut chip = chip(Start::default());
    dma(&mut chip, 10, 0x2000_0010, 2);
    receive(&mut chip);
    assert_eq!(chip.read(at!(DMA1.isr()), 4) & 1 << 1, 0, "not at its end");
    send(&mut chip);
    wait_us(&mut chip, 1);
    assert_eq!(chip.read(at!(DMA1.isr()), 4) & 1 << 1, 1 << 1);
    chip.write(at!(DMA1.ifcr()), 4, 1);
    assert_eq!(chip.read(at!(DMA1.isr()), 4), 0);
    send(&mut chip);
    wait_us(&mut chip, 1);
    let places: Vec<u32> = chip
        .transfers
        .take_stored()
        .iter()
        .map(|(at, _)| *at)
        .collect();
    assert_eq!(places, [0x2000_0010, 0x2000_0011, 0x2000_0010]);
    assert_kept(&chip);
}

#[test]
fn the_unit_of_check_sums_computes_the_converters() {
    use courier_sensor::drivers::ad7606c::CRC16;
    let mut chip = chip(Start::default());
    dma(&mut chip, 10, 0x2000_0000, 2);
    chip.write(at!(CRC.init()), 4, 0);
    chip.write(at!(CRC.pol()), 4, u32::from(CRC16.algorithm.poly));
    chip.write(at!(CRC.cr()), 4, 1 << 3 | 1);
    for word in [*b"1234", *b"5678"] {
        chip.write(at!(CRC.dr32()), 4, u32::from_be_bytes(word));
    }
    chip.write(at!(CRC.dr8()), 1, u32::from(b'9'));
    let found = chip.read(at!(CRC.dr32()), 4);
    assert_eq!(found, u32::from(CRC16.algorithm.check));
    assert_kept(&chip);
}

#[test]
fn two_readings_in_a_row_are_fresh() {
    let mut chip = chip(Start::default());
    adc(&mut chip);
    for _ in 0..3 {
        chip.write(at!(IWDG.kr()), 4, 0xAAAA);
        convert(&mut chip);
        convert(&mut chip);
        wait_us(&mut chip, 100_000);
    }
    assert_kept(&chip);
}

#[test]
fn the_second_of_a_sequence_is_fresh() {
    let mut chip = chip(Start::default());
    adc(&mut chip);
    // Overwriting; two conversions of channel 16.
    set(&mut chip, at!(ADC1.cfgr()), 1 << 12);
    chip.write(at!(ADC1.sqr1()), 4, 16 << 12 | 16 << 6 | 1);
    for _ in 0..3 {
        chip.write(at!(IWDG.kr()), 4, 0xAAAA);
        convert(&mut chip);
        wait_us(&mut chip, 100_000);
    }
    assert_kept(&chip);
}

#[test]
fn flash_that_is_written_as_the_manual_wants_holds_it_and_trips_none() {
    let mut chip = chip(Start::default());
    program(&mut chip, false);
    chip.write(at!(FLASH.cr()), 4, ERASE);
    chip.write(at!(FLASH.cr()), 4, ERASE | 1 << 16);
    wait_us(&mut chip, 25_000);
    chip.write(at!(FLASH.cr()), 4, 1);
    double_word(&mut chip);
    chip.write(at!(FLASH.cr()), 4, 1 << 31);
    set(&mut chip, at!(FLASH.acr()), 1 << 12);
    let acr = chip.read(at!(FLASH.acr()), 4) & !(1 << 12);
    chip.write(at!(FLASH.acr()), 4, acr);
    set(&mut chip, at!(FLASH.acr()), 1 << 10);
    assert_eq!(
        (
            chip.read_far(0, 4),
            chip.read_far(4, 4),
            chip.read_far(8, 4)
        ),
        (1, 2, u32::MAX)
    );
    assert_kept(&chip);
}

#[test]
fn banks_that_change_places_are_the_same_banks_and_a_reset_takes_it_back() {
    let mut chip = chip(Start::default());
    program(&mut chip, false);
    double_word(&mut chip);
    wait_us(&mut chip, 100);
    chip.write(at!(FLASH.cr()), 4, 1 << 31);
    swapped(&mut chip);
    assert!(chip.take_remapped() && chip.banks_swapped());
    // Bank 1 is the other one now: its pages are those without BKER.
    assert_eq!(chip.read_far(0, 4), u32::MAX);
    program(&mut chip, false);
    double_word(&mut chip);
    wait_us(&mut chip, 100);
    chip.write(at!(FLASH.cr()), 4, 2);
    chip.write(at!(FLASH.cr()), 4, 2 | 1 << 16);
    wait_us(&mut chip, 25_000);
    assert_eq!(chip.read_far(0, 4), u32::MAX, "erased");
    chip.reset(chip::peripheral::rcc::Cause::Software)
        .expect("no host");
    assert!(!chip.banks_swapped());
    assert_eq!(chip.read_far(0, 4), 1, "bank 2 holds what was written");
    assert_kept(&chip);
}

/// CRC-32/ISCSI as the first stage lets the unit make it.
#[test]
fn the_unit_of_check_values_turns_bits_round() {
    let mut chip = chip(Start::default());
    set(&mut chip, at!(RCC.ahb1enr()), 1 << 12);
    chip.write(at!(CRC.pol()), 4, 0x1EDC_6F41);
    chip.write(at!(CRC.cr()), 4, 1 << 7 | 3 << 5 | 1);
    for word in [*b"1234", *b"5678"] {
        chip.write(at!(CRC.dr32()), 4, u32::from_le_bytes(word));
    }
    let wanted = courier_sensor::update::header::CRC32.checksum(b"12345678");
    assert_eq!(!chip.read(at!(CRC.dr32()), 4), wanted);
    assert_kept(&chip);
}

#[test]
fn option_bytes_are_in_force_after_their_load_and_not_before() {
    use chip::peripheral::rcc::Cause;
    let level = |chip: &mut Chip| chip.read(at!(FLASH.optr()), 4) >> 8 & 7;
    let mut chip = chip(Start::default());
    assert_eq!(level(&mut chip), 4);
    unlock(&mut chip);
    for key in [0x0819_2A3B, 0x4C5D_6E7F] {
        chip.write(at!(FLASH.optkeyr()), 4, key);
    }
    let options = chip.read(at!(FLASH.optr()), 4) & !(7 << 8);
    chip.write(at!(FLASH.optr()), 4, options | 3 << 8);
    chip.write(at!(FLASH.cr()), 4, 1 << 17);
    assert_eq!(chip.read(at!(FLASH.sr()), 4) >> 16 & 1, 1, "busy");
    wait_us(&mut chip, 30_000);
    chip.reset(Cause::Software).expect("no host");
    assert_eq!(level(&mut chip), 4, "a plain reset loads nothing");
    unlock(&mut chip);
    for key in [0x0819_2A3B, 0x4C5D_6E7F] {
        chip.write(at!(FLASH.optkeyr()), 4, key);
    }
    assert!(!chip.loads_options());
    chip.write(at!(FLASH.cr()), 4, 1 << 27);
    assert!(chip.loads_options());
    chip.reset(Cause::Options).expect("no host");
    assert_eq!(level(&mut chip), 3);
    assert_kept(&chip);
}

#[test]
fn an_error_flag_of_the_past_stops_an_operation_until_it_is_cleared() {
    let start = Start {
        errors: 1 << 7,
        ..Start::default()
    };
    let mut chip = chip(start);
    program(&mut chip, false);
    double_word(&mut chip);
    let sticky = |chip: &Chip| {
        chip.findings
            .list()
            .iter()
            .any(|v| v.rule == Rule::FlashSticky)
    };
    assert!(sticky(&chip));
    assert_eq!(chip.read_far(0, 4), u32::MAX, "not programmed");
    chip.findings.forgive(Rule::FlashSticky);
    chip.write(at!(FLASH.sr()), 4, 0xC3FA);
    double_word(&mut chip);
    assert_kept(&chip);
    assert_eq!(chip.read_far(0, 4), 1);
}
