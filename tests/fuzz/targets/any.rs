#![no_main]

// Whatever the program takes the bytes for, compressed or not.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ballstick_fuzz::go(None, bytes));
