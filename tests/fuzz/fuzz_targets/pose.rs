#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| fabkit_fuzz_targets::targets::pose(data));
