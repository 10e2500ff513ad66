//! Evaluates a network on an image, for `tests/oracles/check_onnx.py` to compare with another runtime.
//!
//! `evaluate NETWORK.onnx IN COLUMNS OUT [touched]`: files hold 32-bit numbers, row by row. Prints the seconds of the
//! fastest of five runs. `RAYON_NUM_THREADS` sets the number of threads.

use std::time::Instant;

use fabkit_network::Network;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (network, input, columns, output) = match &words[..] {
        [network, input, columns, output, ..] => (network, input, columns.parse()?, output),
        _ => return Err("evaluate NETWORK.onnx IN COLUMNS OUT [touched]".into()),
    };
    let network = Network::read(&std::fs::read(network)?)?;
    let bytes = std::fs::read(input)?;
    let image: Vec<f32> =
        bytes.as_chunks().0.iter().map(|four| f32::from_le_bytes(*four)).collect();
    let touched = words.get(4).is_some_and(|word| word == "touched");
    let (mut fastest_s, mut found) = (f64::INFINITY, Vec::new());
    for _ in 0..5 {
        let start = Instant::now();
        found = if touched {
            network.run_nonzero(&image, columns)?
        } else {
            network.run(&image, columns)?
        };
        fastest_s = fastest_s.min(start.elapsed().as_secs_f64());
    }
    let bytes: Vec<u8> = found.iter().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(output, bytes)?;
    println!("{fastest_s}");
    Ok(())
}
