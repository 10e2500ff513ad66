//! Slicer settings of each object, for PrusaSlicer and for OrcaSlicer and its relatives.
//!
//! Printer, filament and temperatures are left out: a file with a whole configuration would replace the user's choice,
//! while settings of objects only override it.

use super::{PrintObject, Xml, object_id};

/// Slicer settings of one object, common to both slicers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicerSettings {
    /// Layer height, mm.
    pub layer_mm: f64,
    /// Number of perimeters.
    pub perimeters: u32,
    /// Number of solid layers at the bottom, and as many at the top.
    pub solid_layers: u32,
    /// Infill density, %.
    pub infill_percent: f64,
    /// True if supports are printed.
    pub supports: bool,
    /// Width of the brim, mm; 0 for none.
    pub brim_mm: f64,
}

type Words = Vec<(&'static str, String)>;

fn switch(is_on: bool) -> String {
    u8::from(is_on).to_string()
}

impl SlicerSettings {
    fn prusa(&self) -> Words {
        vec![
            ("layer_height", self.layer_mm.to_string()),
            ("perimeters", self.perimeters.to_string()),
            ("top_solid_layers", self.solid_layers.to_string()),
            ("bottom_solid_layers", self.solid_layers.to_string()),
            ("fill_density", format!("{}%", self.infill_percent)),
            ("support_material", switch(self.supports)),
            ("brim_width", self.brim_mm.to_string()),
        ]
    }

    fn orca(&self) -> Words {
        let brim = if self.brim_mm > 0.0 { "outer_only" } else { "no_brim" };
        vec![
            ("layer_height", self.layer_mm.to_string()),
            ("wall_loops", self.perimeters.to_string()),
            ("top_shell_layers", self.solid_layers.to_string()),
            ("bottom_shell_layers", self.solid_layers.to_string()),
            ("sparse_infill_density", format!("{}%", self.infill_percent)),
            ("enable_support", switch(self.supports)),
            ("brim_type", brim.to_owned()),
            ("brim_width", self.brim_mm.to_string()),
        ]
    }
}

/// A build object with the objects whose meshes it consists of.
struct Item<'a> {
    id: usize,
    name: &'a str,
    settings: SlicerSettings,
    /// Ids and objects; several for one piece of several materials.
    volumes: Vec<(usize, &'a PrintObject<'a>)>,
}

/// Returns the configuration files beside the model, by name; none if no object has settings.
pub(super) fn configs(objects: &[PrintObject], piece: Option<&str>) -> Vec<(&'static str, String)> {
    let numbered = || objects.iter().enumerate().map(|(i, object)| (object_id(i), object));
    let item = |id, name, volumes: Vec<_>| {
        // All volumes of a piece are printed with the settings of the first that has any.
        let settings =
            volumes.iter().find_map(|(_, object): &(usize, &PrintObject)| object.settings)?;
        Some(Item { id, name, settings, volumes })
    };
    let items: Vec<Item> = match piece {
        Some(name) => {
            item(object_id(objects.len()), name, numbered().collect()).into_iter().collect()
        }
        None => numbered()
            .filter_map(|(id, object)| item(id, object.name, vec![(id, object)]))
            .collect(),
    };
    if items.is_empty() {
        return Vec::new();
    }
    vec![
        ("Metadata/Slic3r_PE_model.config", prusa(&items)),
        ("Metadata/model_settings.config", orca(&items)),
    ]
}

/// Returns the extruder slot of each volume; `None` unless the piece has several materials.
fn slots(volumes: &[(usize, &PrintObject)]) -> Vec<Option<usize>> {
    let mut materials: Vec<_> =
        volumes.iter().map(|(_, object)| (object.material, object.color)).collect();
    let all = materials.clone();
    let mut seen = Vec::new();
    materials.retain(|material| {
        let is_new = !seen.contains(material);
        seen.push(*material);
        is_new
    });
    let slot = |material| materials.iter().position(|m| *m == material).map(|i| i + 1);
    all.into_iter().map(|one| slot(one).filter(|_| materials.len() > 1)).collect()
}

/// Writes PrusaSlicer's configuration, in which the triangles of an object's volumes are numbered consecutively.
fn prusa(items: &[Item]) -> String {
    let mut xml = Xml::document("config");
    for item in items {
        xml.line(&format!(r#" <object id="{}" instances_count="1">"#, item.id));
        let object = |xml: &mut Xml, key: &str, value: &str| {
            xml.setting(r#"  <metadata type="object" "#, key, value);
        };
        object(&mut xml, "name", item.name);
        for (key, value) in item.settings.prusa() {
            object(&mut xml, key, &value);
        }
        let mut first = 0;
        for ((_, volume), slot) in item.volumes.iter().zip(slots(&item.volumes)) {
            let count = volume.mesh.triangles().len();
            xml.line(&format!(r#"  <volume firstid="{first}" lastid="{}">"#, first + count - 1));
            first += count;
            xml.setting(r#"   <metadata type="volume" "#, "name", volume.name);
            if let Some(slot) = slot {
                xml.setting(r#"   <metadata type="volume" "#, "extruder", &slot.to_string());
            }
            xml.line("  </volume>");
        }
        xml.line(" </object>");
    }
    xml.line("</config>");
    xml.0
}

/// Writes the configuration of OrcaSlicer, Bambu Studio and their relatives.
fn orca(items: &[Item]) -> String {
    let mut xml = Xml::document("config");
    for item in items {
        xml.line(&format!(r#"  <object id="{}">"#, item.id));
        xml.setting("    <metadata ", "name", item.name);
        for (key, value) in item.settings.orca() {
            xml.setting("    <metadata ", key, &value);
        }
        for ((id, volume), slot) in item.volumes.iter().zip(slots(&item.volumes)) {
            xml.line(&format!(r#"    <part id="{id}" subtype="normal_part">"#));
            xml.setting("      <metadata ", "name", volume.name);
            if let Some(slot) = slot {
                xml.setting("      <metadata ", "extruder", &slot.to_string());
            }
            xml.line("    </part>");
        }
        xml.line("  </object>");
    }
    xml.line("</config>");
    xml.0
}

impl Xml {
    fn document(root: &str) -> Self {
        Self(format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<{root}>\n"))
    }

    fn setting(&mut self, start: &str, key: &str, value: &str) {
        self.put(&format!(r#"{start}key="{key}" value=""#));
        self.escaped(value);
        self.line(r#""/>"#);
    }
}
