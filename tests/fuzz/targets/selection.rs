#![no_main]

// A selection, asked of a peptide; what is written of it means the same.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| ballstick_fuzz::selection(bytes));
