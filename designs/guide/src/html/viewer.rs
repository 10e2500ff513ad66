//! Interactive 3D model, which can be turned, cut and taken apart in the page. It makes no requests, and is invisible
//! without scripts.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fabkit_report::page_with_style;
use serde_json::{Value, json};

/// Script of the viewer, bundled from `viewer/` by `npm run build`, with the licences of its contents.
const SCRIPT: &str = include_str!("../viewer/viewer.js");
/// Style of the viewer, based on the colours of all pages.
pub(super) const STYLE: &str = include_str!("../viewer/viewer.css");

/// Content of the viewer.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewerModel {
    /// Title of the model.
    pub title: String,
    /// GLB file as fabkit writes it; the viewer opens with its first scene.
    pub glb: Vec<u8>,
    /// Camera rays over the first scene.
    pub rays: Option<CameraRays>,
    /// Surface under load, in the first scene.
    pub pressed: Option<PressedSurface>,
}

/// Rays of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraRays {
    /// Rays in any order.
    pub rays: Vec<CameraRay>,
}

/// Ray from the camera to the point it sees.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraRay {
    /// Colour of the point it sees, sRGB.
    pub color: [u8; 3],
    /// Corners of the ray in the frame of the first scene's bodies, mm.
    pub path_mm: Vec<[f64; 3]>,
}

/// Surface that a ball is pressed into.
#[derive(Clone, Debug, PartialEq)]
pub struct PressedSurface {
    /// Diameter of the ball, mm.
    pub ball_mm: f64,
    /// Indentation, mm.
    pub indentation_mm: f64,
    /// Vertices in the frame of the first scene's bodies, mm.
    pub positions_mm: Vec<[f32; 3]>,
    /// Unit normals, one per vertex.
    pub normals: Vec<[f32; 3]>,
    /// sRGB colours, one per vertex, by depth.
    pub colors: Vec<[u8; 3]>,
    /// Triangles, by indices of their vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Names of bodies that are hidden meanwhile, because the ball would penetrate them.
    pub hidden_bodies: Vec<String>,
}

impl ViewerModel {
    /// Returns the section of the page. It is hidden until the script shows it.
    pub(super) fn section(&self) -> String {
        // Escaped, so that no text in the data can end the element.
        let data = self.to_json().to_string().replace('<', "\\u003c");
        format!(
            "<section class=\"viewer\" id=\"model\" hidden>\n<h2>Model</h2>\n\
             <script type=\"application/json\">{data}</script></section>\n"
        )
    }

    /// Returns the script, for the end of the page.
    pub(super) fn script() -> String {
        format!("<script>{SCRIPT}</script>\n")
    }

    /// Returns a page with the model alone. It makes no requests, and opens from disk and in a frame.
    ///
    /// ```
    /// use fabkit_guide::ViewerModel;
    /// let model = ViewerModel { title: "Puck".into(), glb: Vec::new(), rays: None, pressed: None };
    /// assert!(model.to_html().contains("<noscript>"));
    /// ```
    pub fn to_html(&self) -> String {
        let without = "<noscript><p>The model needs JavaScript; <code>fabkit render</code> draws the same as \
                       images.</p></noscript>\n";
        let body = self.section() + without + &Self::script();
        page_with_style(&self.title, STYLE, &body)
    }

    /// Returns the data that the script reads: binary arrays are encoded as base64.
    fn to_json(&self) -> Value {
        let mut json = json!({ "title": self.title, "glb": STANDARD.encode(&self.glb) });
        if let Some(CameraRays { rays }) = &self.rays {
            let ray = |ray: &CameraRay| {
                let path = ray.path_mm.iter().map(|point| point.map(micrometres));
                json!({ "color": ray.color, "path_mm": path.collect::<Vec<_>>() })
            };
            let rays: Vec<Value> = rays.iter().map(ray).collect();
            json["rays"] = json!({ "title": "Rays of the camera", "rays": rays });
        }
        if let Some(pressed) = &self.pressed {
            let floats = |vectors: &[[f32; 3]]| {
                let numbers = vectors.as_flattened().iter();
                STANDARD.encode(numbers.flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>())
            };
            let corners = pressed.triangles.as_flattened().iter();
            let corners: Vec<u8> = corners.flat_map(|corner| corner.to_le_bytes()).collect();
            let PressedSurface { ball_mm, indentation_mm: deep_mm, .. } = pressed;
            json["pressed"] = json!({
                "title": format!("Pressed: a ball of {ball_mm} mm, {deep_mm:.2} mm deep, dark is 0"),
                "instead_of": pressed.hidden_bodies,
                "positions": floats(&pressed.positions_mm),
                "normals": floats(&pressed.normals),
                "colors": STANDARD.encode(pressed.colors.as_flattened()),
                "triangles": STANDARD.encode(corners),
            });
        }
        json
    }
}

/// Rounds to a micrometre, which is enough for lines; adding zero avoids -0.
fn micrometres(mm: f64) -> f64 {
    (mm * 1e3).round() / 1e3 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_ends_the_element_and_the_licence_stays() {
        let title = "</script><b>".to_owned();
        let model = ViewerModel { title, glb: vec![0; 4], rays: None, pressed: None };
        let section = model.section();
        assert_eq!(section.matches("</script").count(), 1, "{section}");
        assert!(SCRIPT.contains("Permission is hereby granted") && !SCRIPT.contains("</script"));
    }
}
