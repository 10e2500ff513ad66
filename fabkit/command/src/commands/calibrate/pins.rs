//! `fabkit calibrate pins --reference ref.png IMAGE...`

use std::fmt::Write;

use fabkit_application::calibration::pin_detection::{
    Detection, DetectionOptions, Polarity, RejectionReason,
};
use fabkit_application::calibration_runs::images;
use serde_json::{Value, json};

use super::Outcome;
use crate::cli::CalibratePins;
use crate::failure::Failure;
use crate::table::format_count;

pub(super) fn run(args: &CalibratePins) -> Result<Outcome, Failure> {
    let polarity = if args.brighter { Polarity::Brighter } else { Polarity::Darker };
    let options = DetectionOptions { polarity, ..DetectionOptions::default() };
    let detections = images::detect_all(&args.reference, &args.images, &options)?;
    let files = args.images.iter().map(|path| path.display().to_string());
    let mut text = String::new();
    let mut images = Vec::new();
    for (file, detection) in files.zip(&detections) {
        let _ = writeln!(text, "{file}: {}", format_count(detection.marks.kept().len(), "pin"));
        for mark in detection.marks.kept() {
            let _ = writeln!(
                text,
                "  ({:8.2}, {:8.2}) px, sigma {:.2} px, contrast {:.2}, {:.0} times the noise",
                mark.pixel.x,
                mark.pixel.y,
                mark.sigma_px,
                mark.contrast,
                mark.significance.sigmas()
            );
        }
        let left_out = detection.marks.summary();
        if left_out.count > 0 {
            let _ = writeln!(text, "  {left_out}");
        }
        images.push(image_json(&file, detection));
    }
    let json = json!({
        "format": "fabkit-pins",
        "version": 1,
        "reference": args.reference.display().to_string(),
        "images": images,
    });
    Ok(Outcome { text, json, failed: false })
}

fn image_json(file: &str, detection: &Detection) -> Value {
    let marks = detection.marks.kept().iter().map(|mark| {
        json!({
            "pixel": [mark.pixel.x, mark.pixel.y],
            "sigma_px": mark.sigma_px,
            "contrast": mark.contrast,
            "significance": mark.significance.sigmas(),
            "diameter_px": mark.diameter_px,
            "hidden_outline": mark.hidden_outline,
        })
    });
    let rejected = detection.rejected.iter().map(|(pixel, reason)| {
        let reason = match reason {
            RejectionReason::TooSmall => "too small",
            RejectionReason::TooLarge => "too large",
            RejectionReason::Elongated => "elongated",
            RejectionReason::Hidden => "hidden",
        };
        json!({ "pixel": [pixel.x, pixel.y], "reason": reason })
    });
    let left_out = detection.marks.left_out().iter().map(|spot| {
        json!({
            "pixel": [spot.pixel.x, spot.pixel.y],
            "contrast": spot.contrast,
            "significance": spot.significance.sigmas(),
        })
    });
    json!({
        "file": file,
        "pins": marks.collect::<Vec<_>>(),
        "rejected": rejected.collect::<Vec<_>>(),
        "left_out": left_out.collect::<Vec<_>>(),
        "noise": detection.noise,
    })
}
