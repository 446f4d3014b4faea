//! Exceptions as an ARMv7-M takes them, on programs of a few instructions.

use crate::bench::{around, clear};
use crate::steps::unlock;
use chip::chip::Chip;
use chip::peripheral::flash::Start;
use chip::processor::Processor;
use chip::rule::Rule;
use chip::time::from_us;

const STACK: u32 = 0x2000_1004;
const FLASH: u32 = 0x0800_0000;
const RESET_AT: u32 = 0x100;
const HANDLER_AT: u32 = 0x180;
/// Branch to itself; return.
const STAY: u16 = 0xE7FE;
const RETURN: u16 = 0x4770;

/// A program after reset, and a handler of this exception.
fn start(program: &[u16], exception: u32, handler: &[u16]) -> Processor {
    let mut flash = vec![0xFF; 256 << 10];
    let mut put =
        |at: u32, bytes: &[u8]| flash[at as usize..][..bytes.len()].copy_from_slice(bytes);
    put(0, &STACK.to_le_bytes());
    put(4, &(FLASH + RESET_AT + 1).to_le_bytes());
    put(4 * exception, &(FLASH + HANDLER_AT + 1).to_le_bytes());
    for (at, code) in [(RESET_AT, program), (HANDLER_AT, handler)] {
        let bytes: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
        put(at, &bytes);
    }
    Processor::start(&flash, Chip::new(around(), Start::default())).expect("it starts")
}

fn run_us(processor: &mut Processor, us: u64) {
    processor.run(from_us(us)).expect("it runs");
}

#[test]
fn a_handler_sees_its_number_and_what_it_changes_comes_back() {
    // movs r0,#7; svc #0 | mrs r4,ipsr; movs r0,#9; bx lr
    let program = [0x2007, 0xDF00, STAY];
    let mut processor = start(&program, 11, &[0xF3EF, 0x8405, 0x2009, RETURN]);
    run_us(&mut processor, 10);
    let register = |number| processor.register(number);
    assert_eq!((register(0), register(4), register(13)), (7, 11, STACK));
    assert_eq!(register(15), FLASH + RESET_AT + 4);
}

#[test]
fn floating_point_registers_come_back() {
    // vmov.f32 s0,#1.0; svc #0 | vmov.f32 s0,#2.0; bx lr
    let program = [0xEEB7, 0x0A00, 0xDF00, STAY];
    let mut processor = start(&program, 11, &[0xEEB0, 0x0A00, RETURN]);
    run_us(&mut processor, 10);
    assert_eq!(processor.float_register(0), 1.0f32.to_bits());
    assert_eq!(processor.register(13), STACK);
}

/// mov r4,sp; mov r5,lr
const FRAME: [u16; 2] = [0x466C, 0x4675];

#[test]
fn a_frame_is_as_long_as_what_is_in_use() {
    // Without floating-point registers: 8 words, and one of padding since the stack is not at a multiple of eight.
    let handler = [FRAME[0], FRAME[1], RETURN];
    let mut processor = start(&[0xDF00, STAY], 11, &handler);
    run_us(&mut processor, 10);
    let found = [4, 5, 13].map(|number| processor.register(number));
    assert_eq!(found, [STACK - 36, 0xFFFF_FFF9, STACK]);
    // vmov.f32 s0,#1.0; svc #0: 26 words.
    let mut processor = start(&[0xEEB7, 0x0A00, 0xDF00, STAY], 11, &handler);
    run_us(&mut processor, 10);
    let found = [4, 5, 13].map(|number| processor.register(number));
    assert_eq!(found, [STACK - 108, 0xFFFF_FFE9, STACK]);
}

#[test]
fn a_handler_follows_another_without_the_frame_between_them() {
    // The vector table in RAM: movw r0,#0xED08; movt r0,#0xE000; movw r1,#0x8000; movt r1,#0x2001; str r1,[r0]. PendSV waits, of lower
    // priority than the supervisor call: movw r0,#0xED20; movt r0,#0xE000; movs r1,#0xFF; strb r1,[r0,#2]; svc #0.
    let program = [
        0xF64E, 0x5008, 0xF2CE, 0x0000, 0xF248, 0x0100, 0xF2C2, 0x0101, 0x6001, 0xF64E, 0x5020,
        0xF2CE, 0x0000, 0x21FF, 0x7081, 0xDF00, STAY,
    ];
    // movw r0,#0xED04; movt r0,#0xE000; mov r1,#0x10000000; str r1,[r0]; mov r4,sp; bx lr
    let calls = [
        0xF64E, 0x5004, 0xF2CE, 0x0000, 0xF04F, 0x5180, 0x6001, 0x466C, RETURN,
    ];
    let mut processor = start(&program, 11, &calls);
    // PendSV's: mov r6,sp; mov r5,lr; bx lr.
    let second = [0x466E, 0x4675, RETURN].map(u16::to_le_bytes).concat();
    let (table, place) = (0x2001_8000, 0x2001_C000);
    let vector = |address: u32| (address + 1).to_le_bytes();
    for (at, bytes) in [
        (place, &second[..]),
        (table + 4 * 11, &vector(FLASH + HANDLER_AT)),
        (table + 4 * 14, &vector(place)),
    ] {
        processor.write_memory(at, bytes).expect("it is RAM");
    }
    run_us(&mut processor, 20);
    let found = [4, 6, 5, 13].map(|number| processor.register(number));
    assert_eq!(found, [STACK - 36, STACK - 36, 0xFFFF_FFF9, STACK]);
}

/// movw r0,#0xE010; movt r0,#0xE000; movs r1,#99; str r1,[r0,#4]; movs r1,#7; str r1,[r0]: the timer, every 100 cycles.
const TIMER: [u16; 8] = [
    0xF24E, 0x0010, 0xF2CE, 0x0000, 0x2163, 0x6041, 0x2107, 0x6001,
];
/// adds r5,#1; bx lr
const COUNT: [u16; 2] = [0x3501, RETURN];

#[test]
fn the_timer_interrupts_at_its_period() {
    let program: Vec<u16> = TIMER.into_iter().chain([STAY]).collect();
    let mut processor = start(&program, 15, &COUNT);
    run_us(&mut processor, 1000);
    // 16,000 cycles after reset.
    let count = processor.register(5);
    assert!((158..=160).contains(&count), "{count}");
}

#[test]
fn a_masked_interrupt_waits_until_the_mask_is_gone() {
    // movw r2,#0xED20; movt r2,#0xE000; movs r1,#0x80; strb r1,[r2,#3]; movs r3,#0x40; msr basepri,r3
    let mask = [
        0xF64E, 0x5220, 0xF2CE, 0x0200, 0x2180, 0x70D1, 0x2340, 0xF383, 0x8811,
    ];
    // movw r6,#1000; subs r6,#1; bne; movs r3,#0; msr basepri,r3
    let unmask = [
        0xF240, 0x36E8, 0x3E01, 0xD1FD, 0x462F, 0x2300, 0xF383, 0x8811, STAY,
    ];
    let program: Vec<u16> = mask.into_iter().chain(TIMER).chain(unmask).collect();
    let mut processor = start(&program, 15, &COUNT);
    run_us(&mut processor, 1000);
    // mov r7,r5 before the mask goes: none had come by then.
    assert_eq!(processor.register(7), 0);
    assert!(processor.register(5) > 100, "{}", processor.register(5));
}

mod fault {
    use super::*;

    #[test]
    fn an_access_to_nothing_is_a_hard_one() {
        // movs r0,#0; movt r0,#0x3000; ldr r1,[r0] | movs r4,#3
        let program = [0x2000, 0xF2C3, 0x0000, 0x6801, STAY];
        let mut processor = start(&program, 3, &[0x2403, STAY]);
        run_us(&mut processor, 10);
        assert_eq!(processor.register(4), 3);
        assert_eq!(processor.findings().list()[0].rule, Rule::Fault);
    }
}

#[test]
fn code_runs_from_ram_too() {
    // movs r0,#0; movt r0,#0x2000; movw r1,#0x2407; movt r1,#0xE7FE; str r1,[r0]; adds r0,#1; bx r0: movs r4,#7; a branch to itself.
    let program = [
        0x2000, 0xF2C2, 0x0000, 0xF242, 0x4107, 0xF2CE, 0x71FE, 0x6001, 0x3001, 0x4700,
    ];
    let mut processor = start(&program, 3, &[STAY]);
    run_us(&mut processor, 10);
    assert_eq!(processor.register(4), 7);
    assert_eq!(processor.register(15), 0x2000_0002);
    assert!(processor.findings().list().is_empty());
}

#[test]
fn a_stack_that_runs_over_still_reaches_the_hard_fault() {
    // movs r0,#0; movt r0,#0x2000; mov sp,r0; push {r0} | movs r4,#3
    let program = [0x2000, 0xF2C2, 0x0000, 0x4685, 0xB401, STAY];
    let mut processor = start(&program, 3, &[0x2403, STAY]);
    run_us(&mut processor, 10);
    assert_eq!(processor.register(4), 3);
    assert!(processor.register(13) < 0x2000_0000);
}

mod reset {
    use super::*;

    #[test]
    fn one_that_nobody_asked_for() {
        // movw r0,#0xED0C; movt r0,#0xE000; movw r1,#4; movt r1,#0x05FA; str r1,[r0]
        let program = [
            0xF64E, 0x500C, 0xF2CE, 0x0000, 0xF240, 0x0104, 0xF2C0, 0x51FA, 0x6001, STAY,
        ];
        let mut processor = start(&program, 3, &[STAY]);
        run_us(&mut processor, 10);
        assert!(processor.resets() > 0);
        assert_eq!(processor.findings().list()[0].rule, Rule::Reset);
    }
}

#[test]
fn waiting_for_an_interrupt_takes_time_and_no_instructions() {
    // the timer; wfi; mov r6,r5
    let program: Vec<u16> = TIMER.into_iter().chain([0xBF30, 0x462E, STAY]).collect();
    let mut processor = start(&program, 15, &COUNT);
    run_us(&mut processor, 12);
    assert_eq!(processor.register(6), 1);
}

/// movw r1,#0x400; movt r1,#0x0800; here: ldr r0,[r1]; adds r2,#1; b here
const LOADS: [u16; 7] = [0xF240, 0x4100, 0xF6C0, 0x0100, 0x6808, 0x3201, 0xE7FC];
/// Access control of the flash: four wait states, instruction cache; the data cache besides.
const NO_DATA_CACHE: u32 = 4 | 1 << 9;
const DATA_CACHE: u32 = NO_DATA_CACHE | 1 << 10;

/// How often the loop that loads from flash goes round within 100 us.
fn rounds(access: u32, counted: bool) -> u32 {
    let mut processor = start(&LOADS, 11, &[RETURN]);
    processor.chip().write(at!(FLASH.acr()), 4, access);
    processor.set_wait_states(counted).expect("unicorn can");
    run_us(&mut processor, 100);
    processor.register(2)
}

#[test]
fn a_load_from_flash_waits_unless_the_data_cache_holds_it() {
    let without = rounds(DATA_CACHE, false);
    let cached = rounds(DATA_CACHE, true);
    assert!(
        without.abs_diff(cached) <= 5,
        "{without} rounds, {cached} with wait states"
    );
    // 16 MHz: 1,600 cycles. A round takes 6 (load 2, addition 1, branch 3), and four more.
    let uncached = rounds(NO_DATA_CACHE, true);
    assert!((155..=160).contains(&uncached), "{uncached} rounds");
    assert!((260..=267).contains(&without), "{without} rounds");
}

#[test]
fn a_read_of_the_bank_that_is_erased_holds_the_processor_up() {
    // movw r1,#0; movt r1,#0x0804; ldr r0,[r1]; movs r2,#1
    let program = [0xF240, 0x0100, 0xF6C0, 0x0104, 0x6808, 0x2201, STAY];
    let mut processor = start(&program, 11, &[RETURN]);
    let chip = processor.chip();
    unlock(chip);
    clear(chip, at!(FLASH.acr()), 1 << 10);
    chip.write(at!(FLASH.cr()), 4, 1 << 1 | 1 << 11 | 1 << 16);
    run_us(&mut processor, 100);
    // An erase takes 22 ms: 352,000 cycles at 16 MHz.
    assert!((352_000..352_100).contains(&processor.cycles()));
    let found = processor.findings().list();
    let rules: Vec<Rule> = found.iter().map(|violation| violation.rule).collect();
    assert_eq!(rules, [Rule::FlashReadWhileWrite]);
}
