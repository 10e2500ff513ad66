//! `cargo run --release -p fabkit-tests --example edits [-- SENSOR...]`: the share of edits that is
//! refused, and why.

use std::env;

use fabkit_tests::edits;

fn main() {
    let named: Vec<String> = env::args().skip(1).collect();
    let all = ["rtac0", "shadowtac", "tactip", "uvdtact", "fluidic", "9dtact"].map(str::to_owned);
    for sensor in if named.is_empty() { &all[..] } else { &named[..] } {
        for share in [0.1, 0.25] {
            let edits = edits(sensor, share);
            let refused: Vec<_> = edits.iter().filter(|e| !e.problems.is_empty()).collect();
            let percent = 100.0 * refused.len() as f64 / edits.len() as f64;
            let (of, share) = (edits.len(), 100.0 * share);
            println!("{sensor} by {share} %: {} of {of} refused, {percent:.1} %", refused.len());
            for edit in refused.iter().filter(|_| !named.is_empty()) {
                println!("  {} = {}", edit.path, edit.value);
                for problem in &edit.problems {
                    println!("    {}", problem.message);
                }
            }
        }
    }
}
