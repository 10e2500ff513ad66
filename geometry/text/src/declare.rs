//! Declaration of parameters: one declaration yields the type, its limits, its schema and its table.

use std::ops::{Deref, RangeInclusive};

use serde_json::{Value as Json, json};

use crate::{Reader, Scalar, ValueKind};

/// Parameter or section, as declared.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{FieldDeclaration, FieldShape, Parameter};
///
/// let shape = Length::shape(&(1.0..=20.0));
/// let radius = FieldDeclaration { name: "radius", summary: "Outer radius.".into(), shape };
/// let FieldShape::Value { is_list, allowed, .. } = radius.shape else { panic!("it is a value") };
/// assert_eq!((is_list, allowed.as_str()), (false, "1 mm to 20 mm"));
/// ```
#[derive(Clone, Debug)]
pub struct FieldDeclaration {
    /// Key in YAML.
    pub name: &'static str,
    /// First paragraph of the documentation.
    pub summary: String,
    /// Content of the key.
    pub shape: FieldShape,
}

/// Content of a key.
#[derive(Clone, Debug)]
pub enum FieldShape {
    /// Section with further keys.
    Section(Vec<FieldDeclaration>),
    /// Value, or list of values.
    Value {
        /// True for a sequence of scalars, false for one scalar.
        is_list: bool,
        /// Kind of the value; of lists, of each item.
        kind: ValueKind,
        /// Description of the allowed values, for people.
        allowed: String,
        /// JSON Schema of the plain form.
        schema: Json,
    },
}

/// Content that can stand behind a key: a section or a value.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{Dialect, TextLayer, TextPlace, parameters, read_section};
///
/// parameters! {
///     /// A gel.
///     pub struct Gel {
///         /// Hardness, Shore 00.
///         hardness: Option<f64> = 0.0..=100.0,
///         /// Diameters of dots.
///         dots: Vec<Length> = (1..=3, 0.1..=5.0),
///     }
/// }
/// const GEL: &Dialect = &Dialect::new("gel", 1, "");
/// let place = TextPlace::new(TextLayer::File, "gel.yaml", GEL);
/// let gel: Gel = read_section("format: 1\ndots: [0.5 mm, 1 mm]\n", &place)?;
/// assert_eq!((gel.hardness, gel.dots.len()), (None, 2));
/// assert!(read_section::<Gel>("format: 1\ndots: [0.5 mm, 9 mm]\n", &place).is_err());
/// # Ok::<(), fabkit_text::InvalidDesign>(())
/// ```
pub trait Parameter: Sized + Clone {
    /// Type of the limits; `()` for sections and where the type itself is the limit.
    type Limits;

    /// Returns the content of the key.
    fn shape(limits: &Self::Limits) -> FieldShape;

    /// Reads the value at `path`. Problems go to the reader.
    fn read(reader: &mut Reader, path: &str, summary: &str, limits: &Self::Limits) -> Option<Self>;

    /// Calls `look` with copies of itself, each with one value at or below `path` changed to another allowed value, and
    /// with the path of that value. Used to find dependencies. For the amount of change see [`Scalar::neighbours`].
    fn neighbours(
        &self,
        path: &str,
        limits: &Self::Limits,
        share: f64,
        look: NeighbourCallback<Self>,
    );

    /// Returns the path behind a key of the section at `section`.
    fn path_in(section: &str, key: &str) -> String {
        join(section, key)
    }

    /// Returns the fields that the containing section gets from it, behind `key`.
    fn fields_behind(
        key: &'static str,
        summary: String,
        limits: &Self::Limits,
    ) -> Vec<FieldDeclaration> {
        vec![FieldDeclaration { name: key, summary, shape: Self::shape(limits) }]
    }
}

/// Callback for a copy with another value, and the path of that value. Every field of every struct passes its copies to
/// the callback of the whole struct. A dynamic function is used because a chain of generic iterators took a fifth of
/// the compile time of the families.
pub type NeighbourCallback<'a, P> = &'a mut dyn FnMut(&str, P);

/// Struct declared with [`parameters!`](crate::parameters!).
pub trait Section: Parameter<Limits = ()> {
    /// Returns its keys, in order.
    fn fields() -> Vec<FieldDeclaration>;
}

impl<T: Scalar> Parameter for T {
    type Limits = T::Limits;

    fn shape(limits: &T::Limits) -> FieldShape {
        FieldShape::Value {
            is_list: false,
            kind: T::KIND,
            allowed: T::allowed(limits),
            schema: T::schema(limits),
        }
    }

    fn read(reader: &mut Reader, path: &str, summary: &str, limits: &T::Limits) -> Option<Self> {
        reader.read_scalar(path, summary, limits)
    }

    fn neighbours(
        &self,
        path: &str,
        limits: &T::Limits,
        share: f64,
        look: NeighbourCallback<Self>,
    ) {
        for other in Scalar::neighbours(self, limits, share) {
            look(path, other);
        }
    }
}

/// Value that may be omitted: `None` means unknown.
impl<T: Scalar> Parameter for Option<T> {
    type Limits = T::Limits;

    fn shape(limits: &T::Limits) -> FieldShape {
        T::shape(limits)
    }

    fn read(reader: &mut Reader, path: &str, summary: &str, limits: &T::Limits) -> Option<Self> {
        match reader.is_written(path) {
            true => reader.read_scalar(path, summary, limits).map(Some),
            // Omitted is not missing: nothing is reported.
            false => Some(None),
        }
    }

    fn neighbours(
        &self,
        path: &str,
        limits: &T::Limits,
        share: f64,
        look: NeighbourCallback<Self>,
    ) {
        if let Some(value) = self {
            Parameter::neighbours(value, path, limits, share, &mut |path, other| {
                look(path, Some(other));
            });
        }
    }
}

/// Section whose keys stand directly among those of the containing section: what several sections share is declared
/// once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inline<S>(pub S);

impl<S> Deref for Inline<S> {
    type Target = S;

    fn deref(&self) -> &S {
        &self.0
    }
}

impl<S: Section> Parameter for Inline<S> {
    type Limits = ();

    fn shape((): &()) -> FieldShape {
        S::shape(&())
    }

    fn read(reader: &mut Reader, path: &str, summary: &str, (): &()) -> Option<Self> {
        S::read(reader, path, summary, &()).map(Self)
    }

    fn neighbours(&self, path: &str, (): &(), share: f64, look: NeighbourCallback<Self>) {
        self.0.neighbours(path, &(), share, &mut |path, other| look(path, Self(other)));
    }

    fn path_in(section: &str, _key: &str) -> String {
        section.to_owned()
    }

    fn fields_behind(_key: &'static str, _summary: String, (): &()) -> Vec<FieldDeclaration> {
        S::fields()
    }
}

/// Maximum number of list items that are moved one by one. Items of longer lists are moved together, because a thousand
/// single moves take seconds.
const MAX_ITEMS_MOVED_SINGLY: usize = 12;

/// Limits: number of items, and limits of each item.
impl<T: Scalar> Parameter for Vec<T> {
    type Limits = (RangeInclusive<usize>, T::Limits);

    fn shape((count, each): &Self::Limits) -> FieldShape {
        let (low, high) = (count.start(), count.end());
        FieldShape::Value {
            is_list: true,
            kind: T::KIND,
            allowed: format!("{low} to {high} items, each {}", T::allowed(each)),
            schema: json!({
                "type": "array",
                "items": T::schema(each),
                "minItems": low,
                "maxItems": high,
            }),
        }
    }

    fn read(
        reader: &mut Reader,
        path: &str,
        summary: &str,
        (count, each): &Self::Limits,
    ) -> Option<Self> {
        reader.read_list(path, summary, count, each)
    }

    fn neighbours(
        &self,
        path: &str,
        (count, each): &Self::Limits,
        share: f64,
        look: NeighbourCallback<Self>,
    ) {
        if self.len() > MAX_ITEMS_MOVED_SINGLY {
            let others: Vec<Vec<T>> =
                self.iter().map(|item| Scalar::neighbours(item, each, share)).collect();
            // Choices have more neighbours than numbers, so items may differ in how many they have.
            for k in 0..others.iter().map(Vec::len).max().unwrap_or(0) {
                // Items that have no such neighbour stay as they are.
                let moved = |(item, others): (&T, &Vec<T>)| others.get(k).unwrap_or(item).clone();
                look(path, self.iter().zip(&others).map(moved).collect());
            }
            return;
        }
        for (i, item) in self.iter().enumerate() {
            for other in Scalar::neighbours(item, each, share) {
                let mut list = self.clone();
                list[i] = other;
                look(path, list);
            }
        }
        // A shorter list is a neighbour too.
        if let [rest @ .., _] = &self[..]
            && count.contains(&rest.len())
        {
            look(path, rest.to_vec());
        }
    }
}

/// Joins `surface` and `radius` to `surface.radius`.
///
/// ```
/// assert_eq!(fabkit_text::join("surface", "radius"), "surface.radius");
/// assert_eq!(fabkit_text::join("", "radius"), "radius");
/// ```
pub fn join(section: &str, key: &str) -> String {
    if section.is_empty() { key.to_owned() } else { format!("{section}.{key}") }
}

/// Returns the first paragraph of a documentation comment, given line by line.
///
/// ```
/// let summary = fabkit_text::summary(&[" Radius of the", " dome.", "", " Details."]);
/// assert_eq!(summary, "Radius of the dome.");
/// ```
pub fn summary(lines: &[&str]) -> String {
    let paragraph = lines.iter().map(|line| line.trim()).take_while(|line| !line.is_empty());
    paragraph.collect::<Vec<_>>().join(" ")
}

/// Declares a section of parameters: a plain struct that can be read from YAML.
///
/// Each field is either a section of its own, or a value with inclusive limits after `=`:
///
/// | type | YAML | limits |
/// |---|---|---|
/// | `Length` | `12.5 mm` | `4.0..=60.0`, mm |
/// | `Angle` | `160 deg` | `0.0..=180.0`, deg |
/// | `u32` | `8` | `1..=64` |
/// | `f64` | `0.5` | `0.0..=1.0` |
/// | `String` | `text` | `1..=80`, characters |
/// | `bool` | `true` | none |
/// | an enum of [`choices!`](crate::choices!) | `round` | none |
/// | `Vec` of one of these | `[1 mm, 2 mm]` | `(1..=8, 0.0..=5.0)`: number of items, then limits of each |
/// | `Option` of one of these | omitted if unknown | as without `Option` |
/// | [`Inline`] of a section | its keys, among those of this section | none |
///
/// The first paragraph of each comment appears in `fabkit show` and in the schema.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{Inline, Section, parameters};
///
/// parameters! {
///     /// The sensing surface: a hemisphere on a straight wall.
///     pub struct SurfaceTriangles {
///         /// Radius of hemisphere and wall.
///         radius: Length = 4.0..=60.0,
///         /// Height of the straight wall.
///         wall_height: Length = 0.0..=60.0,
///     }
/// }
/// parameters! {
///     /// The finish of a coat: several sections have it.
///     pub struct Finish {
///         /// Thickness when dry.
///         thickness: Length = 0.005..=1.0,
///     }
/// }
/// parameters! {
///     /// Everything about a sensor.
///     pub struct DomeShape {
///         /// The sensing surface.
///         surface: SurfaceTriangles,
///         /// The finish: `thickness` beside `surface`.
///         finish: Inline<Finish>,
///     }
/// }
///
/// let top_radius_mm = |p: &DomeShape| p.surface.radius.mm() - p.finish.thickness.mm();
/// assert_eq!(SurfaceTriangles::fields()[1].summary, "Height of the straight wall.");
/// assert_eq!(DomeShape::fields()[1].name, "thickness");
/// # let _ = top_radius_mm;
/// ```
#[macro_export]
macro_rules! parameters {
    (
        $(#[doc = $doc:literal])+
        pub struct $name:ident {
            $(
                $(#[doc = $field_doc:literal])+
                $field:ident: $type:ty $(= $limits:expr)?
            ),+ $(,)?
        }
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $(
                $(#[doc = $field_doc])+
                $(#[doc = concat!("\n\nLimits: `", stringify!($limits), "`.")])?
                pub $field: $type,
            )+
        }

        impl $crate::Parameter for $name {
            type Limits = ();

            fn shape((): &()) -> $crate::FieldShape {
                $crate::FieldShape::Section(
                    <Self as $crate::Section>::fields(),
                )
            }

            fn read(
                reader: &mut $crate::Reader,
                path: &str,
                _summary: &str,
                (): &(),
            ) -> Option<Self> {
                use $crate::{Parameter, summary};
                // Read all fields before returning `None` for any: every error is reported.
                $(
                    let $field = <$type as Parameter>::read(
                        reader,
                        &<$type as Parameter>::path_in(path, stringify!($field)),
                        &summary(&[$($field_doc),+]),
                        &$crate::parameter_limits!($($limits)?),
                    );
                )+
                Some(Self { $($field: $field?),+ })
            }

            fn neighbours(
                &self,
                path: &str,
                (): &(),
                share: f64,
                look: $crate::NeighbourCallback<Self>,
            ) {
                use $crate::Parameter;
                $(
                    Parameter::neighbours(
                        &self.$field,
                        &<$type as Parameter>::path_in(path, stringify!($field)),
                        &$crate::parameter_limits!($($limits)?),
                        share,
                        &mut |path, other| {
                            let mut neighbour = self.clone();
                            neighbour.$field = other;
                            look(path, neighbour);
                        },
                    );
                )+
            }
        }

        impl $crate::Section for $name {
            fn fields() -> Vec<$crate::FieldDeclaration> {
                use $crate::{Parameter, summary};
                let mut fields = Vec::new();
                $(
                    fields.extend(<$type as Parameter>::fields_behind(
                        stringify!($field),
                        summary(&[$($field_doc),+]),
                        &$crate::parameter_limits!($($limits)?),
                    ));
                )+
                // A section without keys cannot be written in a file.
                fields.retain(|field| !matches!(&field.shape, $crate::FieldShape::Section(inner) if inner.is_empty()));
                fields
            }
        }
    };
}

/// Limits of a field: `()` if none are written.
#[doc(hidden)]
#[macro_export]
macro_rules! parameter_limits {
    () => {
        ()
    };
    ($limits:expr) => {
        $limits
    };
}

/// Declares a parameter whose value is one of a few words.
///
/// ```
/// fabkit_text::choices! {
///     /// Outline of the base, seen from above.
///     pub enum PadMapping {
///         /// A circle.
///         Round = "round",
///         /// A square with the circle's diameter as its side.
///         Square = "square",
///     }
/// }
/// assert_eq!(PadMapping::Square.word(), "square");
/// ```
#[macro_export]
macro_rules! choices {
    (
        $(#[doc = $doc:literal])+
        pub enum $name:ident {
            $(
                $(#[doc = $choice_doc:literal])+
                $choice:ident = $word:literal
            ),+ $(,)?
        }
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {
            $(
                $(#[doc = $choice_doc])+
                $choice,
            )+
        }

        impl $name {
            /// The words, in order of declaration.
            pub const WORDS: &'static [&'static str] = &[$($word),+];

            /// Returns the word used in YAML.
            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$choice => $word,)+
                }
            }
        }

        impl $crate::Scalar for $name {
            const KIND: $crate::ValueKind = $crate::ValueKind::Text;
            type Limits = ();

            fn parse(text: &str) -> Result<Self, $crate::Refusal> {
                match text.trim() {
                    $($word => Ok(Self::$choice),)+
                    other => Err($crate::Refusal::not_a_choice(other, Self::WORDS)),
                }
            }

            fn is_within(&self, (): &()) -> bool {
                true
            }

            fn nearest(&self, (): &()) -> Option<Self> {
                None
            }

            fn neighbours(&self, (): &(), _share: f64) -> Vec<Self> {
                let mut others = vec![$(Self::$choice),+];
                others.retain(|other| other != self);
                others
            }

            fn show(&self) -> String {
                self.word().to_owned()
            }

            fn allowed((): &()) -> String {
                Self::WORDS.join(", ")
            }

            fn must_be((): &()) -> String {
                format!("one of {}", Self::WORDS.join(", "))
            }

            fn schema((): &()) -> $crate::Json {
                $crate::Json::from_iter([("enum", Self::WORDS)])
            }
        }
    };
}
