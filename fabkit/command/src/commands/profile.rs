//! `fabkit profile COUPON.yaml -o FILE.yaml`: profile of a printer, or of a gel batch.

use std::path::Path;

use fabkit_application::designs::profile::{CouponGroup, GelCoupon, LinearFit, MeasuredProfile};
use fabkit_application::edited_files::{check_replaceable, sign_text};
use fabkit_application::reading::{self, ExpectedFile};
use fabkit_application::source::MAX_YAML_BYTES;
use fabkit_application::staging::write_each;
use fabkit_application::text::{FileSafeName, Scalar};
use serde_json::{Value, json};

use super::Outcome;
use crate::cli::Profile;
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::FileRoles;
use crate::table::{Align::Left, Align::Right, table};

pub(super) fn run(args: &Profile) -> Result<Outcome, Failure> {
    FileRoles::default()
        .reads("COUPON.yaml", [&args.coupon])
        .writes("-o", [&args.output])
        .check()?;
    let hint = "is it the right file? `fabkit export` with `SENSOR/coupon` or `SENSOR/gel-coupon` writes it";
    let expected = ExpectedFile { what: "a coupon's file", max_bytes: MAX_YAML_BYTES, hint };
    let (file, text) =
        (args.coupon.display().to_string(), reading::read_text(&args.coupon, expected)?);
    let (text, outcome) = if GelCoupon::is_gel_file(&text) {
        stem(&args.output)?;
        super::gel_profile::fit_gel(args, &file, &text)?
    } else {
        evaluate_coupon(args, file, text)?
    };
    let text = sign_text(&text);
    let files = [(args.output.clone(), text.into_bytes())];
    check_replaceable(&files, args.force)?;
    interrupt::begin_writing()?;
    let files = files.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
    write_each(files, &interrupt::is_requested)?;
    Ok(outcome)
}

/// Evaluates a printed coupon. Returns the profile's file and the outcome.
fn evaluate_coupon(
    args: &Profile,
    file: String,
    text: String,
) -> Result<(String, Outcome), Failure> {
    let name = printer(&args.output)?;
    let measured = MeasuredProfile::read(&file, &text, &name)
        .map_err(|invalid| Failure::invalid(invalid, file, text))?;
    let outcome = Outcome {
        text: text_of(&measured, &args.output),
        json: json_of(&measured, &args.output),
        failed: false,
    };
    Ok((measured.profile.to_yaml(&comments(&measured)), outcome))
}

fn bad(message: String, hint: &str) -> Failure {
    Failure::new(ErrorKind::BadInput, message, hint)
}

/// Returns the output's name without its ending, which must be that of YAML.
fn stem(output: &Path) -> Result<&str, Failure> {
    let shown = output.display();
    let hint = "write for example `-o my-printer.yaml`";
    let (Some(file), Some(stem)) = (
        output.file_name().and_then(|name| name.to_str()),
        output.file_stem().and_then(|name| name.to_str()),
    ) else {
        return Err(bad(format!("{shown} does not name a file"), hint));
    };
    if !file.ends_with(".yaml") && !file.ends_with(".yml") {
        return Err(bad(format!("{shown} does not end in .yaml"), hint));
    }
    Ok(stem)
}

/// Returns the printer's name, which is the output's name.
fn printer(output: &Path) -> Result<FileSafeName, Failure> {
    let stem = stem(output)?;
    FileSafeName::parse(stem).map_err(|refusal| {
        let hint = "write for example `-o my-printer.yaml`";
        bad(format!("`{stem}` cannot be a printer's name: it {}", refusal.says), hint)
    })
}

/// Lists the other measurements as comments of the file.
fn comments(measured: &MeasuredProfile) -> Vec<String> {
    let mut comments = vec![
        "What a printer does to sizes: printed = gain * designed + offset.".to_owned(),
        "From a measured coupon; standard deviations:".to_owned(),
    ];
    comments.extend(measured.fits.iter().map(|(group, fit)| {
        format!(
            "  {}: offset {:+.3} +- {:.3} mm, gain {:.5} +- {:.5}, from {} sizes",
            group.key(),
            fit.offset_mm,
            fit.sigma_offset_mm,
            fit.gain,
            fit.sigma_gain,
            fit.count
        )
    }));
    comments.extend(
        measured
            .smallest_mm
            .iter()
            .map(|(group, mm)| format!("  smallest of the {} that came out: {mm} mm", group.key())),
    );
    comments.push(
        "`export --process` scales files against shrinkage and fits upright round holes. Pins,"
            .into(),
    );
    comments
        .push("slots and walls stay as designed; enter the elephant foot in your slicer.".into());
    comments
}

fn text_of(measured: &MeasuredProfile, output: &Path) -> String {
    let cells = |cells: [&str; 5]| cells.map(str::to_owned).to_vec();
    let mut rows = vec![cells(["measured", "sizes", "offset mm", "gain", "shrinkage %"])];
    for (group, fit) in &measured.fits {
        rows.push(vec![
            group.key().to_owned(),
            fit.count.to_string(),
            format!("{:+.3} +- {:.3}", fit.offset_mm, fit.sigma_offset_mm),
            format!("{:.5} +- {:.5}", fit.gain, fit.sigma_gain),
            shrinkage(*group, fit),
        ]);
    }
    let profile = &measured.profile;
    let mut text = table(&[Left, Right, Right, Right, Right], &rows);
    text += &format!("elephant foot {:.3} mm on each side\n", profile.elephant_foot.mm());
    for (group, mm) in &measured.smallest_mm {
        text += &format!("smallest of the {}: {mm} mm\n", group.key());
    }
    text + &format!("{}: {} on {}\n", output.display(), profile.material, profile.name.as_str())
}

/// Formats the shrinkage of a group. Only for lengths is the slope due to shrinkage alone.
fn shrinkage(group: CouponGroup, fit: &LinearFit) -> String {
    use CouponGroup::{LengthsX, LengthsY, LengthsZ};
    match group {
        LengthsX | LengthsY | LengthsZ => {
            format!("{:.3} +- {:.3}", 100.0 * (1.0 - fit.gain), 100.0 * fit.sigma_gain)
        }
        _ => String::new(),
    }
}

fn json_of(measured: &MeasuredProfile, output: &Path) -> Value {
    let fits: serde_json::Map<String, Value> = measured
        .fits
        .iter()
        .map(|(group, fit)| {
            let fit = json!({
                "offset_mm": fit.offset_mm,
                "sigma_offset_mm": fit.sigma_offset_mm,
                "gain": fit.gain,
                "sigma_gain": fit.sigma_gain,
                "sizes": fit.count,
            });
            (group.key().to_owned(), fit)
        })
        .collect();
    let smallest: serde_json::Map<String, Value> = measured
        .smallest_mm
        .iter()
        .map(|(group, mm)| (group.key().to_owned(), json!(mm)))
        .collect();
    json!({
        "format": "fabkit-profile",
        "version": 1,
        "file": output.display().to_string(),
        "printer": measured.profile.name.as_str(),
        "elephant_foot_mm": measured.profile.elephant_foot.mm(),
        "fits": fits,
        "smallest_mm": smallest,
    })
}
