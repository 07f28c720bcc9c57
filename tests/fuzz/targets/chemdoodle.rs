#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ballstick_fuzz::go(Some(ballstick::import::Format::ChemDoodleJson), bytes));
