//! Properties of a purchasable article.

use fabkit_geometry::{Angle, Length};

use super::PackSize;
use crate::materials::{Current, Euros, Kelvin, Voltage, Wavelength};
use crate::parameters::{choices, parameters};

choices! {
    /// Reason why an article is bought.
    pub enum Role {
        /// Piece of the sensor or of its molds, or component of a mix.
        Piece = "piece",
        /// Material that parts are made from.
        Stock = "stock",
        /// Consumable that the work uses up.
        Supply = "supply",
        /// Tool that is used again.
        Tool = "tool",
    }
}

parameters! {
    /// Something that is bought; what is not known is left out.
    pub struct Article {
        /// Why it is bought; a piece where nothing is said.
        role: Option<Role>,
        /// What matters of it, where there is no number to order by.
        what: Option<String> = 1..=300,
        /// Who makes it.
        maker: Option<String> = 1..=100,
        /// The maker's name or number for it.
        number: Option<String> = 1..=100,
        /// The standard that it follows.
        standard: Option<String> = 1..=60,
        /// How much is sold at once.
        pack: Option<PackSize>,
        /// What a pack, or the kit, costs.
        price: Option<Euros> = 0.01..=100000.0,
        /// What it is sold as together with others, which is paid for once.
        kit: Option<String> = 1..=100,
        /// What may be bought in its place.
        substitutes: Option<String> = 1..=300,
        /// Words of a chain's steps that ask for it, or of a material that it is stock of; between semicolons.
        words: Option<String> = 1..=200,
        /// What it is made by, where it is stock.
        process: Option<String> = 1..=20,
        /// Length of a sheet.
        length: Option<Length> = 1.0..=10000.0,
        /// Width of a sheet.
        width: Option<Length> = 1.0..=10000.0,
        /// Forward voltage of a lamp.
        forward_voltage: Option<Voltage> = 0.5..=60.0,
        /// Current that a lamp is made for.
        current: Option<Current> = 0.1..=5000.0,
        /// Dominant wavelength of a lamp, or its peak where that is invisible.
        wavelength: Option<Wavelength> = 200.0..=2000.0,
        /// Colour temperature of a white lamp.
        color_temperature: Option<Kelvin> = 1000.0..=20000.0,
        /// Full angle at half of a lamp's intensity.
        view_angle: Option<Angle> = 1.0..=180.0,
        /// Where it comes from what is said of it.
        source: Option<String> = 1..=300,
        /// Where the price comes from.
        price_source: Option<String> = 1..=200,
    }
}
