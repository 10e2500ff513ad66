//! Examples at the end of each `--help`. A test parses them as the command does.

pub(crate) const SHOW: &str = "\
Examples:
  fabkit show rtac0
  fabkit show rtac0 --chain
  fabkit show rtac0/pin-dome --set surface.radius=14mm";

pub(crate) const CHECK: &str = "\
Examples:
  fabkit check uvdtact
  fabkit check my-finger.yaml --json
  fabkit check rtac0/pin-dome --preset published-2025";

pub(crate) const EXPORT: &str = "\
Examples:
  fabkit export rtac0
  fabkit export rtac0/shell --format stl --tolerance 2um
  fabkit export rtac0 --fixtures --bed bambu-a1 -o out/all
  fabkit export rtac0 --set coat.thickness=0.1mm -o out/thin
  fabkit export rtac0 --robot mjcf,usd -o out/robot

A file fabkit.yaml in the working folder sets defaults below `format: 1`: `bed`, `stock`, `profile` \
(--process), `tolerance`, `kerf`, `output` (instead of `out`).";

pub(crate) const SCHEMA: &str = "\
Examples:
  fabkit schema > sensor.schema.json
  fabkit schema --sweep > sweep.schema.json
  fabkit schema --output error";

pub(crate) const GUIDE: &str = "\
Examples:
  fabkit guide rtac0 -o rtac0-guide
  fabkit guide rtac0/pin-dome -o dome-guide
  fabkit guide 9dtact --units 5 -o five";

pub(crate) const DIFF: &str = "\
Examples:
  fabkit diff rtac0 rtac0 --set-to surface.radius=16mm
  fabkit diff rtac0-published-2025 rtac0 -o difference.html
  fabkit diff rtac0/pin-dome rtac0/pin-dome --set-to surface.radius=16mm";

pub(crate) const PROFILE: &str = "\
Examples:
  fabkit export rtac0/coupon
  fabkit profile out/rtac0/coupon/coupon.yaml -o printer.yaml
  fabkit export rtac0 --process printer.yaml
  fabkit export rtac0/gel-coupon
  fabkit profile out/rtac0/gel-coupon/gel-smooth-on-ecoflex-00-30.yaml -o my-batch.yaml";

pub(crate) const RENDER: &str = "\
Examples:
  fabkit render rtac0 --exploded -o exploded.png
  fabkit render rtac0/base --view bottom -o base.png
  fabkit render rtac0 --section --assembly translucent-mold -o mold.png
  fabkit render rtac0 --rays --view -53,0 -o rays.png
  fabkit render rtac0 --camera -o seen.png";

pub(crate) const DEPTH: &str = "\
Examples:
  fabkit depth rtac0 --press semi-dome-017 -o truth.npz --png truth.png
  fabkit depth rtac0 --press hemisphere@30deg,120deg,0.75mm -o truth.npz
  fabkit depth 9dtact --press ball@2mm,-3mm,0.8mm --png truth.png";

pub(crate) const PRESS: &str = "\
Examples:
  fabkit press rtac0 --indenter ball@0deg,0deg --depth 0.6mm
  fabkit press 9dtact --indenter ball@0mm,0mm --depth 0.5mm --csv curve.csv --plot curve.svg -o field.npz";

pub(crate) const CAPTURE: &str = "\
Examples:
  fabkit capture rtac0 --reference -o ref.png
  fabkit capture rtac0 --press ball@24deg,120deg,1mm -o pressed.png --truth pressed.npz
  fabkit capture 9dtact --press ball@0mm,0mm,1.5mm --seed 7 --bits 16 -o pressed.png";

pub(crate) const FIT_LIGHT: &str = "\
Examples:
  fabkit fit-light rtac0 --camera camera.yaml --captures images -o light.json
  fabkit fit-light 9dtact --ball-diameter 8mm --scale 0.051mm --captures balls
  fabkit capture rtac0 --constants light.json --press ball@24deg,120deg,1mm -o pressed.png";

pub(crate) const OPTICS_PACK: &str = "\
Examples:
  fabkit optics-pack digit-like -o digit-optics
  fabkit optics-pack rtac0 --constants light.json -o rtac0-optics";

pub(crate) const DATASET: &str = "\
Examples:
  fabkit dataset rtac0 -o data
  fabkit dataset rtac0 --captures images -o data --resume
  fabkit dataset rtac0 --probes --count 500 -o probes.csv";

pub(crate) const INTRINSICS: &str = "\
Examples:
  fabkit calibrate intrinsics rtac0 --board charuco.board.json *.jpg -o camera.yaml --report lens.html";

pub(crate) const PINS: &str = "\
Examples:
  fabkit calibrate pins 01_05_08.png --reference ref.png --json";

pub(crate) const EXTRINSICS: &str = "\
Examples:
  fabkit calibrate extrinsics rtac0 --camera camera.yaml --captures images -o pose.yaml
  fabkit calibrate extrinsics 9dtact --camera camera.yaml --captures images --pin long -o pose.yaml \
--report pose.html
  fabkit calibrate extrinsics rtac0 --camera camera.yaml --captures halves --fixture semi-domes \
-o pose.yaml";

pub(crate) const RECONSTRUCT: &str = "\
Examples:
  fabkit reconstruct rtac0 --reference ref.png image.png -o depth
  fabkit reconstruct rtac0 --pose pose.yaml --constants light.json --reference ref.png images/*.png -o depth
  fabkit reconstruct rtac0 --network network.onnx --reference ref.png images/*.png -o depth
  fabkit reconstruct uvdtact --light uv --reference ref.png images/*.png -o markers";

pub(crate) const BENCH: &str = "\
Examples:
  fabkit bench uvdtact --quick -o bench
  fabkit bench rtac0 --set translucent_gel.thickness=1.2mm --seed 1 -o thin";

pub(crate) const PLAN: &str = "\
Examples:
  fabkit calibrate plan rtac0 --captures 10
  fabkit calibrate plan rtac0 --camera camera.yaml --done images --pin long";

pub(crate) const SWEEP: &str = "\
Examples:
  fabkit sweep sweep.yaml -o out/sweep
  fabkit sweep sweep.yaml -o out/sweep --resume";

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use crate::cli::Cli;

    /// Of a command and those below it.
    fn examples(command: &clap::Command, found: &mut Vec<String>) {
        let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let lines = text.lines().skip_while(|line| !line.starts_with("Examples:")).skip(1);
        // What follows an empty line is prose.
        let lines = lines.take_while(|line| !line.is_empty());
        found.extend(lines.map(|line| line.trim().to_owned()));
        command.get_subcommands().for_each(|below| examples(below, found));
    }

    #[test]
    fn every_example_is_understood() {
        let mut found = Vec::new();
        examples(&Cli::command(), &mut found);
        assert!(found.len() > 20, "{found:?}");
        for line in found {
            // Where output goes to is the shell's.
            let words = line.split_whitespace().take_while(|word| *word != ">");
            Cli::try_parse_from(words).unwrap_or_else(|e| panic!("{line}: {e}"));
        }
    }
}
