//! Questions of rules for properties of materials, and which of them nobody answered.
//!
//! Rules reach the properties of a body only through here: each question that no source answers is written down with
//! the rule that asked it, and ends up in [`CheckReport::not_known`](crate::CheckReport::not_known). A rule that skips
//! such a body cannot do so silently. A test reads this crate's sources and refuses any other way.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{
    Body, BodyKind, CureMechanism, Elasticity, MaterialClass, MaterialProperty, OpticalClarity,
    Shore,
};

use crate::rule::Rule;

/// A property that a rule or an image needed and no source at hand states.
///
/// ```
/// use fabkit_checks::UnknownProperty;
/// use fabkit_geometry::{Body, MaterialProperty, Process, Solid};
///
/// let cube = Body::made("shell", "", Process::Fdm, Solid::cuboid(1.0, 1.0, 1.0));
/// let cube = cube.with_material("unobtainium");
/// let unknown = UnknownProperty::of_body(MaterialProperty::Reflectance, &cube);
/// assert_eq!(unknown.subject(), "reflectance of unobtainium");
/// assert!(unknown.remedy.contains("state `reflectance` of `unobtainium`"));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownProperty {
    /// The property.
    pub property: MaterialProperty,
    /// Name of the material; empty if the bodies state none.
    pub material: String,
    /// Names of the bodies that are of it, in order.
    pub bodies: Vec<String>,
    /// Rules that needed the property, and left these bodies out, in order; none where an image needed it.
    pub rules: Vec<Rule>,
    /// What would settle it, as an instruction.
    pub remedy: String,
}

impl UnknownProperty {
    /// Creates the statement that a property of a body's material is not known, and what would settle it.
    pub fn of_body(property: MaterialProperty, body: &Body) -> Self {
        let material = material_name(body);
        let remedy = property.remedy(&material, body.kind == BodyKind::Cast);
        Self { property, material, bodies: vec![body.name.clone()], rules: Vec::new(), remedy }
    }

    /// Joins statements about the same property of the same material, by property and material.
    ///
    /// ```
    /// use fabkit_checks::UnknownProperty;
    /// use fabkit_geometry::{Body, MaterialProperty, Process, Solid};
    ///
    /// let part = |name: &str| {
    ///     let body = Body::made(name, "", Process::Fdm, Solid::cuboid(1.0, 1.0, 1.0));
    ///     UnknownProperty::of_body(MaterialProperty::Density, &body.with_material("unobtainium"))
    /// };
    /// let merged = UnknownProperty::merged([part("shell"), part("base")]);
    /// assert_eq!(merged.len(), 1);
    /// assert_eq!(merged[0].bodies, ["base", "shell"]);
    /// ```
    pub fn merged(unknown: impl IntoIterator<Item = Self>) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for one in unknown {
            let is_same =
                |known: &&mut Self| known.subject() == one.subject() && known.remedy == one.remedy;
            match all.iter_mut().find(is_same) {
                Some(known) => {
                    known.bodies.extend(one.bodies);
                    known.bodies.sort();
                    known.bodies.dedup();
                }
                None => all.push(one),
            }
        }
        all.sort_by(|a, b| (a.property, &a.material).cmp(&(b.property, &b.material)));
        all
    }

    /// Returns the text `PROPERTY of MATERIAL`.
    pub fn subject(&self) -> String {
        match &*self.material {
            "" => format!("{} of {}", self.property, self.bodies.join(", ")),
            material => format!("{} of {material}", self.property),
        }
    }
}

/// Returns whether the maker of a filament says that it warps and advises a brim. Advice for the print alone: no rule needs
/// it, so that nobody is asked.
pub(crate) fn warps(part: &Body) -> bool {
    part.substance.warps == Some(true)
}

/// Property, material and whether it is cast: what an unanswered question is about.
type Subject = (MaterialProperty, String, bool);

/// Names of the bodies that it was asked for, and the rules that asked.
type Asked = (BTreeSet<String>, BTreeSet<Rule>);

/// Record of the questions that nobody answered.
#[derive(Debug, Default)]
pub(crate) struct MaterialQuestions {
    open: RefCell<BTreeMap<Subject, Asked>>,
}

impl MaterialQuestions {
    /// Asks for the class of a body's material.
    pub(crate) fn class(&self, rule: Rule, body: &Body) -> Option<MaterialClass> {
        self.note(rule, body, MaterialProperty::Class, body.substance.class)
    }

    /// Asks how a layer cures.
    pub(crate) fn cure(&self, rule: Rule, body: &Body) -> Option<CureMechanism> {
        self.note(rule, body, MaterialProperty::Cure, body.substance.cure_mechanism)
    }

    /// Asks whether a wall inhibits a cure.
    pub(crate) fn inhibits(&self, rule: Rule, body: &Body, cure: CureMechanism) -> Option<bool> {
        let inhibited = body.substance.inhibited_cures.as_ref();
        // What a cast body gives off follows from how it cured.
        let property = match body.kind {
            BodyKind::Cast => MaterialProperty::Cure,
            _ => MaterialProperty::Inhibition,
        };
        // Only platinum catalysts are known to be poisoned by what they touch.
        let answer = match cure {
            CureMechanism::Platinum => inhibited.map(|cures| cures.contains(&cure)),
            _ => Some(inhibited.is_some_and(|cures| cures.contains(&cure))),
        };
        self.note(rule, body, property, answer)
    }

    /// Asks for the hardness.
    pub(crate) fn shore(&self, rule: Rule, body: &Body) -> Option<Shore> {
        self.note(rule, body, MaterialProperty::Hardness, body.substance.shore)
    }

    /// Asks for the stress at which it fails, MPa.
    pub(crate) fn strength_mpa(&self, rule: Rule, body: &Body) -> Option<f64> {
        self.note(rule, body, MaterialProperty::Strength, body.substance.tear_strength_mpa)
    }

    /// Asks for the viscosity of a mixture, Pa s.
    pub(crate) fn viscosity_pa_s(&self, rule: Rule, body: &Body) -> Option<f64> {
        self.note(rule, body, MaterialProperty::Viscosity, body.substance.viscosity_pa_s)
    }

    /// Asks for the linear shrinkage of a layer on curing, as a fraction.
    pub(crate) fn cast_shrinkage(&self, rule: Rule, body: &Body) -> Option<f64> {
        let answer = match body.substance.class {
            // What stays liquid fills its hollow.
            Some(MaterialClass::Liquid) => Some(0.0),
            _ => body.substance.cast_shrinkage,
        };
        self.note(rule, body, MaterialProperty::Shrinkage, answer)
    }

    /// Asks whether a body is dark.
    pub(crate) fn is_dark(&self, rule: Rule, body: &Body) -> Option<bool> {
        self.note(rule, body, MaterialProperty::Shade, body.substance.is_dark)
    }

    /// Asks how light passes a body.
    pub(crate) fn transparency(&self, rule: Rule, body: &Body) -> Option<OpticalClarity> {
        let answer = (!body.has_unknown_transparency()).then(|| body.clarity());
        self.note(rule, body, MaterialProperty::Transparency, answer)
    }

    /// Asks for the elasticity of a soft layer.
    pub(crate) fn elasticity<'b>(&self, rule: Rule, body: &'b Body) -> Option<&'b Elasticity> {
        self.note(rule, body, MaterialProperty::Elasticity, body.substance.elasticity.as_ref())
    }

    /// Asks for the diffuse reflectance, as a camera without colours sees it.
    pub(crate) fn reflectance(&self, rule: Rule, body: &Body) -> Option<f64> {
        let reflectance = body.substance.optics.mean_reflectance();
        self.note(rule, body, MaterialProperty::Reflectance, reflectance)
    }

    /// Asks for the share of the light that passes.
    pub(crate) fn transmission(&self, rule: Rule, body: &Body) -> Option<f64> {
        let transmission = body.substance.optics.transmission.as_ref().map(|passes| passes.value);
        // Where it is drawn opaque, no light passes, whatever its material could let through.
        let transmission = match body.clarity() {
            OpticalClarity::Opaque => Some(0.0),
            _ => transmission,
        };
        self.note(rule, body, MaterialProperty::Transmission, transmission)
    }

    /// Returns the answer, and writes the question down if there is none.
    fn note<T>(
        &self,
        rule: Rule,
        body: &Body,
        property: MaterialProperty,
        answer: Option<T>,
    ) -> Option<T> {
        if answer.is_none() {
            let key = (property, material_name(body), body.kind == BodyKind::Cast);
            let mut open = self.open.borrow_mut();
            let (bodies, rules) = open.entry(key).or_default();
            bodies.insert(body.name.clone());
            rules.insert(rule);
        }
        answer
    }

    /// Returns the questions that nobody answered, by property and material.
    pub(crate) fn unanswered(self) -> Vec<UnknownProperty> {
        let unknown =
            |((property, material, is_cast), (bodies, rules)): (Subject, Asked)| UnknownProperty {
                property,
                remedy: property.remedy(&material, is_cast),
                material,
                bodies: bodies.into_iter().collect(),
                rules: rules.into_iter().collect(),
            };
        self.open.into_inner().into_iter().map(unknown).collect()
    }
}

/// Returns the name of a body's material: what it is called, or what a bought body is made of; empty if neither is
/// stated.
fn material_name(body: &Body) -> String {
    match body.stock {
        Some(stock) if body.material.is_empty() => stock.to_owned(),
        _ => body.material.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::{Process, Solid};

    #[test]
    fn unanswered_questions_are_grouped_by_material() {
        let questions = MaterialQuestions::default();
        let cube = || Solid::cuboid(1.0, 1.0, 1.0);
        let part =
            |name: &str| Body::made(name, "", Process::Fdm, cube()).with_material("unobtainium");
        for name in ["shell", "base"] {
            assert_eq!(questions.shore(Rule::Softness, &part(name)), None);
        }
        assert_eq!(
            questions.inhibits(Rule::Chemistry, &part("shell"), CureMechanism::Tin),
            Some(false)
        );
        let open = questions.unanswered();
        assert_eq!(open.len(), 1, "{open:#?}");
        assert_eq!(open[0].subject(), "hardness of unobtainium");
        assert_eq!((open[0].bodies.len(), &*open[0].rules), (2, &[Rule::Softness][..]));
    }

    #[test]
    fn a_window_of_unknown_transparency_is_asked_for() {
        let questions = MaterialQuestions::default();
        let pane = Body::made("pane", "", Process::Laser, Solid::cuboid(9.0, 9.0, 2.0));
        let pane = |clarity| pane.clone().with_material("unobtainium").as_window(clarity);
        let clear = Some(OpticalClarity::Clear);
        assert_eq!(questions.transparency(Rule::Sight, &pane(clear)), clear);
        assert_eq!(questions.transparency(Rule::Sight, &pane(None)), None);
        let open = questions.unanswered();
        assert_eq!((open.len(), &*open[0].subject()), (1, "transparency of unobtainium"));
    }

    #[test]
    fn no_rule_reads_properties_without_asking() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut folders = vec![folder];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if !path.ends_with("material_questions.rs") {
                    let text = std::fs::read_to_string(&path).unwrap();
                    let code = text.split("#[cfg(test)]").next().unwrap();
                    let code = code.lines().filter(|line| !line.trim_start().starts_with("//"));
                    for line in code {
                        for answer in [".substance", ".clarity()", ".optics"] {
                            assert!(!line.contains(answer), "{}: {line}", path.display());
                        }
                    }
                }
            }
        }
    }
}
