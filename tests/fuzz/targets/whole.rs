#![no_main]

// Whatever the program takes the bytes for, up to a small picture.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ballstick_fuzz::draw(bytes));
