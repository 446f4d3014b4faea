//! The unit for check sums and check values.

use crate::bench::{assert_kept, chip, set};
use crate::dma::dma;
use chip::peripheral::flash::Start;

trips! {
    crc_setup {
        a_polynomial_longer_than_its_size: |chip| {
            dma(chip, 10, 0x2000_0000, 2);
            chip.write(at!(CRC.pol()), 4, 0x755A);
            chip.write(at!(CRC.cr()), 4, 1 << 3 | 1);
            chip.write(at!(CRC.dr32()), 4, 1);
        };
    }
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
